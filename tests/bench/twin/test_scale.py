"""Scales are wide enough, per direction, and only of what enough recordings have."""

from __future__ import annotations

import numpy as np
import pytest

from bench.simulation.terms import MOTOR_TORQUE, TRANSMISSION_ERROR
from bench.twin.scale import CALIBRATION, scales
from bench.twin.streams import DIRECTION, MEAN, OFFSET, ORDER, Stream, streams

FORWARDS, BACKWARDS = (Stream(MOTOR_TORQUE, MEAN, side) for side in (1, -1))


def test_a_friction_off_from_the_beginning_is_no_change() -> None:
    rng = np.random.default_rng(4)
    first = [
        {FORWARDS if k % 2 else BACKWARDS: (0.3 if k % 2 else -0.3) + rng.normal(0.0, 0.01)} for k in range(CALIBRATION)
    ]
    table = scales(first, [Stream(MOTOR_TORQUE, OFFSET), Stream(MOTOR_TORQUE, DIRECTION)])
    along = table[Stream(MOTOR_TORQUE, DIRECTION)]
    assert along.change({FORWARDS: 0.3}) == pytest.approx(0.0, abs=0.01)
    # more drag both ways counts alike along the direction, and cancels in the mean as it is
    assert along.change({FORWARDS: 0.5}) == pytest.approx(0.2, abs=0.01)
    assert along.change({BACKWARDS: -0.5}) == pytest.approx(0.2, abs=0.01)
    assert table[Stream(MOTOR_TORQUE, OFFSET)].change({BACKWARDS: -0.5}) == pytest.approx(-0.2, abs=0.01)


def test_scales_are_too_small_almost_never() -> None:
    rng = np.random.default_rng(5)
    order = Stream(TRANSMISSION_ERROR, ORDER, 3)
    small = 0
    for _ in range(500):
        first = [{order: float(rng.normal(0.0, 2.0))} for _ in range(CALIBRATION)]
        small += scales(first, [order])[order].size < 2.0
    assert small <= 5  # 0.002 of 500, and room for chance


def test_too_few_recordings_make_no_scale() -> None:
    assert scales([{FORWARDS: 1.0}] * 5, [Stream(MOTOR_TORQUE, OFFSET)]) == {}


def test_weights_of_streams_sum_to_one_and_channels_are_alike() -> None:
    table = streams([TRANSMISSION_ERROR, MOTOR_TORQUE], [1, 3, 46])
    assert sum(table.values()) == pytest.approx(1.0)
    assert sum(w for s, w in table.items() if s.channel == MOTOR_TORQUE) == pytest.approx(0.5)
