"""A pulse is told by its size where it acts, however many orders stand beside it."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.orders.defects import Defect
from bench.mismatch.orders.model import GivenOrders, TransmissionModel
from bench.mismatch.orders.periodic import Periodic, Pulse
from bench.mismatch.orders.reported import of_pulses
from bench.mismatch.orders.revolutions import Revolution
from bench.mismatch.orders.series import calibrate
from bench.mismatch.orders.weak import WeakOrder
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.noise import Mixture
from bench.simulation.frame import ARRAYS, FloatArray, Frame

NOISE = 4e-6
KNOWN = (1.0, 3.0, 6.0, 9.0, 14.0, 19.0, 46.0, 92.0, 138.0)
WEAK = tuple(float(f) for f in range(2, 150) if f % 2 == 0 and f not in KNOWN)
"""half of all orders that the pulse has a part in"""


def model(orders: tuple[float, ...] = WEAK) -> TransmissionModel:
    """Two revolutions of a gearbox with some weak orders beside those of its simulation."""
    each = 5236
    theta = np.tile(np.linspace(0.0, 2.0 * np.pi, each, endpoint=False), 2)
    values: dict[str, FloatArray] = {name: np.zeros(theta.size) for name in ARRAYS}
    values |= {"theta": theta, "velocity": np.full(theta.size, 0.1), "last_direction": np.ones(theta.size)}
    values |= {"recording": np.repeat(np.arange(2), each)}
    rows = Rows(Frame(ratio=185.0, **values), np.zeros(theta.size), np.ones(theta.size))  # type: ignore[arg-type]
    revolutions = [Revolution(k % 2, slice(0, 0), 100.0 * k, 0.1, 25.0, 0.0, 1.0, 1.0, 60.0) for k in range(12)]
    vectors = np.full((len(revolutions), len(KNOWN)), 5e-6 + 0j)
    weak = tuple(WeakOrder(f, ("1",), np.array([1e-6 + 0j]), np.array([1e-18]), 100.0) for f in orders)
    inside, train, folds = (
        np.ones(theta.size, dtype=bool),
        np.ones(len(revolutions), dtype=bool),
        np.zeros(2, dtype=np.int64),
    )
    out = TransmissionModel(rows, inside, revolutions, train, GivenOrders(KNOWN), folds, ())
    out.periodic = Periodic(calibrate(revolutions, vectors, np.full(vectors.shape, 1e-8), KNOWN), weak)
    out.noise = Mixture(NOISE**2, (), 500.0)
    return out


def defect(angle: float, height: float) -> Defect:
    """A damaged place of 10 mrad."""
    pulse = Pulse(angle, 0.01, height)
    return Defect(pulse, (pulse,), 400.0, 1e-4)


@pytest.mark.parametrize("angle", [4.92, 0.01])
def test_a_narrow_pulse_is_told_among_dozens_of_orders(angle: float) -> None:
    """As high as the noise of a sample; also where it lies across the zero of the angle."""
    told = of_pulses(model(), [defect(angle, NOISE)])
    assert told is not None
    assert told.excess is not None
    alone = of_pulses(model(()), [defect(angle, NOISE)])
    assert alone is not None
    assert alone.excess is not None
    # its place is where it lies beyond the simulation; what it adds is beside the orders that were found as well
    np.testing.assert_allclose(told.excess, alone.excess)
    assert np.mean(told.added**2) < 0.7 * np.mean(alone.added**2)


def test_a_pulse_far_below_the_noise_is_not_told() -> None:
    assert of_pulses(model(), [defect(4.92, 0.1 * NOISE)]) is None
