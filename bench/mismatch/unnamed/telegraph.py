"""Telegraphs: what is left jumps between two levels at random, as a bearing seat or a contact that is loose does.

Two descriptions of the residual in steady motion are compared, each with an offset of each piece of a recording that is
not known: a chain of two levels with white noise (Rabiner, Proc. IEEE 77 (1989) 257), and Gaussian noise whose spectrum
may be the same (two first-order processes and white noise). The chain is fitted to every other recording and asked of
the rest, and the other way round; the Gaussian noise is fitted to the recordings that are asked. Such a split
likelihood ratio is above 1/p in a share p of all folders at most, whatever the noise's spectrum (Wasserman, Ramdas and
Balakrishnan, PNAS 117 (2020) 16880).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.ndimage import median_filter
from scipy.optimize import minimize
from scipy.special import logsumexp

from bench.mismatch import criteria
from bench.mismatch.recordings.rows import settled_rows
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray, Frame, IntArray
from bench.simulation.quantities import factor

BIN_S = 1.0
"""means of the residual over this long; stays that are shorter are noise here"""
LONGEST = 120
"""bins of a piece; longer recordings are cut"""
FEWEST_BINS = 8
FEWEST_PIECES = 12
SHORTEST_STAY = 3.0
"""bins: a level that is left sooner is an outlier"""
FEWEST_MOVES = 10.0
"""jumps in the campaign below which nobody can say that they come at random: of so many a rate is known to a third"""
OUTLIER = 4.0
"""standard deviations from the neighbours beyond which one bin is left out"""
NEIGHBOURS = 5
FACTORS = ("1", "d")
"""what the jumps may be multiplied with: nothing, or the direction, as friction is"""
STEPS = 60
"""of expectation maximisation"""
MEMORIES_S = (2.0, 8.0, 30.0, 100.0)
"""time constants with which the fit of the Gaussian noise begins"""


@dataclass(frozen=True, slots=True)
class Telegraph:
    """Two levels: what they are multiplied with, their distance with its standard deviation, mean stays (s) in the
    lower and the upper one with theirs, p-value; ``course`` (n,): what it adds to each row of the channel, about the
    mean of its piece.
    """

    times: str
    height: float
    height_std: float
    stays: tuple[float, float]
    stays_std: tuple[float, float]
    p_value: float
    course: FloatArray


@dataclass(frozen=True, slots=True)
class _Pieces:
    """Means of a residual (pieces, bins), the samples of each relative to the usual bin (0: none), the recording of
    each piece; of each row used its piece and bin.
    """

    values: FloatArray
    weight: FloatArray
    recording: IntArray
    rows: IntArray
    piece: IntArray
    bin: IntArray

    def some(self, chosen: NDArray[np.bool_]) -> _Pieces:
        """Of some pieces, without their rows."""
        none = np.zeros(0, dtype=np.int64)
        return _Pieces(self.values[chosen], self.weight[chosen], self.recording[chosen], none, none, none)


@dataclass(frozen=True, slots=True)
class _Chain:
    """Distance of the levels, probability of leaving the lower and the upper one in a bin, variance of a usual bin."""

    height: float
    leave: tuple[float, float]
    variance: float

    @property
    def upper(self) -> float:
        """Share of the time in the upper level."""
        return self.leave[0] / (self.leave[0] + self.leave[1])

    @property
    def lasting(self) -> bool:
        """Whether both levels last."""
        return max(self.leave) <= 1.0 / SHORTEST_STAY


def telegraph(search: Search) -> Telegraph | None:
    """The clearest telegraph in what a channel's model leaves in steady motion; None where none can be told."""
    problem = search.model.problem
    if problem.spec.integral or problem.free:
        return None
    rows = np.flatnonzero(problem.train & settled_rows(problem.rows.frame))
    frame = problem.rows.frame.take(rows)
    left = (problem.rows.y - search.model.predict(problem.rows.frame))[rows]
    number = np.asarray(problem.rows.number[rows], dtype=np.float64)
    looks: list[Telegraph] = []
    for times in FACTORS:
        pieces = _pieces(frame, left * factor(times, frame), number)
        if pieces is None:
            return None
        found = _look(pieces, times)
        if found is not None:
            course = np.zeros(problem.rows.size)
            own = _course(pieces, found[0])[pieces.piece, pieces.bin]
            course[rows[pieces.rows]] = own * factor(times, frame)[pieces.rows]
            looks.append(_told(pieces, found[0], times, min(1.0, len(FACTORS) * found[1]), course))
    return min(looks, key=lambda t: t.p_value, default=None)


def _pieces(frame: Frame, left: FloatArray, number: FloatArray) -> _Pieces | None:
    """Bins of the rows of a frame, by recording; None where too few are long enough."""
    bins = np.floor(frame.elapsed / BIN_S).astype(np.int64)
    keys = frame.recording.astype(np.int64) * (1 << 32) + bins // LONGEST
    values: list[FloatArray] = []
    weights: list[FloatArray] = []
    recordings: list[int] = []
    used, piece, place = [], [], []
    for key in np.unique(keys):
        own = np.flatnonzero(keys == key)
        at = bins[own] - bins[own].min()
        if at.max() + 1 < FEWEST_BINS:
            continue
        samples = np.asarray(np.bincount(at, number[own], LONGEST), dtype=np.float64)
        sums = np.asarray(np.bincount(at, number[own] * left[own], LONGEST), dtype=np.float64)
        used.append(own)
        piece.append(np.full(own.size, len(values)))
        place.append(at)
        values.append(np.divide(sums, samples, out=np.zeros(LONGEST), where=samples > 0.0))
        weights.append(samples)
        recordings.append(int(key >> 32))
    if len(values) < FEWEST_PIECES:
        return None
    table: FloatArray = np.array(values)
    weight: FloatArray = np.array(weights)
    weight = weight / np.median(weight[weight > 0.0])
    weight[weight < 0.5] = 0.0  # begins and ends
    return _Pieces(
        table,
        _without_outliers(table, weight),
        np.array(recordings),
        np.concatenate(used),
        np.concatenate(piece),
        np.concatenate(place),
    )


def _without_outliers(values: FloatArray, weight: FloatArray) -> FloatArray:
    """Weights (pieces, bins) without single bins far from their neighbours: spikes are no level."""
    off = values - median_filter(values, (1, NEIGHBOURS), mode="nearest")
    seen = weight > 0.0
    spread = 1.4826 * float(np.median(np.abs(off[seen]))) or float(np.std(off[seen])) or 1.0
    return np.where(np.abs(off) > OUTLIER * spread, 0.0, weight)


def _look(pieces: _Pieces, times: str) -> tuple[_Chain, float] | None:
    """The chain of all pieces and its p-value; None where there is none that lasts, or Gaussian noise says as much."""
    halves = [np.unique(pieces.recording, return_inverse=True)[1] % 2 == k for k in (0, 1)]
    ratios = []
    for fitted, asked in (halves, halves[::-1]):
        chain = _fitted(pieces.some(fitted))
        if chain is None or not chain.lasting:
            return None
        ratios.append(_ratio(pieces.some(asked), chain))
        if ratios[-1] is None:
            return None
    whole = _fitted(pieces)
    if whole is None or not whole.lasting or _moves(pieces, whole) < FEWEST_MOVES:
        return None
    e_value = float(logsumexp(np.array(ratios, dtype=np.float64)) - np.log(2.0))
    return whole, float(np.exp(-max(e_value, 0.0)))


def _fitted(pieces: _Pieces) -> _Chain | None:
    """The most likely chain, with an offset of each piece (expectation maximisation)."""
    seen = pieces.weight > 0.0
    centre = pieces.values - _means(pieces.values, pieces.weight)[:, None]
    spread = float(np.sqrt(np.sum(pieces.weight * centre**2) / pieces.weight.sum()))
    if spread == 0.0:
        return None
    best: tuple[float, _Chain] | None = None
    for share in (0.3, 0.7):
        chain = _Chain(2.0 * spread, (0.1 * share / 0.5, 0.1 * (1.0 - share) / 0.5), 0.3 * spread**2)
        offset = _means(pieces.values, pieces.weight) - chain.height * chain.upper
        total = -np.inf
        for _ in range(STEPS):
            up, moves, total = _smoothed(pieces, chain, offset)
            weight = pieces.weight
            offset = _means(pieces.values - chain.height * up, weight)
            rest = pieces.values - offset[:, None]
            height = float(np.sum(weight * up * rest) / max(np.sum(weight * up), 1e-12))
            squares = (1.0 - up) * rest**2 + up * (rest - height) ** 2
            variance = float(np.sum(np.where(seen, weight * squares, 0.0)) / seen.sum())
            leave = tuple(float(np.clip(moves[k, 1 - k] / max(moves[k].sum(), 1e-12), 1e-4, 0.9)) for k in (0, 1))
            if not np.isfinite(height) or height <= 0.0 or variance <= 0.0:
                break
            chain = _Chain(height, (leave[0], leave[1]), variance)
        if np.isfinite(total) and (best is None or total > best[0]):
            best = (total, chain)
    return None if best is None else best[1]


def _means(values: FloatArray, weight: FloatArray) -> FloatArray:
    return np.asarray((values * weight).sum(axis=1) / np.maximum(weight.sum(axis=1), 1e-12))


def _emissions(rest: FloatArray, weight: FloatArray, chain: _Chain) -> FloatArray:
    """Log density of what is left beside an offset (...) in each level (..., 2)."""
    off = np.stack([rest, rest - chain.height], axis=-1)
    known = weight[..., None] > 0.0
    precision = np.where(known, weight[..., None], 1.0) / chain.variance
    return np.where(known, 0.5 * (np.log(precision / (2.0 * np.pi)) - precision * off**2), 0.0)


def _transition(chain: _Chain) -> FloatArray:
    a, b = chain.leave
    return np.array([[1.0 - a, a], [b, 1.0 - b]])


def _smoothed(pieces: _Pieces, chain: _Chain, offset: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Probability of the upper level (pieces, bins), expected moves from level to level (2, 2), log-likelihood."""
    log = _emissions(pieces.values - offset[:, None], pieces.weight, chain)
    peak = log.max(axis=-1, keepdims=True)
    likely = np.exp(log - peak)
    moves = _transition(chain)
    ahead = np.empty_like(likely)
    scale = np.empty(likely.shape[:2])
    now = np.broadcast_to([1.0 - chain.upper, chain.upper], likely[:, 0].shape)
    for k in range(likely.shape[1]):
        now = now * likely[:, k] if k == 0 else (now @ moves) * likely[:, k]
        scale[:, k] = now.sum(axis=1)
        now = now / scale[:, [k]]
        ahead[:, k] = now
    behind = np.ones(likely[:, 0].shape)
    both = np.empty_like(likely)
    counts = np.zeros((2, 2))
    last = _last(pieces.weight)
    for k in range(likely.shape[1] - 1, -1, -1):
        both[:, k] = ahead[:, k] * behind
        if k:
            # what lies behind a piece's last bin is no move
            into = likely[:, k] * behind / scale[:, [k]]
            counts += np.einsum("p,pi,ij,pj->ij", (k <= last).astype(float), ahead[:, k - 1], moves, into)
            behind = into @ moves.T
    return both[..., 1] / both.sum(axis=-1), counts, float(np.log(scale).sum() + peak.sum())


def _last(weight: FloatArray) -> IntArray:
    return np.asarray(weight.shape[1] - 1 - np.argmax(weight[:, ::-1] > 0.0, axis=1))


def _ratio(pieces: _Pieces, chain: _Chain) -> float | None:
    """Logarithm of the likelihood of a chain over that of the best Gaussian noise; None where it is below one."""
    of_chain = _likelihood(pieces, chain)
    seen = [np.flatnonzero(w > 0.0) for w in pieces.weight]
    data = [(k, v[k], 1.0 / w[k]) for k, v, w in zip(seen, pieces.values, pieces.weight, strict=True) if k.size > 1]
    total = float(np.sum(pieces.weight * (pieces.values - _means(pieces.values, pieces.weight)[:, None]) ** 2))
    variance = total / float((pieces.weight > 0.0).sum())
    begins = [
        np.log([variance * (1.0 - share), variance * share, memory, 0.1 * variance * share, 4.0 * memory])
        for memory in MEMORIES_S
        for share in (0.3, 0.7)
    ]
    costs = [_gaussian_cost(x, data) for x in begins]
    if -min(costs) >= of_chain:
        return None
    found = minimize(
        _gaussian_cost, begins[int(np.argmin(costs))], (data,), "Nelder-Mead", options={"maxfev": 250, "fatol": 0.1}
    )
    ratio = of_chain + float(found.fun)
    return ratio if ratio > 0.0 else None


def _gaussian_cost(x: FloatArray, data: Sequence[tuple[IntArray, FloatArray, FloatArray]]) -> float:
    """Minus the log-likelihood of white noise and two first-order processes, the offsets integrated over all values.

    ``x``: logarithms of the white variance, and of variance and time constant (bins) of each process.
    """
    white, first, memory, second, longer = np.exp(np.clip(x, -80.0, 80.0))
    out = 0.0
    lags = np.arange(LONGEST)
    course = first * np.exp(-lags / memory) + second * np.exp(-lags / longer)
    for at, values, noise in data:
        whole = course[np.abs(at[:, None] - at[None, :])]
        whole[np.diag_indices(at.size)] += white * noise
        try:
            factored = cho_factor(whole, lower=True, check_finite=False)
        except np.linalg.LinAlgError:
            return float("inf")
        one = cho_solve(factored, np.ones(at.size), check_finite=False)
        inside = cho_solve(factored, values, check_finite=False)
        level = float(one.sum())
        squares = float(values @ inside) - float(values @ one) ** 2 / level
        constants = 2.0 * float(np.log(np.diag(factored[0])).sum()) + np.log(level)
        out += 0.5 * (squares + constants + (at.size - 1) * np.log(2.0 * np.pi))
    return out


def _likelihood(pieces: _Pieces, chain: _Chain) -> float:
    """Log-likelihood of a chain, the offsets integrated over all values, as those of the Gaussian noise."""
    moves = _transition(chain)
    out = 0.0
    for values, weight in zip(pieces.values, pieces.weight, strict=True):
        seen = np.flatnonzero(weight > 0.0)
        if seen.size < 2:
            continue
        step = np.sqrt(chain.variance / weight.sum())
        middle = float(np.average(values, weights=weight))
        offsets = np.arange(middle - chain.height - 8.0 * step, middle + 8.0 * step, step)
        last = int(seen[-1]) + 1
        log = _emissions(values[:last, None] - offsets, np.repeat(weight[:last, None], offsets.size, axis=1), chain)
        peak = log.max(axis=-1, keepdims=True)
        likely = np.exp(log - peak)
        now = np.broadcast_to([1.0 - chain.upper, chain.upper], likely[0].shape)
        total = peak[..., 0].sum(axis=0)
        for k in range(last):
            now = now * likely[k] if k == 0 else (now @ moves) * likely[k]
            scale = now.sum(axis=1)
            total = total + np.log(scale)
            now = now / scale[:, None]
        out += float(logsumexp(total) + np.log(step))
    return out


def _course(pieces: _Pieces, chain: _Chain) -> FloatArray:
    """What the chain adds to each bin (pieces, bins), about the mean of its piece."""
    offset = _means(pieces.values, pieces.weight) - chain.height * chain.upper
    for _ in range(STEPS):
        up = _smoothed(pieces, chain, offset)[0]
        offset = _means(pieces.values - chain.height * up, pieces.weight)
    return np.asarray(chain.height * (up - _means(up, pieces.weight)[:, None]))


def _moves(pieces: _Pieces, chain: _Chain) -> float:
    """Jumps up that a chain has in so many bins."""
    return float(np.sum(pieces.weight > 0.0)) * (1.0 - chain.upper) * chain.leave[0]


def _told(pieces: _Pieces, chain: _Chain, times: str, p_value: float, course: FloatArray) -> Telegraph:
    """A chain with what its bins say of its numbers: a mean of as many, a rate of as many moves."""
    seen = float(np.sum(pieces.weight > 0.0))
    share = (1.0 - chain.upper, chain.upper)
    moves = _moves(pieces, chain)
    stays = (BIN_S / chain.leave[0], BIN_S / chain.leave[1])
    return Telegraph(
        times,
        chain.height,
        float(np.sqrt(chain.variance * sum(1.0 / max(seen * s, 1.0) for s in share))),
        stays,
        (stays[0] / float(np.sqrt(moves)), stays[1] / float(np.sqrt(moves))),
        max(p_value, criteria.LEAST_P),
        course,
    )
