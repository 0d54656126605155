"""From what rates are taken and over how long they are smoothed, where a motion is nobody's set speed: as the torque
asks for.

A long window takes the noise of an acceleration and the acceleration: a rotor that is shaken by its cogging sixty times
a second has none left over 60 ms. A short one leaves noise in it, and a regression takes that for motion. Either way
the torque is followed worse. So the window is the one with which inertia and plain friction leave least of the torque.
A drive that records its speed may know it better than the differences of a coarse angle do, or later; the same is asked
of it, smoothed and as it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from bench.mismatch.recordings.runs import Runs, smoothed
from bench.mismatch.recordings.smoothing import WINDOWS_S, local_quadratic, repaired, window
from bench.recording import Recording
from bench.simulation.frame import FloatArray

Item = TypeVar("Item")
SPANS_S = (0.004, 0.008, *WINDOWS_S)
"""lengths of the window that are asked, the shortest first"""
LONG_S = (0.12, 0.25, 0.5, 1.0)
"""further ones, for coarse angles at low rates, each if it leaves less than all shorter ones by more than is as good:
a long window takes from all that changes within it
"""
DILUTED = 0.05
"""of the variance of an acceleration that is noise, from which longer windows are asked: by that share a regression
takes the inertia for smaller (Fuller, Measurement Error Models, Wiley 1987, eq. 1.1.11)
"""
OF_A_RECORDING = 0.15
"""of the time that a recording lasts, that a long window is at most: at both ends half of it is lost"""
SAMPLES_AS_RECORDED = 2.0
"""samples over which a speed that is not smoothed says an acceleration"""
FEWEST_RECORDINGS, MOST_SAMPLES = 6, 100_000
"""recordings that are asked, spread over the folder; and more, up to so many samples: six short pieces may show nothing
but rest
"""
FEWEST_SAMPLES = 100
"""of a recording, from which its differences tell noise"""
AS_GOOD = 1.02
"""what a longer window may leave, over the least: the noise in a rate falls with the power 2.5 of its window; and what
the angle may leave, over the recorded speed
"""
ANGLE, VELOCITY, RECORDED = "angle", "velocity", "velocity as recorded"
"""what rates are taken from"""


@dataclass(frozen=True, slots=True)
class Rates:
    """How rates are taken: window in s, and from what."""

    span: float
    source: str = ANGLE


def motion(angle: FloatArray, velocity: FloatArray, how: Rates, runs: Runs) -> tuple[FloatArray, FloatArray]:
    """Speed and acceleration (n,) of a motor, of which ``how`` says which signal is read, smoothed in ``runs``."""
    if how.source == RECORDED:
        return velocity, np.gradient(runs.bridged(velocity))[runs.at] * runs.rate
    if how.source == VELOCITY:
        return smoothed(velocity, how.span, runs)[:2]
    return smoothed(angle, how.span, runs)[1:]


def best_rates(recordings: Sequence[Recording], standstill: float) -> Rates | None:
    """How rates are taken so that inertia and friction leave least of the motor torque; None where that cannot be told.

    ``standstill``: speed in rad/s (a linear axis: m/s) below which the direction of motion is not told.
    """
    usable = [r for r in recordings if {"motor_angle", "motor_torque"} <= set(r.specs) and r.size > 1]
    wanted = max(FEWEST_RECORDINGS, MOST_SAMPLES * len(usable) // max(1, sum(r.size for r in usable)))
    chosen = spread_over(usable, wanted)
    if not chosen:
        return None
    found = _best([Rates(span) for span in SPANS_S], chosen, standstill)
    if found is None or any("motor_velocity" not in r.specs for r in recordings):
        return None if found is None else found[0]
    fastest = max(float(r.sample_rate) for r in recordings)
    as_recorded = Rates(max(SPANS_S[0], SAMPLES_AS_RECORDED / fastest), RECORDED)
    other = _best([as_recorded, *(Rates(span, VELOCITY) for span in SPANS_S)], chosen, standstill)
    return other[0] if other is not None and AS_GOOD * other[1] < found[1] else found[0]


def spread_over(items: Sequence[Item], most: int) -> list[Item]:
    """So many of some items at most, spread evenly."""
    spread = np.linspace(0.0, len(items) - 1.0, min(most, len(items))).round().astype(int)
    return [items[i] for i in np.unique(spread)]


def _best(hows: Sequence[Rates], recordings: Sequence[Recording], standstill: float) -> tuple[Rates, float] | None:
    """Of ways to take rates, in the order of their windows, the last that is as good as any, or a longer one that
    leaves less; and what it leaves.
    """

    def left(how: Rates) -> float:
        return _left([_columns(r, how, standstill) for r in recordings])

    each = [left(how) for how in hows]
    least = min(each)
    if not np.isfinite(least) or least <= 0.0:
        return None
    found = next(
        (how, size) for how, size in zip(reversed(hows), reversed(each), strict=True) if size <= AS_GOOD * least
    )
    if found[0] != hows[-1] or _noise_share(recordings, found[0]) < DILUTED:
        return found
    lasts = float(np.median([r.size / float(r.sample_rate) for r in recordings]))
    for span in (s for s in LONG_S if s <= OF_A_RECORDING * lasts):
        longer = Rates(span, found[0].source)
        size = left(longer)
        if AS_GOOD * size < found[1]:
            found = longer, size
    return found


def _noise_share(recordings: Sequence[Recording], how: Rates) -> float:
    """Share of noise in the variance of the acceleration, the middle one of the recordings. The signal's noise is read
    from its third differences, whose variance is 20 times its own.
    """
    shares = []
    for recording in recordings:
        rate, of_angle = float(recording.sample_rate), how.source == ANGLE
        name = "motor_angle" if of_angle else "motor_velocity"
        signal = recording.si(name)
        signal = repaired(signal, ~np.isfinite(signal))
        if signal.size < FEWEST_SAMPLES:
            continue
        noise = float(np.var(np.diff(signal, 3))) / 20.0
        # variance of a local quadratic's curvature and slope, in units of the samples' (Savitzky and Golay 1964)
        n = window(rate, how.span)
        part = 720.0 * rate**4 / (n * (n**2 - 1) * (n**2 - 4)) if of_angle else 12.0 * rate**2 / (n * (n**2 - 1))
        _, slope, curvature = local_quadratic(signal, rate, how.span)
        shares.append(noise * part / max(float(np.var(curvature if of_angle else slope)), 1e-300))
    return float(np.median(shares)) if shares else 0.0


def _columns(recording: Recording, how: Rates, standstill: float) -> FloatArray:
    """Samples of a recording (n, k): direction, speed, acceleration, one, load where there is one, gravity, which a
    smoothed acceleration of a swing resembles; last the torque.
    """
    names = [n for n in ("motor_angle", "motor_velocity", "motor_torque", "load_torque") if n in recording.specs]
    signals = {n: repaired(values, ~np.isfinite(values)) for n, values in recording.read_si(names).items()}
    none = np.zeros(recording.size)
    angle, velocity = signals["motor_angle"], signals.get("motor_velocity", none)
    speed, acceleration = motion(angle, velocity, how, Runs.whole(recording.size, float(recording.sample_rate)))
    direction = np.where(np.abs(speed) > standstill, np.sign(speed), 0.0)
    load = signals.get("load_torque", none)
    output = angle / float(recording.gearbox.ratio or 1.0)
    gravity = [np.sin(output), np.cos(output)]
    return np.column_stack(
        [direction, speed, acceleration, np.ones(speed.size), load, *gravity, signals["motor_torque"]]
    )


def _left(parts: Sequence[FloatArray]) -> float:
    """Root mean square of what least squares leave of the last column."""
    data = np.vstack(parts)
    scale = np.maximum(np.sqrt(np.mean(data**2, axis=0)), 1e-300)
    x, y = data[:, :-1] / scale[:-1], data[:, -1]
    return float(np.sqrt(np.mean((y - x @ np.linalg.lstsq(x, y, rcond=1e-9)[0]) ** 2)))
