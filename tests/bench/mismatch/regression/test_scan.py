"""What a gain is worth: in noise the best of a bank reaches its price as seldom as was asked."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch import criteria
from bench.mismatch.regression.bank import Bank, fit
from bench.mismatch.regression.maxima import tail, tail_probability
from bench.mismatch.regression.scan import Scan, scan
from bench.mismatch.regression.sign_blocks import units
from bench.simulation.frame import FloatArray
from tests.bench.mismatch.regression.synthetic import banked, campaign, problem

SIGMA, OFFSET, CANDIDATES, DRAWS = 0.05, 0.02, 40, 80
FRAME = campaign(20)


def candidates() -> FloatArray:
    """Functions of what is recorded (n, CANDIDATES): waves over the angle, bumps over speed, load and temperature."""
    rng = np.random.default_rng(7)
    out = []
    for k in range(CANDIDATES):
        name = ("q", "velocity", "torque", "temperature")[k % 4]
        values = getattr(FRAME, name)
        middle, width = rng.choice(values), 0.3 * np.std(values)
        out.append(np.cos(rng.integers(1, 9) * values) if name == "q" else np.exp(-(((values - middle) / width) ** 2)))
    return np.array(out).T


def looked(seed: int, shuffled: bool, effect: float = 0.0) -> Scan:
    rng = np.random.default_rng([seed, 3])
    columns = candidates()
    y = 0.6 * FRAME.direction + rng.normal(scale=SIGMA, size=FRAME.size) + effect * columns[:, 5]
    own = problem(FRAME, y + rng.normal(scale=OFFSET, size=20)[FRAME.recording])
    bank, base = banked(own, SIGMA)
    places = [bank.add(columns[:, [k]]) for k in range(CANDIDATES)]
    index = [i for b in base for i in b.indices]
    fitted = fit(bank, index, bank.variances())
    left = bank.residual(index, fitted.coefficients)
    blocks = units(FRAME.elapsed, bank.whitening.starts, criteria.BLOCK_S)
    none = np.zeros(len(index))
    return scan(bank, index, none, fitted, left, places, np.zeros(CANDIDATES), blocks, seed, shuffled)


@pytest.mark.parametrize("shuffled", [False, True])
def test_false_alarms_in_noise_are_as_rare_as_asked(shuffled: bool) -> None:
    seen = [looked(seed, shuffled) for seed in range(DRAWS)]
    alarms = sum(s.gain.max() > s.price for s in seen)
    # at 1 in 400 three of 80 have a chance of 1 in 800
    assert alarms <= 2
    low = sum(s.p_value(float(s.gain.max())) < 0.1 for s in seen)
    # the variance of twenty offsets is itself only known by them: p-values may be half as large as they should be, and
    # at 1 in 5, 26 of 80 and more have a chance of 1 in 200
    assert low < 26


def test_an_effect_is_seen_above_its_price() -> None:
    seen = looked(1, False, effect=0.2)
    assert int(np.argmax(seen.gain)) == 5
    assert seen.gain.max() > seen.price
    assert seen.p_value(float(seen.gain.max())) < criteria.ERROR_RATE_OF_A_CHANNEL


def test_the_law_of_maxima_tells_rates() -> None:
    drawn = np.random.default_rng(1).gumbel(3.0, 2.0, 4000)
    level = tail(drawn, 0.01)
    assert np.mean(drawn > level) == pytest.approx(0.01, abs=0.005)
    assert tail_probability(drawn, level) == pytest.approx(0.01, abs=0.005)
    assert tail_probability(drawn[:300], level + 50.0) == criteria.LEAST_P
    assert tail_probability(drawn[:300], level + 50.0, 0.0) < 1e-6


def test_units_stay_inside_their_recordings() -> None:
    starts = np.array([0, 30, 60])
    blocks = units(np.tile(np.arange(30.0), 2), starts, 5.0)
    assert {0, 30, 60} <= set(blocks.starts.tolist())
    assert np.bincount(blocks.recording).tolist() == [6, 6]
    assert isinstance(banked(problem(FRAME, FRAME.theta), 1.0)[0], Bank)


def test_a_large_effect_that_is_one_level_a_recording_is_a_candidate() -> None:
    # offsets a hundred times the noise of a recording's mean explain all of it until it is asked for
    rng = np.random.default_rng(5)
    level = rng.normal(size=20)[FRAME.recording]
    y = 0.6 * FRAME.direction + rng.normal(scale=SIGMA, size=FRAME.size) + 100.0 * SIGMA * level
    bank, base = banked(problem(FRAME, y), SIGMA)
    columns = np.column_stack([candidates(), level])
    places = [bank.add(columns[:, [k]]) for k in range(CANDIDATES + 1)]
    index = [i for b in base for i in b.indices]
    fitted = fit(bank, index, bank.variances())
    assert fitted.variance * np.median(bank.energy) > 1e4
    left = bank.residual(index, fitted.coefficients)
    blocks = units(FRAME.elapsed, bank.whitening.starts, criteria.BLOCK_S)
    extra, none = np.zeros(CANDIDATES + 1), np.zeros(len(index))
    seen = scan(bank, index, none, fitted, left, places, extra, blocks, 5, False)
    assert int(np.argmax(seen.gain)) == CANDIDATES
    assert seen.gain.max() > seen.price
