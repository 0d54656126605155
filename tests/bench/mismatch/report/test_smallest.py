"""The smallest box over several quantities that holds nine tenths of some energy."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.mismatch.report.smallest import box, interval
from bench.simulation.frame import FloatArray

SHARE = 0.9


def held(found: dict[str, tuple[float, float]], values: dict[str, FloatArray], energy: FloatArray) -> float:
    """Share of the energy inside a box."""
    inside = np.ones(energy.size, dtype=bool)
    for name, (low, high) in found.items():
        inside &= (values[name] >= low) & (values[name] <= high)
    return float(energy[inside].sum() / energy.sum())


def size(found: dict[str, tuple[float, float]], values: dict[str, FloatArray]) -> float:
    """Product of the relative widths of a box."""
    return float(np.prod([(high - low) / np.ptp(values[name]) for name, (low, high) in found.items()]))


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10_000), number=st.integers(1, 3), rows=st.integers(1, 60))
def test_it_holds_enough_whatever_the_rows(seed: int, number: int, rows: int) -> None:
    rng = np.random.default_rng(seed)
    values = {f"q{k}": np.round(rng.normal(size=rows), 1) for k in range(number)}
    energy = rng.exponential(size=rows) ** 3
    found = box(values, energy, SHARE)
    assert set(found) == set(values)
    assert held(found, values, energy) >= SHARE * (1.0 - 1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_no_box_of_two_quantities_is_much_smaller(seed: int) -> None:
    """Against all boxes between values of rows."""
    rng = np.random.default_rng(seed)
    values = {"speed": rng.uniform(size=25), "heat": rng.uniform(size=25)}
    energy = rng.exponential(size=25) * np.exp(4.0 * values["speed"] - 3.0 * values["heat"])
    sides = [list(itertools.combinations(np.sort(values[name]), 2)) for name in values]
    smallest = min(
        size(candidate, values)
        for pair in itertools.product(*sides)
        if held(candidate := dict(zip(values, pair, strict=True)), values, energy) >= SHARE
    )
    assert size(box(values, energy, SHARE), values) <= 1.1 * smallest


def test_what_is_left_out_goes_where_that_makes_a_quantity_narrow() -> None:
    """A tail at low speed with a twentieth of the energy, and a tail in temperature that ends nearby."""
    speed = np.concatenate([np.linspace(0.8, 1.0, 80), np.full(20, 0.5)])
    heat = np.tile(np.linspace(20.0, 47.0, 20), 5)
    energy = np.concatenate([np.full(80, 0.0115), np.full(20, 0.004)])
    found = box({"velocity": speed, "temperature": heat}, energy, SHARE)
    assert found["velocity"][0] >= 0.8
    assert found["temperature"] == (20.0, 47.0)


def test_one_quantity_has_its_shortest_interval_and_nothing_has_none() -> None:
    rng = np.random.default_rng(3)
    values, energy = rng.normal(size=200), rng.exponential(size=200)
    assert box({"q": values}, energy, SHARE) == {"q": interval(values, energy, SHARE * float(energy.sum()))}
    assert box({"q": values}, np.zeros(200), SHARE) == {}
    assert box({}, energy, SHARE) == {}
