"""Offsets of recordings are no larger than the recordings' means allow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.bank import Bank, Whitening, fit
from bench.mismatch.regression.model import Block, fit_blocks
from bench.mismatch.regression.noise import RowNoise
from bench.mismatch.regression.regressors import named
from bench.simulation.frame import FloatArray
from bench.simulation.terms import MOTOR_TORQUE

RECORDINGS, EACH, SIGMA = 30, 40, 0.05
ROWS = RECORDINGS * EACH
STARTS = np.arange(0, ROWS + 1, EACH)


def banked(y: FloatArray, columns: FloatArray) -> tuple[Bank, tuple[int, ...]]:
    """A bank of white rows."""
    bank = Bank(y, Whitening(RowNoise(np.full(ROWS, SIGMA), np.zeros(ROWS), 0.1), STARTS))
    return bank, bank.add(columns)


@pytest.mark.parametrize("offset", [0.0, 0.4])
def test_what_the_means_leave_bounds_the_offsets(offset: float) -> None:
    rng = np.random.default_rng(3)
    level = np.repeat(rng.uniform(-1.0, 1.0, RECORDINGS), EACH)
    own = np.repeat(rng.normal(scale=offset, size=RECORDINGS), EACH) if offset else np.zeros(ROWS)
    y = 2.0 * level + own + rng.normal(scale=SIGMA, size=ROWS)
    bank, index = banked(y, np.column_stack([np.ones(ROWS), level]))
    widest = bank.variances()[-1]
    bank.bound_offsets(index, 0.0025)
    assert offset**2 < bank.most < 4.0 * (offset**2 + SIGMA**2 / EACH)
    assert bank.variances()[-1] <= bank.most < widest
    assert len(bank.variances()) >= 2


def test_few_means_bound_nothing() -> None:
    rng = np.random.default_rng(4)
    columns = np.repeat(rng.normal(size=(RECORDINGS, RECORDINGS - 5)), EACH, axis=0)
    bank, index = banked(rng.normal(scale=SIGMA, size=ROWS), columns)
    bank.bound_offsets(index, 0.0025)
    assert bank.most == np.inf


def test_of_free_motion_no_variance_is_tried_that_the_means_rule_out() -> None:
    """What acts inside the recordings pulls friction away from what their means say, unless offsets are bounded."""
    rng = np.random.default_rng(3)
    level = np.repeat(rng.uniform(-1.0, 1.0, RECORDINGS), EACH)
    wave = np.tile(np.sin(np.linspace(0.0, 2.0 * np.pi, EACH)), RECORDINGS)
    y = 2.0 * level + 3.0 * wave + rng.normal(scale=SIGMA, size=ROWS)
    noise = replace(RowNoise(np.full(ROWS, SIGMA), np.zeros(ROWS), 0.1), independent_rows=float(ROWS))
    bank = Bank(y, Whitening(noise, STARTS))
    index = bank.add(np.column_stack([np.ones(ROWS), level + 0.01 * wave]))
    block = Block(named("friction.coulomb", MOTOR_TORQUE, "nominal"), index, np.zeros(2))
    free = fit(bank, index, bank.variances(), np.zeros(2))
    bounded = fit_blocks(bank, [block], bank.variances())
    assert free.coefficients[1] > 3.0
    assert bounded.coefficients[1] == pytest.approx(2.0, abs=0.3)
    assert len(bank.ruled_in(bank.variances(), index, 0.0025)) < len(bank.variances())


@pytest.mark.parametrize("inside", [0.0, 40.0])
def test_what_acts_inside_the_recordings_contradicts_their_means(inside: float) -> None:
    """A slow wave inside each recording goes with a load that wavers a little there, and with nothing else."""
    rng = np.random.default_rng(6)
    level = np.repeat(rng.uniform(-1.0, 1.0, RECORDINGS), EACH)
    wave = np.tile(np.sin(np.linspace(0.0, 2.0 * np.pi, EACH)), RECORDINGS)
    load = level + 0.01 * wave
    y = 2.0 * level + inside * SIGMA * wave + rng.normal(scale=SIGMA, size=ROWS)
    bank, index = banked(y, np.column_stack([np.ones(ROWS), load]))
    bank.bound_offsets(index, 0.0025)
    fitted = fit(bank, index, bank.variances(), np.zeros(2))
    assert bank.contradicted(index, fitted.coefficients, 0.0025) is bool(inside)
    assert not bank.contradicted(index, np.array([0.0, 2.0]), 0.0025)
