"""Functions that were found get finer tables where their knots are too far apart for them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.finer import coarser, finer_tables
from bench.mismatch.regression.knots import halved
from bench.mismatch.regression.model import Chosen, add_block
from bench.mismatch.regression.regressors import Free, knots_of_table, named
from bench.mismatch.regression.search import begun, searched
from bench.simulation.tables import Grid
from tests.bench.mismatch.regression.synthetic import campaign, problem

SIGMA = 0.02


def _table(number: int, over: tuple[str, ...] = ("temperature",), times: str = "d", effect: str = "unknown") -> Free:
    knots = tuple(np.linspace(20.0, 40.0, number).tolist())
    return Free("motor_torque", (Grid(over, times, (knots,) * len(over)),), effect)


@pytest.mark.parametrize(("width", "finer"), [(0.6, True), (6.0, False)])
def test_what_is_sharper_than_a_coarse_table_gets_a_finer_one(width: float, finer: bool) -> None:
    """A hump of drag at 31 degC, much narrower than the distance of twelve knots over the temperatures, or wider."""
    frame = campaign(120)
    hump = 0.3 * frame.direction * np.exp(-0.5 * ((frame.temperature - 31.0) / width) ** 2)
    noise = np.random.default_rng(4).normal(scale=SIGMA, size=frame.size)
    model = searched(problem(frame, 0.6 * frame.direction + hump + noise)).model
    (found,) = model.chosen
    assert found.main.regressor.variables == ("temperature",)
    assert (len(knots_of_table(found.main.regressor)) > 12) is finer
    left = hump - model.contribution(found, frame)
    assert np.std(left[frame.direction > 0]) < SIGMA


def test_a_table_of_a_quantity_that_keeps_a_few_levels_gets_no_finer() -> None:
    frame = campaign(24)
    levels = np.round(frame.temperature / 10.0) * 10.0
    frame = replace(frame, temperature=levels)
    effect = 0.3 * frame.direction * (levels == 30.0)
    noise = np.random.default_rng(4).normal(scale=SIGMA, size=frame.size)
    search = searched(problem(frame, 0.6 * frame.direction + effect + noise))
    assert search.model.chosen
    assert finer_tables(search) == []


def test_a_finer_table_stands_in_place_of_the_same_function_alone() -> None:
    assert coarser(_table(6), _table(12))
    assert not coarser(_table(12), _table(12))
    assert not coarser(_table(6), _table(12, times="1"))
    assert not coarser(_table(6), _table(12, over=("speed",)))
    assert coarser(_table(6, effect="friction.run_in"), _table(12))
    assert not coarser(_table(6, effect="friction.run_in"), _table(12, effect="friction.viscous_temperature"))
    assert not coarser(_table(4, over=("speed", "load")), _table(12))
    assert not coarser(named("friction.stribeck", "motor_torque", "gaussian", (0.5,)), _table(12))


def test_finer_knots_are_those_of_the_coarse_table_and_some_between_where_there_are_values() -> None:
    coarse = (0.0, 1.0, 4.0, 16.0)
    assert halved(coarse, np.linspace(0.0, 16.0, 400)) == (0.0, 0.5, 1.0, 2.5, 4.0, 10.0, 16.0)
    assert halved(coarse, np.array([0.0, 0.1, 1.0, 2.4, 4.0, 16.0])) == (0.0, 1.0, 2.5, 4.0, 16.0)


@pytest.mark.parametrize(
    ("refuted", "out"), [(6, [True, True, True]), (12, [True, True, True]), (23, [False, False, True])]
)
def test_a_finer_table_that_was_refuted_says_nothing_of_coarser_ones(refuted: int, out: list[bool]) -> None:
    frame = campaign(24)
    own = problem(frame, 0.6 * frame.direction + np.random.default_rng(4).normal(scale=SIGMA, size=frame.size))
    search = begun(own)
    search.refuted = [Chosen(add_block(own, search.bank, _table(refuted)))]
    assert [search.out(_table(number)) for number in (6, 12, 41)] == out
    assert not search.out(_table(41, times="1"))
