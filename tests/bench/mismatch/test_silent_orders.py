"""At the orders of the load motor's ripple a prediction of the transmission error is silent."""

import numpy as np
import pytest

from bench.mismatch.prediction import Compared, silent
from bench.simulation.frame import ARRAYS, FloatArray, Frame

RATE, SPEED, NOISE = 500.0, 0.17, 1e-6


def recording(beyond: FloatArray, angle: FloatArray) -> Compared:
    """A little over a revolution at one speed, and what it has ``beyond`` (n,) a prediction of nothing."""
    ones = np.ones(angle.size)
    values = {name: np.zeros(angle.size) for name in ARRAYS} | {"q": angle, "theta": angle, "velocity": SPEED * ones}
    values |= {"direction": ones, "last_direction": ones, "steady": ones, "elapsed": angle / SPEED}
    frame = Frame(ratio=185.0, **values | {"recording": np.zeros(angle.size, dtype=np.int64)})
    return Compared(beyond, ones > 0.0, frame, None)


def test_what_the_ripple_makes_of_the_transmission_error_stands_in_its_prediction() -> None:
    rng = np.random.default_rng(1)
    angle: FloatArray = np.arange(20_000, dtype=np.float64) * (SPEED / RATE)
    noise = NOISE * rng.normal(size=angle.size)
    nothing = np.zeros(angle.size)
    ripple = 8e-7 * np.sin(150.0 * angle + 0.3) + 4e-7 * np.cos(300.0 * angle)
    found = silent(recording(ripple + noise, angle), nothing, (150.0, 300.0))
    assert found == pytest.approx(ripple, abs=0.1 * NOISE)
    assert not silent(recording(ripple + noise, angle), nothing, ()).any()
    # an order of the gearbox that a prediction lacks stays in what it leaves
    other = 5e-6 * np.sin(92.0 * angle)
    assert np.std(silent(recording(other + noise, angle), nothing, (150.0, 300.0))) < 0.02 * np.std(other)
