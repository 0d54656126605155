"""Predictive gains: useless columns lose, true ones win, however the recordings are offset or coloured."""

import numpy as np
import pytest

from bench.mismatch.bank import Bank, Noise, whiten

ROWS, RECORDINGS = 3000, 30


def _starts() -> np.ndarray:
    return np.linspace(0, ROWS, RECORDINGS + 1).astype(np.int64)


def _bank(y: np.ndarray, columns: np.ndarray, variances: tuple[float, ...] = (0.0,), rho: float = 0.0) -> Bank:
    noise = Noise(np.ones(ROWS), np.full(ROWS, rho), variances)
    return Bank(y, _starts(), np.arange(RECORDINGS), columns, np.zeros(columns.shape[1]), noise)


@pytest.fixture(name="rng")
def _rng() -> np.random.Generator:
    return np.random.default_rng(7)


def test_a_useless_column_loses_and_a_true_one_wins(rng: np.random.Generator) -> None:
    columns = rng.normal(size=(ROWS, 3))
    y = 2.0 * columns[:, 0] + 0.3 * columns[:, 2] + rng.normal(size=ROWS)
    bank = _bank(y, columns)
    base = bank.fit([0]).total
    assert bank.fit([0, 1]).total < base + 4.0
    assert bank.fit([0, 2]).total > base + 80.0


def test_coefficients_and_their_spread(rng: np.random.Generator) -> None:
    columns = rng.normal(size=(ROWS, 2))
    y = columns @ np.array([1.5, -0.7]) + rng.normal(size=ROWS)
    fit = _bank(y, columns).fit([0, 1], leave_out=False)
    assert fit.coefficients == pytest.approx([1.5, -0.7], abs=0.08)
    assert np.sqrt(np.diag(fit.covariance)) == pytest.approx(1 / np.sqrt(ROWS), rel=0.1)


def test_offsets_between_recordings_are_not_taken_for_an_effect(rng: np.random.Generator) -> None:
    level = np.repeat(rng.normal(size=RECORDINGS), np.diff(_starts()))
    between = np.repeat(rng.normal(size=RECORDINGS), np.diff(_starts()))[:, None]
    y = level + rng.normal(size=ROWS)
    free = _bank(y, between, (0.0, 0.1, 1.0, 10.0))
    assert free.fit([0]).total - free.fit([]).total < 5.0
    assert free.fit([]).offset_variance == pytest.approx(1.0)


def test_a_column_seen_in_one_recording_only_pays_for_it(rng: np.random.Generator) -> None:
    once = np.zeros((ROWS, 1))
    once[: ROWS // RECORDINGS] = 1.0
    y = rng.normal(size=ROWS)
    bank = _bank(y, once)
    assert bank.fit([0]).total < bank.fit([]).total


def test_replacing_columns_is_the_same_as_building_anew(rng: np.random.Generator) -> None:
    columns = rng.normal(size=(ROWS, 3))
    y = rng.normal(size=ROWS) + columns[:, 1]
    other = rng.normal(size=(ROWS, 1))
    bank = _bank(y, columns, (0.0, 0.1), rho=0.4)
    bank.replace([2], other)
    anew = _bank(y, np.hstack([columns[:, :2], other]), (0.0, 0.1), rho=0.4)
    assert bank.fit([0, 1, 2]).total == pytest.approx(anew.fit([0, 1, 2]).total, rel=1e-9)


def test_whitening_takes_the_correlation_out(rng: np.random.Generator) -> None:
    noise = np.zeros(ROWS)
    shocks = rng.normal(size=ROWS)
    for i in range(1, ROWS):
        noise[i] = 0.8 * noise[i - 1] + shocks[i]
    white = whiten(noise[:, None], Noise(np.full(ROWS, 1.0 / 0.6), np.full(ROWS, 0.8)), np.array([0, ROWS]))[:, 0]
    assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.06


def test_what_the_base_absorbs(rng: np.random.Generator) -> None:
    columns = rng.normal(size=(ROWS, 2))
    doubled = np.column_stack([columns, columns @ [1.0, 1.0], rng.normal(size=ROWS)])
    bank = _bank(rng.normal(size=ROWS), doubled)
    assert bank.explained([2], [0, 1]) < 1e-6
    assert bank.explained([3], [0, 1]) > 0.9


def test_the_offsets_variance_falls_as_far_as_a_column_explains_them(rng: np.random.Generator) -> None:
    inside = np.repeat(np.arange(RECORDINGS) < 9, np.diff(_starts())).astype(float)
    y = 6.0 * inside + rng.normal(size=ROWS)
    bank = _bank(y, np.column_stack([np.ones(ROWS), inside]), (0.0, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0))
    assert bank.fit([0]).offset_variance >= 3.0
    assert bank.fit([0, 1]).offset_variance == 0.0
    assert bank.fit([0, 1]).total - bank.fit([0]).total > 60.0
