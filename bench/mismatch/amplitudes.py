"""Whether the known orders behave as the polynomial series says, and which law their amplitudes follow if not.

A law multiplies an order's vectors by a factor: a resonance by H(f·|v|), a lubricant film, a temperature or the time by
1 + ε·g. The laws 1 + ε·g are scored by marginal likelihood: the polynomials' coefficients are free beside them, with
the spread that the orders themselves have shown, so that nothing counts that a calibration could absorb. A resonance is
no small change: the series is calibrated anew on the vectors divided by H, and the two calibrations are compared.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import minimize

from bench.mismatch.columns import RIPPLE_ORDERS
from bench.mismatch.series import Series, calibrate
from bench.mismatch.spectrum import Complex, Turn
from bench.simulation.frame import FloatArray
from bench.simulation.laws import Law, Reference, factor, resonant, value
from bench.simulation.terms.te.resonance import response

LEAST_GAIN = 40.0
LEAST_SIZE = 0.05
LEAST_EXCESS = 0.12
"""excess of the known orders, over the noise of a row, from which a resonance is looked for"""
LEAST_TOUCHED = 3.0
"""log-likelihood an order gains from a resonance that acts on it"""
USUAL_DAMPING, DAMPING_SPREAD = 0.06, 0.7
"""of structures that resonate: median, and standard deviation of the logarithm"""
PRICE = 2.5
"""log-likelihood asked of each order's strength (two numbers)"""


@dataclass(frozen=True, slots=True)
class Orders:
    """Vectors (turns, orders) of the known orders, their noise, the states, directions and times of the turns."""

    vectors: Complex
    sigma: FloatArray
    x: FloatArray
    direction: FloatArray
    time: FloatArray
    orders: tuple[float, ...]
    train: NDArray[np.bool_]
    series: Series
    smooth: Complex
    """the calibrated series' vectors"""
    white: float
    turns: tuple[Turn, ...]

    @property
    def ripple(self) -> NDArray[np.bool_]:
        """Which orders are those of the load motor's ripple (orders,)."""
        return np.isin(np.asarray(self.orders), RIPPLE_ORDERS)


def _stack(values: Complex) -> FloatArray:
    return np.concatenate([values.real, values.imag])


def _whitener(data: Orders, k: int) -> tuple[FloatArray, FloatArray]:
    """Cholesky factor of the covariance of order k's training vectors, polynomials' freedom in it; the residual."""
    rows = np.flatnonzero(data.train)
    series = data.series
    blocks: list[FloatArray] = []
    target = data.vectors[rows, k] - data.smooth[rows, k]
    for side in series.amplitude:
        own = data.direction[rows] * side > 0
        basis = np.where(own[:, None], series.scaling[side].monomials(data.x[rows]), 0.0)
        turn = np.exp(1j * (basis @ series.phase[side][k]))
        amplitude = basis @ series.amplitude[side][k]
        size = float(np.sqrt(np.mean(np.abs(data.smooth[rows][own, k]) ** 2))) if own.any() else 1.0
        spread = np.concatenate([series.prior[:9] * size, [10.0 * size], series.prior[9:], [10.0]])
        columns = np.hstack([turn[:, None] * basis, (1j * amplitude * turn)[:, None] * basis])
        target = target + columns @ np.concatenate([series.amplitude[side][k], series.phase[side][k]])
        blocks.append(np.vstack([columns.real, columns.imag]) * spread)
    tangent = np.hstack(blocks)
    sigma = np.sqrt(data.sigma[rows, k] ** 2 + (1e-3 * np.abs(data.smooth[rows, k])) ** 2)
    covariance = tangent @ tangent.T + np.diag(np.concatenate([sigma, sigma]) ** 2)
    return np.asarray(np.linalg.cholesky(covariance)), _stack(target)


def resonance(data: Orders) -> Law | None:
    """The best second-order resonance, by calibrating the series on the vectors divided by its response."""
    rows = np.flatnonzero(data.train)
    turn_list = [data.turns[i] for i in rows]
    frequency = np.abs(data.x[rows, 1])[:, None] * np.asarray(data.orders)[None, :]

    def losses(point: tuple[float, ...]) -> FloatArray:
        answer = resonant(frequency, point)
        sigma = np.sqrt(data.sigma[rows] ** 2 + (1e-3 * np.abs(data.vectors[rows])) ** 2) / np.abs(answer)
        return calibrate(turn_list, data.vectors[rows] / answer, data.orders, sigma, data.series.prior).loss

    plain = losses((1e9, 0.5))
    low, high = max(float(np.percentile(frequency, 10)), 0.05), 1.5 * float(frequency.max())
    best: tuple[float, tuple[float, ...], FloatArray] | None = None

    def consider(*point: float) -> float:
        nonlocal best
        gain = np.where(data.ripple, 0.0, 0.5 * (plain - losses(point)))
        # orders far below the resonance feel nothing; those that it would spoil do not belong to its mode
        total = float(np.sum(np.maximum(gain, -2.0))) - _unusual(point)
        if best is None or total > best[0]:
            best = (total, point, gain)
        return -total

    naturals = np.geomspace(low, high, 40)
    for natural in naturals[::2]:
        for damping in (0.03, 0.15):
            consider(float(natural), damping, 1.0)
    assert best is not None
    begins = [best[1], *_small_resonances(data, naturals)]

    def clipped(x: FloatArray) -> float:
        damping, participation = np.clip(np.exp(x[1:]), [0.004, 0.005], [0.8, 1.5])
        return consider(float(np.exp(x[0])), float(damping), float(participation))

    for begin in begins:
        start = np.log(begin)
        simplex = start + np.array([[0, 0, 0], [0.05, 0, 0], [0, -0.4, 0], [0, 0, -0.4]])
        minimize(clipped, start, method="Nelder-Mead", options={"maxfev": 60, "initial_simplex": simplex})
    total, point, gain = best
    touched = tuple(f for f, g in zip(data.orders, gain, strict=True) if g > LEAST_TOUCHED)
    ones = np.ones(len(data.orders), dtype=np.complex128)
    return Law(
        "te.resonance",
        "second_order",
        point,
        total,
        touched,
        ones,
        ("order_frequency",),
        series=data.orders,
    )


def _unusual(point: tuple[float, ...]) -> float:
    """How unusual a resonance's damping is (log-likelihood): where no speed meets the mode, nothing else tells it."""
    return float(0.5 * (np.log(point[1] / USUAL_DAMPING) / DAMPING_SPREAD) ** 2)


def _small_resonances(data: Orders, naturals: FloatArray) -> list[tuple[float, float, float]]:
    """The likeliest resonances that change the vectors little: natural frequency, damping, participation."""
    rows = np.flatnonzero(data.train)
    whiteners = [_whitener(data, k) for k in range(len(data.orders))]
    flat = [solve_triangular(lower, target, lower=True) for lower, target in whiteners]
    frequency = np.abs(data.x[rows, 1])[:, None] * np.asarray(data.orders)[None, :]
    found: list[tuple[float, tuple[float, float, float]]] = []
    for natural in naturals:
        for damping in (0.03, 0.06, 0.12, 0.25):
            change = (response(frequency, natural, damping) - 1.0) * data.smooth[rows]
            energy = product = 0.0
            for k, (lower, _) in enumerate(whiteners):
                z = solve_triangular(lower, _stack(change[:, k]), lower=True)
                energy += float(z @ z)
                product += float(z @ flat[k])
            participation = product / max(energy, 1e-300)
            if participation > 0.0:
                point = (float(natural), damping, min(max(participation, 0.005), 1.0))
                found.append((0.5 * product * participation - _unusual(point), point))
    return [point for _, point in sorted(found, key=lambda f: -f[0])[:2]]


def _grids(data: Orders) -> list[tuple[str, str, tuple[str, ...], list[tuple[float, ...]]]]:
    """Laws tried: effect, form, the quantities it depends on, points."""
    fastest = float(np.abs(data.x[:, 1]).max())
    coldest, span = float(data.x[:, 2].min()), max(float(np.ptp(data.x[:, 2])), 1.0)
    speeds: list[tuple[float, ...]] = [(float(v),) for v in np.geomspace(0.08, 0.8, 7) * fastest]
    decays: list[tuple[float, ...]] = [(float(s),) for s in np.array([0.08, 0.15, 0.3, 0.6]) * span]
    knees: list[tuple[float, ...]] = [(float(coldest + s * span),) for s in (0.2, 0.35, 0.5, 0.65, 0.8)]
    return [
        ("te.velocity_nonlinear", "exponential", ("speed",), speeds),
        ("te.velocity_nonlinear", "rational", ("speed",), speeds),
        ("te.temperature_nonlinear", "exponential", ("temperature",), decays),
        ("te.temperature_nonlinear", "threshold", ("temperature",), knees),
        ("te.drift_time", "linear", ("time",), [()]),
        ("te.drift_time", "creep", ("time",), [(0.05,), (0.15,), (0.4,)]),
        *_bands(data),
        ("unknown", "amplitude over load", ("torque",), [()]),
        ("unknown", "amplitude about zero load", ("torque",), [(0.05,), (0.15,), (0.3,)]),
    ]


def _bands(data: Orders) -> list[tuple[str, str, tuple[str, ...], list[tuple[float, ...]]]]:
    """Bands of load, speed and temperature in which an amplitude may swell: centre and width."""
    out: list[tuple[str, str, tuple[str, ...], list[tuple[float, ...]]]] = []
    for form, name, values in (
        ("amplitude in a band of load", "torque", data.x[data.train, 0]),
        ("amplitude in a band of speed", "speed", np.abs(data.x[data.train, 1])),
        ("amplitude in a band of temperature", "temperature", data.x[data.train, 2]),
    ):
        low, span = float(values.min()), float(np.ptp(values))
        points: list[tuple[float, ...]] = [
            (float(low + c * span), w * span) for c in np.linspace(0.0, 1.0, 17) for w in (0.05, 0.09, 0.15)
        ]
        if span > 0.0:
            out.append(("unknown", form, (name,), points))
    return out


def factors(data: Orders) -> list[Law]:
    """The best point of every law of the form 1 + ε·g, ε free for each order; strongest first."""
    rows = np.flatnonzero(data.train)
    whiteners = [_whitener(data, k) for k in range(len(data.orders))]
    flat = [solve_triangular(lower, target, lower=True) for lower, target in whiteners]
    out: list[Law] = []
    reference = Reference.of(data.x, data.time)
    for effect, form, variables, points in _grids(data):
        best: Law | None = None
        for point in points:
            g = value(effect, form, point, data.x, data.time, reference)[rows]
            gain = np.zeros(len(data.orders))
            strength = np.zeros(len(data.orders), dtype=np.complex128)
            for k, (lower, _) in enumerate(whiteners):
                change = g * data.smooth[rows, k]
                z = solve_triangular(lower, np.column_stack([_stack(change), _stack(1j * change)]), lower=True)
                # a weak prior: a law changes an amplitude by less than ten times itself
                normal = z.T @ z + 0.01 * np.eye(2)
                right = z.T @ flat[k]
                found = np.linalg.solve(normal, right)
                gain[k] = 0.5 * float(right @ found)
                strength[k] = found[0] + 1j * found[1]
            gain[data.ripple] = 0.0  # how the ripple's torque twists the gearbox is no finding of the gearbox's orders
            total = float(np.sum(np.maximum(gain - PRICE, 0.0)))
            touched = tuple(f for f, s in zip(data.orders, gain, strict=True) if s > max(8.0, 0.02 * gain.max()))
            kept = np.where(gain > 8.0, strength, 0.0)
            law = Law(effect, form, point, total, touched, kept, variables, reference, data.orders)
            if best is None or law.gain > best.gain:
                best = law
        if best is not None:
            out.append(best)
    return sorted(out, key=lambda law: -law.gain)


def excess(data: Orders, residual: Complex) -> float:
    """Root mean square of what is left at the known orders above the noise, over the noise of a row."""
    rows = data.train
    power = np.mean(np.abs(residual[rows]) ** 2 - 2.0 * data.sigma[rows] ** 2, axis=0)
    return float(np.sqrt(max(float(np.sum(power)) / 2.0, 0.0)) / data.white)


def size(law: Law, data: Orders) -> float:
    """What the law changes at the training turns beyond the polynomials, root mean square over the noise of a row."""
    rows = np.flatnonzero(data.train)
    changed = applied(law, data)[rows]
    total = 0.0
    for k in range(len(data.orders)):
        change = (changed[:, k] - 1.0) * data.smooth[rows, k]
        total += float(np.mean(np.abs(_beyond(data, k, change)) ** 2)) / 2.0
    return float(np.sqrt(total) / data.white)


def _beyond(data: Orders, k: int, change: Complex) -> Complex:
    """What is left of a change of order k's training vectors when the polynomials have followed it as far as they
    can.
    """
    rows = np.flatnonzero(data.train)
    lower, _ = _whitener(data, k)
    sigma = np.concatenate([data.sigma[rows, k]] * 2)
    inner = solve_triangular(lower, _stack(change), lower=True)
    left = sigma**2 * solve_triangular(lower, inner, lower=True, trans="T")
    return np.asarray(left[: rows.size] + 1j * left[rows.size :])


def applied(law: Law, data: Orders) -> Complex:
    """The law's factor on the vectors, (turns, orders)."""
    return factor(law, data.x, data.time, data.orders)


def _shared(law: Law) -> float:
    """Advantage of a law with the same strength in all its orders."""
    return 1.0 + 0.5 * min(max(len(law.orders) - 1, 0), 3)


def best_law(data: Orders) -> Law | None:
    """The law that gains most, if it gains enough and changes more than the noise lets pass."""
    candidates = factors(data)
    if excess(data, data.vectors - data.smooth) > LEAST_EXCESS:
        mode = resonance(data)
        candidates = candidates if mode is None else [mode, *candidates]
    if not candidates:
        return None
    # three numbers for all orders against two for each: a resonance of many orders need not gain as much as other laws
    law = max(candidates, key=lambda found: found.gain * (_shared(found) if found.effect == "te.resonance" else 1.0))
    price, least = (1.0, 1.0) if law.effect == "te.resonance" else (2.5, 2.0)
    return law if law.gain > price * LEAST_GAIN and size(law, data) > least * LEAST_SIZE else None
