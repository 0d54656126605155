"""How well a model meets recordings: RMSE and MAE of the transmission error, mean removed, a₀ left out (paper).

The model of a recording is a function of the angle alone (mean inputs), so it is tabulated once a revolution and
interpolated linearly at every sample. With h the table's step the error is below Σ A_k·(f_k·h)²/8: 3e-9 rad for
25 µrad at order 276.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.identification.samples.fractions import is_whole
from bench.identification.samples.reduction import Reduction
from bench.identification.samples.steady import SteadySums
from bench.identification.series.harmonics import single_recording
from bench.simulation import FourierSet, TransmissionErrorModel, basis

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

TABLE_BITS = 16
BOUND = "bound"
"""Name of the Fourier series fitted to the recording itself: what no model of these orders can beat."""

PAPER_TABLE: dict[str, dict[str, tuple[float, float]]] = {
    "identification": {"positive": (2.76e-5, 2.23e-5), "negative": (3.01e-5, 2.44e-5)},
    "validation": {"positive": (2.40e-5, 1.92e-5), "negative": (2.82e-5, 2.26e-5)},
}
"""The paper's own mean RMSE and mean MAE in rad, on its own bench."""


@dataclass(frozen=True, slots=True)
class Score:
    """RMSE and MAE in rad of one recording by model name (``bound`` among them)."""

    recording_id: str
    kind: str
    direction: int
    inputs: tuple[float, float, float]
    rmse: dict[str, float]
    mae: dict[str, float]


@njit(cache=True)
def _errors(angle: NDArray[np.uint32], sample: NDArray[np.float32], table: FloatArray, shift: int) -> FloatArray:
    models = table.shape[0]
    out = np.zeros((models, 2))
    unit = 1.0 / (1 << shift)
    mean = 0.0
    for n in range(sample.size):
        mean += sample[n]
    mean /= max(sample.size, 1)
    for n in range(sample.size):
        cell = angle[n] >> shift
        part = (angle[n] - (cell << shift)) * unit
        value = sample[n] - mean
        for m in range(models):
            e = value - table[m, cell] - part * (table[m, cell + 1] - table[m, cell])
            out[m, 0] += e * e
            out[m, 1] += abs(e)
    out /= max(sample.size, 1)
    return out


def revolution(orders: Sequence[float], z: ComplexArray, bits: int = TABLE_BITS) -> FloatArray:
    """Series Σ |z|·sin(f·θ + arg z) at 2^bits + 1 angles of one revolution, by an inverse FFT.

    Orders that are no whole number do not come back after a revolution, and are left out.
    """
    listed = np.asarray(orders, dtype=np.float64)
    at = is_whole(listed)
    size = 1 << bits
    spectrum = np.zeros(size // 2 + 1, dtype=np.complex128)
    # sin(fθ)·Re z + cos(fθ)·Im z is the real part of −i·z·exp(i·f·θ).
    np.add.at(spectrum, np.rint(listed[at]).astype(np.int64), -0.5j * z[at] * size)
    values = np.fft.irfft(spectrum, size)
    return np.concatenate([values, values[:1]])


def _without_fractions(steady: SteadySums, orders: FloatArray, z: ComplexArray) -> NDArray[np.float32]:
    """Kept samples (N,) less what orders (K,) that are no whole number make of them, with complex amplitudes z (K,)."""
    theta, left = steady.turned(), steady.sample.astype(np.float64)
    for k in np.flatnonzero(~is_whole(orders)):
        left -= (np.exp(1j * orders[k] * theta) * z[k]).imag
    return left.astype(np.float32)


def model_harmonics(fourier: FourierSet, torque: float, velocity: float, temperature: float) -> ComplexArray:
    """Complex amplitudes z (K,) of a model at inputs; NaN inputs count as 0."""
    row = np.nan_to_num(basis(torque, velocity, temperature))
    return np.asarray((fourier.amplitude @ row) * np.exp(1j * (fourier.phase @ row)))


def mean_inputs(steady: SteadySums) -> tuple[float, float, float]:
    """Mean torque N·m, velocity rad/s, temperature °C of a steady window."""
    return float(steady.torque.mean()), float(steady.velocity.mean()), float(steady.temperature.mean())


def score(
    reduction: Reduction,
    models: Mapping[str, TransmissionErrorModel],
    orders: Sequence[float],
    notch_orders: Sequence[int],
) -> Score | None:
    """Score models on one recording; None where it has no transmission error or a model lacks its direction."""
    steady = reduction.steady
    if steady is None:
        return None
    inputs = mean_inputs(steady)
    z, ripple = single_recording(steady, orders, notch_orders)
    extra = [n for n in notch_orders if n not in orders]
    names, rows = [BOUND], [revolution([*orders, *extra], np.concatenate([z, ripple]))]
    series = [z]
    for name, model in models.items():
        fourier = model.direction(steady.window.direction)
        if fourier is None:
            return None
        harmonics = model_harmonics(fourier, *inputs)
        names.append(name)
        series.append(harmonics)
        # The ripple is taken off by the same notch for every model.
        rows.append(revolution([*fourier.orders, *extra], np.concatenate([harmonics, ripple])))
    if steady.fractions.size:
        listed = np.asarray(orders, dtype=np.float64)
        errors = np.concatenate([
            _errors(steady.angle, _without_fractions(steady, listed, harmonics), row[None, :], 32 - TABLE_BITS)
            for harmonics, row in zip(series, rows, strict=True)
        ])  # fmt: skip
    else:
        errors = _errors(steady.angle, steady.sample, np.stack(rows), 32 - TABLE_BITS)
    return Score(
        reduction.recording_id,
        reduction.kind,
        steady.window.direction,
        inputs,
        {name: float(np.sqrt(errors[i, 0])) for i, name in enumerate(names)},
        {name: float(errors[i, 1]) for i, name in enumerate(names)},
    )


def table(scores: Sequence[Score]) -> dict[str, dict[str, dict[str, dict[str, float]]]]:
    """Mean RMSE and MAE by set (identification, validation), direction and model, with the number of recordings."""
    out: dict[str, dict[str, dict[str, dict[str, float]]]] = {}
    for title, wanted in (("identification", False), ("validation", True)):
        for direction, sign in (("positive", 1), ("negative", -1)):
            rows = [s for s in scores if (s.kind == "validation") == wanted and s.direction == sign]
            if not rows:
                continue
            out.setdefault(title, {})[direction] = {
                name: {
                    "rmse": float(np.mean([s.rmse[name] for s in rows])),
                    "mae": float(np.mean([s.mae[name] for s in rows])),
                    "recordings": float(len(rows)),
                }
                for name in rows[0].rmse
            }
    return out
