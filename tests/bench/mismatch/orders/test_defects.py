"""A pulse beats the orders that would draw it; orders with phases of their own are no pulse."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.orders import defects, pulse_mean
from bench.mismatch.orders.defects import Defect
from bench.mismatch.orders.discoveries import _of_pulses
from bench.mismatch.orders.periodic import Pulse
from bench.mismatch.orders.pulse_forms import extent
from bench.mismatch.orders.revolutions import Complex, Revolution
from bench.mismatch.orders.sight import Sight
from bench.mismatch.orders.weak import Stage

ORDERS = 601
ERROR = 2e-8
QUIET = 5e-10
TURNS = 12


def sight(mean: Complex, found: tuple[float, ...], error: float = ERROR) -> Sight:
    """Revolutions that all show the same spectrum, of noise ``error`` in the mean."""
    rng = np.random.default_rng(3)
    noisy = mean + error * (rng.normal(size=ORDERS) + 1j * rng.normal(size=ORDERS))
    turn = Revolution(0, slice(0, 1), 0.0, 0.1, 30.0, 0.0, 1.0, 1.0, 60.0)
    stage = Stage((turn,) * TURNS, np.tile(noisy, (TURNS, 1)), np.ones(TURNS), np.full(ORDERS, error * np.sqrt(TURNS)))
    free = np.ones(ORDERS, dtype=bool)
    free[[0, 3, 46, 92]] = False
    return Sight((3.0, 46.0, 92.0), found, stage, noisy, np.full(ORDERS, error), free)


def test_a_pulse_is_found_with_its_angle_height_and_width() -> None:
    """The orders that it draws do not hide it."""
    pulse = Pulse(2.1, 0.03, 2e-5)
    mean = pulse.vectors(np.arange(ORDERS, dtype=np.float64))
    drawn = tuple(float(f) for f in range(1, 60) if f not in (3, 46))
    found = defects.search(sight(mean, drawn), 0)
    assert len(found) == 1
    first = found[0].first
    assert first.std is not None
    assert first.angle == pytest.approx(pulse.angle, abs=5e-3)
    assert first.height == pytest.approx(pulse.height, rel=0.1)
    assert first.width == pytest.approx(pulse.width, rel=0.1)
    assert found[0].p_value < 1e-3


def test_two_places_that_are_alike_are_each_fitted_beside_the_other() -> None:
    """Together they draw every fifth order strongly; the first was found while the second stood in the spectrum."""
    pulses = (Pulse(1.449, 0.036, 1.06e-4), Pulse(2.695, 0.036, 1.06e-4))
    mean = sum(p.vectors(np.arange(ORDERS, dtype=np.float64)) for p in pulses)
    rng = np.random.default_rng(2)
    weak = rng.choice(np.setdiff1d(np.arange(5, 320), [46, 92]), 80, replace=False)
    mean[weak] += 6e-7 * np.exp(0.4 * rng.normal(size=weak.size) + 2j * np.pi * rng.random(weak.size))
    drawn = {float(f) for f in range(1, 70) if f not in (3, 46)} | {float(f) for f in weak}
    found = sorted(defects.search(sight(mean, tuple(sorted(drawn)), 1e-8), 0), key=lambda d: d.first.angle)
    assert [d.first.angle for d in found] == [pytest.approx(p.angle, abs=5e-3) for p in pulses]
    assert [d.first.height for d in found] == [pytest.approx(p.height, rel=0.1) for p in pulses]


def strong_orders(seed: int) -> tuple[Complex, tuple[float, ...]]:
    """Twenty orders some ten times as strong as what a weak pulse draws; with next to no noise each stands."""
    rng = np.random.default_rng(seed)
    mean = np.zeros(ORDERS, dtype=np.complex128)
    stand = rng.choice(np.setdiff1d(np.arange(2, 80), [3, 46]), 20, replace=False)
    mean[stand] = 5e-6 * np.exp(0.3 * rng.normal(size=stand.size) + 2j * np.pi * rng.random(stand.size))
    return mean, tuple(float(f) for f in np.sort(stand))


def test_a_weak_pulse_is_found_among_strong_orders() -> None:
    pulse = Pulse(0.65, 0.035, 1e-5)
    mean, strong = strong_orders(5)
    mean = mean + pulse.vectors(np.arange(ORDERS, dtype=np.float64))
    drawn = tuple(float(f) for f in range(1, 60) if f not in (3, 46) and f not in strong)
    found = defects.search(sight(mean, tuple(sorted((*strong, *drawn))), QUIET), 0)
    assert len(found) == 1
    assert found[0].first.angle == pytest.approx(pulse.angle, abs=5e-3)
    assert found[0].first.height == pytest.approx(pulse.height, rel=0.1)


def test_a_pulse_is_found_where_low_orders_stand_against_it() -> None:
    """Stronger ones than what the pulse draws, each with a phase of its own."""
    pulse = Pulse(5.73, 0.042, 1.2e-5)
    orders = np.arange(ORDERS, dtype=np.float64)
    rng = np.random.default_rng(8)
    mean = pulse.vectors(orders)
    strong = (2, 5, 7, 8, 10, 11, 15, 16, 20, 22, 28, 36, 41, 45, 48, 60, 72, 96)
    mean[list(strong)] += 6e-6 * np.exp(2j * np.pi * rng.random(len(strong)))
    drawn = tuple(float(f) for f in range(1, 40) if f not in (3, 46))
    found = defects.search(sight(mean, tuple(sorted({*drawn, *map(float, strong)})), 1e-7), 0)
    assert [f.first.angle for f in found] == [pytest.approx(pulse.angle, abs=0.02)]
    assert found[0].first.width == pytest.approx(pulse.width, rel=0.25)


def test_a_pulse_is_begun_lower_where_orders_make_its_matched_filter_too_high() -> None:
    pulse = Pulse(2.1, 0.03, 2e-5)
    seen = sight(pulse.vectors(np.arange(ORDERS, dtype=np.float64)), (), 1e-7)
    line = pulse_mean.Mean.of(seen, seen.mean)
    before = np.zeros(line.orders.size, dtype=np.complex128)
    for much in (1.0, 2.0, 4.0):
        gain, (begun,) = pulse_mean._begun((Pulse(2.1, 0.03, much * 2e-5),), line.beside(before))
        assert begun.height == pytest.approx(2e-5)
        assert gain == pytest.approx(line.beside(before)(pulse))


def test_weak_orders_of_pulse_like_sizes_with_phases_of_their_own_are_no_pulse() -> None:
    rng = np.random.default_rng(6)
    mean, strong = strong_orders(5)
    sizes = np.abs(Pulse(0.65, 0.035, 1e-5).vectors(np.arange(ORDERS, dtype=np.float64)))
    mean = mean + sizes * np.exp(2j * np.pi * rng.random(ORDERS))
    drawn = tuple(float(f) for f in range(1, 60) if f not in (3, 46) and f not in strong)
    assert defects.search(sight(mean, tuple(sorted((*strong, *drawn))), QUIET), 0) == []


def test_many_orders_are_no_pulse() -> None:
    """Orders of the same sizes with phases of their own."""
    rng = np.random.default_rng(4)
    mean = np.zeros(ORDERS, dtype=np.complex128)
    stand = rng.choice(np.arange(5, 400), 80, replace=False)
    stand = stand[~np.isin(stand, [46, 92])]
    mean[stand] = 2e-6 * np.exp(0.8 * rng.normal(size=stand.size) + 2j * np.pi * rng.random(stand.size))
    assert defects.search(sight(mean, tuple(float(f) for f in np.sort(stand))), 0) == []


def test_a_second_smaller_pulse_is_found_beside_the_first() -> None:
    """What chance makes of the spectrum of the first says nothing of what it makes beside the first."""
    pulses = [Pulse(4.875, 0.02, -1e-4), Pulse(6.12, 0.02, -1.5e-5)]
    mean = np.asarray(sum(p.vectors(np.arange(ORDERS, dtype=np.float64)) for p in pulses))
    drawn = tuple(float(f) for f in range(1, 130) if f not in (3, 46, 92))
    found = defects.search(sight(mean, drawn), 0)
    assert [f.first.angle for f in found] == [pytest.approx(p.angle, abs=0.01) for p in pulses]


@pytest.mark.parametrize("at_the_pulse", [True, False])
def test_orders_that_lie_at_a_pulse_are_of_its_form(at_the_pulse: bool) -> None:
    places = [Defect(Pulse(2.1, 0.03, 2e-5), (Pulse(2.1, 0.03, 2e-5),), 400.0, 1e-4)]
    orders = np.arange(ORDERS, dtype=np.float64)
    left = Pulse(2.13 if at_the_pulse else 2.9, 0.02, 8e-6).vectors(orders)
    assert _of_pulses(sight(left, ()), places, tuple(orders[1:100])) == at_the_pulse
    rng = np.random.default_rng(7)
    spread = np.abs(left) * np.exp(2j * np.pi * rng.random(ORDERS))
    assert not _of_pulses(sight(spread, ()), places, tuple(orders[1:100]))
    assert not _of_pulses(sight(left, ()), places, (4.5,))


def test_a_pulse_with_corners_far_above_the_noise_is_one_place() -> None:
    """A skewed triangle, 0.02 rad up and 0.07 rad down, whose edges no Gaussian has."""
    angle = np.linspace(0.0, 2.0 * np.pi, 1 << 14, endpoint=False)
    after = np.mod(angle - 2.1, 2.0 * np.pi)
    values = 1.6e-4 * np.where(after < 0.02, after / 0.02, np.clip(1.0 - (after - 0.02) / 0.07, 0.0, None))
    spectrum = 2.0 * np.fft.rfft(values)[:ORDERS] / angle.size
    mean = 1j * spectrum  # b + j*a of a - j*b
    mean[0] = 0.0
    found = defects.search(sight(mean, tuple(float(f) for f in range(1, 200) if f not in (3, 46, 92))), 0)
    assert found
    assert found[0].first.angle == pytest.approx(2.12, abs=0.03)
    assert 0.004 < found[0].first.width < 0.06
    drawn = sum(p.evaluate(angle) for p in found[0].form)
    assert np.std(values - drawn) < 0.25 * np.std(values)


@pytest.mark.parametrize("seed", range(3))
def test_a_pull_beside_a_push_is_one_place_that_leaves_nothing(seed: int) -> None:
    """A pin that passes: a doublet between two smaller lobes, on a spectrum of which each order up to sixty stands."""
    angle = float(np.random.default_rng(seed).uniform(0.5, 5.5))
    pulses = [Pulse(angle - 0.045, 0.0287, -4e-5), Pulse(angle + 0.045, 0.0287, 4e-5)]
    pulses += [Pulse(angle - 0.094, 0.01, 9e-6), Pulse(angle + 0.094, 0.0105, -9e-6)]
    orders = np.arange(ORDERS, dtype=np.float64)
    mean = np.asarray(sum(p.vectors(orders) for p in pulses))
    drawn = tuple(float(f) for f in range(1, 60) if f not in (3, 46))
    found = defects.search(sight(mean, drawn, 2.5e-8), 0)
    assert len(found) == 1
    left = mean - np.asarray(sum(p.vectors(orders) for p in found[0].form))
    assert np.max(np.abs(left[1:])) < 2e-7
    # as the same pulses themselves
    begin, end = extent(pulses)
    assert found[0].window[0] == pytest.approx(begin, abs=0.01)
    assert found[0].window[1] == pytest.approx(end, abs=0.01)


def flat_topped(angle: float, before: float, after: float, height: float) -> Complex:
    """Spectrum of a place with a flat top and two different flanks, height/(1 + (x/width)**4)."""
    theta = np.arange(16384) * 2.0 * np.pi / 16384
    x = np.angle(np.exp(1j * (theta - angle)))
    values = height / (1.0 + (np.abs(x) / np.where(x < 0.0, before, after)) ** 4)
    table = np.fft.rfft(values)[:ORDERS] * 2.0 / 16384
    out: Complex = -table.imag + 1j * table.real
    out[0] = 0.0
    return out


def test_two_places_are_found_in_a_spectrum_in_which_nearly_every_order_stands() -> None:
    """Fifty times their error: what such orders gain whatever their phases are says nothing of a pulse."""
    places = ((1.21, 0.05, 0.024, 3.4e-5), (4.02, 0.035, 0.07, -2.6e-5))
    mean, strong = strong_orders(5)
    mean = mean + sum(flat_topped(*place) for place in places)
    drawn = tuple(float(f) for f in range(1, 75) if f not in (3, 46) and f not in strong)
    found = sorted(defects.search(sight(mean, tuple(sorted((*strong, *drawn))), 8e-9), 0), key=lambda d: d.window[0])
    assert len(found) == 2
    for (angle, before, after, height), one in zip(places, found, strict=True):
        assert one.p_value < 1e-3
        assert one.window[0] == pytest.approx(angle - 2.0 * before, abs=0.06)
        assert one.window[1] == pytest.approx(angle + 2.0 * after, abs=0.06)
        assert sum(p.evaluate(np.array([angle]))[0] for p in one.form) == pytest.approx(height, rel=0.5)


def test_no_pulse_is_wider_than_is_looked_for() -> None:
    """A handful of low orders whose phases happen to agree."""
    wide = Pulse(4.87, 0.3, 3e-5).vectors(np.arange(ORDERS, dtype=np.float64))
    found = defects.search(sight(wide, tuple(float(f) for f in range(1, 11) if f != 3)), 0)
    assert all(d.first.width <= pulse_mean.WIDTHS[-1] * 1.001 for d in found)
