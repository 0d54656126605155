"""A chain of two levels with white noise (Rabiner, Proc. IEEE 77 (1989) 257), in pieces whose offsets are not known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from bench.mismatch.unnamed.binned import Pieces, means
from bench.simulation.frame import FloatArray, IntArray

SHORTEST_STAY = 3.0
"""bins: a level that is left sooner is an outlier"""
STEPS = 60
"""of expectation maximisation at most"""
CONVERGED = 0.01
"""nats that a step has to gain, for another one to be made: a decision needs hundreds of times as much"""


@dataclass(frozen=True, slots=True)
class Chain:
    """Distance of the levels, probability of leaving the lower and the upper one in a bin, variance of a usual bin."""

    height: float
    leave: tuple[float, float]
    variance: float

    @property
    def upper(self) -> float:
        """Share of the time in the upper level."""
        return self.leave[0] / (self.leave[0] + self.leave[1])

    @property
    def size(self) -> float:
        """Root mean square about the mean."""
        return self.height * float(np.sqrt(self.upper * (1.0 - self.upper)))

    @property
    def lasting(self) -> bool:
        """Whether both levels last."""
        return max(self.leave) <= 1.0 / SHORTEST_STAY


def fitted_chain(pieces: Pieces) -> Chain | None:
    """The most likely chain, with an offset of each piece (expectation maximisation)."""
    seen = pieces.weight > 0.0
    centre = pieces.values - means(pieces.values, pieces.weight)[:, None]
    spread = float(np.sqrt(np.sum(pieces.weight * centre**2) / pieces.weight.sum()))
    if spread == 0.0:
        return None
    best: tuple[float, Chain] | None = None
    for share in (0.3, 0.7):
        chain = Chain(2.0 * spread, (0.1 * share / 0.5, 0.1 * (1.0 - share) / 0.5), 0.3 * spread**2)
        offset = means(pieces.values, pieces.weight) - chain.height * chain.upper
        total, before = -np.inf, -np.inf
        for _ in range(STEPS):
            up, moves, total = _smoothed(pieces, chain, offset)
            if total - before < CONVERGED:
                break
            before = total
            weight = pieces.weight
            offset = means(pieces.values - chain.height * up, weight)
            rest = pieces.values - offset[:, None]
            height = float(np.sum(weight * up * rest) / max(np.sum(weight * up), 1e-12))
            squares = (1.0 - up) * rest**2 + up * (rest - height) ** 2
            variance = float(np.sum(np.where(seen, weight * squares, 0.0)) / seen.sum())
            leave = tuple(float(np.clip(moves[k, 1 - k] / max(moves[k].sum(), 1e-12), 1e-4, 0.9)) for k in (0, 1))
            if not np.isfinite(height) or height <= 0.0 or variance <= 0.0:
                break
            chain = Chain(height, (leave[0], leave[1]), variance)
        if np.isfinite(total) and (best is None or total > best[0]):
            best = (total, chain)
    return None if best is None else best[1]


def _emissions(rest: FloatArray, weight: FloatArray, chain: Chain) -> FloatArray:
    """Log density of what is left beside an offset (...) in each level (..., 2)."""
    off = np.stack([rest, rest - chain.height], axis=-1)
    known = weight[..., None] > 0.0
    precision = np.where(known, weight[..., None], 1.0) / chain.variance
    return np.where(known, 0.5 * (np.log(precision / (2.0 * np.pi)) - precision * off**2), 0.0)


def _transition(chain: Chain) -> FloatArray:
    a, b = chain.leave
    return np.array([[1.0 - a, a], [b, 1.0 - b]])


def _smoothed(pieces: Pieces, chain: Chain, offset: FloatArray) -> tuple[FloatArray, FloatArray, float]:
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


def log_likelihood(pieces: Pieces, chain: Chain) -> float:
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


def added(pieces: Pieces, chain: Chain) -> FloatArray:
    """What the chain adds to each bin (pieces, bins), about the mean of its piece."""
    offset = means(pieces.values, pieces.weight) - chain.height * chain.upper
    for _ in range(STEPS):
        up = _smoothed(pieces, chain, offset)[0]
        offset = means(pieces.values - chain.height * up, pieces.weight)
    return np.asarray(chain.height * (up - means(up, pieces.weight)[:, None]))


def jumps(pieces: Pieces, chain: Chain) -> float:
    """Jumps, up and as many down, that a chain has in so many bins."""
    return 2.0 * float(np.sum(pieces.weight > 0.0)) * (1.0 - chain.upper) * chain.leave[0]
