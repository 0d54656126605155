"""Formulas that are tried may be no number somewhere: that is seen by whoever tries them, and printed by nobody. Names
in a file that are not known are said with their place.
"""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from bench.errors import ConfigurationError
from bench.simulation import tables
from bench.simulation.formulas import evaluated, from_json


def test_a_formula_that_divides_by_nothing_says_nothing_of_it() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = evaluated("1.0 / x", {"x": np.array([0.0, 2.0])})
    assert not np.isfinite(found[0])
    assert found[1] == 0.5


@pytest.mark.parametrize(
    ("over", "times", "message"),
    [
        ("risen_352x", "1", "the term unknown: there is no quantity 'risen_352x', it should be one of speed, "),
        ("speed", "d*dd", "the term unknown: there is no factor 'dd', it should be one of 1, d, "),
    ],
)
def test_a_name_that_is_not_known_is_said_with_its_place(over: str, times: str, message: str) -> None:
    table = {"over": [over], "times": times, "knots": [[0.0, 1.0]], "values": [0.0, 1.0]}
    formula = {
        "over": [over],
        "within": [[0.0, 1.0]],
        "parts": [{"times": times, "text": "x1"}],
        "parameters": {"c1": 1.0},
    }
    for read, row in ((tables.from_json, table), (from_json, formula)):
        with pytest.raises(ConfigurationError) as told:
            read(row, "the term unknown")
        assert str(told.value).startswith(message)
