"""Orders between the whole ones: those of wheels and belts that turn no simple number of times."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.orders import between
from bench.mismatch.orders.between import _usual, search_between
from bench.mismatch.orders.look import PARTS, Look
from bench.mismatch.orders.revolutions import Revolution, Seen, seen
from bench.mismatch.orders.weak import WeakOrder, search
from bench.simulation.frame import FloatArray

NOISE = 1e-5
ROWS = 2000
"""of a segment"""
PRICE = 12.0


def shown(
    number: int, travelled: float, waves: FloatArray, fitted: tuple[float, ...] = (), beside: FloatArray | float = 0.0
) -> tuple[Seen, list[Revolution]]:
    """Segments that follow each other, with noise and ``waves`` (k, 3) of an order, an amplitude and a phase, and what
    is ``beside`` them (n,); what is left when some orders are ``fitted``.
    """
    rng = np.random.default_rng(1)
    theta = 2.0 * np.pi * travelled * np.arange(number * ROWS) / ROWS
    y = beside + NOISE * rng.normal(size=theta.size)
    for order, amplitude, phase in waves:
        y += amplitude * np.cos(order * theta + phase)
    places = [slice(k * ROWS, (k + 1) * ROWS) for k in range(number)]
    turned = abs(travelled)
    revolutions = [Revolution(k, rows, 0.0, 0.1, 25.0, 60.0 * k, 1.0, turned, 60.0) for k, rows in enumerate(places)]
    looks = [Look(theta[rows], np.ones(ROWS), rows, 2.0 * np.pi * turned) for rows in places]
    return seen(looks, revolutions, y, fitted), revolutions


def swinging(number: int, travelled: float, size: float) -> FloatArray:
    """Waves of this ``size`` half way between the whole orders from 30 on, their phases drawn in each segment."""
    rng = np.random.default_rng(2)
    theta = 2.0 * np.pi * travelled * np.arange(number * ROWS) / ROWS
    orders = 30.5 + np.arange(220)
    parts = [
        np.cos(np.outer(part, orders) + rng.uniform(0.0, 6.28, 220)).sum(axis=1) for part in np.split(theta, number)
    ]
    return np.asarray(size * np.concatenate(parts))


def found(number: int, travelled: float, *waves: tuple[float, float, float]) -> list[WeakOrder]:
    now, revolutions = shown(number, travelled, np.array(waves))
    train = np.ones(number, dtype=bool)
    return search_between(now, revolutions, train, (), NOISE, PRICE)


def test_an_order_beyond_those_that_are_looked_for_is_not_found() -> None:
    now, revolutions = shown(13, 2.0, np.array([(40.5, 20.0 * NOISE, 0.7)]))
    train = np.ones(13, dtype=bool)
    for highest, orders in ((40.0, []), (41.0, [40.5])):
        lines = search_between(now, revolutions, train, (), NOISE, PRICE, highest)
        assert [line.order for line in lines] == pytest.approx(orders, abs=1e-3)


@pytest.mark.parametrize("order", [87.0 / 26.0, 2.0 * 87.0 / 26.0, 13.0 / 24.0 + 20.0])
def test_a_wheel_that_turns_no_simple_number_of_times_is_found_where_it_is(order: float) -> None:
    (line,) = found(13, 2.0, (order, 20.0 * NOISE, 0.7))
    assert line.order == pytest.approx(order, abs=1e-3)
    assert line.amplitude == pytest.approx(20.0 * NOISE, rel=0.05)


def test_a_part_of_an_order_keeps_its_plain_number() -> None:
    (line,) = found(13, 2.0, (10.0 / 3.0, 20.0 * NOISE, 0.7))
    assert line.order == 40 / PARTS


def test_a_belt_that_turns_slower_than_the_output_is_found_where_a_segment_has_a_period_of_it() -> None:
    wave = (87.0 / 125.0, 50.0 * NOISE, 0.2)
    assert found(13, 2.0, wave)[0].order == pytest.approx(wave[0], abs=5e-3)
    assert all(line.order > 1.0 for line in found(26, 1.0, wave))


def test_nothing_is_found_in_noise() -> None:
    assert found(13, 2.0) == []


@pytest.mark.parametrize(("fitted", "whole"), [(10.5, 10), (91.5, 92), (92.25, 92), (92.0 / 3.0, 31)])
def test_an_order_between_the_whole_ones_takes_none_of_them_away(fitted: float, whole: int) -> None:
    waves = np.array([(fitted, 20.0 * NOISE, 0.4), (float(whole), 10.0 * NOISE, 1.1)])
    now, revolutions = shown(13, 2.0, waves, (fitted,))
    train = np.ones(13, dtype=bool)
    assert whole in [line.order for line in search(now, revolutions, train, (fitted,), NOISE, PRICE)]
    again, _ = shown(13, 2.0, waves, (fitted, float(whole)))
    assert search(again, revolutions, train, (fitted, float(whole)), NOISE, PRICE) == []


def test_an_order_is_found_though_others_have_more_energy_than_noise_everywhere(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It is among the first that are looked at."""
    monkeypatch.setattr(between, "MOST_SUMMITS", 12)
    order, size = 87.0 / 26.0, 0.3 * NOISE
    now, revolutions = shown(13, 2.0, np.array([(order, size, 0.7)]), beside=swinging(13, 2.0, size))
    lines = search_between(now, revolutions, np.ones(13, dtype=bool), (), 0.01 * NOISE, PRICE)
    (line,) = [line for line in lines if abs(line.order - order) < 0.01]
    assert line.amplitude == pytest.approx(size, rel=0.1)


def test_energy_is_usual_where_all_about_it_have_as_much() -> None:
    energy = np.full(200 * PARTS, 5.0)
    energy[100 * PARTS :] = 20.0
    usual = _usual(energy, 5)
    assert usual[: 99 * PARTS] == pytest.approx(1.0)
    assert usual[101 * PARTS :] == pytest.approx(4.0)


def test_one_order_is_not_usual_and_less_than_noise_is_noise() -> None:
    energy = np.full(200 * PARTS, 2.0)
    energy[700] = 1e4
    assert _usual(energy, 5) == pytest.approx(1.0)
