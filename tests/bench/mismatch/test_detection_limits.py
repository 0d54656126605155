"""What recordings could not have shown, as the report says it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.mismatch.detection_limits import limits, one_way
from tests.bench.mismatch.report import made


def outcome(backwards: float, channel: str = "motor_torque") -> Any:
    """Revolutions of which a share goes ``backwards``."""
    frame = made.revolutions((0.1,), (0.0,), 1000)
    direction = np.where(np.arange(frame.size) < backwards * frame.size, -1.0, 1.0)
    rows = SimpleNamespace(frame=replace(frame, direction=direction), number=np.full(frame.size, 4.0))
    every = np.ones(frame.size, dtype=bool)
    return SimpleNamespace(channel=channel, rows=rows, usable=every, held_out=~every, floor=0.03)


@pytest.mark.parametrize(("backwards", "told"), [(0.0, "all"), (0.03, "0.97"), (0.98, "0.98"), (0.1, ""), (0.5, "")])
def test_motion_that_goes_one_way_tells_no_friction(backwards: float, told: str) -> None:
    said = one_way(outcome(backwards))
    if not told:
        assert said == []
        return
    (sentence,) = said
    assert sentence.startswith(f"motor_torque: {told} of the compared motion goes one way, so friction is not told")


def test_only_of_the_motor_torque_and_of_what_is_compared() -> None:
    assert one_way(outcome(0.0, "transmission_error")) == []
    nothing = outcome(0.0)
    nothing.usable[:] = False
    assert one_way(nothing) == []


def test_orders_of_the_output_are_not_denied_where_functions_of_the_angle_are_found() -> None:
    data: Any = SimpleNamespace(linear=False, output={}, members=[], shaft=[])
    swings = outcome(0.5)
    frame = swings.rows.frame
    # half a revolution each way in a thousand rows
    swings.rows.frame = replace(frame, theta=0.5 * frame.theta, recording=np.zeros(frame.size, dtype=np.int64))
    said = limits(swings, data)
    assert "nor orders below 6, which are parts of functions of the angle, or above 667 per output revolution" in said
    swings.rows.frame = replace(frame, theta=0.0 * frame.theta)
    assert "nor single orders of the output, but for functions of the angle" in limits(swings, data)
    assert "once a revolution" not in said
