"""The motor's ripple in the load torque is no effect of its own; other scatter there is."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.mismatch.recordings.vibration import Density
from bench.mismatch.unnamed.passed_on import line_power, without_passed_on

RATE, STEP, NOISE, ORDER = 2000.0, 0.1, 0.01, 4440.0
TURNING = 0.0167
"""revolutions a second of the output: the ripple is at 74 Hz"""


def heard(size: float, order: float, turning: float = TURNING) -> Density:
    """Noise, and a line of a mean square at an order of the output."""
    rng = np.random.default_rng(int(1e6 * turning))
    power = NOISE * rng.exponential(size=int(RATE / 2 / STEP) + 1)
    at = round(order * turning / STEP)
    if at < power.size:
        power[at] += size / STEP
    return Density(0, power, STEP, 3.0, RATE, turning)


def outcomes(rms: float, ripple: tuple[float, ...]) -> tuple[Any, Any]:
    left = SimpleNamespace(effect="unknown", gain=0.0, parameters=({"symbol": "rms", "value": rms},))
    other = SimpleNamespace(effect="load.unbalance", gain=30.0, parameters=())
    found = [SimpleNamespace(effect="motor.torque_ripple", orders=ripple)] if ripple else []
    return SimpleNamespace(discoveries=[left, other], notes=[]), SimpleNamespace(discoveries=found)


def test_a_line_is_as_strong_as_it_is() -> None:
    assert line_power(heard(4.0, ORDER), ORDER) == pytest.approx(4.0, rel=0.03)
    assert line_power(heard(0.0, ORDER), ORDER) < 0.05
    # beyond the band of the recording there is none to be seen
    assert line_power(heard(4.0, ORDER, 0.2), ORDER) == 0.0


@pytest.mark.parametrize(
    ("ripple", "order", "goes"), [((ORDER,), ORDER, True), ((ORDER,), 1000.0, False), ((), ORDER, False)]
)
def test_what_lies_at_the_ripples_orders_is_the_ripples(ripple: tuple[float, ...], order: float, goes: bool) -> None:
    load, motor = outcomes(2.0, ripple)
    without_passed_on(load, motor, [heard(3.6, order, turning) for turning in (0.01, 0.0167, 0.02)])
    assert [d.effect for d in load.discoveries] == (["load.unbalance"] if goes else ["unknown", "load.unbalance"])
    assert bool(load.notes) == goes
    if goes:
        assert "1.9 N*m rms" in load.notes[0]
