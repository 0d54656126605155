"""A thermometer behind its pocket: what a warm-up has not yet brought to it comes in the recording after it."""

from dataclasses import replace

import numpy as np
import pytest

from bench.simulation.frame import FloatArray
from bench.simulation.memory import integral
from bench.simulation.terms import LIBRARY, TEMPERATURE
from bench.simulation.terms.base import Form
from bench.simulation.terms.thermal.sensor_lag import SETTLED, lags_of
from tests.bench.simulation.terms.frames import ROWS, STEP_S, frame

LOSS_W, CAPACITY, TAU_S = 300.0, 2.5e4, 8.0


def test_the_sensor_goes_on_rising_in_the_recording_after_a_warm_up() -> None:
    """Ts lags T, which rises by the loss until the first recording ends; both are written down here by hand."""
    rows = frame().take(slice(0, 2 * ROWS))
    clock = STEP_S * np.arange(rows.size)
    end = clock[ROWS - 1] + 0.5 * STEP_S
    heated = replace(rows, time=np.asarray(clock, dtype=np.float64), power=np.where(clock < end, LOSS_W, 0.0))
    rate = LOSS_W / CAPACITY
    while_warming = rate * (clock - TAU_S * (1.0 - np.exp(-clock / TAU_S)))
    behind = rate * TAU_S * (1.0 - np.exp(-end / TAU_S))
    sensed = np.where(clock < end, while_warming, rate * end - behind * np.exp(-(clock - end) / TAU_S))
    # the loss before the first recording is not known: the state begins as if it had always been there
    sensed = sensed + rate * TAU_S * (1.0 - np.exp(-clock / TAU_S))
    kept = LIBRARY["thermal.sensor_lag"].form(TEMPERATURE, "first_order_kept")
    fresh = LIBRARY["thermal.sensor_lag"].form(TEMPERATURE, "first_order")
    assert kept is not None
    assert fresh is not None
    own = slice(ROWS, None)
    risen = sensed[own] - sensed[ROWS]
    assert risen[-1] > 0.05

    def told(form: Form) -> FloatArray:
        out = (integral(heated.power, heated) + form.columns(heated, (TAU_S,))[:, 0]) / CAPACITY
        return np.asarray(out[own])

    assert told(kept) == pytest.approx(risen, abs=0.01 * risen[-1])
    assert np.abs(told(fresh)).max() < 1e-12


def test_two_lags_are_the_mean_of_one_of_each_by_their_share() -> None:
    rows = frame().take(slice(0, 2 * ROWS))
    clock = STEP_S * np.arange(rows.size)
    heated = replace(rows, time=np.asarray(clock, dtype=np.float64), power=np.where(clock < 20.0, LOSS_W, 0.0))
    one, two = (LIBRARY["thermal.sensor_lag"].form(TEMPERATURE, name) for name in ("first_order_kept", "two_lags_kept"))
    assert one is not None
    assert two is not None
    fast, slow = (one.columns(heated, (tau,))[:, 0] for tau in (TAU_S, 6.0 * TAU_S))
    both = two.columns(heated, (TAU_S, 6.0 * TAU_S, 0.3))[:, 0]
    assert both == pytest.approx(0.7 * fast + 0.3 * slow, abs=1e-9 * np.abs(slow).max())
    assert np.ptp(slow) > 1.5 * np.ptp(fast)


@pytest.mark.parametrize("point", [(TAU_S,), (TAU_S, 5.0 * TAU_S, 0.35)])
def test_a_sensor_that_reads_right_at_the_start_follows_from_there(point: tuple[float, ...]) -> None:
    """The balance by exponentials, the reading by a lag of first order that begins at the lubricant's temperature."""
    cooling, surroundings = 1.0 / 800.0, 31.0
    rows = frame().take(slice(0, ROWS))
    clock = STEP_S * np.arange(rows.size, dtype=np.float64)
    settled = surroundings + LOSS_W / CAPACITY / cooling
    warm = settled + (24.0 - settled) * np.exp(-cooling * clock)
    powers = np.full(rows.size, LOSS_W)
    heated = replace(rows, time=clock, elapsed=clock, power=powers, temperature=warm)

    def read(tau: float) -> FloatArray:
        # response of a first-order lag to an exponential, from its own value
        gain = 1.0 / (1.0 - cooling * tau)
        return np.asarray(
            settled + (24.0 - settled) * (gain * np.exp(-cooling * clock) + (1.0 - gain) * np.exp(-clock / tau))
        )

    reading = sum(share * read(tau) for tau, share in lags_of(point))
    name = SETTLED[len(point) > 1]
    form = LIBRARY["thermal.sensor_lag"].form(TEMPERATURE, name)
    assert form is not None
    coefficients = np.array([1.0 / CAPACITY, cooling, cooling * (surroundings - 25.0)])
    told = warm + form.columns(heated, point) @ coefficients
    behind = warm - reading
    assert behind.max() > 0.05
    assert told == pytest.approx(reading, abs=0.01 * float(behind.max()))
    assert told[0] == pytest.approx(warm[0])
