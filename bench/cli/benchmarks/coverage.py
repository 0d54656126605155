"""``bench benchmark coverage``: how often the intervals of identification hold the truth of the emulated plant."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bench.cli._plain import say
from bench.cli._stored import load_stored
from bench.cli._stored import store as keep
from bench.errors import BenchError

if TYPE_CHECKING:
    from bench.configuration import BenchFile

FORMAT, FORMAT_VERSION = "bench-coverage", "1.0"
PAIRS = 40


def coverage(
    campaigns: Annotated[int, typer.Option("--campaigns", min=2, help="How many.")] = 40,
    first: Annotated[int, typer.Option("--first", min=1, help="Seed of the first one; the others follow.")] = 1,
    bench: Annotated[str, typer.Option("--bench", help="Name of an emulated bench.")] = "rh380n",
    work: Annotated[
        Path, typer.Option("--work", help="Folder of recordings and models; what is there is used.")
    ] = Path("coverage"),
    store: Annotated[
        Path | None, typer.Option("--store", help="Keep results here; later runs go on from them.")
    ] = None,
    table: Annotated[Path | None, typer.Option("--table", help="Write the tables as a page of Markdown.")] = None,
    again: Annotated[bool, typer.Option("--again", help="Identify anew from recordings that are there.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Run short campaigns of one plant, identify each, and count how often 95 % intervals hold the truth.

    Also compares campaigns in forty pairs: nothing differs, so every reported change is wrong; and counts how often
    artificial changes are found. It can be stopped at any time; the table has what is done. Run again without
    --again, it continues.
    """
    from bench.cli.benchmarks.coverage_runs import recordings
    from bench.configuration import load_bench
    from bench.identification.comparison.coverage_table import page
    from bench.proof.results import commit

    # of the program that is running: others may commit meanwhile
    made_by = commit()
    content = load_stored(store, _empty(bench), ("format", "bench"))
    if again:
        content |= {"campaigns": [], "pairs": []}
    content["asked"] = campaigns
    content["command"] = f"bench benchmark coverage --campaigns {campaigns} --first {first} --bench {bench}"
    done = {row["seed"]: row for row in content["campaigns"]}
    file = load_bench(bench)
    rated = file.configuration.load_motor.nominal_torque
    for number, seed in enumerate(range(first, first + campaigns), 1):
        if seed in done and _model(work, seed).exists():
            continue
        done[seed] = _identify_campaign(recordings(seed, work, bench, rated), seed, work, file, made_by)
        content["campaigns"] = [done[key] for key in sorted(done)]
        content["pairs"] = [row for row in content["pairs"] if seed not in (row["before"], row["after"])]
        keep(store, content)
        if not as_json:
            say(f"campaign {number} of {campaigns} (seed {seed})")
        _show(content, work, store, table)
    _show(content, work, store, table)
    say(json.dumps(content, ensure_ascii=False) if as_json else page(content))


def _show(content: dict[str, Any], work: Path, store: Path | None, table: Path | None) -> None:
    """Compare what there is, store it and write the tables."""
    from bench.identification.comparison.coverage_table import page

    content["pairs"] = _pairs(content, work)
    keep(store, content)
    if table is not None:
        table.write_text(page(content), "utf-8")


def _empty(bench: str) -> dict[str, Any]:
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "bench": bench,
        "command": "",
        "asked": 0,
        "campaigns": [],
        "pairs": [],
    }


def _model(work: Path, seed: int) -> Path:
    return work / f"model-{seed:03d}.json"


def _identify_campaign(folder: Path, seed: int, work: Path, bench: BenchFile, made_by: str) -> dict[str, Any]:
    """Identify one campaign; its deviations from the truth as they are stored."""
    from bench.identification import Options, identify_folder, to_simulation
    from bench.identification.comparison.coverage import deviates
    from bench.proof.seal import load_sealed
    from bench.recording import RecordingFolder

    found = to_simulation(identify_folder(folder, Options()))
    plant = bench.configuration.bus.plant
    if plant is None:
        raise BenchError(f"{bench.configuration.name} has no emulated plant: nothing is known of its truth.")
    truth = load_sealed().nominal_truth(plant)
    # the campaign's own tare has taken its part of the zero off already
    tared = RecordingFolder.open(folder).recordings[0].specs["load_torque"].offset
    zero = truth["nominal"]["load.torque_offset"]["z_0"] + tared
    truth["nominal"]["load.torque_offset"]["z_0"] = zero
    # the recorded torque has the zero in it, so the constant of the motor's balance has its share
    truth["nominal"]["motor.torque_offset"]["tau_0"] -= zero / bench.configuration.gearbox.ratio
    found.save(_model(work, seed))
    about = {"seed": seed, "commit": made_by, "day": datetime.now(UTC).date().isoformat()}
    return about | deviates(found, truth)


def pairs_of(seeds: list[int], number: int = PAIRS) -> list[tuple[int, int]]:
    """Return up to ``number`` pairs of campaigns, each campaign in as few as can be: first pairs that share none."""
    n = len(seeds)
    # distances up to half way round the circle, so that no pair comes twice
    rows = [(k, i) for k in range(1, n // 2 + 1) for i in (*range(0, n, 2), *range(1, n, 2)) if 2 * k < n or i < k]
    return [(seeds[i], seeds[(i + k) % n]) for k, i in rows[:number]]


def _pairs(content: dict[str, Any], work: Path) -> list[dict[str, Any]]:
    """Models of campaigns compared two by two; pairs that stand in the content already are kept."""
    from bench.identification.comparison.compare import compare
    from bench.identification.comparison.power import power
    from bench.simulation import Simulation

    known = {(row["before"], row["after"]): row for row in content["pairs"]}
    wanted = pairs_of(sorted(row["seed"] for row in content["campaigns"]))
    models = {seed: Simulation.load(_model(work, seed)) for pair in wanted if pair not in known for seed in pair}
    for before, after in wanted:
        if (before, after) in known:
            continue
        rows = compare(models[before], models[after])
        known[before, after] = {
            "before": before,
            "after": after,
            "compared": sum(row.p_value == row.p_value for row in rows),
            "changed": [row.what for row in rows if row.changed],
            "power": power(models[before], models[after]),
        }
    return [known[pair] for pair in wanted]
