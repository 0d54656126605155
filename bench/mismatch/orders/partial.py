"""Steady parts of less than a revolution: what they say of the series that whole revolutions calibrated.

A slow point may turn the output only half round. Its orders cannot be separated there, so it has no vectors of its
own; but the whole revolutions give each order's polynomials with a covariance, and beside that prior the rows of
the part are one more linear measurement of all orders together: a Gauss-Newton step of the joint posterior, repeated.
Level and line of each part stay free.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from bench.mismatch.orders.revolutions import Revolution
from bench.mismatch.orders.series import Series
from bench.mismatch.recordings.rows import Rows
from bench.simulation.frame import FloatArray
from bench.simulation.laws import Law, factor

STEPS = 8
"""Gauss-Newton steps: phases that were extrapolated may be off by a good part of a radian"""


@dataclass(frozen=True, slots=True)
class _Part:
    """A part's state (3,), time, Gram matrix (2K, 2K) of its rows' sines, then cosines, less level and line, the rows'
    product with them (2K,), the rows' own squares, their number.
    """

    state: FloatArray
    time: float
    gram: FloatArray
    product: FloatArray
    squares: float
    number: int


def refined(
    series: Series, rows: Rows, y: FloatArray, parts: Sequence[Revolution], white: float, laws: Sequence[Law]
) -> Series:
    """``series`` with what the rows ``y`` (n,) of steady ``parts`` say of it; rad.

    ``white``: noise of a row, rad; where a part is left with more than that, its own is taken. ``laws`` multiply the
    series' vectors.
    """
    amplitude, phase, covariance = dict(series.amplitude), dict(series.phase), dict(series.covariance)
    for side in series.amplitude:
        on_side = [p for p in parts if p.direction * side > 0]
        if on_side:
            read = [_read(series, rows, y, p) for p in on_side]
            amplitude[side], phase[side], covariance[side] = _refined(series, side, read, white, laws)
    return replace(series, amplitude=amplitude, phase=phase, covariance=covariance)


def _read(series: Series, rows: Rows, y: FloatArray, part: Revolution) -> _Part:
    theta = rows.frame.theta[part.rows]
    angle = theta[:, None] * np.asarray(series.orders)
    columns = np.hstack([np.sin(angle), np.cos(angle)])
    free = np.column_stack([np.ones(theta.size), theta - theta.mean()])
    free, _ = np.linalg.qr(free)
    columns -= free @ (free.T @ columns)
    values = y[part.rows] - free @ (free.T @ y[part.rows])
    state = np.array([part.torque, part.velocity, part.temperature])
    gram, product = columns.T @ columns, columns.T @ values
    return _Part(state, part.time, gram, product, float(values @ values), theta.size)


def _refined(
    series: Series, side: int, parts: Sequence[_Part], white: float, laws: Sequence[Law]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Amplitude, phase and covariance of one direction after the parts."""
    orders = len(series.orders)
    before = np.concatenate([series.amplitude[side], series.phase[side]], axis=1)
    prior = np.zeros((orders * 20, orders * 20))
    for k, of_order in enumerate(series.covariance[side]):
        block = slice(20 * k, 20 * k + 20)
        prior[block, block] = _inverse(of_order)
    basis = [series.scaling[side].monomials(p.state[None, :])[0] for p in parts]
    answer = [_answer(series, p, laws) for p in parts]
    now = before.copy()
    noise = np.full(len(parts), white**2)
    factored = None
    for _ in range(STEPS):
        normal, right = prior.copy(), prior @ (before - now).ravel()
        for part, b, by, variance in zip(parts, basis, answer, noise, strict=True):
            vectors, step = _linear(now, b, by)
            left = part.product - part.gram @ vectors
            normal += step.T @ part.gram @ step / variance
            right += step.T @ left / variance
        factored = cho_factor(normal)
        now = now + cho_solve(factored, right).reshape(orders, 20)
        for row, (part, b, by) in enumerate(zip(parts, basis, answer, strict=True)):
            vectors, _ = _linear(now, b, by)
            squares = part.squares - 2.0 * float(vectors @ part.product) + float(vectors @ part.gram @ vectors)
            noise[row] = max(white**2, squares / part.number)
    assert factored is not None
    inverse = cho_solve(factored, np.eye(orders * 20))
    covariance = np.stack([inverse[20 * k : 20 * k + 20, 20 * k : 20 * k + 20] for k in range(orders)])
    return now[:, :10].copy(), now[:, 10:].copy(), covariance


def _inverse(covariance: FloatArray) -> FloatArray:
    """Precision of one order's coefficients (20, 20); what the fit has held at zero stays there."""
    spread = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh(covariance / np.outer(spread, spread))
    inner = (vectors / np.maximum(values, 1e-9)) @ vectors.T
    return np.asarray(inner / np.outer(spread, spread))


def _answer(series: Series, part: _Part, laws: Sequence[Law]) -> np.ndarray:
    """What the laws multiply the orders' vectors by in a part (K,)."""
    out = np.ones(len(series.orders), dtype=np.complex128)
    for law in laws:
        out = out * factor(law, part.state[None, :], np.array([part.time]), series.orders)[0]
    return out


def _linear(now: FloatArray, basis: FloatArray, answer: np.ndarray) -> tuple[FloatArray, FloatArray]:
    """Vectors (2K,) at a state, real parts then imaginary ones, and how they move with the coefficients (2K, 20K)."""
    orders = len(now)
    amplitude, phase = now[:, :10] @ basis, now[:, 10:] @ basis
    rotation = np.exp(1j * phase) * answer
    vectors = amplitude * rotation
    step = np.zeros((2 * orders, orders, 20))
    each = np.arange(orders)
    of_amplitude, of_phase = rotation[:, None] * basis, (1j * vectors)[:, None] * basis
    step[each, each, :10], step[each, each, 10:] = of_amplitude.real, of_phase.real
    step[orders + each, each, :10], step[orders + each, each, 10:] = of_amplitude.imag, of_phase.imag
    return np.concatenate([vectors.real, vectors.imag]), step.reshape(2 * orders, orders * 20)
