"""Orders that a tone makes: at one speed a disturbance of one frequency is as much an order, and no other speed says
which.

Where an order of the model acts mostly at speeds at which it has the frequency of a tone, and the tone is heard at
others as well, the tone is fitted in each recording with a phase of its own and taken off, and the orders are
looked for again.
"""

from __future__ import annotations

import numpy as np

from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.sight import known_orders
from bench.mismatch.unnamed.tones import Tone
from bench.simulation.frame import FloatArray, IntArray

MOSTLY = 0.5
"""share of an order's energy, in revolutions in which it is no more than the tone's leakage, from which the tone may
have made it"""
FEWEST_PERIODS = 2.0
"""of the tone in a recording: less is a slope"""
FINENESS = 4
"""frequencies tried a bin, which is one over the time of a recording's rows"""
DEVIATIONS = 3.0
"""standard deviations of the tone's frequency to either side within which each recording has its own"""


def made_by_tone(model: TransmissionModel, tone: Tone) -> tuple[float, ...]:
    """Orders beside the simulation's most of whose energy lies in revolutions in which they are no more than what a
    tone leaks to them: all of its amplitude A where the frequencies are the same, A/(pi*x) where they differ by x over
    the duration of the revolution (a rectangular window's spectrum).
    """
    periodic = model.periodic
    if periodic is None or model.seen is None:
        return ()
    known = known_orders(model)
    further = [f for f in model.seen.orders if f not in known]
    turning = model.training_revolutions
    if not further or not turning:
        return ()
    size = np.abs(periodic.at_revolutions(turning, further))
    duration = np.array([t.duration for t in turning])[:, None]
    hertz = np.array([abs(t.velocity) for t in turning])[:, None] * np.array(further) / (2.0 * np.pi)
    apart = np.maximum(np.abs(hertz - tone.frequency) - DEVIATIONS * tone.frequency_std, 0.0) * duration
    leaked = size <= tone.amplitude / np.maximum(np.pi * apart, 1.0)
    energy = size**2 * duration
    share = np.sum(energy * leaked, axis=0) / np.maximum(np.sum(energy, axis=0), 1e-300)
    return tuple(f for f, s in zip(further, share.tolist(), strict=True) if s > MOSTLY)


def tone_on_rows(model: TransmissionModel, tone: Tone, less: tuple[float, ...]) -> FloatArray:
    """A tone at the rows (n,), rad, fitted in each recording to what the model leaves without the orders ``less``."""
    periodic = model.periodic
    assert periodic is not None
    frame = model.rows.frame
    left = model.without_offset - periodic.less(less).evaluate(frame)
    out = np.zeros(model.rows.size)
    for recording in np.unique(frame.recording):
        rows = np.flatnonzero((frame.recording == recording) & model.inside)
        if rows.size and np.ptp(frame.time[rows]) * tone.frequency >= FEWEST_PERIODS:
            out[rows] = _fitted(frame.time, left, model.rows.number, rows, tone.frequency, tone.frequency_std)
    return out


def _fitted(
    time: FloatArray, left: FloatArray, number: FloatArray, rows: IntArray, hertz: float, std: float
) -> FloatArray:
    """The sine of one frequency about ``hertz`` that takes most off some rows, there."""
    since = time[rows] - time[rows[0]]
    weight = np.sqrt(number[rows].astype(np.float64))
    y = (left[rows] - np.average(left[rows], weights=number[rows])) * weight
    bin_hz = 1.0 / float(np.ptp(since))
    wide = max(DEVIATIONS * std, bin_hz)
    best, least = np.zeros(rows.size), float(y @ y)
    for f in hertz + np.linspace(-wide, wide, 2 * int(np.ceil(wide / bin_hz * FINENESS)) + 1):
        x = np.column_stack([np.cos(2.0 * np.pi * f * since), np.sin(2.0 * np.pi * f * since)])
        beta = np.linalg.lstsq(x * weight[:, None], y, rcond=None)[0]
        rest = y - (x @ beta) * weight
        if float(rest @ rest) < least:
            best, least = x @ beta, float(rest @ rest)
    return np.asarray(best)
