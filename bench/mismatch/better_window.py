"""The window of the rates, asked again when it is known what the torque consists of.

Before anything is found the window is chosen by inertia and plain friction (:mod:`bench.mismatch.recordings.window`).
What these leave may change with the window for another reason: a ripple that shakes the shaft is followed worse the
better its acceleration is seen. With the improved simulation nothing but the noise of the rates and what the window
takes from them makes a difference.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.given import Given
from bench.mismatch.prediction import Predictor, compared
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.recordings.smoothing import window
from bench.mismatch.recordings.window import AS_GOOD, LONG_S, OF_A_RECORDING, RECORDED, SPANS_S, spread_over
from bench.mismatch.score import prepared_members
from bench.simulation.frame import FloatArray
from bench.simulation.model import Simulation
from bench.simulation.terms import MOTOR_TORQUE

MOST = 8
"""fitted recordings that are asked, spread over the folder"""
LEAST_COMPARED = 0.9
"""of the samples that are compared with one window, that have to be with the other: about each reversal half a window
is not, and those that are left are easier
"""
Left = dict[int, tuple[FloatArray, NDArray[np.bool_]]]
"""what a simulation leaves of the samples (n,) of recordings, by their numbers, and which of them are compared"""


def smoothed_over(data: Dataset, span: float) -> Dataset:
    """The data set with rates smoothed over another ``span``, s; its rows are as they were."""
    return replace(data, folder=data.folder.smoothed(span))


def left(data: Dataset, improved: Simulation) -> Left | None:
    """What the improved simulation leaves of the motor torque in some recordings that were fitted; None where it does
    not say a term that matters.
    """
    predictor = Predictor(Given.of(improved))
    members = {m.index: m for m in spread_over([m for m in data.members if not m.held_out], MOST)}
    campaign = {channel: rows.frame for channel, rows in data.rows.items()}
    out: Left = {}
    for part in prepared_members(data, members):
        if MOTOR_TORQUE not in part.measured:
            continue
        side = compared(part, MOTOR_TORQUE)
        if predictor.missing(MOTOR_TORQUE, side.frame):
            return None
        frame = predictor.moved(MOTOR_TORQUE, side.frame, data.folder.manner.smoothing)
        values = predictor.channel(MOTOR_TORQUE, frame, side.start, campaign)
        out[int(part.frame.recording[0])] = side.measured - values, side.counts
    return out


def over(one: Left, other: Left) -> float:
    """Root mean square of ``one`` over that of the ``other`` in the samples that both compare; infinite where these are
    too few.
    """
    squares, samples, most = np.zeros(2), 0, 0
    for number in one.keys() & other.keys():
        (first, counts), (second, others) = one[number], other[number]
        both = counts & others
        squares += [np.sum(first[both] ** 2), np.sum(second[both] ** 2)]
        samples, most = samples + int(both.sum()), most + max(int(counts.sum()), int(others.sum()))
    if not samples or samples < LEAST_COMPARED * most or squares[1] <= 0.0:
        return float("inf")
    return float(np.sqrt(squares[0] / squares[1]))


def better_window(data: Dataset, improved: Simulation) -> float | None:
    """A window (s) with which the improved simulation leaves less of the fitted recordings' motor torque by more than
    is as good; None where there is none, or the rates are no matter of it.
    """
    manner = data.folder.manner
    if not manner.free or manner.source == RECORDED or MOTOR_TORQUE not in data.rows or data.folder.base is not None:
        return None
    now = left(data, improved)
    if not now:
        return None
    fitted = [m.recording for m in data.members if not m.held_out]
    rate = max(float(r.sample_rate) for r in fitted)
    longest = max(SPANS_S[-1], OF_A_RECORDING * float(np.median([r.size / float(r.sample_rate) for r in fitted])))
    # windows of as many samples are one
    asked = {window(rate, s): s for s in (*reversed(LONG_S), *reversed(SPANS_S)) if s <= longest}
    asked.pop(window(rate, manner.smoothing), None)
    each = {s: left(smoothed_over(data, s), improved) for s in asked.values()}
    found = [(over(one, now), s) for s, one in each.items() if one]
    ratio, span = min(found, default=(np.inf, 0.0))
    return span if AS_GOOD * ratio < 1.0 else None


def leaves_less(data: Dataset, improved: Simulation, before: tuple[Dataset, Simulation]) -> bool:
    """Whether what was found with another window leaves less of fitted recordings than what was found ``before``."""
    now, then = left(data, improved), left(*before)
    less = bool(now and then) and over(now or {}, then or {}) < 1.0
    if less:
        data.notes.append(
            f"rates are smoothed over {data.folder.manner.smoothing:g} s instead of"
            f" {before[0].folder.manner.smoothing:g} s: with what was found, less of the motor torque is left so"
        )
    return less
