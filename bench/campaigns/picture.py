"""The picture at the end of a campaign: transmission error over one load-side revolution and its order spectrum."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.recording import Recording

BINS = 2048
"""Angle bins of a revolution: orders up to 1024, each bin the mean of its samples."""
_SHOWN_ORDER = 320
_LABELLED = 8
_MOST_RECORDINGS = 4


def transmission_error(recording: Recording) -> NDArray[np.float64]:
    """Return the transmission error q − θ over one full revolution of steady motion, in rad, shape (BINS,).

    The value of bin i is the mean over input angles θ from 2π·i/BINS to 2π·(i+1)/BINS.

    Raises
    ------
    RecordingError
        If there is no full revolution, an angle is missing, or the ratio is not known.
    """
    ratio = recording.gearbox.ratio
    steady = recording.longest_steady()
    if steady is None or ratio is None or "load_angle" not in recording or "motor_angle" not in recording:
        raise RecordingError(f"{recording.path}: no transmission error without steady motion, both angles and a ratio")
    values = recording.read_si(["motor_angle", "load_angle"], steady.start, steady.stop)
    theta, q = values["motor_angle"] / ratio, values["load_angle"]
    first_revolution = np.abs(theta - theta[0]) < 2.0 * np.pi
    if first_revolution.all():
        raise RecordingError(f"{recording.path}: steady motion covers less than one load-side revolution")
    theta, error = theta[first_revolution], (q - theta)[first_revolution]
    index = np.minimum((np.mod(theta, 2.0 * np.pi) * (BINS / (2.0 * np.pi))).astype(np.int64), BINS - 1)
    count = np.bincount(index, minlength=BINS)
    mean = np.bincount(index, weights=error, minlength=BINS) / np.maximum(count, 1)
    # a fast point may leave a bin without sample; its neighbours say what it would have held
    missing = count == 0
    if missing.any():
        mean[missing] = np.interp(np.flatnonzero(missing), np.flatnonzero(~missing), mean[~missing], period=BINS)
    return np.asarray(mean)


def order_amplitudes(error: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return single-sided amplitudes in rad at the integer orders 0 … n/2 of one revolution, shape (n/2 + 1,)."""
    amplitude = np.abs(np.fft.rfft(error)) * (2.0 / error.size)
    amplitude[0] /= 2.0
    return np.asarray(amplitude)


def draw(recordings: Sequence[Recording], target: Path, title: str) -> Path:
    """Draw up to four recordings with a full revolution into a PNG file.

    Raises
    ------
    RecordingError
        If none of them has one.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 7.5), layout="constrained")
    FigureCanvasAgg(figure)
    over_angle, spectrum = figure.subplots(2, 1)
    for recording in recordings[:_MOST_RECORDINGS]:
        error = transmission_error(recording)
        amplitude = order_amplitudes(error)[: _SHOWN_ORDER + 1]
        degrees = (np.arange(BINS) + 0.5) * (360.0 / BINS)
        setpoint = recording.setpoint
        label = f"{setpoint.load_torque:.4g} N·m, {np.degrees(setpoint.velocity):+.3g} °/s"
        (line,) = over_angle.plot(degrees, 1e3 * (error - error.mean()), linewidth=0.8, label=label)
        # orders are lines, not a curve; recordings stand side by side within an order
        orders = np.arange(1, amplitude.size) + 0.25 * len(over_angle.lines)
        spectrum.vlines(orders, 0.0, 1e6 * amplitude[1:], linewidth=1.0, color=line.get_color())
    if not over_angle.lines:
        raise RecordingError("no recording with a full revolution of steady motion, there is no picture to draw")
    _label_orders(spectrum, amplitude)
    over_angle.set(xlabel="input angle θ = motor angle / u [°]", ylabel="transmission error\nwithout mean [mrad]")
    over_angle.set_xlim(0, 360)
    over_angle.legend(fontsize=8, loc="upper right")
    spectrum.set(
        xlabel="order (times a load-side revolution)", ylabel="amplitude [µrad]", xlim=(0, _SHOWN_ORDER), ylim=(0, None)
    )
    figure.suptitle(title)
    figure.savefig(target, dpi=120)
    return target


def _label_orders(axes: Any, amplitude: NDArray[np.float64]) -> None:
    for order in np.argsort(amplitude[1:])[::-1][:_LABELLED] + 1:
        axes.annotate(
            str(order), (order, 1e6 * amplitude[order]), textcoords="offset points", xytext=(3, 2), fontsize=8
        )
