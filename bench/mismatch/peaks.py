"""Orders and pulses that stand in the spectra of the transmission error and that the simulation does not have.

The data are the residual's complex amplitudes R at every integer order of every steady revolution, with their noise. A
new order is a vector that is the same in all recordings (or in each direction, or moves in proportion to the state); a
sideband is such a vector relative to the order it modulates; a local defect is one pulse that explains many orders at
once. All compete by the log-likelihood they gain on recordings left out; the best is taken off, and the search begins
again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.columns import RIPPLE_ORDERS
from bench.mismatch.spectrum import Complex, Turn, states
from bench.simulation.frame import FloatArray

LEAST_GAIN = 90.0
MIXED = 6.0
"""times that for orders at which the load motor's ripple and a known order mix"""
LEAST_SIZE = 0.06
"""root mean square of an order's amplitude over the noise of a row: below that it adds less than 0.2 % to the
residual
"""
LEAST_SCATTER = 3.0
"""variance over the noise's below which an order scatters no more than noise may"""
LEAST_STRAY = 0.5
"""part of an order's power that no function of the state follows, from which on it has no phase of its own"""
HIGHEST_MODULATION = 12
PULSE_WIDTHS = (0.006, 0.012, 0.025, 0.05, 0.1)
MOST = 14


@dataclass(frozen=True, slots=True)
class Peak:
    """One thing found: ``kind`` order, sideband or pulse.

    ``orders`` and for each a ``model`` with coefficients (columns of the model) that give b + j·a at the states: see
    :func:`design`. A pulse has ``angle``, ``width`` and ``height``.
    """

    kind: str
    orders: tuple[int, ...]
    model: str
    gain: float
    coefficients: tuple[Complex, ...] = ()
    carrier: int = 0
    angle: float = 0.0
    width: float = 0.0
    height: float = 0.0


@dataclass(slots=True)
class Spectra:
    """Residual vectors (turns, orders) b + j·a, their noise, the states and directions of the turns, who trains."""

    vectors: Complex
    sigma: FloatArray
    x: FloatArray
    direction: FloatArray
    train: NDArray[np.bool_]
    known: tuple[int, ...]
    carriers: dict[int, Complex]
    """vectors of the known orders that may be modulated, (turns,) each"""
    white: float

    @classmethod
    def of(
        cls, turns: Sequence[Turn], train: NDArray[np.bool_], known: Sequence[float], carriers: dict[int, Complex]
    ) -> Spectra:
        """Collect the turns' residual spectra. What scatters between turns more than their noise is noise, too."""
        vectors = np.array([1j * np.conj(t.spectrum) for t in turns])
        sigma = np.array([t.sigma for t in turns])
        x, direction = states(turns), np.array([t.direction for t in turns])
        sigma = sigma * np.sqrt(_scatter(vectors[train], sigma[train], x[train], direction[train]))
        return cls(
            vectors,
            sigma,
            x,
            direction,
            train,
            tuple(int(f) for f in known),
            carriers,
            float(np.median([t.white for t in turns])),
        )


def design(model: str, x: FloatArray, direction: FloatArray, carrier: Complex | None = None) -> Complex:
    """Regressors (turns, k) of an order's vector: constant, by direction, linear in the state; times a carrier's
    vector.
    """
    one = np.ones(len(direction), dtype=np.complex128)
    if model == "constant":
        columns = [one]
    elif model == "direction":
        columns = [one * (direction > 0), one * (direction < 0)]
    else:
        z = np.column_stack([x[:, 0] / 1000.0, x[:, 1] / 0.1, (x[:, 2] - 35.0) / 15.0])
        columns = [
            one * side * state for side in (direction > 0, direction < 0) for state in (1.0, z[:, 0], z[:, 1], z[:, 2])
        ]
    out = np.column_stack(columns)
    return out if carrier is None else out * carrier[:, None]


MODELS = ("constant", "direction", "linear")


def _scatter(vectors: Complex, sigma: FloatArray, x: FloatArray, direction: FloatArray) -> FloatArray:
    """Variance by which an order scatters about any vector that follows the state, over the noise's (orders,).

    1 where it is little more than noise: there an order with one phase in all turns and one with a new phase each time
    are not told apart yet.
    """
    columns = np.hstack(
        [design("linear", x, direction), ((x - x.mean(axis=0)) / np.maximum(np.ptp(x, axis=0), 1e-9)) ** 2]
    )
    columns = columns[:, np.any(columns != 0, axis=0)]
    if len(vectors) < 2 * columns.shape[1]:
        return np.ones(vectors.shape[1])
    left = vectors - columns @ np.linalg.lstsq(columns, vectors, rcond=1e-9)[0]
    freedom = len(vectors) / (len(vectors) - columns.shape[1])
    over, whole = (np.mean(np.abs(part) ** 2 / (2.0 * sigma**2), axis=0) for part in (left, vectors))
    over = over * freedom
    return np.asarray(np.where((over > LEAST_SCATTER) & (over > LEAST_STRAY * whole), over, 1.0))


def _leave_out(columns: Complex, vectors: Complex, sigma: FloatArray) -> tuple[FloatArray, Complex]:
    """Gain of log-likelihood by order (k,) when each turn is predicted by the others; and the coefficients by all
    turns.
    """
    gram = np.conj(columns.T) @ columns
    gram[np.diag_indices_from(gram)] += 1e-9 * np.trace(gram).real / len(gram) + 1e-300
    inverse = np.linalg.inv(gram)
    hat = columns @ inverse @ np.conj(columns.T)
    left = (vectors - hat @ vectors) / np.maximum(1.0 - np.real(np.diag(hat)), 0.05)[:, None]
    before = np.minimum(np.abs(vectors) ** 2, 1e300) / (2.0 * sigma**2)
    after = np.abs(left) ** 2 / (2.0 * sigma**2)
    return (before - after).sum(axis=0), inverse @ np.conj(columns.T) @ vectors


def _orders(spectra: Spectra) -> tuple[Peak | None, FloatArray]:
    """The best single order, and the gain of each order's constant model."""
    rows = spectra.train
    vectors, sigma = spectra.vectors[rows], spectra.sigma[rows]
    best: Peak | None = None
    constant = np.zeros(vectors.shape[1])
    size = np.sqrt(np.mean(np.abs(vectors) ** 2, axis=0))
    excess = np.sqrt(np.maximum(size**2 - 2.0 * np.mean(sigma**2, axis=0), 0.0))
    allowed = np.ones(vectors.shape[1], dtype=bool)
    allowed[[0, *(f for f in spectra.known if f < allowed.size)]] = False
    allowed &= excess > LEAST_SIZE * spectra.white
    least = np.where(np.isin(np.arange(allowed.size), _mixed(spectra.known)), MIXED * LEAST_GAIN, LEAST_GAIN)
    for model in MODELS:
        columns = design(model, spectra.x[rows], spectra.direction[rows])
        if columns.shape[0] < columns.shape[1] + 4:
            continue
        gain, coefficients = _leave_out(columns, vectors, sigma)
        if model == "constant":
            constant = gain
        price = 0.0 if model == "constant" else 3.0 * columns.shape[1]
        gain = np.where(allowed & (gain > least), gain - price, -np.inf)
        order = int(np.argmax(gain))
        if np.isfinite(gain[order]) and (best is None or gain[order] > best.gain):
            best = Peak("order", (order,), model, float(gain[order]), (coefficients[:, order],))
    return best, constant


def _mixed(known: Sequence[int]) -> list[int]:
    """Orders at which the ripple's torque and a known order may meet in a gearbox that is not linear."""
    return [abs(f + sign * int(r)) for f in known for r in RIPPLE_ORDERS for sign in (1, -1)]


def _sidebands(spectra: Spectra) -> Peak | None:
    rows = spectra.train
    best: Peak | None = None
    for carrier, vector in spectra.carriers.items():
        columns = vector[rows][:, None]
        for m in range(1, HIGHEST_MODULATION + 1):
            pair = (carrier - m, carrier + m)
            if carrier in RIPPLE_ORDERS:
                continue
            if pair[0] < 1 or any(f in spectra.known or f >= spectra.vectors.shape[1] for f in pair):
                continue
            gain, coefficients = _leave_out(columns, spectra.vectors[rows][:, pair], spectra.sigma[rows][:, pair])
            if gain.min() > 0.1 * gain.max() and (best is None or gain.sum() > best.gain):
                best = Peak(
                    "sideband",
                    pair,
                    "constant",
                    float(gain.sum()),
                    (coefficients[:, 0], coefficients[:, 1]),
                    carrier=carrier,
                )
    return best


def pulse_spectrum(width: float, orders: FloatArray) -> FloatArray:
    """Amplitudes of a periodic Gaussian pulse of unit height: a_f = width·sqrt(2/π)·exp(−(f·width)²/2)."""
    return np.asarray(width * np.sqrt(2.0 / np.pi) * np.exp(-0.5 * (orders * width) ** 2))


def _pulse(spectra: Spectra) -> Peak | None:
    rows = spectra.train
    vectors, sigma = spectra.vectors[rows], spectra.sigma[rows]
    number = vectors.shape[1]
    orders = np.arange(number, dtype=np.float64)
    weight = (1.0 / sigma**2).sum(axis=0)
    weight[[0, *(f for f in spectra.known if f < number)]] = 0.0
    total = (vectors / sigma**2).sum(axis=0)
    mean = np.where(weight > 0, total / np.where(weight > 0, weight, 1.0), 0.0)
    best: Peak | None = None
    for width in PULSE_WIDTHS:
        shape = pulse_spectrum(width, orders)
        # height·shape·(cos fα, sin fα) against (a, b): the matched filter over α is a Fourier series
        matched = (
            np.fft.irfft(np.append(shape * weight * (mean.imag - 1j * mean.real), np.zeros(4096 - number + 1)), 8192)
            * 4096
        )
        energy = float(np.sum(shape**2 * weight))
        gain = 0.5 * matched**2 / max(energy, 1e-300)
        place = int(np.argmax(gain))
        if best is None or gain[place] > best.gain:
            best = Peak(
                "pulse",
                (),
                "constant",
                float(gain[place]),
                angle=float(2.0 * np.pi * place / 8192),
                width=width,
                height=float(matched[place] / max(energy, 1e-300)),
            )
    return best


def prediction(peak: Peak, spectra: Spectra) -> Complex:
    """What a peak contributes to the vectors, (turns, orders)."""
    out = np.zeros_like(spectra.vectors)
    if peak.kind == "pulse":
        f = np.arange(out.shape[1], dtype=np.float64)
        shape = peak.height * pulse_spectrum(peak.width, f)
        out += (shape * (np.sin(f * peak.angle) + 1j * np.cos(f * peak.angle)))[None, :]
        out[:, 0] = 0.0
        return out
    carrier = spectra.carriers.get(peak.carrier) if peak.kind == "sideband" else None
    columns = design(peak.model, spectra.x, spectra.direction, carrier)
    for order, coefficients in zip(peak.orders, peak.coefficients, strict=True):
        out[:, order] = columns @ coefficients
    return out


def search(spectra: Spectra) -> list[Peak]:
    """Take off the best order, pair of sidebands or pulse until none gains enough; strongest first."""
    found: list[Peak] = []
    taken: set[int] = set()
    while len(found) < MOST:
        order, _ = _orders(spectra)
        candidates = [p for p in (order, _sidebands(spectra), _pulse(spectra)) if p is not None and p.gain > LEAST_GAIN]
        if not candidates:
            break
        # a pair must beat its stronger half alone; a pulse must beat the strongest order
        peak = max(candidates, key=lambda p: p.gain * (0.9 if p.kind == "pulse" else 1.0))
        if peak.kind == "order" and peak.orders[0] in taken:
            break
        if peak.kind == "pulse":
            energy = 0.5 * peak.height**2 * np.sum(pulse_spectrum(peak.width, np.arange(1.0, 1500.0)) ** 2)
            if energy < (LEAST_SIZE * spectra.white) ** 2 / 2.0:
                break
        taken.update(peak.orders)
        spectra.vectors = spectra.vectors - prediction(peak, spectra)
        found.append(peak)
    return found
