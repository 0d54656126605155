"""Places must be told, and told tightly: every entry alone can spoil the place."""

from __future__ import annotations

from typing import Any

import pytest

from bench.proof.location import misplaced, overlap
from tests.bench.proof.test_score import concealed, finding

SPAN = {"velocity": (0.0, 0.18), "load_torque": (-1000.0, 1000.0), "temperature": (20.0, 50.0)}
SLOW: dict[str, Any] = {
    "conditions": {"velocity": [0.0, 0.1]},
    "core": {"velocity": [0.0, 0.04]},
    "measured": {"velocity": (0.0, 0.17), "load_torque": (-600.0, 1000.0), "temperature": (22.0, 50.0)},
    "span": SPAN,
    "measured_direction": "both",
    "recordings": {"a": 60.0, "b": 30.0, "c": 9.0, "d": 1.0},
}
TOLD: dict[str, Any] = {
    "conditions": {
        "velocity": [0.0, 0.05],
        "load_torque": [-1000, 1000],
        "temperature": [20, 50],
        "direction": "both",
    },
    "recordings": ["a", "b.h5"],
}


def wrong(true: dict[str, Any], told: dict[str, Any], effect: str = "friction.stribeck") -> list[str]:
    return misplaced(concealed(effect, location=true), finding(effect, location=told))


def test_a_tight_place_is_right() -> None:
    assert wrong(SLOW, TOLD) == []


@pytest.mark.parametrize(
    ("changed", "complaint"),
    [
        ({"velocity": [0.0, 0.0005]}, "velocity"),
        ({"velocity": [0.1, 0.18]}, "velocity"),
        ({"velocity": None}, "velocity"),
        ({"load_torque": [-1000, -100]}, "load_torque"),
        ({"load_torque": None}, "load_torque"),
        ({"load_torque": [-10000, 10000]}, "load_torque"),
        ({"temperature": [20, 30]}, "temperature"),
        ({"direction": "positive"}, "direction"),
        ({"direction": None}, "direction"),
    ],
)
def test_each_condition_alone_can_be_wrong(changed: dict[str, Any], complaint: str) -> None:
    told = TOLD | {"conditions": {k: v for k, v in (TOLD["conditions"] | changed).items() if v is not None}}
    assert wrong(SLOW, told) == [complaint]


def test_an_effect_of_lost_motion_is_not_at_the_whole_campaign() -> None:
    lost = {
        "conditions": {"load_torque": [-240.0, 240.0]},
        "core": {"load_torque": [-80.0, 80.0]},
        "measured": SLOW["measured"] | {"load_torque": (-300.0, 300.0)},
        "span": SPAN,
        "measured_direction": "both",
    }
    whole = TOLD["conditions"] | {"velocity": [0.0, 0.18]}
    assert wrong(lost, {"conditions": whole | {"load_torque": [-1010.0, 1010.0]}}) == ["load_torque"]
    assert wrong(lost, {"conditions": whole | {"load_torque": [-100.0, 100.0]}}) == []


@pytest.mark.parametrize(
    ("told", "right"),
    [(["a"], True), (["a", "b"], True), (["a", "c"], False), (["d"], False), ([], False), (["a", "a", "b"], True)],
)
def test_recordings_are_the_strongest(told: list[str], right: bool) -> None:
    assert wrong(SLOW, TOLD | {"recordings": told}) == ([] if right else ["recordings"])


@pytest.mark.parametrize(
    ("true", "told", "right"),
    [
        ([48.0], [48.0], True),
        ([48.0], [48.3], True),
        ([48.0], [49.0], False),
        ([48.0], [], False),
        ([45.0, 47.0], [45.0, 47.0], True),
        ([45.0, 47.0], [40.0, 41.0, 42.0, 45.0], False),
        ([], [3.0], True),
    ],
)
def test_orders(true: list[float], told: list[float], right: bool) -> None:
    assert wrong({"orders": true}, {"orders": told}) == ([] if right else ["orders"])


@pytest.mark.parametrize(
    ("told", "right"),
    [
        ([[6.2, 6.4]], True),
        ([[6.25, 0.07]], True),
        ([[6.2, 6.3], [6.3, 6.4]], True),
        ([[6.4, 6.6]], False),
        ([[5.8, 6.8]], False),
        ([], False),
    ],
)
def test_windows_overlap_by_half(told: list[list[float]], right: bool) -> None:
    place = {"angle_windows": [[6.2, 6.4]], "core_windows": [[6.25, 6.35]]}
    assert wrong(place, {"angle_windows": told}, "te.local_defect") == ([] if right else ["angle_windows"])


def test_only_a_function_of_the_angle_may_be_told_as_orders() -> None:
    place, orders = {"angle_windows": [[1.0, 2.0]]}, {"orders": [1.0, 2.0]}
    assert wrong(place, orders, "te.local_defect") == ["angle_windows"]
    assert wrong(place, orders, "friction.position_dependent") == []


def test_overlap_of_ranges() -> None:
    assert overlap((0.0, 2.0), (1.0, 3.0)) == pytest.approx(1.0 / 3.0)
    assert overlap((0.0, 1.0), (2.0, 3.0)) == 0.0
    assert overlap((1.0, 1.0), (1.0, 1.0)) == 1.0
