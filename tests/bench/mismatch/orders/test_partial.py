"""Half revolutions: what they say of orders at a speed at which no whole revolution was made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bench.mismatch.orders.partial import refined
from bench.mismatch.orders.revolutions import Complex, Revolution
from bench.mismatch.orders.series import Series, calibrate
from bench.mismatch.recordings.rows import Rows
from bench.simulation.frame import ARRAYS, FloatArray, Frame

ORDERS = (1.0, 4.0, 7.0)
SIZES = np.array([50e-6, 15e-6, 9e-6])
NOISE = 0.3e-6
SPEEDS = (0.1, 0.17)
SLOW = 0.05
HALF = 2600
"""rows of half a revolution"""


def true(velocity: float, torque: float) -> Complex:
    """Vectors of the orders: amplitudes that fall with speed along a parabola, which two speeds cannot tell."""
    fast = abs(velocity) - 0.135
    size = SIZES * (1.0 - 2.5 * fast + 20.0 * fast**2 + 0.1 * torque / 1000.0)
    return np.asarray(size * np.exp(1j * np.array([0.2, -1.0, 2.0])))


def turn(velocity: float, torque: float, rows: slice = slice(0, 0)) -> Revolution:
    """A steady segment one way."""
    return Revolution(0, rows, torque, velocity, 25.0, 0.0, 1.0, 1.0, 60.0)


def calibrated(seed: int = 0, parts: Sequence[Revolution] = ()) -> Series:
    """The series from whole revolutions at two speeds."""
    rng = np.random.default_rng(seed)
    revolutions = [turn(v, tau) for v in SPEEDS for tau in (-800.0, -300.0, 0.0, 300.0, 800.0)]
    noise = 0.005e-6
    drawn = rng.normal(size=(2, len(revolutions), len(ORDERS)))
    vectors = np.array([true(t.velocity, t.torque) for t in revolutions]) + noise * (drawn[0] + 1j * drawn[1])
    return calibrate(revolutions, vectors, np.full(vectors.shape, noise), ORDERS, parts=parts)


def half(seed: int = 1, level: float = 3e-6) -> tuple[Rows, FloatArray]:
    """Half a revolution at the slow speed, with a level and a drift of its own."""
    rng = np.random.default_rng(seed)
    theta = np.linspace(1.0, 1.0 + np.pi, HALF)
    values: dict[str, FloatArray] = {name: np.zeros(HALF) for name in ARRAYS}
    values |= {"theta": theta, "velocity": np.full(HALF, SLOW), "last_direction": np.ones(HALF)}
    values |= {"temperature": np.full(HALF, 25.0), "recording": np.zeros(HALF, dtype=np.int64)}
    frame = Frame(ratio=185.0, **values)  # type: ignore[arg-type]
    own = true(SLOW, 0.0)
    waves = [v.real * np.sin(f * theta) + v.imag * np.cos(f * theta) for f, v in zip(ORDERS, own, strict=True)]
    y = np.sum(waves, axis=0) + level + 1e-6 * (theta - theta[0]) + NOISE * rng.normal(size=HALF)
    return Rows(frame, y, np.ones(HALF)), y


def error(series: Series) -> float:
    """How far the series is off at the slow speed, rad."""
    told = series.vectors(np.array([[0.0, SLOW, 25.0]]), np.ones(1))[0]
    return float(np.max(np.abs(told - true(SLOW, 0.0))))


def test_half_a_revolution_tells_the_third_speed() -> None:
    before = calibrated()
    rows, y = half()
    after = refined(before, rows, y, [turn(SLOW, 0.0, slice(0, HALF))], NOISE, ())
    assert error(after) < 0.2 * error(before)
    # and the speeds of the whole revolutions stay what they were
    at = np.array([[300.0, SPEEDS[0], 25.0]])
    assert np.allclose(after.vectors(at, np.ones(1)), before.vectors(at, np.ones(1)), atol=0.05e-6)


def test_what_a_part_has_told_is_known_better() -> None:
    before = calibrated()
    rows, y = half()
    after = refined(before, rows, y, [turn(SLOW, 0.0, slice(0, HALF))], NOISE, ())
    at = np.array([[0.0, SLOW, 25.0]])
    assert after.variance(at, np.ones(1))[0] < 0.3 * before.variance(at, np.ones(1))[0]


def test_a_part_the_other_way_says_nothing_of_this_one() -> None:
    before = calibrated()
    rows, y = half()
    backwards = Revolution(0, slice(0, HALF), 0.0, -SLOW, 25.0, 0.0, -1.0, 0.5, 60.0)
    after = refined(before, rows, y, [backwards], NOISE, ())
    assert np.array_equal(after.amplitude[1], before.amplitude[1])


def test_the_prior_is_of_states_that_vary_as_the_parts_do() -> None:
    """Whole revolutions at one temperature say nothing of a warmer part: a degree away is no reason for a phase that
    nobody knows.
    """
    warm = replace(turn(SLOW, 0.0), temperature=45.0)
    at = np.array([[0.0, SLOW, 45.0]])
    alone, together = calibrated(), calibrated(parts=[warm])
    assert together.variance(at, np.ones(1))[0] < 0.1 * alone.variance(at, np.ones(1))[0]
    # what the revolutions have shown is told alike
    shown = np.array([[300.0, SPEEDS[0], 25.0]])
    assert np.allclose(together.vectors(shown, np.ones(1)), alone.vectors(shown, np.ones(1)), atol=0.05e-6)


def test_many_parts_move_the_prior_no_more_than_one() -> None:
    one = calibrated(parts=[turn(SLOW, 0.0)])
    many = calibrated(parts=[turn(SLOW, 0.0)] * 200)
    assert np.array_equal(one.scaling[1].centre, many.scaling[1].centre)
    assert np.array_equal(one.scaling[1].spread, many.scaling[1].spread)


def test_parts_that_no_step_explains_leave_the_series_no_worse() -> None:
    """A phase that is off by more than a step can turn."""
    before = calibrated()
    rows, y = half()
    wrong = replace(before, phase={1: before.phase[1] + 2.0 * (np.arange(10) == 9)})
    part = turn(SLOW, 0.0, slice(0, HALF))
    after = refined(wrong, rows, y, [part], NOISE, ())

    def left(series: Series) -> float:
        frame = rows.frame.take(part.rows)
        free = np.column_stack([np.ones(HALF), frame.theta])
        off = y - series.evaluate(frame)
        return float(np.std(off - free @ np.linalg.lstsq(free, off, rcond=None)[0]))

    assert left(after) <= left(wrong)
    # and what is left says how little the part has told
    assert (
        after.variance(np.array([[0.0, SLOW, 25.0]]), np.ones(1))[0]
        > 0.5 * before.variance(np.array([[0.0, SLOW, 25.0]]), np.ones(1))[0]
    )
