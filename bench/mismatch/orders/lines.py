"""Orders of a torque that stand in its revolutions, with what their vectors are in proportion to.

An order's vector may be the same always, change its sign with the direction, or grow with the load. Each is scored by
how well each revolution is predicted by the others; how much the best of all orders and all of these gains in noise is
measured on the same revolutions with the phase of every vector drawn at random.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from bench.mismatch import criteria
from bench.mismatch.regression.folds import weights
from bench.mismatch.regression.maxima import tail, tail_rate
from bench.simulation.frame import FloatArray, IntArray

Complex = NDArray[np.complex128]
Model = tuple[str, ...]

SURROGATES = 100
NEIGHBOURS = 9
"""orders whose median tells the noise at an order"""
NEIGHBOUR_REVOLUTIONS = 20.0
"""revolutions' worth of evidence that they give of it"""
APART = 0.1
"""smallest singular value of factors of length one that revolutions tell apart: each of them is said to act"""
SOLVABLE = 1e-3
"""the same of a polynomial, of which the whole is said alone"""


@dataclass(frozen=True, slots=True)
class Revolutions:
    """Vectors a + j·b (revolutions, orders) of some revolutions, not a number where an order was not seen; their
    ``sigma`` (revolutions,); factors of each revolution by name, (revolutions,) each; ``fold`` of each, -1 where it is
    held out.
    """

    vectors: Complex
    sigma: FloatArray
    factors: Mapping[str, FloatArray]
    fold: IntArray

    @property
    def train(self) -> NDArray[np.bool_]:
        """Revolutions that may be fitted."""
        return np.asarray(self.fold >= 0)


@dataclass(frozen=True, slots=True)
class Line:
    """An order that stands: factors of its waves, amplitudes a + j·b (k,), covariance of a component (k, k), gain,
    p-value; ``shares``: weight of each model that was tried.
    """

    order: int
    model: Model
    amplitude: Complex
    covariance: FloatArray
    gain: float
    p_value: float
    shares: Mapping[Model, float]
    losses: Mapping[Model, tuple[float, float]]

    @property
    def variance(self) -> FloatArray:
        """Variance of a component of each amplitude (k,)."""
        return np.diag(self.covariance)

    def at(self, factors: Mapping[str, FloatArray]) -> Complex:
        """Vectors at revolutions of given factors (revolutions,)."""
        return np.asarray(np.column_stack([factors[t] for t in self.model]) @ self.amplitude)


def significant_lines(revolutions: Revolutions, models: Sequence[Model], seed: int) -> list[Line]:
    """Significant orders of the training revolutions, strongest first."""
    train = revolutions.train
    if int(train.sum()) < criteria.FEWEST_TURNS:
        return []
    scale = revolutions.sigma[train]
    vectors = revolutions.vectors[train] / scale[:, None]
    seen = np.isfinite(vectors)
    vectors = np.where(seen, vectors, 0.0)
    usable = seen.sum(axis=0) >= criteria.FEWEST_TURNS
    usable[0] = False
    if not usable.any():
        return []
    noise = _noise(vectors, seen)
    bases = {m: b for m in models if (b := _basis(revolutions, train, m)) is not None}
    parts = [_parts(x / scale[:, None], seen) for x in bases.values()]
    gains = _gains(vectors, seen, parts, noise)
    best = _choice(gains, [len(m) for m in bases])
    nulls = _nulls(vectors, seen, parts, noise, usable, seed)
    price = tail(nulls, criteria.ERROR_RATE_OF_A_CHANNEL)
    out = []
    names = list(bases)
    for f in np.flatnonzero(usable & (gains[best, np.arange(usable.size)] > price)):
        model = names[int(best[f])]
        out.append(
            _estimated(revolutions, train, int(f), model, bases, noise[f], float(gains[best[f], f]), nulls, seed)
        )
    return sorted(out, key=lambda line: -line.gain)


def _basis(revolutions: Revolutions, train: NDArray[np.bool_], model: Model) -> FloatArray | None:
    """Columns (revolutions, k) of a model; None where the revolutions do not tell them apart."""
    x = np.column_stack([revolutions.factors[t][train] for t in model])
    return x if _distinguishable(x) else None


def _distinguishable(x: FloatArray) -> bool:
    """Whether some revolutions distinguish the factors (revolutions, k) of a model."""
    unit = np.sqrt(np.sum(x**2, axis=0))
    if np.any(unit == 0.0) or len(x) < 2 * x.shape[1] + 2:
        return False
    apart = APART if x.shape[1] <= 2 else SOLVABLE
    return bool(np.linalg.svd(x / unit, compute_uv=False)[-1] >= apart)


def _noise(vectors: Complex, seen: NDArray[np.bool_]) -> FloatArray:
    """Standard deviation of a component at each order (orders,), over the revolutions' scale."""
    # the expected median of noise where an order was not seen at all
    middle = np.full(vectors.shape[1], 2.0 * np.log(2.0))
    for f in np.flatnonzero(seen.any(axis=0)):
        middle[f] = float(np.median(np.abs(vectors[seen[:, f], f]) ** 2))
    middle[0] = middle[1]
    # mirrored at its ends: a strong first or last order that is repeated there would be taken for noise
    level = median_filter(middle, NEIGHBOURS, mode="mirror") / np.log(2.0)
    return np.asarray(np.sqrt(np.maximum(level, 1e-12) / 2.0))


@dataclass(frozen=True, slots=True)
class _Part:
    """Revolutions ``rows`` and ``orders`` that are alike in where they were seen; orthonormal ``basis`` of a model's
    factors there (rows, k), and the ``share`` that all others have in what is said of each revolution.
    """

    rows: IntArray
    orders: IntArray
    basis: FloatArray
    share: FloatArray

    def left_out(self, vectors: Complex) -> FloatArray:
        """Square of what each revolution differs from what all others say of it (rows, orders)."""
        seen = vectors[np.ix_(self.rows, self.orders)]
        return np.asarray(np.abs((seen - self.basis @ (self.basis.T @ seen)) / self.share[:, None]) ** 2)


def _parts(x: FloatArray, seen: NDArray[np.bool_]) -> list[_Part]:
    """Where the orders (revolutions, orders) of a model of factors ``x`` (revolutions, k) can be predicted. An order
    that was seen in some revolutions alone has no model that these do not tell.
    """
    out = []
    patterns, number = np.unique(seen, axis=1, return_inverse=True)
    for k in range(patterns.shape[1]):
        rows = patterns[:, k]
        if not _distinguishable(x[rows]):
            continue
        left, values, _ = np.linalg.svd(x[rows], full_matrices=False)
        basis = left[:, values > 1e-6 * values.max()]
        leverage = np.minimum(np.sum(basis**2, axis=1), 0.99)
        out.append(_Part(np.flatnonzero(rows), np.flatnonzero(number.ravel() == k), basis, 1.0 - leverage))
    return out


def _gains(
    vectors: Complex, seen: NDArray[np.bool_], models: Sequence[Sequence[_Part]], noise: FloatArray
) -> FloatArray:
    """Gain of each model at each order (models, orders)."""
    before = np.sum(np.abs(vectors) ** 2, axis=0)
    prior = 2.0 * NEIGHBOUR_REVOLUTIONS * noise**2
    number = seen.sum(axis=0) + NEIGHBOUR_REVOLUTIONS
    gains = []
    for parts in models:
        left = before.copy()
        for part in parts:
            left[part.orders] = part.left_out(vectors).sum(axis=0)
        gains.append(number * np.log((before + prior) / (left + prior)))
    return np.asarray(gains)


def _choice(gains: FloatArray, sizes: Sequence[int]) -> IntArray:
    """The best model of each order (orders,); one of more factors than the best before it has to gain clearly more."""
    best = np.zeros(gains.shape[1], dtype=np.int64)
    value = np.full(gains.shape[1], -np.inf)
    size = np.asarray(sizes)
    for k, gain in enumerate(gains):
        margin = np.where((size[k] > size[best]) & np.isfinite(value), criteria.RICHER, 0.0)
        better = gain > value + margin
        best, value = np.where(better, k, best), np.where(better, gain, value)
    return best


def _nulls(
    vectors: Complex,
    seen: NDArray[np.bool_],
    models: Sequence[Sequence[_Part]],
    noise: FloatArray,
    usable: NDArray[np.bool_],
    seed: int,
) -> FloatArray:
    rng = np.random.default_rng([seed, 4])
    out = []
    for _ in range(SURROGATES):
        drawn = vectors * np.exp(2j * np.pi * rng.random(vectors.shape))
        out.append(float(_gains(drawn, seen, models, noise)[:, usable].max()))
    return np.asarray(out)


def _estimated(
    revolutions: Revolutions,
    train: NDArray[np.bool_],
    order: int,
    model: Model,
    bases: Mapping[Model, FloatArray],
    noise: float,
    gain: float,
    nulls: FloatArray,
    seed: int,
) -> Line:
    vectors = revolutions.vectors[train, order]
    seen = np.isfinite(vectors)
    scale = revolutions.sigma[train][seen]
    target = vectors[seen] / scale
    x = bases[model][seen] / scale[:, None]
    inverse = np.linalg.inv(x.T @ x)
    amplitude = inverse @ x.T @ target
    left = float(np.sum(np.abs(target - x @ amplitude) ** 2))
    freedom = max(target.size - x.shape[1], 1)
    variance = (left + 2.0 * NEIGHBOUR_REVOLUTIONS * noise**2) / (2.0 * (freedom + NEIGHBOUR_REVOLUTIONS))
    fold = np.unique(revolutions.fold[train][seen], return_inverse=True)[1]
    densities = {}
    for other, columns in bases.items():
        squares = np.abs(target) ** 2
        for part in _parts(columns[seen] / scale[:, None], np.ones((target.size, 1), dtype=bool)):
            squares[part.rows] = part.left_out(target[:, None])[:, 0]
        densities[other] = -0.5 * np.bincount(fold, squares / variance)
    shares = weights(np.asarray(list(densities.values())), seed)
    losses = {}
    for other, density in densities.items():
        gap = densities[model] - density
        error = float(np.std(gap, ddof=1) * np.sqrt(gap.size)) if gap.size > 1 else 0.0
        losses[other] = (float(gap.sum()), error)
    share = dict(zip(densities, (float(s) for s in shares), strict=True))
    return Line(order, model, amplitude, variance * inverse, gain, tail_rate(nulls, gain), share, losses)
