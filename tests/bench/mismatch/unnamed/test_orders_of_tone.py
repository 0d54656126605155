"""Orders that a tone makes, and those that it does not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.periodic import Periodic
from bench.mismatch.orders.revolutions import Revolution
from bench.mismatch.orders.weak import WeakOrder
from bench.mismatch.unnamed.orders_of_tone import made_by_tone, tone_on_rows
from bench.mismatch.unnamed.tones import Tone
from tests.bench.mismatch.orders.test_reaction import NOTHING
from tests.bench.mismatch.regression.synthetic import campaign

AMPLITUDE = 2e-6
SPEED = 0.1
HERTZ = 40.0 * SPEED / (2.0 * np.pi)
"""of order 40 at that speed"""


def heard(frequency: float) -> Tone:
    return Tone(frequency, 0.0005, AMPLITUDE, 1e-8, 1e-4, ())


def turning() -> list[Revolution]:
    """Forward at one speed, backward at two others."""
    velocities = [SPEED, SPEED, SPEED, -0.05, -0.05, -0.17, -0.17]
    return [
        Revolution(k, slice(0, 1), 0.0, v, 30.0, 60.0 * k, float(np.sign(v)), 1.0, 2.0 * np.pi / abs(v))
        for k, v in enumerate(velocities)
    ]


def made(order: float, factors: tuple[str, ...], amplitude: float, frequency: float = HERTZ) -> tuple[float, ...]:
    k = len(factors)
    weak = WeakOrder(order, factors, np.full(k, amplitude, dtype=np.complex128), np.zeros(k), 0.0)
    model = SimpleNamespace(
        periodic=Periodic(NOTHING, weak=(weak,)),
        seen=SimpleNamespace(orders=(1.0, order)),
        given=SimpleNamespace(orders=(1.0,), notch=()),
        training_revolutions=turning(),
    )
    return made_by_tone(cast("Any", model), heard(frequency))


def test_an_order_that_acts_where_a_tone_has_its_frequency_may_be_the_tones() -> None:
    assert made(40.0, ("p",), 0.8 * AMPLITUDE) == (40.0,)


@pytest.mark.parametrize(("order", "amplitude"), [(42.0, 0.14), (44.0, 0.07)])
def test_so_may_one_to_which_it_leaks(order: float, amplitude: float) -> None:
    assert made(order, ("p",), amplitude * AMPLITUDE) == (order,)
    assert made(order, ("p",), 3.0 * amplitude * AMPLITUDE) == ()


def test_none_is_that_acts_at_other_speeds_as_well() -> None:
    assert made(40.0, ("p", "n"), 0.8 * AMPLITUDE) == ()


def test_none_is_that_is_larger_than_the_tone() -> None:
    assert made(40.0, ("p",), 1.2 * AMPLITUDE) == ()


def test_none_is_of_another_frequency() -> None:
    assert made(40.0, ("p",), 0.8 * AMPLITUDE, 1.5 * HERTZ) == ()


def test_a_tone_is_taken_off_each_recording_with_its_own_phase() -> None:
    frame, rng = campaign(6), np.random.default_rng(1)
    phase = rng.uniform(0.0, 2.0 * np.pi, 6)[frame.recording]
    wave = AMPLITUDE * np.sin(2.0 * np.pi * 0.237 * frame.time + phase)
    inside = frame.recording != 2
    model = SimpleNamespace(
        periodic=Periodic(NOTHING),
        rows=SimpleNamespace(frame=frame, number=frame.count, size=frame.size),
        without_offset=wave + 1e-9 * rng.normal(size=frame.size),
        inside=inside,
    )
    found = tone_on_rows(cast("TransmissionModel", model), heard(0.237), ())
    assert not found[~inside].any()
    assert np.sqrt(np.mean((found - wave)[inside] ** 2)) < 0.1 * AMPLITUDE
