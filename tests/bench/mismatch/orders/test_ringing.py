"""Rows in which a resonance still rings after the speed has changed."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bench.mismatch.orders.ringing import ringing, rings_for
from bench.simulation.frame import ARRAYS, Frame
from bench.simulation.laws import RESONANCE, Law

NATURAL, DAMPING, SHARE, SIZE, NOISE = 15.0, 0.1, 0.5, 4e-5, 1e-8


def mode(effect: str = RESONANCE) -> Law:
    return Law(effect, "second_order", (NATURAL, DAMPING, SHARE), 0.0, (27.0,), np.ones(1, dtype=np.complex128))


def series() -> Any:
    return SimpleNamespace(amplitude={1: np.array([[0.0] * 9 + [SIZE]])})


def test_it_lasts_until_a_mass_that_is_let_go_is_as_quiet_as_the_noise() -> None:
    seconds = rings_for([mode()], series(), NOISE)
    time = np.linspace(0.0, 2.0 * seconds, 4000)
    swing = solve_ivp(
        lambda t, y: [y[1], -2.0 * DAMPING * NATURAL * y[1] - NATURAL**2 * y[0]],
        (0.0, time[-1]),
        [SHARE * SIZE, 0.0],
        t_eval=time,
        rtol=1e-9,
        atol=1e-15,
    ).y[0]
    loud = time[np.abs(swing) > NOISE].max()
    assert 0.8 * seconds < loud < 1.1 * seconds
    assert rings_for([mode("te.drift_time")], series(), NOISE) == 0.0


def of_two(**columns: Any) -> Frame:
    """Two recordings of ten rows, a second each."""
    values: dict[str, Any] = {name: np.zeros(20) for name in ARRAYS}
    values |= {"elapsed": np.tile(np.arange(10.0), 2), "recording": np.repeat([0, 1], 10), "steady": np.ones(20)}
    values |= {name: np.asarray(column) for name, column in columns.items()}
    return Frame(ratio=185.0, **cast("Any", values))


@pytest.mark.parametrize(("seconds", "first"), [(0.0, [0, 0]), (3.0, [5, 0])])
def test_rows_after_a_change_of_speed_ring_and_those_of_another_recording_do_not(
    seconds: float, first: list[int]
) -> None:
    """The first recording sets out and is steady from 2 s on; the second is steady throughout."""
    frame = of_two(steady=[0.0, 0.4, 0.9, *np.ones(17)], last_direction=np.repeat([1.0, -1.0], 10))
    rings = ringing(frame, seconds).reshape(2, 10)
    assert [int(own.sum()) for own in rings] == first
    assert not rings[0, first[0] :].any()


def test_rows_after_a_reversal_ring_though_the_segment_is_called_steady() -> None:
    rings = ringing(of_two(last_direction=np.repeat([1.0, -1.0, 1.0], [4, 9, 7])), 3.0)
    assert np.flatnonzero(rings).tolist() == [4, 5, 6, 13, 14, 15]
