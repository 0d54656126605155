"""A name at the end of its range, beside a function without a name of the same quantity."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.mismatch.regression.model import Chosen, add_block
from bench.mismatch.regression.pruning import no_name_at_its_end
from bench.mismatch.regression.refine import at_longest, bounds
from bench.mismatch.regression.regressors import Free, Named, named
from bench.mismatch.regression.search import begun
from bench.simulation.tables import Grid
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE
from tests.bench.mismatch.regression.synthetic import campaign, problem

FRAME = campaign()
SEARCH = begun(problem(FRAME, 0.6 * FRAME.direction + np.random.default_rng(1).normal(0.0, 0.05, FRAME.size)))
FORM = LIBRARY["friction.presliding"].form(MOTOR_TORQUE, "reversal")
assert FORM is not None
LONGEST = float(bounds(FORM, FRAME)[1][0])


def chosen(regressor: Named | Free) -> Chosen:
    return Chosen(add_block(SEARCH.model.problem, SEARCH.model.bank, regressor))


def presliding(way: float) -> Chosen:
    return chosen(named("friction.presliding", MOTOR_TORQUE, "reversal", (way,)))


def function_of(quantity: str) -> Chosen:
    return chosen(Free(MOTOR_TORQUE, (Grid((quantity,), "d", ((1.0, 2.0, 4.0),)),)))


def that_predicts_with(best: Chosen) -> Any:
    """A search whose points left out are predicted better by models that have one effect."""
    return SimpleNamespace(model=SEARCH.model, density=lambda own: np.array([float(any(c is best for c in own))]))


@pytest.mark.parametrize("quantity", ["distance_since_start", "since_reversal"])
def test_what_decays_over_a_longer_way_than_a_name_can_is_the_function_beside_it(quantity: str) -> None:
    name, function = presliding(LONGEST), function_of(quantity)
    assert at_longest(name.main.regressor, FRAME)
    assert no_name_at_its_end(that_predicts_with(function), [name, function]) == [function]


def test_a_name_that_says_more_than_the_function_stays() -> None:
    name, function = presliding(LONGEST), function_of("since_reversal")
    assert no_name_at_its_end(that_predicts_with(name), [name, function]) == [name, function]


def test_a_name_inside_its_range_stays_and_so_does_one_beside_another_quantity() -> None:
    inside, at_end = presliding(0.3 * LONGEST), presliding(LONGEST)
    shortest = presliding(float(bounds(FORM, FRAME)[0][0]))
    function, other = function_of("distance_since_start"), function_of("temperature")
    of_function, of_other = that_predicts_with(function), that_predicts_with(other)
    assert no_name_at_its_end(of_function, [inside, function]) == [inside, function]
    assert no_name_at_its_end(of_function, [shortest, function]) == [shortest, function]
    assert no_name_at_its_end(of_other, [at_end, other]) == [at_end, other]
    assert no_name_at_its_end(of_other, [at_end]) == [at_end]
