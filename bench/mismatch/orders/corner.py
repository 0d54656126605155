"""Orders whose vector has a corner or a bend over the torque that the polynomials of the series do not follow.

The tooth pairs that carry change with the sign of the torque, and what lies close in one lies open in the other. The
vector of such an order has a corner where the torque is zero, and may level off beyond it. Two quadratic polynomials in
each direction (amplitude and phase) have forty numbers: with few revolutions they go through every one, by what speed
and temperature happen to be in each, and say something wild of all other states. Waves in proportion to powers of the
torque and of its size say the same with few numbers, and revolutions left out tell which is true.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.orders.revolutions import Complex, Revolution, directions, states, states_of
from bench.mismatch.orders.series import Series, fit_order
from bench.mismatch.orders.weak import WEAK, Stage, WeakOrder, design, gain_of
from bench.simulation.frame import FloatArray, IntArray

BENDS: tuple[tuple[str, ...], ...] = (
    ("1", "tau", "abs_tau"),
    ("1", "tau", "abs_tau", "tau*tau", "tau*abs_tau"),
    ("1", "tau", "abs_tau", "tau*tau", "tau*abs_tau", "tau*tau*tau", "tau*tau*abs_tau"),
)
"""functions of the torque that an order's vector may follow: a line, a parabola or a cubic on either side of zero"""
SIDES: tuple[tuple[str, ...], ...] = (("1",), ("p", "n"))
"""whether both directions share one function"""
STATES: tuple[tuple[str, ...], ...] = ((), ("v", "T"))
"""what the vector may go in proportion to beside"""


def cornered(
    order: WeakOrder, stage: Stage, vectors: Complex, series: Series, noise: FloatArray, points: IntArray
) -> WeakOrder | None:
    """An order as waves over the torque, if these predict operating points left out better than the polynomials of the
    ``series``; None where they do not.

    ``vectors`` (revolutions,) of the order in the ``stage``'s revolutions, ``noise`` (revolutions,) of a component,
    ``points`` (revolutions,) the operating points that are left out together.
    """
    best: tuple[float, tuple[str, ...]] | None = None
    torque = states(stage.revolutions)[:, 0]
    levels = states_of(torque, criteria.WAVERING * float(np.abs(torque).max()))
    for bends in BENDS:
        if len(bends) >= levels:
            break  # a function through every level that was driven says nothing between them
        for sides in SIDES:
            for further in STATES:
                model = tuple(_times(side, factor) for side in sides for factor in (*bends, *further))
                squares = _left_out_by_waves(model, stage.revolutions, vectors / noise, 1.0 / noise, points)
                if squares is not None and (best is None or squares < best[0]):
                    best = squares, model
    if best is None:
        return None
    before = _left_out_by_polynomials(order.order, series, stage.revolutions, vectors, noise, points)
    gain = gain_of(np.array([before]), np.array([best[0]]), len(stage.revolutions), np.ones(1))[0]
    if gain < criteria.RICHER:
        return None
    sigma = stage.shape_at(order.order)
    return stage.estimated(order.order, best[1], vectors / stage.scale, sigma, order.gain)


def _times(side: str, factor: str) -> str:
    if factor == "1":
        return side
    return factor if side == "1" else f"{side}*{factor}"


def _left_out_by_waves(
    model: Sequence[str], revolutions: Sequence[Revolution], vectors: Complex, weight: FloatArray, points: IntArray
) -> float | None:
    """Squares, over the noise's, of what waves miss of operating points left out; None where revolutions are too few
    for them.
    """
    whole = design(model, revolutions)
    x = whole[:, np.any(whole != 0.0, axis=0)] * weight[:, None]
    if len(revolutions) < x.shape[1] + 2:
        return None
    x = x / np.sqrt(np.sum(x**2, axis=0))
    out = 0.0
    for point in np.unique(points):
        there = points == point
        rest = x[~there]
        normal = rest.T @ rest + WEAK**2 * np.eye(x.shape[1])
        beta = np.linalg.solve(normal, rest.T @ vectors[~there])
        out += float(np.sum(np.abs(vectors[there] - x[there] @ beta) ** 2))
    return out


def _left_out_by_polynomials(
    order: float,
    series: Series,
    revolutions: Sequence[Revolution],
    vectors: Complex,
    noise: FloatArray,
    points: IntArray,
) -> float:
    """The same of the polynomials of an order of a calibrated series."""
    x, direction = states(revolutions), directions(revolutions)
    k = series.orders.index(order)
    out = 0.0
    for side, scaling in series.scaling.items():
        on_side = direction * side > 0
        basis = scaling.monomials(x)
        spread = noise * np.sqrt(series.doubt[0 if side > 0 else 1, k])
        for point in np.unique(points[on_side]):
            there, rest = on_side & (points == point), on_side & (points != point)
            if not rest.any():
                out += float(np.sum(np.abs(vectors[there] / noise[there]) ** 2))
                continue
            fit = fit_order(basis[rest], vectors[rest], spread[rest], series.prior[k])
            said = (basis[there] @ fit.amplitude) * np.exp(1j * (basis[there] @ fit.phase))
            out += float(np.sum(np.abs((vectors[there] - said) / noise[there]) ** 2))
    return out
