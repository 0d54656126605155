"""Formulas that are tried may be no number somewhere: that is seen by whoever tries them, and printed by nobody."""

from __future__ import annotations

import warnings

import numpy as np

from bench.simulation.formulas import evaluated


def test_a_formula_that_divides_by_nothing_says_nothing_of_it() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = evaluated("1.0 / x", {"x": np.array([0.0, 2.0])})
    assert not np.isfinite(found[0])
    assert found[1] == 0.5
