"""``bench prove``: examine the mismatch analysis on concealed effects and say how it fared."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from bench.proof.analyse import Job
    from bench.proof.run import Progress
    from bench.proof.score import CaseScore

_SETS = "clear,faint,null,compound,unknown,ambiguous,switched_off"


@dataclass(frozen=True, slots=True)
class _Options:
    """What the command line asked for, apart from which cases."""

    out: Path
    jobs: int
    dask: str | None
    keep: bool


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="prove")(prove)


def prove(
    out: Annotated[Path, typer.Option("--out", help="Folder for cases, truths and reports; kept and resumed.")] = Path(
        "proof"
    ),
    sets: Annotated[str, typer.Option("--set", help="Sets to prove, comma-separated.")] = _SETS,
    seed: Annotated[int, typer.Option(help="Seed of the whole exam.")] = 1,
    count: Annotated[int | None, typer.Option(help="At most so many cases of each set.")] = None,
    nulls: Annotated[int | None, typer.Option(help="Number of folders without effect.")] = None,
    held_back: Annotated[bool, typer.Option("--held-back", help="Draw from the forms nobody tunes on.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Two small cases, for continuous integration.")] = False,
    severity: Annotated[bool, typer.Option("--severity", help="Sweep the strength of every effect.")] = False,
    strengths: Annotated[
        str, typer.Option(help="Strengths of the sweep, in units of the noise floor.")
    ] = "0.05,0.1,0.2,0.4,0.8,1.6",
    repeats: Annotated[int, typer.Option(help="Benches of the sweep: seeds from --seed on.")] = 1,
    effects: Annotated[str, typer.Option(help="Effects of the sweep, comma-separated; all where empty.")] = "",
    peers: Annotated[
        bool, typer.Option("--peers", help="Let pysindy, SysIdentPy, gplearn and lassos sit the exam too.")
    ] = False,
    jobs: Annotated[int, typer.Option("--jobs", help="Cases at once on this machine.")] = 1,
    dask: Annotated[str | None, typer.Option(help="Address of a Dask scheduler to use instead.")] = None,
    make_only: Annotated[bool, typer.Option("--make-only", help="Make folders and truths, analyse nothing.")] = False,
    keep: Annotated[bool, typer.Option("--keep", help="Keep the recordings after their analysis.")] = False,
    table: Annotated[Path | None, typer.Option(help="Write the table as Markdown to this file.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Conceal effects in generated campaigns, seal the truth, run `bench mismatch`, score what it says.

    Nothing is proved twice: a case whose seal and analyser are unchanged is taken from the folder. The same command
    goes on where it was stopped.
    """
    from bench.proof.make import RECORDINGS, TRUTHS
    from bench.proof.run import Plan, jobs_of, sweep_jobs
    from bench.proof.run import make_only as make_folders

    groups = ("quick",) if quick else tuple(s.strip() for s in sets.split(","))
    plan = Plan(groups, seed, count, nulls, held_back)
    options = _Options(out / f"seed-{seed}{'-held-back' if held_back else ''}", jobs, dask, keep)
    listed = jobs_of(plan, options.out, keep or peers)
    if severity:
        values = [float(value) for value in strengths.split(",")]
        seeds = range(seed, seed + repeats)
        single = [job for s in seeds for job in jobs_of(Plan(("clear",), s, count), options.out, keep)]
        listed = sweep_jobs(_with_effects(single, effects), values)
    if make_only:
        for path in make_folders(listed, jobs):
            typer.echo(str(options.out / RECORDINGS / path.stem))
        typer.echo(f"what is in each: {options.out / TRUTHS}")
        return
    _report(_prove(listed, options, quiet=as_json), options, severity, peers, table, as_json, listed)


def _with_effects(listed: list[Job], effects: str) -> list[Job]:
    """The jobs that conceal one of the effects named, all where none is named."""
    from bench.proof.analyse import draw_case
    from bench.proof.make import load_examiner

    wanted = {name.strip() for name in effects.split(",") if name.strip()}
    if not wanted:
        return listed
    examiner = load_examiner()
    return [job for job in listed if {form.effect for form in draw_case(examiner, job).forms} & wanted]


def _prove(listed: list[Job], options: _Options, quiet: bool) -> list[CaseScore]:
    from bench.proof.run import prove as run_all

    progress: Progress | None = None if quiet else _say
    return run_all(listed, options.jobs, options.dask, progress)


def _say(done: int, of: int, score: CaseScore) -> None:
    mark = "right" if score.every_point_right else "not right"
    concealed = ", ".join(effect.effect for effect in score.effects) or "nothing"
    extra = f"; false: {', '.join(score.false_companions)}" if score.false_companions else ""
    failed = f"; failed: {score.failed}" if score.failed else ""
    typer.echo(f"[{done}/{of}] {score.case} ({concealed}): {mark}{extra}{failed}, {score.seconds:.0f} s", err=True)


def _report(
    scores: list[CaseScore],
    options: _Options,
    severity: bool,
    peers: bool,
    table: Path | None,
    as_json: bool,
    listed: list[Job],
) -> None:
    from bench.proof.analyse import analyser_digest
    from bench.proof.make import seal_of_seals
    from bench.proof.table import as_json as to_json
    from bench.proof.table import markdown, severity_markdown

    seal = seal_of_seals(options.out)
    text = severity_markdown(scores) if severity else markdown(scores, seal=seal)
    content = to_json(scores, seal=seal, analyser=analyser_digest())
    if peers:
        from bench.proof.peers import compare_peers

        compared = compare_peers(listed)
        text += compared.markdown()
        content["peers"] = compared.to_dict()
    if table is not None:
        table.write_text(text, encoding="utf-8")
    options.out.joinpath("proof.json").write_text(json.dumps(content, indent=1), encoding="utf-8")
    typer.echo(json.dumps(content) if as_json else text)
