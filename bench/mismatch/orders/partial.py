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
HALVINGS = 4
"""times that a step is halved which makes the posterior worse"""


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

    def missed(point: FloatArray) -> FloatArray:
        """Mean square of what a series leaves of each part."""
        out = []
        for part, b, by in zip(parts, basis, answer, strict=True):
            vectors, _ = _linear(point, b, by)
            squares = part.squares - 2.0 * float(vectors @ part.product) + float(vectors @ part.gram @ vectors)
            out.append(max(squares, 0.0) / part.number)
        return np.asarray(out)

    def loss(point: FloatArray, squares: FloatArray) -> float:
        """Negative logarithm of the posterior, the noise of each part at its likeliest, no less than ``white``."""
        off = (point - before).ravel()
        variance = np.maximum(squares, white**2)
        number = np.array([part.number for part in parts])
        return 0.5 * float(off @ prior @ off) + 0.5 * float(number @ (np.log(variance) + squares / variance))

    def equations(point: FloatArray, noise: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Normal equations of a step from a series."""
        normal, right = prior.copy(), prior @ (before - point).ravel()
        for part, b, by, variance in zip(parts, basis, answer, noise, strict=True):
            vectors, turning = _linear(point, b, by)
            left = part.product - part.gram @ vectors
            _add(normal, turning.T @ part.gram @ turning / variance, b)
            right += ((turning.T @ left)[:, None] * b / variance).ravel()
        return normal, right

    now, squares = before.copy(), missed(before)
    reached = loss(now, squares)
    # a first step is taken as if the parts had no more than noise: what they have more is what the series misses
    noise = np.full(len(parts), white**2)
    for _ in range(STEPS):
        normal, right = equations(now, noise)
        step = cho_solve(cho_factor(normal), right).reshape(orders, 20)
        for _ in range(HALVINGS):
            tried = missed(now + step)
            if loss(now + step, tried) < reached:
                break
            step = 0.5 * step
        else:
            break
        now, squares = now + step, tried
        reached = loss(now, squares)
        noise = np.maximum(squares, white**2)
    # what is left beyond noise is waves that the series misses, as long as the part: a reading for each of its numbers
    rows = np.array([part.number for part in parts]) / (2.0 * orders)
    normal, _ = equations(now, white**2 + np.maximum(squares - white**2, 0.0) * np.maximum(rows, 1.0))
    inverse = cho_solve(cho_factor(normal), np.eye(orders * 20))
    covariance = np.stack([inverse[20 * k : 20 * k + 20, 20 * k : 20 * k + 20] for k in range(orders)])
    return now[:, :10].copy(), now[:, 10:].copy(), covariance


def _add(normal: FloatArray, turning: FloatArray, basis: FloatArray) -> None:
    """Add to normal equations (20K, 20K) those of amplitudes and phases (2K, 2K) at a state's monomials (10,)."""
    size = basis.size
    blocks = normal.reshape(len(turning), size, len(turning), size)
    blocks += turning[:, None, :, None] * np.outer(basis, basis)[None, :, None, :]


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
    """Vectors (2K,) at a state, real parts then imaginary ones, and how they move with amplitude and phase of each
    order there (2K, 2K).
    """
    orders = len(now)
    amplitude, phase = now[:, :10] @ basis, now[:, 10:] @ basis
    rotation = np.exp(1j * phase) * answer
    vectors = amplitude * rotation
    turning = np.zeros((2 * orders, orders, 2))
    each = np.arange(orders)
    for column, moves in enumerate((rotation, 1j * vectors)):
        turning[each, each, column], turning[orders + each, each, column] = moves.real, moves.imag
    return np.concatenate([vectors.real, vectors.imag]), turning.reshape(2 * orders, 2 * orders)
