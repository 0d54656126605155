"""Lines: orders that stand in every recording with a phase that is new each time, such as a cage that slips.

No regressor can follow them (their phase cannot be predicted), and averaged over recordings they vanish. So powers
are laid over each other, over the order: what belongs to the shaft stays at its order whatever the speed, a vibration
of the surroundings does not.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.spectrum import Turn, nufft
from bench.mismatch.tones import LEAST_RECORDINGS, at_every_speed, longest_run, surroundings
from bench.simulation.frame import FloatArray

LOWEST = 5
"""orders below are left to functions of the angle: a recording of one revolution hardly tells them from drift"""
BESIDE_KNOWN = 1.5
"""orders next to known ones, whose leakage they may be"""
LEAST_RATIO = 1.8
"""of an order's power over the noise about it, the median of all recordings"""
LEAST_SIGMAS = 6.0
"""of the logarithm of that between orders"""
MOST = 4
HIGHEST = 4000
LEAST_TURN = 1.9 * np.pi
NYQUIST_SHARE = 0.42


@dataclass(frozen=True, slots=True)
class Line:
    """An order with its amplitude (root mean square over recordings, times √2) and the deviation of that, power over
    the noise, recordings that show it.
    """

    order: float
    amplitude: float
    deviation: float
    ratio: float
    recordings: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class OrderSpectrum:
    """Power of a recording's steady part over the order (K,), relative to the power about each order; ``power`` in the
    channel's unit squared (of an amplitude); ``turning`` |v| in rad/s.
    """

    recording: int
    relative: FloatArray
    power: FloatArray
    turning: float


def order_spectrum(
    index: int,
    signal: FloatArray,
    valid: NDArray[np.bool_],
    steady: NDArray[np.bool_],
    rate: float,
    theta: FloatArray,
) -> OrderSpectrum | None:
    """Spectrum over the angle of the longest steady run of a recording; None where that is no whole revolution.

    One revolution under a Hann window: a line is four orders wide, and what stands beside it does not leak further.
    """
    a, b = longest_run(steady)
    if a == b:
        return None
    span = abs(float(theta[b - 1] - theta[a]))
    if span < LEAST_TURN:
        return None
    middle = float(np.median(signal[a:b]))
    own = np.where(valid[a:b], signal[a:b], middle) - middle
    limit = 6.0 * 1.4826 * float(np.median(np.abs(own))) or 1.0
    window = np.hanning(own.size)
    turning = span / ((b - a) / rate)
    amplitude = 2.0 * nufft(theta[a:b], np.clip(own, -limit, limit) * window, HIGHEST) / max(float(window.sum()), 1.0)
    power = np.abs(amplitude) ** 2
    power[int(min(NYQUIST_SHARE * 2.0 * np.pi * rate / max(turning, 1e-9), HIGHEST)) :] = np.nan
    seen = np.isfinite(power)
    about = np.full(power.size, np.nan)
    about[seen] = surroundings(power[seen])
    return OrderSpectrum(index, power / np.maximum(about, 1e-300), np.maximum(power - about, 0.0), turning)


def of_turns(turns: Sequence[Turn]) -> list[OrderSpectrum]:
    """The residual's spectra of the transmission error's revolutions, relative to their noise."""
    out = []
    for turn in turns:
        noise = 2.0 * turn.sigma**2
        power = np.abs(turn.spectrum) ** 2
        out.append(OrderSpectrum(turn.recording, power / noise, np.maximum(power - noise, 0.0), abs(turn.velocity)))
    return out


def search(spectra: Sequence[OrderSpectrum], known: Collection[float] = ()) -> list[Line]:
    """Orders whose power stands out of the noise at every speed, strongest first; ``known`` ones are passed over."""
    if len(spectra) < LEAST_RECORDINGS:
        return []
    relative = np.array([s.relative for s in spectra])
    orders = np.arange(relative.shape[1])
    for order in known:
        relative[:, np.abs(orders - order) < BESIDE_KNOWN] = np.nan
    middle = at_every_speed(relative, np.array([s.turning for s in spectra]))
    middle[:LOWEST] = 0.0
    heard = middle > 0.0
    if heard.sum() < 20:
        return []
    usual = float(np.median(middle[heard]))
    spread = 1.4826 * float(np.median(np.abs(np.log(middle[heard] / usual))))
    least = usual * max(LEAST_RATIO, float(np.exp(LEAST_SIGMAS * spread)))
    out: list[Line] = []
    while len(out) < MOST and middle.max() > least:
        k = int(np.argmax(middle))
        near = slice(max(k - 2, 0), k + 3)
        weight = np.maximum(np.nan_to_num(np.nanmedian(relative[:, near], axis=0)) - usual, 0.0)
        centre = float(np.sum(weight * orders[near]) / max(float(weight.sum()), 1e-300))
        power = np.array([float(np.nanmax(s.power[near])) for s in spectra])
        size = np.sqrt(power)
        shown = tuple(s.recording for s, row in zip(spectra, relative, strict=True) if row[k] > LEAST_RATIO * usual)
        error = float(np.std(size) / np.sqrt(size.size))
        out.append(Line(centre, float(np.sqrt(np.mean(power))), error, float(middle[k] / usual), shown))
        middle[max(k - 4, 0) : k + 5] = 0.0
    return out


def unfollowed(turns: Sequence[Turn], orders: Sequence[float]) -> list[float]:
    """Known orders whose amplitudes the polynomials do not follow: those that hold most of what the turns have left."""
    if not turns or len(orders) != turns[0].amplitude.size:
        return []
    power = np.mean([np.abs(t.amplitude) ** 2 for t in turns], axis=0)
    place = [min(round(f), turns[0].sigma.size - 1) for f in orders]
    noise = np.mean([2.0 * t.sigma[place] ** 2 for t in turns], axis=0)
    excess = power - noise
    return [float(f) for f, e, n in zip(orders, excess, noise, strict=True) if e > max(0.3 * excess.max(), 9.0 * n)]
