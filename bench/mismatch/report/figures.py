"""Figures of the report that are mean squares: of what is left with a discovery, without it, with an alternative in its
place.

All are per sample: a row of ``number`` samples counts so often, and what samples scatter inside a row stands in the
channel's own root mean square, from the simulation file, to which differences of rows are added.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.mismatch import criteria
from bench.mismatch.discovery import ChannelOutcome, Discovery, RefittedAlternative
from bench.mismatch.recordings.rows import error_of_mean, hardly_acts
from bench.simulation.frame import FloatArray

SMALLEST = 1e-300
"""below which a sum of squares counts as none"""


@dataclass(frozen=True, slots=True)
class Scored:
    """The rows that figures are of: ``held_out`` ones, or, where none could be held out, all that are compared.

    ``after``: root mean square per sample there, None where it was not computed.
    """

    rows: NDArray[np.bool_]
    held_out: bool
    after: float | None

    @classmethod
    def of(cls, outcome: ChannelOutcome) -> Scored:
        """Rows of a channel that are scored."""
        if bool(np.any(outcome.held_out)):
            return cls(outcome.held_out, True, finite(outcome.rmse.get("after")))
        return cls(outcome.usable, False, finite(outcome.in_sample.get("after")))


def finite(value: float | None) -> float | None:
    """The number as a report has it: None where there is none, or it is not finite."""
    return None if value is None or not np.isfinite(value) else float(value)


def mean(values: FloatArray, outcome: ChannelOutcome, rows: NDArray[np.bool_]) -> float | None:
    """Mean per sample of ``values`` (n,) over some rows of a channel; None where these hold no sample."""
    number = np.where(rows, outcome.rows.number, 0.0)
    total = float(number.sum())
    return finite(float(np.sum(np.where(number > 0, values, 0.0) * number)) / total) if total > 0 else None


def gained(discovery: Discovery, outcome: ChannelOutcome) -> float | None:
    """Mean square per scored sample that a discovery takes off, in squares of the channel's unit."""
    if discovery.squares is not None:
        return finite(discovery.squares[0] - discovery.squares[1])
    left = outcome.left
    return mean((left + discovery.added) ** 2 - left**2, outcome, Scored.of(outcome).rows)


def against(discovery: Discovery, outcome: ChannelOutcome) -> bool:
    """Whether recordings held out are predicted better without a discovery than with it, by more than the standard
    error of that (one recording to another). They say nothing of what adds less than half to them of what it adds to
    the fitted ones.
    """
    scored, more = Scored.of(outcome), gained(discovery, outcome)
    if not scored.held_out or more is None or more >= 0.0:
        return False
    if hardly_acts(discovery.added, outcome.rows.number, scored.rows, outcome.usable & ~scored.rows):
        return False
    error = _of_recordings((outcome.left + discovery.added) ** 2 - outcome.left**2, outcome, scored.rows)
    return error is None or -more > criteria.ONE_ERROR * error


def without(discovery: Discovery, outcome: ChannelOutcome) -> float | None:
    """Root mean square per scored sample of the final model without a discovery, refitted."""
    return _root(Scored.of(outcome).after, gained(discovery, outcome))


def with_alternative(alternative: RefittedAlternative, outcome: ChannelOutcome) -> float | None:
    """Root mean square per scored sample with another explanation in a discovery's place."""
    if alternative.left is None:
        return None
    scored = Scored.of(outcome)
    return _root(scored.after, mean(alternative.left**2 - outcome.left**2, outcome, scored.rows))


def share_of_excess(discovery: Discovery, outcome: ChannelOutcome) -> float | None:
    """Part of the held-out residual energy above the noise floor that a discovery explains.

    The floor is no more than what is left with all that was found: a part of what was there is at most one. None where
    nothing was held out, or what is left without it is no more than the floor.
    """
    scored, more = Scored.of(outcome), gained(discovery, outcome)
    if not scored.held_out or scored.after is None or more is None:
        return None
    excess = scored.after**2 + more - min(outcome.floor, scored.after) ** 2
    return finite(more / excess) if excess > 0.0 else None


def square_error(outcome: ChannelOutcome) -> float | None:
    """Standard error of the mean square that is left, from how it differs from one scored recording to another.

    In squares of the channel's unit; None where fewer than two recordings are scored.
    """
    return _of_recordings(outcome.left**2, outcome, Scored.of(outcome).rows)


def _of_recordings(values: FloatArray, outcome: ChannelOutcome, chosen: NDArray[np.bool_]) -> float | None:
    """Standard error of the mean per sample of ``values`` (n,) over some rows, recordings taken as drawn; None where
    they are fewer than two.
    """
    rows = chosen & (outcome.rows.number > 0)
    return finite(error_of_mean(values[rows], outcome.rows.frame.recording[rows], outcome.rows.number[rows]))


def energy(discovery: Discovery, outcome: ChannelOutcome) -> FloatArray:
    """Energy (n,) of what a discovery adds beyond the recalibrated simulation; 0 where a row is not compared."""
    usable = outcome.usable & (outcome.rows.number > 0)
    return np.asarray(np.where(usable, discovery.beyond**2 * outcome.rows.number, 0.0))


def strength(discovery: Discovery, outcome: ChannelOutcome) -> float:
    """Mean square of what a discovery adds to a sample, over the square of the channel's noise floor."""
    if discovery.squares is not None:
        size = max(discovery.squares[0] - discovery.squares[1], 0.0)
    else:
        number = float(outcome.rows.number[outcome.usable].sum())
        size = float(energy(discovery, outcome).sum()) / max(number, 1.0)
    return size / max(outcome.floor**2, SMALLEST)


def _root(after: float | None, more: float | None) -> float | None:
    if after is None or more is None or after**2 + more < 0.0:
        return None
    return float(np.sqrt(after**2 + more))
