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
    assert {"stack_released", "play_kept", "forgetting"} <= set(sensor)


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
