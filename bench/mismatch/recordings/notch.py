"""The load motor's torque ripple: its orders read from the recordings, and taken off the channels that see them.

A permanent-magnet motor ripples at six and twelve times its pole pairs. The simulation knows that and leaves it out,
as a notch (bench-physics, "Nominal simulation" 1); how many pole pairs there are, the recordings say.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import finufft
import numpy as np
from numpy.typing import NDArray
from scipy import stats
from scipy.ndimage import median_filter, uniform_filter1d

from bench.mismatch import criteria
from bench.mismatch.recordings.late import Complex, lags_tried
from bench.recording import Recording
from bench.simulation.frame import FloatArray
from bench.simulation.sines import phasors
from bench.simulation.waves import of_orders

ACCURACY = 1e-9
"""relative, of spectra over angles"""
MOST_POLE_PAIRS = 120
_LOOKED_AT = 12
"""recordings whose spectra are averaged"""
_ENOUGH = 20_000
"""samples that the ripple is fitted to"""
_FEWEST = 200
"""samples below which no ripple is fitted"""
_NEIGHBOURS = 15
"""orders on either side whose median tells the noise at an order"""


def spectrum(theta: FloatArray, values: FloatArray, highest: int) -> Complex:
    """Sum of values·exp(j·f·theta) for the orders f = 0 … highest (non-uniform FFT)."""
    full = finufft.nufft1d1(
        np.ascontiguousarray(np.mod(theta, 2.0 * np.pi)),
        np.ascontiguousarray(values.astype(np.complex128)),
        2 * highest + 1,
        eps=ACCURACY,
        isign=1,
        nthreads=1,
    )
    return np.asarray(full[highest:])


@dataclass(frozen=True, slots=True)
class Lines:
    """What the torque sensor reads at the orders 0 … highest of the output's revolution in steady motion.

    ``torque``, ``shaken`` (recordings, orders): as measured, and the load's acceleration there, both over the noise of
    their recording; ``one`` (recordings,): a ripple of 1 N·m over that noise; ``speed`` (recordings,): of the output,
    rad/s, positive and negative.
    """

    torque: Complex
    shaken: Complex
    one: FloatArray
    speed: FloatArray


def steady_lines(recordings: Sequence[Recording]) -> Lines | None:
    """Lines of some of the recordings, spread over the campaign; None where too few of them run steadily."""
    seen: list[Complex] = []
    levels: list[float] = []
    shaken: list[Complex] = []
    speeds: list[float] = []
    highest = 12 * MOST_POLE_PAIRS + 2 * _NEIGHBOURS
    having = [r for r in recordings if {"load_torque", "load_angle"} <= set(r.specs)]
    steady = [(r, part) for r in having if (part := r.longest_steady()) is not None]
    for recording, part in steady[:: max(1, len(steady) // _LOOKED_AT)]:
        names = [n for n in ("load_angle", "load_torque", "motor_angle") if n in recording.specs]
        values = recording.read_si(names, part.start, part.stop)
        angle, torque = values["load_angle"], values["load_torque"]
        if angle.size < _FEWEST or not np.isfinite(angle).all() or not np.isfinite(torque).all():
            continue
        if np.ptp(angle) < 2.0 * np.pi / 6.0:
            continue
        torque = torque - np.median(torque)
        limit = 6.0 * float(np.median(np.abs(torque))) or 1.0
        taper = np.hanning(angle.size)
        clipped = np.clip(torque, -limit, limit) * taper
        line = 2.0 * spectrum(angle, clipped, highest) / max(float(taper.sum()), 1.0)
        levels.append(max(float(np.median(np.abs(line))), 1e-300))
        seen.append(line / levels[-1])
        shaken.append(_shaking(recording, values, taper, highest) / levels[-1])
        speeds.append(float(angle[-1] - angle[0]) * float(recording.sample_rate) / (angle.size - 1))
    if len(seen) < criteria.FEWEST_RECORDINGS:
        return None
    return Lines(np.array(seen), np.array(shaken), 1.0 / np.array(levels), np.array(speeds))


def orders_of(seen: Lines) -> tuple[float, ...]:
    """Orders per output revolution of the load motor's ripple in lines; none where nothing of the kind stands out.

    Looked for in what the torque sensor reads beyond the load's inertia, with one phase in all recordings.
    """
    torques, one = seen.torque, seen.one
    lines = _without_inertia(torques, seen.shaken)
    pairs = np.arange(1, MOST_POLE_PAIRS + 1)
    # a ripple stands out in the torque itself: taking off the inertia of what only an encoder misreads would make one
    measured, beside = (np.abs(one @ of) ** 2 for of in (torques, lines))
    strength = np.array(
        [[min(_line_strength(power, 6 * k * int(p)) for power in (measured, beside)) for k in (1, 2)] for p in pairs]
    )
    # two orders of each number of pole pairs are asked
    least = float(stats.f.isf(criteria.ERROR_RATE / strength.size, 2, 2 * (one.size - 1)))
    for k, order in itertools.product((1, 2), 6 * pairs):
        if strength[order // 6 - 1, k - 1] < criteria.LINE_POWER:
            continue  # none of the ripple's anyway
        line, turned = lines[:, k * order], seen.speed * float(k * order)
        if _coherence(line, one) < least and not _coherent_late(line, one, turned, strength.size):
            strength[order // 6 - 1, k - 1] = 0.0
    best = int(np.argmax(strength.max(axis=1)))
    if strength[best].max() < criteria.LINE_POWER:
        return ()
    p = int(pairs[best])
    if strength[best, 0] < criteria.LINE_POWER and strength[best, 1] == strength.max():
        # only twelve times p stands out: it is six times twice as many; an odd number may be the true one all the same
        return (12.0 * p, 24.0 * p) if p % 2 == 0 else (6.0 * p, 12.0 * p, 24.0 * p)
    return (6.0 * p, 12.0 * p)


def _shaking(recording: Recording, values: dict[str, FloatArray], taper: FloatArray, highest: int) -> Complex:
    """Acceleration of the load, rad/s², at the orders 0 … highest, by the transmission error in steady motion: of each
    wave that stands out of the noise it grows with the square of the speed. Zeros where there is no second angle.
    """
    ratio = recording.gearbox.ratio
    if "motor_angle" not in values or ratio is None or not np.isfinite(values["motor_angle"]).all():
        return np.zeros(highest + 1, dtype=np.complex128)
    angle = values["load_angle"]
    error = angle - values["motor_angle"] / ratio
    speed = float(np.ptp(angle)) * float(recording.sample_rate) / angle.size
    waves = 2.0 * spectrum(angle, (error - np.median(error)) * taper, highest) / max(float(taper.sum()), 1.0)
    return np.asarray(np.where(standing_out(waves), -((np.arange(highest + 1) * speed) ** 2) * waves, 0.0))


def standing_out(waves: Complex) -> NDArray[np.bool_]:
    """Which of the waves of a spectrum, from the constant on (orders,), stand out of the noise about them; the constant
    is none.
    """
    power = np.abs(waves) ** 2
    power[0] = power[1]
    noise = median_filter(power, 2 * _NEIGHBOURS + 1, mode="mirror") / np.log(2.0)
    clear = np.asarray(power > criteria.LINE_POWER * np.maximum(noise, 1e-300))
    clear[0] = False
    return clear


def _without_inertia(lines: Complex, shaken: Complex) -> Complex:
    """Torque at the orders (recordings, orders) less what follows the load's acceleration there, with one inertia for
    all orders and recordings: that the simulation has. As it is where no inertia is seen.
    """
    energy = float(np.sum(np.abs(shaken) ** 2))
    if energy <= 0.0:
        return lines
    inertia = float(np.vdot(shaken, lines).real) / energy
    left = lines - inertia * shaken
    # a load that wavers stands at low orders: what is usual of all is noise
    scatter = float(np.sqrt(np.median(np.abs(left[shaken != 0.0]) ** 2) / np.log(2.0) / 2.0 / energy))
    return left if inertia > criteria.TOLD * scatter else lines


def _coherence(line: Complex, one: FloatArray) -> float:
    """Square of one ripple in vectors (recordings,) over their scatter about it, as F with 2 and 2(n - 1) degrees of
    freedom. A slow wavering of the load stands at low orders, with a phase of its own in each recording.
    """
    energy = float(one @ one)
    ripple = np.vdot(one, line) / energy
    scatter = float(np.sum(np.abs(line - one * ripple) ** 2)) / (line.size - 1)
    return energy * float(np.abs(ripple)) ** 2 / max(scatter, 1e-300)


def _coherent_late(line: Complex, one: FloatArray, turned: FloatArray, asked: int) -> bool:
    """Whether vectors (recordings,) are of one ripple that the sensor tells late, among as many orders as are asked;
    ``turned`` (recordings,): rad by which it turns in a second.
    """
    tried = lags_tried(turned, [1.0])
    freedom = 2 * (one.size - 1) - 1
    least = float(stats.f.isf(criteria.ERROR_RATE / (asked * tried.size), 2, freedom))
    return any(_coherence(line * np.exp(-1j * turned * lag), one) > least for lag in tried.tolist())


def _line_strength(power: FloatArray, order: int) -> float:
    """Power at an order over the mean noise about it (the median of an exponential variable is ln 2 of its mean)."""
    near = np.concatenate([power[order - _NEIGHBOURS : order - 1], power[order + 2 : order + _NEIGHBOURS + 1]])
    if order - _NEIGHBOURS < 1:
        near = power[order + 2 : order + 2 * _NEIGHBOURS]
    return float(power[order] / max(float(np.median(near)) / np.log(2.0), 1e-300))


def notched(
    angle: FloatArray,
    torque: FloatArray,
    direction: FloatArray,
    bad: NDArray[np.bool_],
    orders: Sequence[float],
    beside: Sequence[FloatArray] = (),
    driven: bool = False,
) -> FloatArray:
    """The ripple in a recording's torque at ``orders`` over the output angle; 0 where it stands or hardly turns.

    All arrays (n,). The slow part stands beside the waves: a constant, the direction, a line over time, and what else
    is given ``beside``: while a shaft starts, its waves are slow, and drag that grows with the speed looks like them.
    Where the torque is ``driven`` up and down, its course is taken off, from the waves as well, and they are fitted
    where that is straight.
    """
    out = np.zeros(angle.size)
    moving = (direction != 0) & ~bad
    if not orders or moving.sum() < _FEWEST or float(np.ptp(angle[moving])) * min(orders) < 6.0 * np.pi:
        return out
    off = np.abs(torque[moving] - np.median(torque[moving]))
    width = _wave_length(angle, moving, min(orders)) if driven else 0
    course = uniform_filter1d(torque, width, mode="nearest") if width else np.zeros(angle.size)
    chosen = _straight(course, width, moving) if width else moving.copy()
    chosen[moving] &= off <= np.percentile(off[:: max(1, off.size // _ENOUGH)], 99)
    if chosen.sum() > _ENOUGH:  # a wave of a million samples is as well known from some ten thousand
        chosen[np.flatnonzero(chosen)[np.arange(int(chosen.sum())) % (chosen.sum() // _ENOUGH) != 0]] = False
    if chosen.sum() < _FEWEST:
        return out
    frequencies = np.asarray(orders, dtype=np.float64)
    if width:
        waves = _waves(angle, frequencies)
        design = (waves - uniform_filter1d(waves, width, axis=1, mode="nearest"))[:, chosen]
    else:
        line: FloatArray = np.linspace(-1.0, 1.0, angle.size)
        slow = np.vstack([np.ones(int(chosen.sum())), *(x[chosen] for x in (direction, line, *beside))])
        slow /= np.maximum(np.abs(slow).max(axis=1, keepdims=True), 1e-300)
        design = np.vstack([_waves(angle[chosen], frequencies), slow])
    normal, right = design @ design.T, design @ (torque - course)[chosen]
    normal[np.diag_indices_from(normal)] *= 1.0 + 1e-9
    beta: FloatArray = np.asarray(np.linalg.lstsq(normal, right, rcond=1e-12)[0], dtype=np.float64)
    cosine, sine = (beta[k : 2 * frequencies.size : 2] for k in (0, 1))
    return np.where(moving, of_orders(angle, frequencies, cosine, sine), 0.0)


def _wave_length(angle: FloatArray, moving: NDArray[np.bool_], order: float) -> int:
    """Samples of a wave of an order at the speed that is usual where an angle (n,) is ``moving``; the mean over so many
    is the course of a torque that is driven up and down. 0 where a wave has too few samples, or a recording too few
    waves.
    """
    step = float(np.median(np.abs(np.diff(angle))[moving[1:]]))
    width = round(2.0 * np.pi / order / max(step, 1e-300))
    return width if 3 <= width <= angle.size // 4 else 0


def _straight(course: FloatArray, width: int, moving: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The half of the ``moving`` samples, but for the ends, where a course (n,) bends least over a ``width``: a
    staircase holds all orders, and its corners are far larger than any ripple.
    """
    bend = np.full(course.size, np.inf)
    bend[width:-width] = np.abs(course[2 * width :] - 2.0 * course[width:-width] + course[: -2 * width])
    inside = moving & np.isfinite(bend)
    return np.asarray(inside & (bend <= np.median(bend[inside]))) if inside.any() else inside


def _waves(angle: FloatArray, orders: FloatArray) -> FloatArray:
    """Cosine and sine (2 * orders, n) of each order over an angle (n,)."""
    wave = phasors(orders[:, None] * angle)
    return np.stack([wave.real, wave.imag], axis=1).reshape(2 * orders.size, angle.size)
