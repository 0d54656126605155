"""The load's reaction through the transmission error: asked of the motor torque, and taken off it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.given import Given
from bench.mismatch.orders.periodic import Periodic, Pulse
from bench.mismatch.orders.reaction import Reaction, reaction_of, unit
from bench.mismatch.orders.series import calibrate
from bench.mismatch.recordings.output_orders import OutputSpectrum, orders_of
from bench.mismatch.recordings.vibration import HIGHEST_SHAFT_ORDER, ShaftSpectrum
from bench.mismatch.series_given import periodic_part, slope
from bench.simulation import Simulation
from bench.simulation.frame import ARRAYS, FloatArray, Frame
from bench.simulation.waves import Wave

RATIO, NOISE, RECORDINGS, SPEED = 90.0, 0.02, 14, 0.17
ROWS, STEP = 2600, 2.6e-3
SHARE = 0.9
WAVES = (Wave(46.0, "1", 2e-5, 1e-5), Wave(180.0, "1", -8e-6, 1e-5), Wave(371.5, "1", 0.0, 6e-6))
NOTHING = calibrate([], np.zeros((0, 0), dtype=np.complex128), np.zeros((0, 0)), [])
PERIODIC = Periodic(NOTHING, waves=WAVES)
TRAIN = np.ones(RECORDINGS, dtype=bool)


def frame() -> Frame:
    """A little over a revolution in each recording, loads and directions in turn, rows over the angle."""
    number = np.repeat(np.arange(RECORDINGS), ROWS)
    sign = np.where(number % 2 == 0, 1.0, -1.0)
    angle = np.tile(np.arange(ROWS) * STEP, RECORDINGS)
    values = {name: np.zeros(number.size) for name in ARRAYS}
    values |= {"theta": sign * angle, "q": sign * angle + 0.03, "velocity": sign * SPEED, "direction": sign}
    values |= {"last_direction": sign, "steady": np.ones(number.size), "count": np.full(number.size, 30.0)}
    values |= {"elapsed": angle / SPEED, "step": np.full(number.size, STEP / SPEED), "torque": 200.0 * (number - 6.5)}
    values |= {"time": number * 60.0 + angle / SPEED, "reversal_time": 10.0 + angle, "reversal_travel": 1.0 + angle}
    return Frame(ratio=RATIO, **values | {"recording": number.astype(np.int64)})


def measured(own: Frame, share: float, seed: int = 3) -> Frame:
    """The frame with a motor torque: friction that comes and goes slowly, noise, and a share of the reaction."""
    noise = NOISE * np.random.default_rng(seed).normal(size=own.size)
    friction = 0.5 * own.direction + 0.1 * np.sin(0.3 * own.elapsed)
    return replace(own, motor_torque=own.torque / RATIO + friction + noise + share * unit(PERIODIC, own))


def found(own: Frame, known: float = 0.0, train: np.ndarray = TRAIN) -> Reaction | None:
    return reaction_of(PERIODIC, own, np.ones(own.size, dtype=bool), train, known, 0)


def test_its_share_is_found_with_its_uncertainty() -> None:
    told = found(measured(frame(), SHARE))
    assert told is not None
    assert told.std is not None
    assert abs(told.share - SHARE) < 4.0 * told.std < 0.3
    assert f"{told.share:.3g}" in told.words


def test_a_torque_without_it_has_none() -> None:
    told = [found(measured(frame(), 0.0, seed)) for seed in range(20)]
    assert sum(t is not None for t in told) <= 1
    # orders that the torque holds whatever the load are no reaction to it
    own = measured(frame(), 0.0)
    wave = replace(own, motor_torque=own.motor_torque + 0.05 * np.cos(46.0 * own.theta))
    assert found(wave) is None
    # a reaction of the wrong sign would make energy of nothing
    assert found(measured(frame(), -SHARE)) is None


def test_recordings_that_do_not_tell_it_leave_what_was_given() -> None:
    few = np.arange(RECORDINGS) < 4
    told = found(measured(frame(), SHARE), 0.8, few)
    assert told is not None
    assert (told.share, told.std) == (0.8, None)
    assert found(measured(frame(), SHARE), 0.0, few) is None


def test_rows_have_the_mean_of_the_slope_over_their_angle() -> None:
    own = frame()
    wide = replace(own, step=np.full(own.size, 0.1 / SPEED))
    ahead, behind = (PERIODIC.evaluate(replace(own, theta=own.theta + half)) for half in (0.05, -0.05))
    assert PERIODIC.slope_of_rows(wide) == pytest.approx((ahead - behind) / 0.1, abs=1e-12)
    narrow = replace(own, step=np.full(own.size, 1e-6))
    assert PERIODIC.slope_of_rows(narrow) == pytest.approx(PERIODIC.slope(own), abs=3e-5)


def test_spectra_of_the_torque_are_without_it() -> None:
    own = measured(frame(), SHARE)
    told = found(own)
    assert told is not None
    rows = slice(9 * ROWS, 10 * ROWS)
    values = own.motor_torque[rows] - own.torque[rows] / RATIO
    amplitude = orders_of(own.q[rows], values)
    seen = OutputSpectrum(9, amplitude, NOISE, NOISE, 500.0, -SPEED, 25.0, float(own.time[rows].mean()), -1.0, 1.0)
    left = told.less_output(seen)
    assert abs(seen.amplitude[46]) > 5.0 * abs(left.amplitude[46])
    assert left.amplitude[20] == pytest.approx(seen.amplitude[20], abs=2e-4)
    # order 180 of the output is the second of this motor's shaft
    turned = np.exp(1j * np.arange(HIGHEST_SHAFT_ORDER + 1)[:, None] * own.theta[rows] * RATIO)
    shaft = ShaftSpectrum(9, 2.0 / ROWS * turned @ (values - values.mean()), NOISE, 1.0, -SPEED, 25.0)
    assert abs(shaft.amplitude[2]) > 5.0 * abs(told.less_shaft(shaft).amplitude[2])
    other = replace(shaft, recording=RECORDINGS + 1)
    assert told.less_shaft(other) is other


def series(*orders: float) -> dict[str, object]:
    """Coefficients of a series of some orders, the same at every state."""
    return {
        side: {"a0": [0.0] * 10, **{f"{f:g}": {"A": [0.0] * 9 + [1e-5], "phi": [0.0] * 9 + [0.4]} for f in orders}}
        for side in ("positive", "negative")
    }


def test_a_file_says_the_slope_of_all_but_what_an_encoder_misreads() -> None:
    own: Frame = frame()
    terms = [
        {"effect": "motor.load_reaction", "parameters": {"k_te": {"value": 0.9, "unit": "1", "std": 0.1}}},
        {"effect": "te.fourier", "parameters": series(3.0, 90.0)},
        {"effect": "te.local_defect", "parameters": {"theta_p": 1.0, "w_p": 0.05, "p": 2e-5}},
        {"effect": "te.harmonic", "channels": ["transmission_error"], "waves": [w.to_json() for w in WAVES]},
        {"effect": "sensor.motor_encoder", "orders": [90.0]},
    ]
    model = Simulation.from_json({"format": "bench-simulation", "format_version": "1.0", "terms": terms})
    given = Given.of(model)
    assert given.reaction == 0.9
    assert given.misread == (90.0,)

    def plain(theta: FloatArray) -> FloatArray:
        moved = replace(own, theta=theta)
        wrong = 1e-5 * np.sin(90.0 * theta + 0.4)
        return periodic_part(given, moved) - wrong + PERIODIC.evaluate(moved)

    numeric = (plain(own.theta + 1e-6) - plain(own.theta - 1e-6)) / 2e-6
    assert slope(given, own) == pytest.approx(numeric, abs=1e-7)
    assert np.abs(Pulse(1.0, 0.05, 2e-5).slope(own.theta)).max() > 1e-4
