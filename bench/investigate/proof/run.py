"""One hidden plant, asked in three ways: designed experiments, random points, the grid once more."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from bench.investigate.design import Experiment
from bench.investigate.loop import LOOK, Choice, Goal, Scene, choose_experiment, investigate
from bench.investigate.offer import offered_points, plan_points, states
from bench.investigate.proof.plants import SECONDS_AN_HOUR, HiddenBench
from bench.mismatch.report.candidates import Candidate
from bench.mismatch.report.report import Report
from bench.mismatch.run import run as compare

EXPERIMENTS = 3
HOURS = 12.0
ASKED, RANDOM, GRID = "asked", "random", "grid"
WAYS = (ASKED, RANDOM, GRID)
RIGHT, WRONG, OPEN, UNSEEN = "right", "wrong", "open", "nothing found"


@dataclass(slots=True)
class _Counted:
    """Designed experiments, and how many points each had: as many are drawn at random, or taken from the grid."""

    sizes: list[int] = field(default_factory=list)

    def designed(self, scene: Scene) -> Experiment | None:
        out = choose_experiment(scene)
        if out is not None:
            self.sizes.append(len(out.points))
        return out

    def others(self, draw: Callable[[Scene, int, int], tuple[Candidate, ...]], name: str) -> Choice:
        """A choice that takes points from ``draw(scene, step, number)``."""
        step = 0

        def choose(scene: Scene) -> Experiment | None:
            nonlocal step
            number = self.sizes[min(step, len(self.sizes) - 1)] if self.sizes else MOST
            points = draw(scene, step, number)
            step += 1
            if not points:
                return None
            hours = plan_points(name, points, scene.bench, scene.celsius).duration_s / SECONDS_AN_HOUR
            return Experiment(points, hours, tuple((q, None) for q in scene.questions), name, name)

        return choose


MOST = 6
"""points where no experiment was designed to count them"""


def random_points(seed: int) -> Callable[[Scene, int, int], tuple[Candidate, ...]]:
    """Points at random from what the bench can do, after a warm-up, a cooling or neither, at random as well."""

    def draw(scene: Scene, step: int, number: int) -> tuple[Candidate, ...]:
        rng = np.random.default_rng([seed, 17, step])
        every = list(states(scene.covered, scene.bench, scene.celsius))
        first = int(rng.integers(len(every)))
        # a state in which the bench refuses every point gives way to the next
        for state in (*every[first:], *every[:first]):
            points, _ = offered_points(state, scene.bench)
            if points:
                picked = rng.choice(len(points), min(number, len(points)), replace=False)
                before = () if state.before is None else (state.before,)
                return (*before, *(points[k].point for k in picked))
        return ()

    return draw


def repeated_points(grid: list[Candidate]) -> Callable[[Scene, int, int], tuple[Candidate, ...]]:
    """The next points of the grid, which begins again at its end."""
    at = 0

    def draw(scene: Scene, step: int, number: int) -> tuple[Candidate, ...]:
        nonlocal at
        out = tuple(grid[(at + k) % len(grid)] for k in range(number))
        at += number
        return out

    return draw


def judge_report(report: dict[str, Any], truth: dict[str, Any]) -> str:
    """How the concealed effect stands in a report: right where it is named, wrong where another name has its place.

    Any other named finding in a channel of the effect is wrong; without a finding there it is unseen; anything else is
    open.
    """
    concealed = truth["effects"][0]
    here = [f for f in report["findings"] if {f["channel"], *f["also_in"]} & set(concealed["channels"])]
    named = {f["effect"] for f in here if f["status"] == "named"}
    if concealed["effect"] in named:
        return RIGHT
    if not here:
        return UNSEEN
    return WRONG if all(f["status"] == "named" for f in here) else OPEN


def run(case: Any, seed: int, report_progress: Callable[[str], None] = lambda _: None) -> list[dict[str, Any]]:
    """A row for each way; all start from the same campaign and the same look at it."""
    with TemporaryDirectory() as place:
        work = Path(place)
        begun = HiddenBench(case)
        truth = begun.begin(work / "first")
        first = compare(work / "first", work / "look")
        stands = judge_report(first.to_json(), truth)
        counted = _Counted()
        rows = []
        for way in WAYS:
            # each way goes on from the same history; none changes what was recorded in it
            lab = copy(begun)
            choices: dict[str, Choice] = {
                ASKED: counted.designed,
                RANDOM: counted.others(random_points(seed), "as many points at random"),
                GRID: counted.others(repeated_points(lab.grid()), "as many points of the grid again"),
            }
            at = time.process_time()
            row = _run_way(lab, work / "first", work / way, first, truth, choices[way])
            row |= {"way": way, "first": stands, "processor_s": round(time.process_time() - at, 1)}
            rows.append(_case_columns(case, seed, truth) | row)
            report_progress(f"{case.name} of seed {seed}, {way}: {row['result']} after {row['experiments']}")
        return rows


def _case_columns(case: Any, seed: int, truth: dict[str, Any]) -> dict[str, Any]:
    concealed = truth["effects"][0]
    return {
        "case": case.name,
        "seed": seed,
        "effect": concealed["effect"],
        "also": concealed["also"],
        "strength": concealed["strength"],
    }


def _run_way(
    lab: HiddenBench, folder: Path, out: Path, first: Report, truth: dict[str, Any], choose: Choice
) -> dict[str, Any]:
    log = investigate(folder, out, lab, Goal(hours=HOURS, experiments=EXPERIMENTS), choose, first=first)
    steps = log.to_json()["steps"]
    results = [
        judge_report(json.loads((out / f"{LOOK}-{k}" / "report.json").read_text("utf-8")), truth)
        for k in range(1, len(steps) + 1)
    ]
    last = results[-1] if results else judge_report(first.to_json(), truth)
    # counted from where it is right and stays so
    right = next((k for k in range(len(results)) if all(r == RIGHT for r in results[k:])), None)
    hours = [float(step["took_h"]) for step in steps]
    return {
        "result": last,
        "experiments": len(steps),
        "needed": None if right is None else right + 1,
        "hours": round(sum(hours), 3),
        "hours_to_name": None if right is None else round(sum(hours[: right + 1]), 3),
        "gains": [[(q["expected_gain"], q["came"]) for q in step["questions"]] for step in steps],
        "ended": log.state["ended"],
    }
