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

from bench.mismatch.orders.revolutions import Complex, Revolution
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
    posterior = _Posterior.of(series, side, parts, laws)
    number = np.array([part.number for part in parts])
    orders, noise = len(series.orders), np.full(len(parts), white**2)

    def loss(point: FloatArray, squares: FloatArray) -> float:
        """Negative logarithm of the posterior, the noise of each part at its likeliest, no less than ``white``."""
        variance = np.maximum(squares, white**2)
        return posterior.strain(point) + 0.5 * float(number @ (np.log(variance) + squares / variance))

    now, squares = posterior.before, posterior.missed(posterior.before)
    reached = loss(now, squares)
    # a first step is taken as if the parts had no more than noise: what they have more is what the series misses
    for _ in range(STEPS):
        normal, right = posterior.equations(now, noise)
        step = cho_solve(cho_factor(normal), right).reshape(orders, 20)
        for _ in range(HALVINGS):
            tried = posterior.missed(now + step)
            likely = loss(now + step, tried)
            if likely < reached:
                break
            step = 0.5 * step
        else:
            break
        now, squares, reached = now + step, tried, likely
        noise = np.maximum(squares, white**2)
    # what is left beyond noise is waves that the series misses, as long as the part: a reading for each of its numbers
    rows = np.maximum(number / (2.0 * orders), 1.0)
    normal, _ = posterior.equations(now, white**2 + np.maximum(squares - white**2, 0.0) * rows)
    inverse = cho_solve(cho_factor(normal), np.eye(orders * 20))
    covariance = np.stack([inverse[20 * k : 20 * k + 20, 20 * k : 20 * k + 20] for k in range(orders)])
    return now[:, :10].copy(), now[:, 10:].copy(), covariance


@dataclass(frozen=True, slots=True)
class _Posterior:
    """What a direction's coefficients (K, 20) were ``before`` the ``parts``, with the precision of these (20K, 20K);
    and of each part the monomials (10,) of its state and what laws multiply the orders' vectors by (K,).
    """

    before: FloatArray
    precision: FloatArray
    parts: Sequence[_Part]
    basis: Sequence[FloatArray]
    answer: Sequence[Complex]

    @classmethod
    def of(cls, series: Series, side: int, parts: Sequence[_Part], laws: Sequence[Law]) -> _Posterior:
        """Of one direction of a series."""
        before = np.concatenate([series.amplitude[side], series.phase[side]], axis=1)
        precision = np.zeros((before.size, before.size))
        for k, of_order in enumerate(series.covariance[side]):
            block = slice(20 * k, 20 * k + 20)
            precision[block, block] = _inverse(of_order)
        basis = [series.scaling[side].monomials(p.state[None, :])[0] for p in parts]
        return cls(before, precision, parts, basis, [_answer(series, p, laws) for p in parts])

    def strain(self, point: FloatArray) -> float:
        """Half of the square of how far some coefficients are from what they were, in standard deviations."""
        off = (point - self.before).ravel()
        return 0.5 * float(off @ self.precision @ off)

    def missed(self, point: FloatArray) -> FloatArray:
        """Mean square of what some coefficients leave of each part."""
        out = []
        for part, basis, answer in zip(self.parts, self.basis, self.answer, strict=True):
            vectors = _stacked(_vectors(point, basis, answer)[1])
            squares = part.squares - 2.0 * float(vectors @ part.product) + float(vectors @ part.gram @ vectors)
            out.append(max(squares, 0.0) / part.number)
        return np.asarray(out)

    def equations(self, point: FloatArray, noise: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Normal equations of a step from some coefficients; ``noise`` (parts,): variance of a row."""
        normal, right = self.precision.copy(), self.precision @ (self.before - point).ravel()
        for part, basis, answer, variance in zip(self.parts, self.basis, self.answer, noise, strict=True):
            rotation, vectors = _vectors(point, basis, answer)
            turning = _turning(rotation, vectors)
            left = part.product - part.gram @ _stacked(vectors)
            _add(normal, turning.T @ part.gram @ turning / variance, basis)
            right += ((turning.T @ left)[:, None] * basis / variance).ravel()
        return normal, right


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


def _answer(series: Series, part: _Part, laws: Sequence[Law]) -> Complex:
    """What the laws multiply the orders' vectors by in a part (K,)."""
    out = np.ones(len(series.orders), dtype=np.complex128)
    for law in laws:
        out = out * factor(law, part.state[None, :], np.array([part.time]), series.orders)[0]
    return out


def _vectors(point: FloatArray, basis: FloatArray, answer: Complex) -> tuple[Complex, Complex]:
    """How the orders' vectors (K,) move with their amplitudes at a state, and these vectors."""
    rotation = np.exp(1j * (point[:, 10:] @ basis)) * answer
    return rotation, (point[:, :10] @ basis) * rotation


def _stacked(vectors: Complex) -> FloatArray:
    """Real parts of vectors (K,), then imaginary ones (2K,)."""
    return np.concatenate([vectors.real, vectors.imag])


def _turning(rotation: Complex, vectors: Complex) -> FloatArray:
    """How stacked vectors (2K,) move with amplitude and phase of each order (2K, 2K)."""
    orders = vectors.size
    turning = np.zeros((2 * orders, orders, 2))
    each = np.arange(orders)
    for column, moves in enumerate((rotation, 1j * vectors)):
        turning[each, each, column], turning[orders + each, each, column] = moves.real, moves.imag
    return turning.reshape(2 * orders, 2 * orders)
