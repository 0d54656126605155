"""An answer with every point right, and what an analyser could get wrong about it: each must cost it the folder."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import pytest

from bench.proof.score import CaseScore, score
from bench.proof.statistics import summarise
from tests.bench.proof.test_location import SLOW, TOLD
from tests.bench.proof.test_score import OWN, concealed, finding, report, truth

Answer = dict[str, Any]  # "report" and "own"

WINDOWS = {"angle_windows": [[1.0, 1.2]], "core_windows": [[1.04, 1.16]]}
TRUTH = truth(
    concealed(location=SLOW),
    concealed("te.harmonic", channels=["transmission_error"], location={"orders": [7.0, 48.0]}, parameters=[]),
    concealed("te.local_defect", channels=["transmission_error"], location=WINDOWS, parameters=[]),
)


def right() -> Answer:
    told = report(
        finding(location=TOLD),
        finding("te.harmonic", channel="transmission_error", location={"orders": [7.0, 48.0]}),
        finding("te.local_defect", channel="transmission_error", location={"angle_windows": [[1.0, 1.2]]}),
    )
    own = OWN | {"residual": {"motor_torque": 1.0, "transmission_error": 1.01}}
    return copy.deepcopy({"report": told, "own": own})


def first(answer: Answer) -> dict[str, Any]:
    found: dict[str, Any] = answer["report"]["findings"][0]
    return found


def place(answer: Answer) -> dict[str, Any]:
    where: dict[str, Any] = first(answer)["location"]
    return where


MUTATIONS: dict[str, Callable[[Answer], object]] = {
    "verdict": lambda a: a["report"].update(verdict="match"),
    "name swapped": lambda a: first(a).update(effect="friction.run_in"),
    "names of two findings swapped": lambda a: [
        f.update(effect=e) for f, e in zip(a["report"]["findings"][1:], ("te.local_defect", "te.harmonic"), strict=True)
    ],
    "status": lambda a: first(a).update(status="ambiguous"),
    "unknown for a name": lambda a: first(a).update(effect="unknown", status="unknown"),
    "a finding dropped": lambda a: a["report"]["findings"].pop(),
    "a finding too many": lambda a: a["report"]["findings"].append(finding("friction.run_in")),
    "a finding twice": lambda a: a["report"]["findings"].append(copy.deepcopy(first(a))),
    "channel": lambda a: first(a).update(channel="temperature"),
    "place of everything": lambda a: place(a)["conditions"].update(load_torque=[-1e4, 1e4]),
    "place of half": lambda a: place(a)["conditions"].update(temperature=[20, 29]),
    "place not told": lambda a: place(a)["conditions"].pop("velocity"),
    "direction": lambda a: place(a)["conditions"].update(direction="negative"),
    "recordings in the order of their names": lambda a: place(a).update(recordings=["d", "c"]),
    "recordings not told": lambda a: place(a).update(recordings=[]),
    "order off by one": lambda a: a["report"]["findings"][1]["location"].update(orders=[8.0, 49.0]),
    "orders by the dozen": lambda a: a["report"]["findings"][1]["location"]["orders"].extend(range(100, 110)),
    "window turned": lambda a: a["report"]["findings"][2]["location"].update(angle_windows=[[1.12, 1.32]]),
    "window of half a turn": lambda a: a["report"]["findings"][2]["location"].update(angle_windows=[[0.0, 3.1]]),
    "residual of a dropped fold": lambda a: a["own"]["residual"].update(motor_torque=1.08),
    "residual in the second channel": lambda a: a["own"]["residual"].update(transmission_error=1.2),
    "residual below the noise": lambda a: a["own"]["residual"].update(motor_torque=0.5, transmission_error=0.5),
    "no model": lambda a: a["own"].update(residual={}, why="there is no model.json"),
}


def scored(answer: Answer) -> CaseScore:
    return score(TRUTH, answer["report"], 1.0, recomputed=answer["own"])


def test_the_answer_itself_is_right() -> None:
    assert scored(right()).every_point_right


@pytest.mark.parametrize("name", MUTATIONS)
def test_each_mutation_costs_the_folder(name: str) -> None:
    answer = right()
    MUTATIONS[name](answer)
    assert not scored(answer).every_point_right


@pytest.mark.parametrize(
    ("value", "std", "error", "covered"), [(-0.2, 0.01, 2.0, False), (0.24, 0.01, 0.2, False), (0.24, 0.03, 0.2, True)]
)
def test_parameters_and_intervals_are_counted(value: float, std: float, error: float, covered: bool) -> None:
    answer = right()
    answer["own"]["parameters"] = {"friction.stribeck": {"f_s": [value, std]}}
    row = summarise("g", [scored(answer)])
    assert row.parameter_error == pytest.approx(error)
    assert row.coverage == (int(covered), 1)


def test_confidence_in_what_is_false_costs_brier() -> None:
    answer, bold = right(), right()
    for a, confidence in ((answer, 0.3), (bold, 0.98)):
        a["report"]["findings"].append(finding("friction.run_in", confidence=confidence))
    assert summarise("g", [scored(bold)]).brier > summarise("g", [scored(answer)]).brier + 0.1
