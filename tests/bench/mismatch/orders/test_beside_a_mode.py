"""Orders that pass a mode which they are found beside, and a pulse that does not pass it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.mismatch.orders.discoveries import discoveries
from bench.mismatch.orders.model import GivenOrders, TransmissionModel, begun
from bench.mismatch.orders.periodic import Pulse
from bench.mismatch.orders.turns import find_orders
from bench.mismatch.recordings.rows import Rows
from bench.simulation.laws import resonant
from tests.bench.mismatch.report import made

KNOWN = (2.0, 46.0, 92.0, 138.0)
WEAK = (7.0, 31.0, 58.0, 77.0, 111.0, 132.0, 188.0, 223.0, 287.0)
SPEEDS, TORQUES = (0.03, 0.06, 0.1, 0.16), (-700.0, 0.0, 700.0)
EACH, NOISE = 3000, 2.5e-6
MODE = (12.0, 0.06, 0.15)
PULSE = Pulse(2.1, 0.03, 1e-5)


def model(pulses: tuple[Pulse, ...]) -> TransmissionModel:
    """A gearbox whose orders pass a mode, and some pulses that do not pass it."""
    rng, frame = np.random.default_rng(5), made.revolutions(SPEEDS, TORQUES, EACH)
    y = NOISE * rng.normal(size=frame.size)
    for order in (*KNOWN, *WEAK):
        size = 1e-5 if order in KNOWN else 3e-6
        vector = size * np.exp(2j * np.pi * rng.random()) * resonant("second_order", order * frame.velocity, MODE)
        y += vector.real * np.sin(order * frame.theta) + vector.imag * np.cos(order * frame.theta)
    y += sum((p.evaluate(frame.theta) for p in pulses), np.zeros(frame.size))
    number = len(SPEEDS) * len(TORQUES) * 2
    none = np.zeros(frame.size)
    rows = Rows(frame, y, np.ones(frame.size), none, none, none)
    out = begun(rows, np.arange(number) % 6 - 1, GivenOrders(KNOWN), ())
    out.quiet = y
    find_orders(out, y, 0)
    return out


@pytest.mark.parametrize("pulses", [(), (PULSE,)])
def test_orders_are_found_under_the_mode_and_a_pulse_beside_it(pulses: tuple[Pulse, ...]) -> None:
    own = model(pulses)
    teeth: Any = SimpleNamespace(ratio=185.0, z1=24, z2=96, z3=45, z4=46)
    told = {d.effect: d for d in discoveries(own, teeth, 0)}
    assert set(told) == {"te.resonance", "te.harmonic", *(["te.local_defect"] if pulses else [])}
    assert sorted(told["te.harmonic"].orders) == sorted(WEAK)
    numbers = [row["value"] for row in told["te.resonance"].parameters]
    assert numbers == pytest.approx(MODE, rel=0.1)
    assert own.periodic is not None
    if pulses:
        ((begin, end),) = told["te.local_defect"].angle_windows
        assert begin < PULSE.angle < end
        # the model has the mode that is told, as it is beside the pulse
        assert own.periodic.laws[0].point == pytest.approx(numbers)
    left = own.rows.y - own.periodic.evaluate(own.rows.frame)
    assert np.sqrt(np.mean(left**2)) < 1.05 * NOISE
