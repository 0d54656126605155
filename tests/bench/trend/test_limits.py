"""Limits of control hold what they promise, whether the campaigns scatter or only the identifications do."""

from __future__ import annotations

import numpy as np
import pytest

from bench.trend.limits import chance_of_change, limits_from, scatter_between
from bench.trend.quantities import Value

CHARTS = 400


@pytest.mark.parametrize("scatter", [0.0, 2.0])
@pytest.mark.parametrize("campaigns", [3, 8])
def test_a_gearbox_that_stays_as_it_is_stays_within(scatter: float, campaigns: int) -> None:
    rng = np.random.default_rng(campaigns)
    outside = 0
    for _ in range(CHARTS):
        std = rng.uniform(0.5, 2.0, campaigns + 1)
        estimated_std = std * np.sqrt(rng.chisquare(9, std.size) / 9)
        x = rng.normal(0.0, scatter, std.size) + std * rng.normal(size=std.size)
        *earlier, new = [Value(float(a), float(b), 9.0) for a, b in zip(x, estimated_std, strict=True)]
        limits = limits_from(earlier, new)
        assert limits is not None
        outside += not limits.lower <= new.value <= limits.upper
    # 0.27 % is meant, one of 400; five have a chance of 0.6 % then
    assert outside <= 4


def test_a_change_beyond_them_is_outside_and_an_uncertain_campaign_has_wider_ones() -> None:
    earlier = [Value(10.0 + 0.1 * k, 0.2, 9.0) for k in range(-3, 4)]
    sharp, blunt = limits_from(earlier, Value(13.0, 0.2, 9.0)), limits_from(earlier, Value(13.0, 2.0, 9.0))
    assert sharp is not None
    assert blunt is not None
    assert sharp.upper < 13.0 < blunt.upper
    assert sharp.centre == pytest.approx(10.0)
    assert limits_from(earlier[:2], earlier[2]) is None


def test_scatter_is_what_the_standard_deviations_do_not_explain() -> None:
    values = np.array([-2.0, 0.0, 2.0, 1.0, -1.0])
    assert scatter_between(values, np.full(5, 0.01)) == pytest.approx(2.5, rel=1e-3)
    assert scatter_between(values, np.full(5, 5.0)) == 0.0
    assert scatter_between(np.ones(4), np.ones(4)) == 0.0


def test_a_change_is_judged_by_both_standard_deviations() -> None:
    assert chance_of_change(Value(0.0, 1.0), Value(2.77, 1.0)) == pytest.approx(0.05, abs=1e-3)
    assert chance_of_change(Value(0.0, 1.0, 3.0), Value(2.77, 1.0, 3.0)) > 0.08
