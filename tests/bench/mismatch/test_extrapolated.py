"""Validation points that the fitted recordings do not cover are fitted; the others stay held out."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.mismatch.recordings.dataset import Member
from bench.mismatch.recordings.extrapolated import fitted_too
from bench.mismatch.recordings.loading import load
from bench.simulation.frame import Frame, concatenate
from tests.bench.mismatch.test_folders import write
from tests.bench.simulation.terms.frames import frame

Point = tuple[float, float, float]
GRID: list[Point] = [
    (load, turn * speed, 25.0 + heat)
    for load in (-800.0, 0.0, 800.0)
    for speed in (0.05, 0.1, 0.15)
    for turn in (1.0, -1.0)
    for heat in (0.0, 4.0, 8.0)
]
INSIDE: list[Point] = [(300.0, 0.12, 27.0), (-300.0, -0.07, 29.0), (100.0, 0.08, 31.0)]


def members(fitted: list[Point], validation: list[Point]) -> list[Member]:
    every = [("constant_velocity", p) for p in fitted] + [("validation", p) for p in validation]
    out = []
    for number, (kind, point) in enumerate(every):
        recording: Any = SimpleNamespace(kind=kind)
        held = kind == "validation"
        out.append(Member(number, recording, (kind, *point), held, -1 if held else number, f"r{number}"))
    return out


def rows(points: list[Point]) -> Frame:
    one = frame()
    parts = []
    for number, (torque, speed, heat) in enumerate(points):
        changed = one.take(np.arange(50))
        changed.recording[:] = number
        changed.torque[:] = torque
        changed.velocity[:] = speed
        changed.direction[:] = np.sign(speed)
        changed.temperature[:] = heat
        parts.append(changed)
    return concatenate(parts)


def fitted(validation: list[Point]) -> tuple[list[Member], list[str]]:
    return fitted_too(members(GRID, validation), rows([*GRID, *validation]))


def test_points_between_the_others_are_held_out() -> None:
    changed, names = fitted(INSIDE)
    assert names == []
    assert [m.held_out for m in changed[-3:]] == [True, True, True]


def test_a_point_far_beyond_the_others_is_fitted_in_a_fold_of_its_own() -> None:
    """Twice the load that anything else was run at: its prediction would be an extrapolation."""
    changed, names = fitted([*INSIDE, (1600.0, 0.1, 29.0)])
    assert names == [f"r{len(GRID) + 3}"]
    assert [m.held_out for m in changed[-4:]] == [True, True, True, False]
    assert changed[-1].fold == 1 + max(m.fold for m in changed[:-1])


def test_the_farthest_first_and_no_more_than_half() -> None:
    """All four lie outside, each another way; the two farthest are fitted."""
    outside = [(1600.0, 0.1, 29.0), (0.0, 0.9, 29.0), (0.0, -0.1, 90.0), (-1700.0, -0.1, 29.0)]
    changed, names = fitted(outside)
    assert len(names) == 2
    assert sum(m.held_out for m in changed[-4:]) == 2
    assert not changed[len(GRID) + 1].held_out


def test_repeats_of_a_point_are_fitted_together() -> None:
    far = (1600.0, 0.1, 29.0)
    changed, names = fitted([*INSIDE, far, far])
    assert len(names) == 2
    assert changed[-1].fold == changed[-2].fold >= 0


def test_without_motion_nothing_changes() -> None:
    still = rows([*GRID, *INSIDE])
    still.direction[:] = 0.0
    before = members(GRID, INSIDE)
    assert fitted_too(before, still) == (before, [])


@pytest.mark.parametrize(
    ("channels", "kind"),
    [
        (("motor_angle", "load_torque"), "constant_velocity"),
        (("motor_angle", "temperature"), "constant_velocity"),
        (("load_angle",), "constant_velocity"),
        (("motor_angle", "load_angle"), "heating"),
    ],
)
def test_recordings_without_a_row_are_loaded(tmp_path: Path, channels: tuple[str, ...], kind: str) -> None:
    """No channel has rows; the report says of each why."""
    every = ("motor_angle", "load_angle", "motor_torque", "load_torque", "load_motor_torque", "temperature")
    for number in range(7):
        write(tmp_path, number, without=tuple(name for name in every if name not in channels), kind=kind)
    assert len(load(tmp_path).members) == 7
