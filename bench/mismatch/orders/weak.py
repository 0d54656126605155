"""Orders that stand in the revolutions and that the simulation's series has not: a gearbox is full of them.

An order is a vector b + j*a that all revolutions share: the same in all, one in each direction, or moving in proportion
to load, speed and temperature. Its gain of log-likelihood is that of a complex Gaussian whose variance is known from
the neighbouring orders only so well. What the best of all orders gains in noise is measured on the revolutions
themselves, with the phase of each drawn at random.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch import criteria
from bench.mismatch.orders.look import PARTS
from bench.mismatch.orders.revolutions import Complex, Revolution, Seen, directions, states
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import FACTORS
from bench.simulation.waves import Wave

SURROGATES = 16
NEIGHBOUR_REVOLUTIONS = 20.0
"""revolutions' worth of evidence that the neighbouring orders give of an order's noise"""
LEAK = 8.0
"""orders within which what stands between the whole ones may be the leakage of something stronger"""
WEAK = 1e-3
"""prior of the vectors, in units of what all revolutions together say of one"""
MODELS: tuple[tuple[str, ...], ...] = (
    ("1",),
    ("p", "n"),
    ("p", "n", "p*tau", "n*tau"),
    ("p", "n", "p*tau", "n*tau", "p*v", "n*v", "p*T", "n*T"),
)
"""factors of an order's waves, from the plainest on"""


@dataclass(frozen=True, slots=True)
class WeakOrder:
    """An order that was found: the factors of its waves, their vectors b + j*a with covariances (k,), net gain."""

    order: float
    model: tuple[str, ...]
    vectors: Complex
    variances: FloatArray
    gain: float

    def waves(self) -> list[Wave]:
        """The order as waves of a simulation file."""
        return [
            Wave(self.order, times, float(v.imag), float(v.real), float(np.sqrt(s)), float(np.sqrt(s)))
            for times, v, s in zip(self.model, self.vectors, self.variances, strict=True)
        ]

    def at(self, design: FloatArray) -> Complex:
        """Vectors at states of which ``design`` (revolutions, k) has the factors."""
        return np.asarray(design @ self.vectors)

    @property
    def amplitude(self) -> float:
        """Root mean square over the directions of the constant parts' size."""
        constant = [abs(v) for v, times in zip(self.vectors, self.model, strict=True) if times in ("1", "p", "n")]
        return float(np.sqrt(np.mean(np.square(constant))))


def design(model: Sequence[str], revolutions: Sequence[Revolution]) -> FloatArray:
    """Factors of a model at the states of the revolutions (revolutions, k)."""
    x, side = states(revolutions), directions(revolutions)
    values = {
        "1": np.ones(len(revolutions)),
        "p": (side > 0).astype(np.float64),
        "n": (side <= 0).astype(np.float64),
        "tau": x[:, 0] / 1000.0,
        "abs_tau": np.abs(x[:, 0]) / 1000.0,
        "v": x[:, 1] / 0.1,
        "T": (x[:, 2] - 35.0) / 15.0,
    }
    assert set(values) <= set(FACTORS)
    columns = []
    for times in model:
        column = np.ones(len(revolutions))
        for part in times.split("*"):
            column = column * values[part]
        columns.append(column)
    return np.column_stack(columns)


def search(
    seen: Seen,
    revolutions: Sequence[Revolution],
    train: NDArray[np.bool_],
    fitted: Sequence[float],
    floor: float,
    price: float,
    highest: float = np.inf,
) -> list[WeakOrder]:
    """Orders that stand in the training revolutions beside those that are ``fitted`` already; strongest first.

    ``floor``: noise of a sample, rad: what adds next to nothing to it is passed over. ``price``: what noise
    gains (:meth:`Stage.maxima`). ``highest``: order up to which they are looked for.
    """
    stage = Stage.of(seen, revolutions, train)
    if stage is None:
        return []
    usable = np.ones(stage.vectors.shape[1], dtype=bool)
    # an order between the whole ones takes none of them away
    whole = [round(f) for f in fitted if f < usable.size - 0.5 and abs(f - round(f)) <= 0.5 / PARTS]
    usable[[0, *whole]] = False
    usable &= np.arange(usable.size) <= highest
    gain, which = stage.gains(stage.vectors)
    # what is strong leaks into its neighbours until it has been fitted: only summits are taken in one round
    gain = np.where(usable, gain, -np.inf)
    found = np.flatnonzero(gain > price)
    out = []
    for f in found:
        if gain[f] < gain[max(f - 2, 0) : f + 3].max():
            continue
        order = stage.estimated(float(f), MODELS[which[f]], stage.vectors[:, f], float(stage.shape[f]), float(gain[f]))
        if stage.power(order) > criteria.LEAST_POWER * floor**2 * stage.share(order.order, fitted) ** 2:
            out.append(order)
    return sorted(out, key=lambda w: -w.gain)


@dataclass(frozen=True, slots=True)
class Stage:
    """The training revolutions, their residual vectors over their own level ``scale`` (revolutions,), and the ``shape``
    of the noise over the order (orders,).

    The factors of each of :data:`MODELS` at the revolutions, and orthonormal bases of them, are worked out once: a
    stage with other vectors or another shape takes them over.
    """

    revolutions: tuple[Revolution, ...]
    vectors: Complex
    scale: FloatArray
    shape: FloatArray
    designs: tuple[FloatArray, ...] = ()
    bases: tuple[FloatArray, ...] = ()

    def __post_init__(self) -> None:
        """Work out designs and bases that were not taken over."""
        if not self.designs:
            object.__setattr__(self, "designs", tuple(design(model, self.revolutions) for model in MODELS))
        if not self.bases:
            object.__setattr__(self, "bases", tuple(_basis(x / self.scale[:, None]) for x in self.designs))

    def rescaled(self, vectors: Complex, scale: FloatArray, shape: FloatArray) -> Stage:
        """The same revolutions with other ``vectors`` (revolutions, orders) whose level is another ``scale``."""
        return replace(self, vectors=vectors, scale=scale, shape=shape, bases=())

    @classmethod
    def of(cls, seen: Seen, revolutions: Sequence[Revolution], train: NDArray[np.bool_]) -> Stage | None:
        """The training revolutions; None where they are too few."""
        trained = tuple(t for t, chosen in zip(revolutions, train, strict=True) if chosen)
        if len(trained) < criteria.FEWEST_TURNS:
            return None
        sigma = seen.sigma[train]
        shape = np.median(sigma, axis=0)
        scale = np.median(sigma / shape, axis=1)
        return cls(trained, seen.left[train] / scale[:, None], scale, shape)

    @property
    def highest(self) -> float:
        """Order beyond which each looks like a lower one within a revolution: half its rows, where they are closest.
        Only revolutions that begin at other angles, or have other speeds, distinguish the two.
        """
        turned = (max(abs(t.velocity) * t.duration, 1e-12) / (2.0 * np.pi) for t in self.revolutions)
        return float(
            0.5 * max((t.rows.stop - t.rows.start) / by for t, by in zip(self.revolutions, turned, strict=True))
        )

    def shape_at(self, order: float) -> float:
        """Shape of the noise at an order."""
        return float(self.shape[min(round(order), self.shape.size - 1)])

    def gains_of(self, vectors: Complex, shape: FloatArray) -> FloatArray:
        """Gain (orders,) of orders that are not the stage's own, whose noise has the ``shape`` (orders,)."""
        return replace(self, vectors=vectors, shape=shape).gains(vectors)[0]

    def gains(self, vectors: Complex) -> tuple[FloatArray, NDArray[np.int64]]:
        """Gain of each order's best model on revolutions left out, and which it is (orders,)."""
        energy = np.sum(np.abs(vectors) ** 2, axis=0)
        best = np.full(vectors.shape[1], -np.inf)
        which = np.zeros(vectors.shape[1], dtype=np.int64)
        for number, basis in enumerate(self.bases):
            if len(self.revolutions) < 2 * basis.shape[1] + 2:
                continue
            gain = gain_of(energy, _left_out(basis, vectors), len(self.revolutions), self.shape)
            better = gain > best + (0.0 if number == 0 else criteria.RICHER)
            best, which = np.where(better, gain, best), np.where(better, number, which)
        return best, which

    def maxima(self, seed: int, shuffled: bool) -> FloatArray:
        """Gain that the best of all orders reaches in surrogates of noise (SURROGATES,).

        Noise is that of the revolutions themselves with the phase of each drawn (``shuffled``), right where nothing but
        noise is left in them; else of their level.
        """
        rng = np.random.default_rng(seed)
        best = []
        for _ in range(SURROGATES):
            if shuffled:
                drawn = self.vectors * np.exp(2j * np.pi * rng.random((len(self.revolutions), 1)))
            else:
                drawn = self.shape * (rng.normal(size=self.vectors.shape) + 1j * rng.normal(size=self.vectors.shape))
            best.append(float(self.gains(drawn)[0][1:].max()))
        return np.asarray(best)

    def estimated(
        self, order: float, model: tuple[str, ...], vectors: Complex, sigma: float, gain: float = 0.0
    ) -> WeakOrder:
        """An order's waves from its ``vectors`` (revolutions,) over the revolutions' scale; a component's noise is
        ``sigma``.
        """
        whole = design(model, self.revolutions)
        alive = np.any(whole != 0.0, axis=0)
        x = whole[:, alive] / self.scale[:, None]
        unit = np.sqrt(np.sum(x**2, axis=0))
        # what a design cannot tell apart is shared out: a weak prior, in units of what all revolutions say
        inverse = np.linalg.inv((x / unit).T @ (x / unit) + WEAK * np.eye(unit.size)) / np.outer(unit, unit)
        beta = inverse @ x.T @ vectors
        left = float(np.sum(np.abs(vectors - x @ beta) ** 2))
        freedom = max(len(self.revolutions) - x.shape[1], 1)
        prior = NEIGHBOUR_REVOLUTIONS
        variance = (left + 2.0 * prior * sigma**2) / (2.0 * (freedom + prior))
        kept = tuple(times for times, here in zip(model, alive, strict=True) if here)
        return WeakOrder(order, kept, beta, variance * np.diag(inverse), gain)

    def power(self, order: WeakOrder) -> float:
        """Mean square of an order's wave over the revolutions, rad²."""
        return float(0.5 * np.mean(np.abs(order.at(design(order.model, self.revolutions))) ** 2))

    def share(self, order: float, fitted: Sequence[float]) -> float:
        """Part of an order's vectors that those of the ``fitted`` orders leave, in the mean over the revolutions."""
        return float(np.mean(self.shares(order, fitted)))

    def shares(self, order: float, fitted: Sequence[float]) -> FloatArray:
        """Part of an order's vector that those of the ``fitted`` orders leave in each revolution (revolutions,).

        Over one revolution a sine is nearly a sum of two at half an order from it, whatever its phase.
        """
        near = np.array([order, *(f for f in fitted if f != order and abs(f - order) < LEAK)])
        if near.size == 1:
            return np.ones(len(self.revolutions))
        travelled = np.array([t.duration * abs(t.velocity) for t in self.revolutions]) / (2.0 * np.pi)
        # to a hundredth of a revolution: most segments are equally long
        each, which = np.unique(np.round(travelled, 2), return_inverse=True)
        alike = np.sinc((near[:, None] - near[None, :]) * each[:, None, None])
        alike += 1e-9 * np.eye(near.size)
        return np.asarray((1.0 / np.linalg.inv(alike)[:, 0, 0])[which])

    def misfit(self, order: WeakOrder, vectors: Complex, sigma: float) -> float:
        """Variance of what an order's model leaves of its vectors, over the noise's."""
        left = vectors - order.at(design(order.model, self.revolutions)) / self.scale
        freedom = max(len(self.revolutions) - len(order.model), 1)
        return float(np.sum(np.abs(left) ** 2) / (2.0 * freedom * sigma**2))


def _basis(x: FloatArray) -> FloatArray:
    """Orthonormal basis (revolutions, k) of a design's columns; what a design cannot tell apart counts once."""
    left, values, _ = np.linalg.svd(x / np.maximum(np.sqrt(np.sum(x**2, axis=0)), 1e-300), full_matrices=False)
    return np.asarray(left[:, values > 1e-3 * values.max()])


def _left_out(basis: FloatArray, vectors: Complex) -> FloatArray:
    """Squares (orders,) of what each revolution differs from what all others say of it."""
    left = vectors - basis @ (basis.T @ vectors)
    # a revolution that alone determines a coefficient says nothing of another
    leverage = np.minimum(np.sum(basis**2, axis=1), 0.99)
    return np.asarray(np.sum(np.abs(left / (1.0 - leverage)[:, None]) ** 2, axis=0))


def gain_of(before: FloatArray, after: FloatArray, revolutions: int, sigma: FloatArray) -> FloatArray:
    """Gain of log-likelihood of complex Gaussians whose variance the neighbouring orders tell as well."""
    prior = 2.0 * NEIGHBOUR_REVOLUTIONS * sigma**2
    return np.asarray((revolutions + NEIGHBOUR_REVOLUTIONS) * (np.log(before + prior) - np.log(after + prior)))
