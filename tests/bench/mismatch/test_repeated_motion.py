"""Recordings held out that repeat a motion of fitted ones say nothing of another motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.recordings.repeated_motion import repeats
from bench.simulation.frame import ARRAYS, FloatArray, Frame, concatenate

ROWS, STEP = 500, 0.05


def recording(number: int, phase: float, rates: tuple[float, ...], size: int = ROWS) -> Frame:
    time = STEP * np.arange(size)
    values: dict[str, FloatArray] = {name: np.zeros(size) for name in ARRAYS}
    noise = 0.02 * np.random.default_rng(number).normal(size=size)
    values |= {"elapsed": time, "velocity": sum(np.cos(r * (time + phase)) for r in rates) + noise}
    return Frame(ratio=1.0, **values | {"recording": np.full(size, number, dtype=np.int64)})  # type: ignore[arg-type]


SAME = (0.9, 2.3, 3.7)


@pytest.mark.parametrize(
    ("held", "again"),
    [
        (recording(3, 0.0, SAME), True),
        (recording(3, 4.0, SAME, ROWS // 2), True),
        (recording(3, 0.0, (1.1, 2.9, 3.2)), False),
    ],
)
def test_the_same_motion_is_recognised_wherever_it_begins(held: Frame, again: bool) -> None:
    fitted = [recording(n, 0.1 * n, SAME) for n in range(3)]
    assert bool(repeats(concatenate([*fitted, held]), {3})) == again


def test_a_motion_of_another_size_or_at_rest_is_another() -> None:
    fitted = [recording(n, 0.0, SAME) for n in range(3)]
    larger = replace(recording(3, 0.0, SAME), velocity=1.7 * fitted[0].velocity)
    assert repeats(concatenate([*fitted, larger]), {3}) == []
    resting = replace(larger, velocity=np.zeros(ROWS))
    assert repeats(concatenate([*fitted, resting]), {3}) == []
    assert repeats(concatenate(fitted), set()) == []


def test_a_motion_in_which_another_joint_moves_otherwise_is_another() -> None:
    frame = concatenate([recording(n, 0.0, SAME) for n in range(4)])
    angle = np.sin(0.7 * frame.elapsed)
    assert repeats(replace(frame, aux={"other joint": angle}), {3})
    otherwise = np.where(frame.recording == 3, np.cos(1.3 * frame.elapsed), angle)
    assert repeats(replace(frame, aux={"other joint": otherwise}), {3}) == []
