"""Loops over a torque, of the transmission and of the torque sensor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.simulation.terms.loops import NARROWEST_STACK, STACK, WIDEST
from bench.simulation.terms.sensor import torque_hysteresis as of_sensor
from bench.simulation.terms.te import hysteresis as of_transmission
from tests.bench.mismatch.regression.synthetic import campaign

LARGEST = 1000.0
FRAME = replace(
    campaign(8),
    torque_level=LARGEST * np.sin(np.arange(8 * 30) / 7.0),
    load_motor_level=LARGEST * np.sin(np.arange(8 * 30) / 7.0),
)


def test_loops_of_sensor_and_transmission_have_the_same_forms() -> None:
    sensor = [form.name.replace("dahl", "bouc_wen") for form in of_sensor.LOOPS.forms()]
    assert sensor == [form.name for form in of_transmission.LOOPS.forms()]
    assert {"stack_released", "play_kept", "forgetting", "pair_kept", "dithered_released"} <= set(sensor)


def test_no_play_of_the_sensors_stack_is_so_wide_that_it_looks_like_a_gain() -> None:
    widths = [w for (w,) in of_sensor.LOOPS.widths_of_a_stack(FRAME)]
    assert min(widths) == pytest.approx(NARROWEST_STACK * LARGEST, rel=0.01)
    assert max(STACK) * max(widths) <= WIDEST * LARGEST * 1.001


@pytest.mark.parametrize("loops", [of_sensor.LOOPS, of_transmission.LOOPS])
def test_a_stack_is_the_sum_of_its_plays(loops: of_sensor.Loops) -> None:
    forms = {form.name: form for form in loops.forms()}
    middle = 150.0
    stack = forms["stack_released"].columns(FRAME, (middle,))
    plays = [forms["play_released"].columns(FRAME, (share * middle,))[:, 0] for share in STACK]
    assert stack == pytest.approx(np.column_stack(plays))


@pytest.mark.parametrize("loops", [of_sensor.LOOPS, of_transmission.LOOPS])
def test_a_pair_is_two_plays(loops: of_sensor.Loops) -> None:
    forms = {form.name: form for form in loops.forms()}
    pair = forms["pair_kept"].columns(FRAME, (150.0, 5.0))
    plays = [forms["play_kept"].columns(FRAME, (w,))[:, 0] for w in (30.0, 150.0)]
    assert pair == pytest.approx(np.column_stack(plays))
    assert all(ratio > 1.0 and w <= WIDEST * LARGEST * 1.001 for w, ratio in forms["pair_kept"].grid(FRAME))


@pytest.mark.parametrize("loops", [of_sensor.LOOPS, of_transmission.LOOPS])
def test_a_dithered_loop_forgets_with_the_angle_and_not_at_rest(loops: of_sensor.Loops) -> None:
    """What it forgets in a turn is the same at any speed."""
    form = {form.name: form for form in loops.forms()}["dithered"]
    level = np.where(FRAME.elapsed > FRAME.elapsed[1], LARGEST, 0.0)
    kept = replace(FRAME, torque_level=level, load_motor_level=level)
    rows = slice(3, 20)
    rest = form.columns(replace(kept, velocity=np.zeros(FRAME.size)), (200.0, 0.5))[rows, 0]
    assert rest == pytest.approx(rest[0])
    assert rest[0] > 0.9
    for speed in (0.05, -0.2):
        turning = form.columns(replace(kept, velocity=np.full(FRAME.size, speed)), (200.0, 0.5))[rows, 0]
        angle = abs(speed) * (FRAME.elapsed[rows] - FRAME.elapsed[3])
        assert turning / turning[0] == pytest.approx(np.exp(-0.5 * angle), rel=1e-6)
