"""The test holds what it proves: fair bets, a bound however long it runs, and it sees changes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bench.twin.evidence import BIAS, Evidence, combined_log, factors, weight, weight_after


def test_weights_of_the_time_of_change_sum_to_one() -> None:
    assert sum(weight(k) for k in range(1, 5001)) + weight_after(5000) == pytest.approx(1.0, abs=1e-12)
    assert weight_after(0) == pytest.approx(1.0)


@pytest.mark.parametrize("signed", [True, False])
def test_no_bet_wins_on_average_while_the_model_holds(signed: bool) -> None:
    rng = np.random.default_rng(1)
    tried = 0
    while tried < 3000:
        # any law of two values with a mean within ±BIAS and a mean square of at most 1
        p, a, b = rng.uniform(0.01, 0.99), *rng.normal(0.0, rng.choice([0.5, 2.0, 8.0]), 2)
        if abs(p * a + (1 - p) * b) > BIAS or p * a * a + (1 - p) * b * b > 1.0:
            continue
        tried += 1
        mean = p * np.exp(factors(a, signed)) + (1 - p) * np.exp(factors(b, signed))
        assert (mean <= 1.0 + 1e-9).all()


def test_false_alarms_stay_below_the_bound_on_dependent_heavy_tailed_numbers() -> None:
    rng = np.random.default_rng(2)
    alarms = 0
    for _ in range(400):
        evidence, spread, highest = Evidence(True), 1.0, 0.0
        for k in range(1, 151):
            # scatter that comes in bursts, tails of Student's t with 3 degrees, a bias that never goes
            spread = 0.9 * spread + 0.1 * rng.choice([0.4, 1.5])
            size = math.sqrt(1.0 - BIAS**2) * min(spread, 1.0) / math.sqrt(3.0)
            evidence.add(float(BIAS + size * rng.standard_t(3)), k)
            highest = max(highest, evidence.log)
        alarms += highest >= math.log(100.0)
    assert alarms <= 4 + 2 * 2  # 1 in 100 of 400, and two standard deviations


def test_a_change_is_seen_and_dated() -> None:
    rng = np.random.default_rng(3)
    evidence, seen = Evidence(True), None
    for k in range(1, 61):
        evidence.add(float(rng.normal(0.0, 0.35) + (2.5 if k >= 30 else 0.0)), k)
        if seen is None and evidence.log > math.log(100.0):
            seen = k
    assert seen is not None
    assert 30 < seen < 42
    since = evidence.since()
    assert since is not None
    assert abs(since - 30) <= 1


def test_recordings_without_a_number_lose_no_weight() -> None:
    whole, gaps = Evidence(False), Evidence(False)
    for k in range(1, 41):
        whole.add(1.0, k)
        if k % 2:
            gaps.add(1.0, k)
    # a square of 1 is worth a factor of 1 in every bet: nothing is won, nothing lost
    assert whole.log == pytest.approx(0.0, abs=1e-9)
    assert gaps.log == pytest.approx(0.0, abs=1e-9)


def test_together_is_a_mean() -> None:
    assert combined_log(np.log([3.0, 1.0]), np.array([0.5, 0.5])) == pytest.approx(math.log(2.0))
