"""Orders of a motor's torque over its shaft and over the output, where both are one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bench.mismatch.given import Given
from bench.mismatch.orders.periodicity import LOW_ORDERS, Periodicity, loudness, on_rows
from bench.mismatch.orders.shaft import factors
from bench.mismatch.orders.shaken import Rates, inertia_from_orders, without_shaking
from bench.mismatch.orders.torques import torque_discoveries
from bench.mismatch.recordings.output_orders import HIGHEST_OUTPUT_ORDER, OutputSpectrum
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.recordings.smoothing import local_quadratic, passed_by
from bench.mismatch.recordings.vibration import ShaftSpectrum
from bench.simulation import Simulation
from bench.simulation.frame import Frame
from bench.simulation.terms import MOTOR_TORQUE
from bench.simulation.waves import Wave
from tests.bench.mismatch.report.made import campaign

NOISE, RECORDINGS = 0.002, 20
LOW, HIGH = 6, 18
"""two ripple orders: rows over the angle show the first, the second only a spectrum"""


def vectors(rng: np.random.Generator, size: int) -> NDArray[np.complex128]:
    out = NOISE * (rng.normal(size=size) + 1j * rng.normal(size=size))
    out[LOW] += 0.05
    out[HIGH] += 0.04j
    return np.asarray(out)


def seen(ratio: float) -> Periodicity:
    frame: Frame = campaign()
    rng = np.random.default_rng(8)
    shaft = [ShaftSpectrum(k, vectors(rng, HIGHEST_OUTPUT_ORDER + 1), NOISE, 1.0, 0.1, 25.0) for k in range(RECORDINGS)]
    output = [
        OutputSpectrum(
            k, vectors(rng, HIGHEST_OUTPUT_ORDER + 1), NOISE, NOISE, 100.0, 0.1, 25.0, 60.0 * k, (-1.0) ** k, 2.0
        )
        for k in range(RECORDINGS)
    ]
    rows = Rows(frame, np.zeros(frame.size), np.full(frame.size, 25.0))
    folds = np.arange(RECORDINGS, dtype=np.int64)
    return Periodicity(MOTOR_TORQUE, output, shaft, rows, folds, ratio, 0.02)


def test_a_low_order_takes_no_higher_one_with_it() -> None:
    found = torque_discoveries(seen(1.0), 0)
    # of a direct drive the shaft's orders are the output's: told once, as the motor's
    assert [d.effect for d in found] == ["motor.torque_ripple"]
    assert found[0].orders == (float(HIGH),)
    assert LOW <= LOW_ORDERS < HIGH


def test_behind_a_gearbox_both_orders_of_the_shaft_are_told() -> None:
    (ripple,) = [d for d in torque_discoveries(seen(185.0), 0) if d.effect == "motor.torque_ripple"]
    assert set(ripple.orders) == {185.0 * LOW, 185.0 * HIGH}


def through_a_loop(falls: float) -> Periodicity:
    """A ripple whose vector falls with the speed and turns the other way in the other direction, or (0) one that stays;
    a recording that reverses is in between.
    """
    rng = np.random.default_rng(9)
    plain = seen(185.0)
    shaft = []
    for k in range(30):
        speed = (-1.0) ** k * (0.05, 0.1, 0.17)[k % 3]
        size = HIGHEST_OUTPUT_ORDER + 1
        amplitude = NOISE * (rng.normal(size=size) + 1j * rng.normal(size=size))
        turned = 1.0 / (1.0 + falls * (0.2j * np.sign(speed) + abs(speed) / 0.1) ** 2)
        amplitude[HIGH] += 0.05j * turned
        shaft.append(ShaftSpectrum(k, amplitude, NOISE, 1.0, speed, 25.0, speed=abs(speed)))
    shaft.append(replace(shaft[-1], recording=30, velocity=0.0, amplitude=np.full(size, 1.0 + 1.0j)))
    return replace(plain, shaft=shaft, output=[], folds=np.arange(31, dtype=np.int64))


@pytest.mark.parametrize("falls", [0.0, 2.0])
def test_a_ripple_inside_a_loop_is_one_all_the_same(falls: float) -> None:
    """The drive answers it less the quicker it is; where it does not, one vector is all that is told."""
    given = through_a_loop(falls)
    (ripple,) = torque_discoveries(given, 0)
    assert ripple.effect == "motor.torque_ripple"
    (row,) = ripple.simulation_rows
    assert ("waves" in row) == (falls > 0.0)
    assert ripple.words.endswith("as the drive's loop answers it at each speed") == (falls > 0.0)
    size = ripple.parameters[0]
    assert size["symbol"] == "a_r"
    assert size["std"] < 0.05 * size["value"]
    mean = np.sqrt(np.mean([abs(s.amplitude[HIGH]) ** 2 for s in given.shaft[:30]]))
    assert size["value"] == pytest.approx(mean, rel=0.05)
    if falls:  # all its factors stand in the equation, over the motor's angle
        assert ripple.equation.count("*theta)") == 12
    # the file's waves come back as what was put in, in each recording
    term = {"enabled": True, **row}
    document = Simulation.nominal().to_json()
    known = Given.of(Simulation.from_json({**document, "terms": [*document["terms"], term]})).ripples
    at = factors(given.shaft[:30], {w.times for w in known})
    for k, one in enumerate(given.shaft[:30]):
        told = sum(complex(w.cosine, w.sine) * at[w.times][k] for w in known)
        assert abs(told - one.amplitude[HIGH]) < 6.0 * NOISE


def test_an_order_that_grows_with_the_size_of_the_load() -> None:
    """Recordings in which it is strong are no noisier for it: quiet ones do not outweigh them."""
    rng = np.random.default_rng(10)
    plain = seen(185.0)
    shaft = []
    for k, one in enumerate(plain.shaft):
        load = rng.uniform(-1000.0, 1000.0)
        amplitude = NOISE * (rng.normal(size=one.amplitude.size) + 1j * rng.normal(size=one.amplitude.size))
        amplitude[1] += (0.02 + 0.03j) * max(abs(load) / 185.0 - 1.8, 0.0)
        shaft.append(replace(one, recording=k, amplitude=amplitude, load=load))
    (found,) = torque_discoveries(replace(plain, shaft=shaft, output=[]), 0)
    assert found.effect == "unknown"
    assert found.orders == (185.0,)
    assert "load" in found.variables


def test_a_wave_too_quick_for_the_rows_is_as_loud_as_it_is() -> None:
    """Rows of a second average a ripple away; its place is where it is, not where the rows happen to show it."""
    frame = campaign()
    rows = Rows(frame, np.zeros(frame.size), np.full(frame.size, 100.0))
    waves = [Wave(4440.0, "1", 3.0, 4.0), Wave(8880.0, "1", 0.0, 2.0)]
    assert np.allclose(loudness(waves, rows), np.sqrt((25.0 + 4.0) / 2.0))
    # what cancels is not heard
    assert np.allclose(loudness([waves[0], Wave(4440.0, "1", -3.0, -4.0)], rows), 0.0)
    moving = np.abs(frame.velocity) * frame.step > 0.01
    assert np.max(np.abs(on_rows(waves, rows)[moving])) < 0.5


INERTIA, RATE, SPAN = 2e-3, 1000.0, 0.015
RATES = Rates(RATE, SPAN)


def shaken_by_its_ripple(stiff: float) -> Periodicity:
    """A ripple that shakes the shaft, more the slower it turns; a loop (``stiff``, 0 to 1) holds against it."""
    rng = np.random.default_rng(11)
    plain = seen(185.0)
    size = HIGHEST_OUTPUT_ORDER + 1
    shaft = []
    for k in range(30):
        speed = (-1.0) ** k * (0.05, 0.1, 0.17)[k % 3]
        shaking = 0.01 * NOISE / INERTIA * (rng.normal(size=size) + 1j * rng.normal(size=size))
        shaking[HIGH] -= 0.05j / INERTIA * (1.0 - stiff * abs(speed) / 0.2)
        amplitude = NOISE * (rng.normal(size=size) + 1j * rng.normal(size=size))
        amplitude[HIGH] += 0.05j
        shaft.append(
            ShaftSpectrum(
                k,
                amplitude + INERTIA * shaking,
                NOISE,
                1.0,
                speed,
                25.0,
                speed=abs(speed),
                shaking=np.asarray(shaking),
                hertz=abs(speed),
            )
        )
    return replace(plain, shaft=shaft, output=[], folds=np.arange(30, dtype=np.int64))


def test_the_orders_tell_the_inertia_of_a_shaft_that_they_shake() -> None:
    given = shaken_by_its_ripple(0.8)
    inertia = inertia_from_orders(given, RATES, 0)
    assert inertia == pytest.approx(INERTIA, rel=0.05)
    (ripple,) = torque_discoveries(without_shaking(given, INERTIA, RATES), 0)
    assert ripple.effect == "motor.torque_ripple"
    assert ripple.parameters[0]["value"] == pytest.approx(0.05, rel=0.05)
    # with the inertia's part in it the order is smaller than the ripple is, and another at each speed
    (smaller,) = torque_discoveries(given, 0)
    assert smaller.parameters[0]["value"] < 0.04


def test_an_inertia_is_not_told_where_the_shaking_is_the_same_always() -> None:
    assert inertia_from_orders(shaken_by_its_ripple(0.0), RATES, 0) is None


def test_an_order_too_fast_for_the_window_of_the_rates_says_nothing_of_the_inertia() -> None:
    given = shaken_by_its_ripple(0.8)
    fast = replace(given, shaft=[replace(s, hertz=90.0 / HIGH) for s in given.shaft])
    assert 0.1 < passed_by(RATE, SPAN, np.array([90.0]))[0] < 0.45
    assert inertia_from_orders(fast, RATES, 0) is None


def test_what_the_window_of_the_rates_takes_of_the_shaking_is_made_up_for() -> None:
    """Else the inertia would come out too large by as much."""
    given = shaken_by_its_ripple(0.8)
    hertz = [(50.0 if k % 2 else 55.0) / HIGH for k in range(30)]
    shares = passed_by(RATE, SPAN, HIGH * np.array(hertz))
    assert 0.5 < shares.min() < shares.max() < 0.7
    shaft = [
        replace(s, hertz=f, shaking=s.shaking * share) for s, f, share in zip(given.shaft, hertz, shares, strict=True)
    ]
    assert inertia_from_orders(replace(given, shaft=shaft), RATES, 0) == pytest.approx(INERTIA, rel=0.05)


def test_the_share_that_the_window_of_the_rates_lets_pass() -> None:
    hertz = np.array([1.0, 20.0, 60.0])
    for span in (0.015, 0.03):
        time = np.arange(0.0, 4.0, 1.0 / RATE)
        for f, passed in zip(hertz, passed_by(RATE, span, hertz), strict=True):
            curve = local_quadratic(np.cos(2.0 * np.pi * f * time), RATE, span)[2]
            inside = slice(100, -100)
            true = -((2.0 * np.pi * f) ** 2) * np.cos(2.0 * np.pi * f * time)
            assert passed == pytest.approx(
                float(curve[inside] @ true[inside] / (true[inside] @ true[inside])), abs=1e-3
            )


def test_a_ripple_that_grows_with_the_load_says_nothing_of_the_inertia() -> None:
    given = shaken_by_its_ripple(0.8)
    loads = [50.0 * (k % 5) for k in range(30)]
    grown = []
    for s, load in zip(given.shaft, loads, strict=True):
        amplitude = s.amplitude.copy()
        amplitude[HIGH] += 0.05j * load / 100.0
        grown.append(replace(s, amplitude=amplitude, load=load))
    told = inertia_from_orders(replace(given, shaft=grown), RATES, 0)
    assert told is None or told == pytest.approx(INERTIA, rel=0.1)


def test_an_order_seen_in_one_direction_alone_has_no_model_of_both() -> None:
    """A drive's loop has a vector for each direction: recordings that are slow enough for an order may all turn one
    way, and their vectors lie on a polynomial of the speed.
    """
    given = through_a_loop(2.0)
    shaft = []
    for s in given.shaft:
        amplitude = s.amplitude.copy()
        if s.velocity <= 0.0:
            amplitude[HIGH] = np.nan
        shaft.append(replace(s, amplitude=amplitude))
    found = [f for d in torque_discoveries(replace(given, shaft=shaft), 0) for f in d.orders]
    assert all(np.isfinite(f) for f in found)
    for discovery in torque_discoveries(replace(given, shaft=shaft), 0):
        assert "as the drive's loop" not in discovery.words


def loaded(of_load: float, of_weight: float) -> Periodicity:
    """A low order of the output in recordings of several loads: so much per kN·m, and so much at any load."""
    rng = np.random.default_rng(21)
    plain = seen(185.0)
    output = []
    for k in range(40):
        load = (-300.0, 100.0, 400.0, 900.0)[k % 4]
        amplitude = NOISE * (rng.normal(size=HIGHEST_OUTPUT_ORDER + 1) + 1j * rng.normal(size=HIGHEST_OUTPUT_ORDER + 1))
        amplitude[5] += of_load * load / 1000.0 + 1j * of_weight
        output.append(OutputSpectrum(k, amplitude, NOISE, NOISE, load, 0.1, 25.0, 60.0 * k, (-1.0) ** (k // 4), 2.0))
    return replace(plain, output=output, shaft=[], folds=np.arange(40, dtype=np.int64))


def test_a_low_order_that_goes_with_the_load_is_told_as_no_function_of_the_rows_does() -> None:
    (found,) = torque_discoveries(loaded(0.05, 0.0), 0)
    assert (found.effect, found.orders) == ("unknown", (5.0,))
    assert found.words == "order 5 of the output in proportion to the load"
    values = {str(p["symbol"]): p["value"] for p in found.parameters}
    assert np.hypot(values["c"], values["s"]) == pytest.approx(0.05, rel=0.1)


def test_of_a_low_order_only_what_goes_with_the_load_is_told() -> None:
    assert torque_discoveries(loaded(0.0, 0.05), 0) == []
    (found,) = torque_discoveries(loaded(0.05, 0.05), 0)
    assert [w["times"] for row in found.simulation_rows for w in row["waves"]] == ["tau"]
