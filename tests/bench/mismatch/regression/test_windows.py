"""Where over the output angle a function acts."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.regression.windows import acting, followed, orders, orders_of_each

ANGLE = np.random.default_rng(0).uniform(-20.0, 20.0, 20_000)
ONE = np.ones(ANGLE.size)


def spot(at: float, width: float) -> np.ndarray:
    """A tight spot, its mean taken off as a calibration takes it."""
    distance = np.mod(ANGLE - at + np.pi, 2.0 * np.pi) - np.pi
    course = np.exp(-0.5 * (distance / width) ** 2)
    return np.asarray(course - course.mean())


@pytest.mark.parametrize("at", [2.0, 0.1])
def test_a_tight_spot_is_one_window(at: float) -> None:
    found = acting(ANGLE, spot(at, 0.3), ONE)
    assert len(found) == 1
    begin, end = found[0]
    # nine tenths of the energy of a Gaussian lie within 1.16 of its widths
    assert np.mod(0.5 * (begin + end), 2.0 * np.pi) == pytest.approx(at, abs=0.07)
    assert end - begin == pytest.approx(2.0 * 1.16 * 0.3, abs=0.2)


def test_what_acts_all_around_has_orders_and_no_window() -> None:
    course = np.sin(3.0 * ANGLE) + 0.1 * np.sin(5.0 * ANGLE)
    assert acting(ANGLE, course, ONE) == ()
    assert orders(ANGLE, course, ONE) == (3.0,)


def test_a_part_of_a_revolution_tells_no_window() -> None:
    inside = (np.mod(ANGLE, 2.0 * np.pi) < 4.0).astype(float)
    assert acting(ANGLE, spot(2.0, 0.3), inside) == ()
    assert orders(ANGLE, spot(2.0, 0.3), inside) == ()


def test_recordings_whose_waves_differ_have_an_order_still() -> None:
    recording = np.repeat(np.arange(10), ANGLE.size // 10)
    phase = np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, 10)[recording]
    noise = 0.1 * np.random.default_rng(2).normal(size=ANGLE.size)
    assert orders_of_each(ANGLE, np.cos(ANGLE + phase) + noise, ONE, recording) == (1.0,)
    # a level of each recording is no order
    assert orders_of_each(ANGLE, phase + noise, ONE, recording) == ()
    # nor is noise
    assert orders_of_each(ANGLE, noise, ONE, recording) == ()


def test_a_wave_that_grows_with_the_load_is_followed_times_the_load() -> None:
    rng = np.random.default_rng(3)
    angle = rng.uniform(0.0, 2.0 * np.pi, 4000)
    load, number = rng.choice([-1.0, -0.5, 0.5, 1.0], 4000), np.full(4000, 10.0)
    course = load * np.cos(2.0 * angle)
    by_load = followed(angle, course, load, number)
    assert by_load == pytest.approx(np.sum(number * course**2), rel=0.02)
    assert followed(angle, course, np.ones(4000), number) < 0.05 * by_load
    assert orders(angle, course / load, number * load**2) == (2.0,)
