"""Search of the transmission error: its offset by regression, its harmonics in the order spectrum, the two in turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.bank import Fit
from bench.mismatch.collected import LIVELY_S, SLOW_S
from bench.mismatch.columns import RIPPLE_ORDERS, Entry
from bench.mismatch.harmonics import Harmonics, calibrated, searched
from bench.mismatch.linear import ChannelModel, analyse, predict, released
from bench.mismatch.offset import fit_offset, wavering
from bench.mismatch.periodic import NOTHING, Periodic
from bench.mismatch.prepare import reduce
from bench.mismatch.rows import Rows
from bench.mismatch.spectrum import turns
from bench.simulation.frame import FloatArray, Frame, IntArray
from bench.simulation.terms import TRANSMISSION_ERROR, Form, Point, Term

WIDEST_SPEED = 1.1
SLOWEST_SPEED = 0.2
"""of the campaign's slowest and fastest steady revolution. The polynomials hold within, and slow passages show a film
or a play best; not so the moments about standstill, nor the speed at which the bench warms up.
"""


@dataclass(slots=True)
class TransmissionModel:
    """The transmission error's model: offset (slow rows) and harmonics (angle rows)."""

    angle: Rows
    inside: NDArray[np.bool_]
    """angle rows within the bounds in which the polynomials hold"""
    offset: ChannelModel
    harmonics: Harmonics | None
    slow_inside: NDArray[np.bool_]
    """blocks of the offset's rows within the bounds"""
    _offsets: dict[bool, tuple[Fit, FloatArray]] = field(default_factory=dict)

    def predict(self, frame: Frame, whole: bool = True, rows: NDArray[np.bool_] | None = None) -> FloatArray:
        """Transmission error at the rows of a frame (those marked), rad; memories run through all of them."""
        out = self._offset(frame, whole)
        chosen = frame if rows is None else frame.take(rows)
        out = out if rows is None else out[rows]
        return out + self.harmonics.evaluate(chosen, whole) if self.harmonics is not None else out

    def _offset(self, frame: Frame, whole: bool) -> FloatArray:
        """The offset at the rows of a frame; on the model's own rows it is remembered as long as its fit stands."""
        if frame is not self.angle.frame:
            return predict(self.offset, frame, whole)
        fit, out = self._offsets.get(whole, (None, np.zeros(0)))
        if fit is not self.offset.fit:
            out = predict(self.offset, frame, whole)
            self._offsets[whole] = self.offset.fit, out
        return out


def slow_rows(rows: Rows, y: FloatArray, inside: NDArray[np.bool_]) -> tuple[Rows, NDArray[np.bool_]]:
    """Average angle rows over a quarter of a second (finer just after a reversal); and which blocks lie ``inside``."""
    frame = rows.frame
    lively = (frame.reversal_time < 1.5) & (frame.reversal_travel < 0.05)
    width = np.where(lively, LIVELY_S, SLOW_S)
    number = np.floor(np.cumsum(frame.step / width))
    change = np.diff(number) != 0
    change |= np.diff(frame.recording) != 0
    change |= np.diff(frame.steady) != 0
    change |= np.diff(frame.direction) != 0
    change |= np.diff(inside) != 0
    edges = np.concatenate(([0], np.flatnonzero(change) + 1)).astype(np.int64)
    weight = rows.number
    total = np.add.reduceat(weight, edges)
    mean = np.add.reduceat(y * weight, edges) / np.maximum(total, 1.0)
    width_rows = np.diff(np.append(edges, y.size))
    within = np.maximum(np.add.reduceat(y**2 * weight, edges) / np.maximum(total, 1.0) - mean**2, 0.0) * total
    return Rows(reduce(frame, edges), mean, total, within / np.maximum(width_rows - 1, 1)), inside[edges]


def analyse_transmission(
    angle: Rows,
    fold_of: IntArray,
    orders: Sequence[float],
    switched_off: Sequence[str] = (),
    known: Sequence[tuple[Term, Form, Point]] = (),
    given: Periodic = NOTHING,
) -> TransmissionModel:
    """Find what the transmission error's simulation lacks, on the training recordings (fold ≥ 0).

    ``known`` terms of the offset, pulses and laws in ``given`` are the simulation's own.
    """
    # the load motor's ripple twists the gearbox, too: orders like the series', known to any simulation
    orders = [*orders, *RIPPLE_ORDERS]
    train = {int(r) for r in np.flatnonzero(fold_of >= 0)}
    angle = replace(angle, y=angle.y - given.pulses_at(angle.frame))
    inside = _within_bounds(angle, orders)
    rows = angle.take(inside)
    first = turns(rows, orders)
    harmonics: Harmonics | None = None
    if sum(t.recording in train for t in first) >= 4:
        offset0 = fit_offset(rows.frame, rows.y, first, train)
        quiet = replace(rows, y=rows.y - wavering(rows.frame, offset0))
        harmonics = calibrated(quiet, orders, train, given)
    for step in range(2):
        periodic = harmonics.evaluate(angle.frame) if harmonics is not None else np.zeros(angle.y.size)
        slow, usable = slow_rows(angle, angle.y - periodic, inside)
        offset = analyse(TRANSMISSION_ERROR, slow, usable, fold_of, switched_off, known)
        if offset.chosen and (step == 1 or harmonics is None):
            offset = analyse(TRANSMISSION_ERROR, slow, usable, fold_of, switched_off, known, beside=_families(offset))
        if harmonics is None:
            break
        if step == 0:
            offset_only = replace(rows, y=rows.y - predict(offset, angle.frame)[inside])
            harmonics = searched(offset_only, orders, train, given)
            if harmonics.law is None and not harmonics.peaks and not offset.found:
                break
    return TransmissionModel(angle, inside, released(offset), harmonics, usable)


def _families(model: ChannelModel) -> list[Entry]:
    """The best point of every form of each effect chosen: what nature's form differs from ours in is no noise."""
    best: dict[tuple[str, str], tuple[float, Entry]] = {}
    for entry in model.chosen:
        others = [e for e in model.chosen if e != entry]
        for candidate in model.search.entries:
            if candidate.effect == entry.effect:
                gain = model.search.fit([*others, candidate]).total
                key = (candidate.effect, candidate.form)
                if key not in best or gain > best[key][0]:
                    best[key] = (gain, candidate)
    return [entry for _, entry in best.values()]


def _within_bounds(angle: Rows, orders: Sequence[float]) -> NDArray[np.bool_]:
    """Rows whose speed lies within that of the steady revolutions (all that move, where there is none)."""
    speed = np.abs(angle.frame.velocity)
    good = angle.number > 0
    driven = [abs(t.velocity) for t in turns(angle.take(good), orders)]
    if not driven:
        return np.asarray(good & (angle.frame.direction != 0))
    return np.asarray(good & (speed > SLOWEST_SPEED * min(driven)) & (speed < WIDEST_SPEED * max(driven)))
