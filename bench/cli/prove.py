"""``bench prove``: examine the mismatch analysis on concealed effects and say how it fared."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bench.cli._plain import say

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


@dataclass(frozen=True, slots=True)
class _Shown:
    """How the result is shown and where it is kept."""

    severity: bool
    peers: bool
    table: Path | None
    store: Path | None
    as_json: bool


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
    held_back: Annotated[
        bool, typer.Option("--held-back", help="Use forms and benches that were not used for tuning.")
    ] = False,
    clutter: Annotated[
        bool, typer.Option("--clutter", help="Give every gearbox 60 to 100 weak orders beside the nominal ones.")
    ] = False,
    through: Annotated[
        bool,
        typer.Option(
            "--through-the-bench", help="Conceal in the plant itself; campaigns are run by the service's run process."
        ),
    ] = False,
    again: Annotated[
        bool,
        typer.Option("--again", help="With --through-the-bench: does the model hold in another campaign on the plant?"),
    ] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Two small cases, for continuous integration.")] = False,
    severity: Annotated[bool, typer.Option("--severity", help="Sweep the strength of every effect.")] = False,
    strengths: Annotated[
        str, typer.Option(help="Strengths of the sweep, in units of the noise floor.")
    ] = "0.05,0.1,0.2,0.4,0.8,1.6",
    criteria: Annotated[
        bool,
        typer.Option("--criteria", help="Analyse again with every number that decides at half and at twice its value."),
    ] = False,
    repeats: Annotated[int, typer.Option(help="Benches of the sweep: seeds from --seed on.")] = 1,
    effects: Annotated[str, typer.Option(help="Effects of the sweep, comma-separated; all where empty.")] = "",
    peers: Annotated[
        bool,
        typer.Option(
            "--peers", help="Analyse the same recordings with lasso, pysindy, SysIdentPy, gplearn, pyoperon too."
        ),
    ] = False,
    jobs: Annotated[int, typer.Option("--jobs", help="Cases at once on this machine.")] = 1,
    dask: Annotated[str | None, typer.Option(help="Address of a Dask scheduler to use instead.")] = None,
    make_only: Annotated[bool, typer.Option("--make-only", help="Make folders and truths, analyse nothing.")] = False,
    keep: Annotated[bool, typer.Option("--keep", help="Keep the recordings after their analysis.")] = False,
    table: Annotated[Path | None, typer.Option(help="Write the table as Markdown to this file.")] = None,
    store: Annotated[Path | None, typer.Option(help="Write the result as JSON to this file, to be quoted.")] = None,
    done: Annotated[
        bool, typer.Option("--done", help="Analyse nothing: the table of what is done so far, of how many.")
    ] = False,
    figures: Annotated[
        bool, typer.Option("--figures", help="Make the figures of README.md and docs from docs/proof/*.json, no more.")
    ] = False,
    real: Annotated[
        Path | None,
        typer.Option("--real", help="Examine recordings of others: a folder with a folder for each public set."),
    ] = None,
    open_seed: Annotated[
        int | None, typer.Option("--open", min=0, help="Break the seal of bench run or serve --conceal SEED, no more.")
    ] = None,
    sealed: Annotated[
        Path | None, typer.Option(help="With --open: folder of recordings whose seal should be that of the seed.")
    ] = None,
    bench: Annotated[
        str, typer.Option(help="Bench whose plant is drawn: name of a shipped one, or a file.")
    ] = "rh380n",
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Conceal effects in generated campaigns, seal the truth, run `bench mismatch`, score what it says.

    A case whose seal and analyser are unchanged is not analysed again. The same command continues where it was
    stopped. With ``--real`` the recordings are those of others (docs/real.md).
    """
    from bench.proof.make import RECORDINGS
    from bench.proof.run import Plan, jobs_of, sweep_jobs
    from bench.proof.run import make_only as make_folders
    from bench.proof.seal import TRUTHS, read_truth

    if figures:
        from bench.proof.figures import write

        for page in write(Path.cwd()):
            typer.echo(f"made anew: {page}")
        return
    if real is not None:
        _real(real, out, () if sets == _SETS else tuple(s.strip() for s in sets.split(",")), table, jobs)
        return
    if open_seed is not None:
        from bench.cli._opened import print_concealed

        print_concealed(bench, open_seed, sealed, as_json)
        return
    groups = ("through",) if through else ("quick",) if quick else tuple(s.strip() for s in sets.split(","))
    plan = Plan(groups, seed, count, nulls, held_back, clutter, again)
    kind = f"{'-held-back' if held_back else ''}{'-clutter' if clutter else ''}"
    options = _Options(out / f"seed-{seed}{kind}", jobs, dask, keep)
    listed = jobs_of(plan, options.out, keep or peers)
    if severity:
        values = [float(value) for value in strengths.split(",")]
        seeds = range(seed, seed + repeats)
        single = [job for s in seeds for job in jobs_of(Plan(("clear",), s, count, clutter=clutter), options.out, keep)]
        listed = sweep_jobs(_with_effects(single, effects), values)
    if criteria:
        _criteria(jobs_of(plan, options.out, keep=True), options, store)
        return
    if make_only:
        if through:
            from bench.errors import ConfigurationError

            raise ConfigurationError(
                "--make-only does not go with --through-the-bench: what such a plant conceals is written down only "
                "after its recordings have been analysed; leave one of the two out."
            )
        for path in make_folders(listed, jobs):
            say(str(options.out / RECORDINGS / read_truth(path)["folder"]))
        say(f"what is in each: {options.out / TRUTHS}")
        return
    scores = _scores_so_far(listed) if done else _prove(listed, options, quiet=as_json)
    _report(scores, _Shown(severity, peers, table, store, as_json), options, listed)


def _criteria(listed: list[Job], options: _Options, store: Path | None) -> None:
    """Every number that decides, at half and at twice its value."""
    from dataclasses import asdict, replace

    from bench.proof import criteria_table
    from bench.proof.results import provenance
    from bench.proof.seal import seal_of_seals

    kept = [replace(job, keep=True) for job in listed]
    found = criteria_table.examined(kept, options.jobs, lambda what: say(what, err=True))
    how = asdict(provenance(sys.argv[1:], kept, seal_of_seals(options.out)))
    content = criteria_table.as_json(found, how)
    target = store or options.out / "criteria.json"
    criteria_table.store(target, content)
    typer.echo(criteria_table.page(target))


def _real(folder: Path, out: Path, names: tuple[str, ...], table: Path | None, jobs: int) -> None:
    """Examine the public sets named, all where none is, so many at once; write the page, or print it."""
    from functools import partial

    from bench import processes
    from bench.errors import ConfigurationError
    from bench.proof.real.examine import Examined, examine
    from bench.proof.real.page import page
    from bench.proof.real.sets import all_sets
    from bench.proof.results import commit

    known = all_sets()
    unknown = set(names) - {case.name for case in known}
    if unknown:
        listed = ", ".join(case.name for case in known)
        raise ConfigurationError(f"--set: there is no real set {', '.join(sorted(unknown))}, there are {listed}.")
    wanted = [case for case in known if not names or case.name in names]
    rows: list[Examined] = []
    for row in processes.over(partial(examine, folder=folder, out=out / "real"), wanted, jobs):
        say(f"[{len(rows) + 1}/{len(wanted)}] {row.real.name}, {row.seconds:.0f} s", err=True)
        rows.append(row)
    made = commit()
    changed = " with changes" if made.endswith("+changes") else ""
    at = f"commit `{made[:12]}`{changed}" if made else "a commit that is not known"
    text = page(rows, f"Made at {at}, {datetime.now(UTC).date().isoformat()}.")
    if table is None:
        typer.echo(text)
    else:
        table.write_text(text, encoding="utf-8")
    broken = [f"{row.real.name}: {row.failed}" for row in rows if row.broken]
    broken += [f"{row.real.name}: {row.missing[0]}" for row in rows if names and row.missing]
    for sentence in broken:
        say(sentence, err=True)
    if broken:
        raise typer.Exit(1)


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
    say(f"[{done}/{of}] {score.case} ({concealed}): {mark}{extra}{failed}, {score.seconds:.0f} s", err=True)


def _scores_so_far(listed: list[Job]) -> list[CaseScore]:
    from bench.proof.run import done_so_far

    return done_so_far(listed)


def _report(scores: list[CaseScore], shown: _Shown, options: _Options, listed: list[Job]) -> None:
    from bench.proof.results import as_json, plain, provenance
    from bench.proof.results import store as write
    from bench.proof.seal import seal_of_seals
    from bench.proof.table import markdown

    how = provenance(sys.argv[1:], listed, seal_of_seals(options.out))
    text = markdown(scores, how, shown.severity)
    content = as_json(scores, how, shown.severity)
    if shown.peers:
        from bench.proof.peers import compare_peers

        compared = compare_peers(listed)
        text += compared.markdown()
        content["peers"] = plain(compared.to_dict())
    if shown.store is not None:
        write(shown.store, content)
    if shown.table is not None:
        shown.table.write_text(text, encoding="utf-8")
    options.out.mkdir(parents=True, exist_ok=True)
    options.out.joinpath("proof.json").write_text(json.dumps(content, indent=1), encoding="utf-8")
    typer.echo(json.dumps(content) if shown.as_json else text)
