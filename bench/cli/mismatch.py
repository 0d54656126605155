"""``bench mismatch``: where simulation and recordings differ, what physics was left out, and how much better it
fits.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bench.cli._plain import PlainConsole, say
from bench.cli.exit_codes import ExitCode

if TYPE_CHECKING:
    from bench.mismatch.many import Result, Task


_VALUES = 6
"""So many values of a finding are printed."""
_SCORES = {"as_given": "as given", "before": "recalibrated", "after": "improved"}
"""root mean squares of a channel, in the words of the page"""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="mismatch")(mismatch)


def mismatch(
    recordings: Annotated[list[Path], typer.Argument(help="Folder of recordings; several are compared one by one.")],
    out: Annotated[
        Path,
        typer.Option("--out", help="For report.json, report.html and model.json; of several folders, one folder each."),
    ],
    simulation: Annotated[
        Path | None,
        typer.Option(
            "--simulation",
            help="What to compare with: model.json; an FMU, or the TOML that maps it; a Python function module:name; "
            "columns (simulated/NAME in the recordings). Default: the nominal simulation, calibrated.",
        ),
    ] = None,
    together: Annotated[
        bool,
        typer.Option(
            "--together", help="Several folders are one data set: campaigns on one gearbox with the same encoder zero."
        ),
    ] = False,
    leave_one_out: Annotated[
        bool,
        typer.Option("--leave-one-out", help="Switch off each nominal term in turn: would it have been found?"),
    ] = False,
    jobs: Annotated[
        int,
        typer.Option(
            "--jobs", min=1, help="Processes: folders, or terms left out, at once; one large folder is read on them."
        ),
    ] = 1,
    dask: Annotated[
        str | None, typer.Option("--dask", help="Address of a Dask scheduler to use instead; it must see the folders.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print report.json (of several folders, a list).")] = False,
) -> None:
    """Compare the simulation with recordings: locate the mismatch, name the physics left out, model it, score it.

    The simulation is calibrated on a part of the recordings; whole operating points, among them half of the validation
    points or more, are held out and only scored. Explanations that the recordings cannot distinguish are ambiguous; an
    effect that no term explains is unknown. Fewer than six recordings are cut into blocks, and the report says so.
    """
    one_thread()
    from bench.mismatch.many import compare_all, tasks_of

    tasks = tasks_of(recordings, out, simulation, leave_one_out, together)
    if len(tasks) == 1:
        _compare_one(tasks[0], jobs, dask, as_json)
        return
    outcomes: list[Result] = []
    for outcome in compare_all(tasks, jobs, dask):
        outcomes.append(outcome)
        if not as_json:
            _say(outcome.report, f"{outcome.task.recordings}: {outcome.sentence}", outcome.task.out)
    if as_json:
        say(json.dumps([t.report or {"folder": str(t.task.recordings), "error": t.sentence} for t in outcomes]))
    if any(t.report is None for t in outcomes):
        raise typer.Exit(ExitCode.BAD_INPUT)


def one_thread() -> None:
    """Keep the linear algebra to one thread unless the environment says otherwise: more threads cost time here.

    The matrices are small.

    Takes effect where numpy has not been imported yet, and in the processes started from here.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def _compare_one(task: Task, jobs: int, dask: str | None, as_json: bool) -> None:
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    from bench.mismatch.many import terms_over
    from bench.mismatch.run import run

    console = PlainConsole(stderr=True, highlight=False)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    elsewhere = terms_over(jobs, dask) if jobs > 1 or dask is not None else None
    with Progress(*columns, console=console, transient=True, disable=as_json) as bar:
        line = bar.add_task("reading", total=1.0)
        report = run(
            task.recordings,
            task.out,
            task.simulation,
            lambda what, share: bar.update(line, description=what, completed=share),
            task.leaving_out,
            elsewhere,
            jobs,
        )
    content = report.to_json()
    if as_json:
        say(json.dumps(content, allow_nan=False))
        return
    _say(content, report.sentence, task.out)
    say(f"report: {task.out / 'report.html'}, {_model_of(content)}: {task.out / 'model.json'}")


def _model_of(content: dict[str, Any]) -> str:
    """What ``model.json`` holds, by a report's ``content``."""
    from bench.mismatch.report.verdict import kind_of_simulation

    scores = [(row[f"{_scored(row)}_before"], row[f"{_scored(row)}_after"]) for row in content["channels"]]
    return kind_of_simulation(scores if content["findings"] else [], content["simulation"]["recalibrated"])


def _say(content: dict[str, Any] | None, sentence: str, out: Path) -> None:
    """The verdict, each finding, the channels' scores, what was left out, and the terms left out in turn."""
    say(sentence)
    if content is None:
        return
    # a linear axis has no torque: units tell, in its own words everything else is already
    linear = any(row["channel"] == "motor_torque" and row["unit"] == "N" for row in content["channels"])
    for finding in content["findings"]:
        for row in _finding(finding, out, linear):
            say(f"  {row}")
    for row in content["channels"]:
        say(f"  {_channel(row)}")
    for row in content["recordings"]["rejected"]:
        say(f"  not used: {row['why']}")
    for note in content["notes"]:
        say(f"  note: {note}")
    if content.get("leave_one_out"):
        from bench.mismatch.report.left_out import LeftOut, table

        say(table([LeftOut(**row) for row in content["leave_one_out"]]))


def _channel(row: dict[str, Any]) -> str:
    """A channel's noise floor and what is left of it; of what was fitted, where no recording could be held out."""
    label = _scored(row)
    floor, after, unit = row["noise_floor"], row[f"{label}_after"], row["unit"]
    scores = ", ".join(f"{words} {_number(row[f'{label}_{name}'])}" for name, words in _SCORES.items())
    ratio = "" if after is None or not floor else f" ({after / floor:.3f} of the noise)"
    of = "" if label == "held_out_rmse" else ", on what was fitted: nothing could be held out"
    return f"{row['channel']:20s} {unit}: noise {_number(floor)}; what is left: {scores}{ratio}{of}"


def _scored(row: dict[str, Any]) -> str:
    """Key of a channel's scores: of recordings held out, or of what was fitted where none could be."""
    return "held_out_rmse" if "in_sample_rmse_after" not in row else "in_sample_rmse"


def _number(value: float | None) -> str:
    return "not computed" if value is None else f"{value:.3g}"


def _finding(finding: dict[str, Any], out: Path, linear: bool = False) -> list[str]:
    """A finding as lines: how sure, where, equation and values, its alternatives, what to run next."""
    from bench.simulation.linear import in_metres

    sure = "not computed" if finding["confidence"] is None else f"{finding['confidence']:.2f}"
    lines = [f"{finding['name']} ({finding['effect']}): {finding['status']}, confidence {sure}"]
    channel = finding["channel"].replace("_", " ")
    lines.append(f"  in {in_metres(channel) if linear else channel}, {finding['location']['text']}")
    if finding["equation"]:
        lines.append(f"  {finding['equation']}")
    values = [_value(p) for p in finding["parameters"][:_VALUES]]
    more = len(finding["parameters"]) - len(values)
    if values:
        lines.append("  " + ", ".join(values) + (f", and {more} more in report.json" if more else ""))
    following = finding.get("next_experiment")
    if following:
        lines.append(f"  next experiment: bench run {out / following['file']} ({following['why']})")
    return lines


def _value(parameter: dict[str, Any]) -> str:
    """A parameter with its standard deviation, where that is known."""
    std = parameter.get("std")
    doubt = "" if std is None else f" ± {std:.2g}"
    unit = "" if parameter["unit"] == "1" else f" {parameter['unit']}"
    return f"{parameter['symbol']} = {_number(parameter['value'])}{doubt}{unit}"
