"""Held-out points: those that the others spare."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from bench.mismatch.recordings.split import _leverage, _spread, none_spared, split

FORWARD = [("constant_velocity", load, 0.1, 8.0, -1) for load in (-900.0, -500.0, 0.0, 500.0, 900.0)]
BACK = [
    ("constant_velocity", load, -speed, heat, -1)
    for load in (-900.0, -450.0, 0.0, 450.0, 900.0)
    for speed in (0.05, 0.1, 0.17)
    for heat in (6.0, 8.0, 11.0)
]


def test_a_direction_with_few_points_keeps_them() -> None:
    """Five points one way and forty-five the other, in turn: a fifth is held out, of the many."""
    members = [p for k, p in enumerate(BACK) for p in ([p, FORWARD[k // 9]] if k % 9 == 4 else [p])]
    held = _spread(members, 10)
    assert len(set(held)) == 10
    assert sum(p[2] > 0 for p in held) <= 1


def test_a_point_without_a_like_speaks_for_itself_alone() -> None:
    """The only hot point is not spared."""
    hot = ("constant_velocity", 0.0, -0.1, 30.0, -1)
    alone = _leverage([*BACK, hot])
    assert alone[hot] > 2.0 * max(alone[p] for p in BACK)
    assert hot not in _spread([*BACK, hot], 6)


def recorded(kind: str, load: float, speed: float = 0.1) -> Any:
    return SimpleNamespace(kind=kind, setpoint=SimpleNamespace(load_torque=load, velocity=speed, temperature=25.0))


def test_whole_points_are_held_out_and_no_kind_of_which_there_are_few() -> None:
    """A fifth of fifteen points, beside the validation; the repeats of a point, the ramps and the warm-up all train."""
    points = [recorded("constant_velocity", 100.0 * k, 0.01 * (k + 1)) for k in range(15)]
    repeats = [recorded("constant_velocity", 0.0, 0.01) for _ in range(2)]
    few = [recorded("torque_ramp", 600.0), recorded("heating", 383.0)]
    held, folds = split([*points, *repeats, *few, recorded("validation", 150.0)])
    assert sum(held[:15]) == 3
    assert held[15:] == [False, False, False, False, True]
    assert not held[0]
    assert all((fold < 0) == out for fold, out in zip(folds, held, strict=True))
    # repeats of a point are left out together
    assert folds[0] == folds[15] == folds[16]


def test_small_loads_are_operating_points_of_their_own() -> None:
    """A servo of less than 1 N·m: seventeen loads, three times each, are no two points."""
    loads = [0.04 * k for k in range(18)]
    held, folds = split([recorded("free", load) for load in loads for _ in range(3)])
    assert sum(held) == 12
    assert all(len(set(held[k : k + 3])) == 1 for k in range(0, len(held), 3))
    assert len({fold for fold in folds if fold >= 0}) == 14


def test_it_is_said_why_nothing_is_held_out() -> None:
    recordings = [recorded("free", load) for load in (0.0, 0.5) for _ in range(5)]
    assert not any(split(recordings)[0])
    said = none_spared(recordings)
    assert said.startswith("nothing could be held out: 10 recordings of kind 'free' at 2 operating points; it takes 6")


@pytest.mark.parametrize("alone", [0, 1, 2, 3, 4, 5])
def test_where_few_points_stand_alone_others_are_held_out_with_their_repeats(alone: int) -> None:
    """Twenty points; a fifth of them is held out, whichever."""
    repeated = [recorded("constant_velocity", 100.0 * k) for k in range(20 - alone)]
    single = [recorded("constant_velocity", 50.0 + 100.0 * k) for k in range(alone)]
    points = [*repeated, *repeated, *single]
    held, _ = split(points)
    assert len({p.setpoint.load_torque for p, out in zip(points, held, strict=True) if out}) == 4
    assert any(held[: 2 * len(repeated)]) is (alone < 4)
