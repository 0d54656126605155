"""Coefficients beyond their physical bounds: no finding, however much they gain."""

from typing import Any, cast

import numpy as np
import pytest

from bench.mismatch.bank import Fit
from bench.mismatch.columns import Entry
from bench.mismatch.select import Search

POSITIVE = ((0.0, np.inf),)


class Bank:
    """Knows the coefficient of every column, and that it is known to a tenth."""

    def __init__(self, *values: float) -> None:
        self.values = np.array(values)

    def fit(self, index: Any, leave_out: bool = True) -> Fit:
        gain = float(np.sum(self.values[list(index)] ** 2))
        coefficients = np.zeros(0) if leave_out else self.values[list(index)]
        return Fit(np.array([gain]), coefficients, 0.01 * np.eye(coefficients.size), 0.0)


def search(bank: Bank, *entries: Entry) -> Search:
    return Search(cast(Any, bank), (0,), list(entries))


def lag(index: int) -> Entry:
    return Entry("thermal.sensor_lag", "first_order", (12.0,), (index,), bounds=POSITIVE)


def test_a_lag_that_leads_is_passed_over_for_the_next_best() -> None:
    made = search(Bank(1.0, -5.0, 3.0), lag(1), lag(2))
    assert made.best((), made.entries) == (lag(2), pytest.approx(9.0))


def test_where_nothing_is_possible_there_is_no_best() -> None:
    made = search(Bank(1.0, -5.0, -3.0), lag(1), lag(2))
    assert made.best((), made.entries) == (None, -np.inf)


@pytest.mark.parametrize(("value", "possible"), [(-0.15, True), (-0.25, False), (4.0, True)])
def test_a_coefficient_may_miss_its_bound_by_its_doubt(value: float, possible: bool) -> None:
    made = search(Bank(1.0, value), lag(1))
    assert made.admissible((), lag(1)) is possible


@pytest.mark.parametrize(("values", "possible"), [((2.0, 1.0), True), ((2.0, -0.1), True), ((2.0, -1.0), False)])
def test_parts_of_one_thing_have_one_sign(values: tuple[float, float], possible: bool) -> None:
    free = ((-np.inf, np.inf),) * 2
    stack = Entry("te.hysteresis", "stack", (50.0,), (1, 2), bounds=free, one_sign=True)
    assert search(Bank(1.0, *values), stack).admissible((), stack) is possible
    assert search(Bank(1.0, *values), stack).admissible((), Entry("unknown", "knots", (), (1, 2)))
