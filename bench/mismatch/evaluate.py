"""Scores on held-out recordings: root mean square per sample before, after, and the noise floor."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.columns import is_integral
from bench.mismatch.harmonics import Harmonics
from bench.mismatch.linear import ChannelModel, dropped, predict, predict_named
from bench.mismatch.noise import quick_variance, robust_spread
from bench.mismatch.pulses import clusters
from bench.mismatch.rows import Rows
from bench.mismatch.transmission import TransmissionModel
from bench.simulation.frame import FloatArray, IntArray, recording_starts

FLOOR_METHOD = (
    "samples' scatter inside blocks and the blocks' scatter about the most flexible model, a class of motion each, "
    "with the offset between recordings; spikes left out"
)
FORGOTTEN_S = {False: 3.0, True: 6.0}
"""time after which noise has forgotten itself, for rows of a quarter of a second and for those of two seconds"""


@dataclass(frozen=True, slots=True)
class Scores:
    """Root mean squares of a channel per sample on the rows scored (held-out recordings, else all)."""

    before: float
    after: float
    floor: float
    rows: NDArray[np.bool_]
    residual_before: FloatArray
    residual_after: FloatArray
    offset: float = 0.0
    """variance of the offsets between recordings, part of the floor's square"""

    def stands_out(self, factor: float, recordings: IntArray) -> bool:
        """Whether the residual after is more than ``factor`` times the floor, and more than the offsets of so few
        recordings can make it by chance; ``recordings`` (n,) says which one each row is of.
        """
        share = np.bincount(recordings[self.rows]) / max(int(self.rows.sum()), 1)
        chance = 6.0 * np.sqrt(2.0 * np.sum(share**2)) * self.offset
        return bool(self.after**2 > factor**2 * self.floor**2 + chance)


def _per_sample(residual: FloatArray, number: FloatArray, within: FloatArray) -> float:
    inner = np.sum(within * np.maximum(number - 1.0, 0.0))
    return float(np.sqrt((np.sum(residual**2 * number) + inner) / max(float(number.sum()), 1.0)))


def linear(
    model: ChannelModel, usable: NDArray[np.bool_], held_out: set[int], ripple: float = 0.0, known: float = 0.0
) -> Scores:
    """Scores of a channel that is regressed on block rows; ``ripple`` is the variance found inside the blocks,
    ``known`` that which the given simulation has there.
    """
    rows = model.rows
    scored = usable & np.isin(rows.frame.recording, list(held_out)) & (rows.number > 0)
    if not scored.any():
        scored = usable & (rows.number > 0)
    before = rows.y - predict(model, rows.frame, whole=False)
    after = rows.y - predict(model, rows.frame, whole=True)
    if is_integral(model.channel):
        before, after = _own_start(before, model), _own_start(after, model)
    number, within = rows.number[scored], rows.within[scored]
    within = np.maximum(within - known, 0.1 * within)
    variance = model.fit.offset_variance
    offset = 0.0 if np.isinf(variance) else variance
    offset = min(offset, float(np.mean(within)))  # recordings that differ more than samples do are no noise
    block = float(np.median(model.noise.sigma**2 * rows.number[model.used]))
    quick = quick_variance(after, rows, usable, FORGOTTEN_S[is_integral(model.channel)])
    sigma = (block if np.isnan(quick) else min(block, quick)) / np.maximum(number, 1.0)
    floor = float(
        np.sqrt((np.sum((sigma + offset) * number) + np.sum(within * np.maximum(number - 1.0, 0.0))) / number.sum())
    )
    quiet = np.maximum(within - ripple, 0.1 * within)
    floor = float(np.sqrt(max(floor**2 - ripple, 0.1 * floor**2)))
    return Scores(
        _per_sample(before[scored], number, within),
        _per_sample(after[scored], number, quiet),
        floor,
        scored,
        before,
        after,
        offset,
    )


def _own_start(residual: FloatArray, model: ChannelModel) -> FloatArray:
    """A recording's temperature is predicted from where it begins: its own level is no error of the heat balance."""
    starts = recording_starts(model.rows.frame)
    number = model.rows.number
    out = residual.copy()
    for a, b in itertools.pairwise(starts):
        out[a:b] -= np.average(residual[a:b], weights=np.maximum(number[a:b], 1e-9))
    return out


def transmission(model: TransmissionModel, held_out: set[int]) -> Scores:
    """Scores of the transmission error on steady rows within the polynomials' bounds."""
    angle, scored = model.angle, _scored(model, held_out)
    own = angle.take(scored)
    before, after = np.zeros(angle.y.size), np.zeros(angle.y.size)
    before[scored], square_before, _ = _square(model, own, scored, whole=False)
    after[scored], square_after, inner = _square(model, own, scored, whole=True)
    white = [
        t.white for t in (model.harmonics.turns if model.harmonics else []) if t.recording in held_out or not held_out
    ]
    level = float(np.median(white)) if white else robust_spread(after[scored])
    variance = model.offset.fit.offset_variance
    offset = 0.0 if np.isinf(variance) else variance
    floor = float(np.sqrt(level**2 + inner + offset))
    return Scores(float(np.sqrt(square_before)), float(np.sqrt(square_after)), floor, scored, before, after, offset)


def _scored(model: TransmissionModel, held_out: set[int]) -> NDArray[np.bool_]:
    """Rows of the transmission error that are scored: steady and held out, as far as there are any."""
    angle = model.angle
    steady = model.inside & (angle.frame.steady > 0.5)
    held = steady & np.isin(angle.frame.recording, list(held_out))
    return held if held.any() else steady if steady.any() else model.inside


def _square(
    model: TransmissionModel, own: Rows, scored: NDArray[np.bool_], whole: bool
) -> tuple[FloatArray, float, float]:
    """Residual of the rows scored, its mean square per sample, and the part of that which lies inside the rows."""
    residual = own.y - model.predict(model.angle.frame, whole=whole, rows=scored)
    inner = _inner(own, model, whole) / float(own.number.sum())
    return residual, float(np.sum(residual**2 * own.number) / own.number.sum()) + inner, inner


def _inner(rows: Rows, model: TransmissionModel, whole: bool) -> float:
    """Sum of squares of the samples about their row's mean, less what the harmonics' slope over the angle says."""
    squares = rows.within * np.maximum(rows.number - 1.0, 0.0)
    if model.harmonics is None or not rows.lean.size:
        return float(squares.sum())
    slope = model.harmonics.slope(rows.frame, whole)
    return float(np.sum(np.maximum(squares - rows.number * (2.0 * slope * rows.lean - slope**2 * rows.sweep), 0.0)))


LEAST_HELD_OUT = 0.0008
"""of the floor's square: what a finding has to take off the held-out residual, per sample"""
LEAST_UNKNOWN = 0.02
"""the same for structure without a name: a free function finds something in any noise"""
CERTAIN = 500.0
"""log-likelihood on training recordings left out that no free function gains in noise: it may act in few samples"""
HARM = 0.01
"""of the floor's square: what a finding beyond doubt may cost held-out recordings in which it does not act"""
BEYOND_DOUBT = 50.0
"""log-likelihood on training recordings left out from which a finding stands that no held-out recording shows"""


ACTS = 0.25
"""of its mean square in the training rows: where a finding changes held-out ones as much, it has to show there"""
REFUTED = 2.5
"""standard errors between recordings by which a finding may miss the squares it should take off"""


def _mean_square(values: FloatArray, rows: NDArray[np.bool_], number: FloatArray) -> float:
    return float(np.sum(values[rows] ** 2 * number[rows]) / max(float(number[rows].sum()), 1.0))


def _standard_errors(values: FloatArray, recording: IntArray) -> float:
    """Mean of a quantity over its standard error, the recordings being the units."""
    total = np.bincount(recording, values)[np.unique(recording)]
    if total.size < 3:
        return 0.0
    return float(np.mean(total) / max(np.std(total, ddof=1) / np.sqrt(total.size), 1e-300))


def gate(model: ChannelModel, usable: NDArray[np.bool_], held_out: set[int]) -> dict[str, tuple[float, float]]:
    """Drop findings that do not improve recordings which selected nothing; RMS without and with each that stays.

    A finding that acts in no held-out recording (a single reversal, say) can neither be confirmed nor refuted there:
    it stands when the training recordings left out leave no doubt.
    """
    rows = model.rows
    scored = usable & np.isin(rows.frame.recording, list(held_out)) & (rows.number > 0)
    out: dict[str, tuple[float, float]] = {}
    if not scored.any():
        return out
    number = rows.number[scored]
    inner = float(np.sum(rows.within[scored] * np.maximum(number - 1.0, 0.0)))
    noise = (float(np.sum(number * np.median(model.noise.sigma**2))) + inner) / number.sum()

    def squares(values: FloatArray) -> FloatArray:
        left = rows.y - values
        return (_own_start(left, model) if is_integral(model.channel) else left)[scored] ** 2 * number

    for found in sorted(model.found, key=lambda f: f.gain):
        whole, without = predict_named(model, rows.frame), predict_named(model, rows.frame, found.entry)
        full, rest = squares(whole), squares(without)
        added = whole - without
        acts = _mean_square(added, scored, rows.number) > ACTS * _mean_square(added, model.used, rows.number)
        promised = added[scored] ** 2 * number - (rest - full)
        refuted = acts and _standard_errors(promised, rows.frame.recording[scored]) > REFUTED
        change = (rest.sum() - full.sum()) / number.sum()
        by_recording = np.bincount(rows.frame.recording[scored], rest - full)
        touched = by_recording[np.abs(by_recording) > 0.05 * np.abs(by_recording).max()]
        better = bool(np.mean(touched > 0) >= 0.5) if touched.size else False
        named = found.entry.effect != "unknown"
        silent = named and change > -HARM * noise and not refuted and found.gain > BEYOND_DOUBT
        least = LEAST_HELD_OUT if named or found.gain > CERTAIN else LEAST_UNKNOWN
        if silent or (change > least * noise and better):
            level = (inner + float(full.sum())) / number.sum()
            out[found.entry.effect] = (float(np.sqrt(max(level + change, 0.0))), float(np.sqrt(level)))
        else:
            dropped(model, found.entry)
    return out


def gate_harmonics(model: TransmissionModel, held_out: set[int]) -> None:
    """Take the law of the amplitudes, then the peaks, back where they do not improve held-out revolutions."""
    harmonics = model.harmonics
    if harmonics is None:
        return

    scores = transmission(model, held_out)
    whole, floor = scores.after**2, scores.floor**2
    own = model.angle.take(scores.rows)

    def better(other: Harmonics, least: float) -> bool:
        """Whether the held-out residual grows by less than ``least`` with less; the smaller model is then kept."""
        nonlocal whole
        model.harmonics = other
        _, square, _ = _square(model, own, scores.rows, whole=True)
        if square - whole > least * floor:
            model.harmonics = harmonics
            return False
        whole = square
        return True

    if harmonics.law is not None and better(harmonics.without_law(), LEAST_UNKNOWN):
        harmonics = harmonics.without_law()
    groups = [[p] for p in harmonics.peaks if p.kind != "pulse"]
    groups += clusters([p for p in harmonics.peaks if p.kind == "pulse"])
    for group in sorted(groups, key=lambda peaks: sum(p.gain for p in peaks)):
        if better(harmonics.without(group), LEAST_HELD_OUT):
            harmonics = harmonics.without(group)
