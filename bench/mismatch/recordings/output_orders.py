"""Orders per output revolution in the torques of steady revolutions.

Rows of a torque average over a second; what turns with the output is looked at here instead: in the samples of each
steady revolution, less what the torque must be by geometry (tau/u in the motor's, the load motor's torque in the
sensor's).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.recordings.prepared import Prepared
from bench.simulation.frame import FloatArray
from bench.simulation.sines import phasors
from bench.simulation.terms import MOTOR_TORQUE

Complex = NDArray[np.complex128]

HIGHEST_OUTPUT_ORDER = 60
_BINS = 720
"""a revolution: twelve a period of the highest order"""
_SHORTEST_REVOLUTION = 0.97 * 2.0 * np.pi
"""rad: a segment that falls short of a revolution by a smoothing window still counts"""
_RIDGE = 1e-9
"""of the samples: what a gap of a hundredth of a revolution cannot tell is taken for nothing"""
_SMOOTHED = 40
"""orders from which on a revolution shows little but noise"""


@dataclass(frozen=True, slots=True)
class OutputSpectrum:
    """Amplitudes a + j·b of a·cos(f·q) + b·sin(f·q) in one steady segment's torque, f = 0 … HIGHEST_OUTPUT_ORDER.

    ``sigma``: standard deviation of each part by the segment's noise at high orders; ``spread``: noise of a sample;
    ``torque`` at the output N·m, ``velocity`` rad/s, ``temperature`` °C, ``time`` s of the campaign, means of the
    segment; ``direction`` of motion; ``revolutions`` it has; ``shaking``: amplitudes of the motor's acceleration,
    rad/s², where the torque is the motor's.
    """

    recording: int
    amplitude: Complex
    sigma: float
    spread: float
    torque: float
    velocity: float
    temperature: float
    time: float
    direction: float
    revolutions: float
    shaking: Complex = field(default_factory=lambda: np.zeros(0, dtype=np.complex128))


def output_spectra(prepared: Prepared, channel: str) -> list[OutputSpectrum]:
    """Spectra over the output angle of a torque's steady segments of a revolution or more."""
    frame, measured = prepared.frame, prepared.measured[channel]
    if channel == MOTOR_TORQUE:
        load = prepared.measured.get("load_torque")
        looked_at = [measured.mean - (frame.torque if load is None else load.mean) / frame.ratio, frame.acceleration]
    else:
        looked_at = [measured.mean - frame.load_motor_torque]
    steady = (frame.steady > 0.5) & (frame.direction != 0)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], steady.astype(np.int8), [0])))).reshape(-1, 2)
    out = []
    for a, b in edges.tolist():
        good = measured.number[a:b] > 0
        angle = frame.q[a:b][good]
        if angle.size < 2 * HIGHEST_OUTPUT_ORDER or abs(float(angle[-1] - angle[0])) < _SHORTEST_REVOLUTION:
            continue
        signals = [signal[a:b][good] for signal in looked_at]
        amplitudes, sigma, spread = _fitted(angle, signals)
        rows = slice(a, b)
        travelled = abs(float(angle[-1] - angle[0])) / (2.0 * np.pi)
        out.append(
            OutputSpectrum(
                int(frame.recording[a]),
                amplitudes[0],
                sigma,
                spread * float(np.sqrt(prepared.thinning.group)),
                float(np.mean(frame.torque[rows])),
                float(np.mean(frame.velocity[rows])),
                float(np.mean(frame.temperature[rows])),
                float(np.mean(frame.time[rows])),
                float(np.sign(np.mean(frame.velocity[rows]))),
                travelled,
                *amplitudes[1:],
            )
        )
    return out


def orders_of(angle: FloatArray, values: FloatArray) -> Complex:
    """Amplitudes (HIGHEST_OUTPUT_ORDER + 1,) of a steady segment's values (n,) over the output angle, as of
    :class:`OutputSpectrum`.
    """
    return _fitted(angle, [values])[0][0]


def _fitted(angle: FloatArray, signals: Sequence[FloatArray]) -> tuple[list[Complex], float, float]:
    """Orders of signals (n,) beside a constant and a line, by least squares on means over small angles; of the first
    signal their noise and a sample's noise.
    """
    bin_of_sample = np.floor((angle - angle.min()) / (2.0 * np.pi) * _BINS).astype(np.int64)
    number = np.bincount(bin_of_sample)
    filled = number > 0
    count = number[filled].astype(np.float64)
    means = np.column_stack([np.bincount(bin_of_sample, values)[filled] / count for values in signals])
    centre = np.bincount(bin_of_sample, angle)[filled] / count
    orders = np.arange(1, HIGHEST_OUTPUT_ORDER + 1)
    line = (centre - centre.mean()) / max(float(np.ptp(centre)), 1e-12)
    waves = phasors(orders[None, :] * centre[:, None])
    x = np.column_stack([np.ones(centre.size), line, waves.real, waves.imag])
    weighted = x * count[:, None]
    normal = x.T @ weighted
    # orders of a revolution that is nearly whole are nearly orthogonal: normal equations are safe, and far quicker
    normal[np.diag_indices_from(normal)] += _RIDGE * float(count.sum())
    beta = np.linalg.solve(normal, weighted.T @ means)
    waves_of = beta[2 : 2 + orders.size] + 1j * beta[2 + orders.size :]
    amplitudes = np.concatenate((np.zeros((1, len(signals))), waves_of)).T
    high = np.abs(amplitudes[0, _SMOOTHED:]) ** 2
    sigma = float(np.sqrt(np.median(high) / np.log(2.0) / 2.0))
    left = signals[0] - np.interp(angle, *_rising(centre, x @ beta[:, 0]))
    return list(amplitudes), sigma, float(1.4826 * np.median(np.abs(left - np.median(left))))


def _rising(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    order = np.argsort(x)
    return x[order], y[order]
