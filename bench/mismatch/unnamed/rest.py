"""What is left is more than noise, and nothing recorded predicts it: that is told, too."""

from __future__ import annotations

from dataclasses import replace
from itertools import compress

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import UNKNOWN, UNNAMED, ChannelOutcome, Discovery
from bench.mismatch.regression import windows
from bench.mismatch.regression.candidates import PERIODIC
from bench.mismatch.regression.problem import CHANNELS
from bench.mismatch.regression.strength import active
from bench.mismatch.report.figures import strength
from bench.simulation.frame import FloatArray
from bench.simulation.terms import CHANNEL_UNITS, LIBRARY, TRANSMISSION_ERROR

LINES = frozenset(PERIODIC) - {"te.resonance"}
"""effects with lines or places of their own in the angle; a resonance is a law of all of them"""
ORDERS = "te.harmonic"
"""orders have no form that could leave something of nature's"""
LOOKED_AT_S = 1.0
"""over which what is left is averaged before it is asked where it lies: ten correlation times of a sensor's noise"""


def unexplained(outcome: ChannelOutcome) -> None:
    """Add what an outcome leaves as a discovery without a name, where it is clearly more than the noise floor.

    That is asked of the median recording. Where the test for structure says that what is left of the fitted recordings
    is no noise, and it is more than what the forms of the findings may leave of nature's, recordings held out are a
    second witness: all are asked together, a few far off among them. Where nothing was found, more than the floor
    within its uncertainty is then enough (not of an integral). Of an integral in which nothing was found the fitted
    recordings are asked as well: those held out may hold no warm-up that shows it. Levels of held-out recordings that
    differ no more than those of the fitted ones are offsets between recordings.

    What comes and goes in the transmission error leaves the median recording as it is. There all steady samples are
    asked as well, beyond what the forms of the findings may leave; levels are no offsets where blocks of time are too
    loud for noise; and where a tone is heard in some recordings, half of the energy is enough. Torques waver with the
    control loops in some recordings more than in others: of them this says nothing.
    """
    p = None if outcome.structure is None else outcome.structure.p_value
    after, every = outcome.settled, outcome.rmse.get("after")
    much = _much(outcome, every)
    if _rare(p) or much:
        # blocks that scatter are what is left themselves: beside them is noise, unless its amount says otherwise
        outcome.discoveries = [_whole(d, outcome) if d.simulation_rows or much else d for d in outcome.discoveries]
    if any(d.effect == UNNAMED for d in outcome.discoveries):
        if every is not None and much:
            _with_the_small(outcome, every)
        return
    if after is None or outcome.floor_std is None:
        return
    usual, levels, integral = criteria.MORE_THAN_NOISE, outcome.of_levels, CHANNELS[outcome.channel].integral
    if integral:  # its floor has no noise slower than the blocks, which may be as much again
        usual = float(np.hypot(usual, 1.0))
    if _rare(p) and every is not None and every**2 > outcome.floor**2 + _of_forms(outcome):
        after = max(after, every)
        # an integral's floor knows nothing of slow noise that adds up in what is integrated
        usual, levels = usual if integral or outcome.discoveries else 1.0, 0.0
    if integral and _rare(p) and not outcome.discoveries:
        after = max(after, _of_all(outcome))
    most = usual * outcome.floor + criteria.FLOOR_ERRORS * outcome.floor_std
    if outcome.channel == TRANSMISSION_ERROR and outcome.altogether is not None:
        after, most, levels = _coming_and_going(outcome, after, most, levels)
    # at states that the calibration hardly knows, it may be off by what it says itself
    if after**2 < most**2 + levels + criteria.FLOOR_ERRORS**2 * outcome.doubt:
        return
    left = np.where(outcome.usable, outcome.left, 0.0)
    size = float(np.sqrt(after**2 - outcome.floor**2))
    std = float(outcome.floor * outcome.floor_std / size)
    part = _taken_out(outcome, size)
    left = left + np.where(outcome.usable, sum((d.added for d in part), np.zeros(left.size)), 0.0)
    outcome.discoveries.append(
        Discovery(
            UNNAMED,
            UNKNOWN,
            None,
            outcome.channel,
            "what is left, more than noise, that nothing recorded predicts",
            f"{outcome.channel} += what no function of the recorded quantities follows, rms: its root mean square",
            ("speed", "torque", "temperature"),
            ({"symbol": "rms", "value": size, "unit": CHANNEL_UNITS[outcome.channel], "std": std},),
            left,
            0.0,
            None,
            tuple(row for d in part for row in d.simulation_rows),
            excess=averaged(left, outcome),
            squares=(after**2, after**2),
            orders=_orders(outcome, left),
        )
    )


def _of_all(outcome: ChannelOutcome) -> float:
    """What is left of all recordings of an integral, per sample: its floor, and what rows of many samples leave."""
    number = np.where(outcome.usable, outcome.rows.number, 0.0)
    rows = float(np.average(outcome.left**2, weights=number)) if number.any() else 0.0
    return float(np.sqrt(outcome.floor**2 + rows))


def _of_forms(outcome: ChannelOutcome) -> float:
    """Mean square of what the forms of an outcome's findings may leave of nature's; orders have none."""
    energy = sum(strength(d, outcome) for d in outcome.discoveries if d.effect != ORDERS)
    return float(criteria.SHAPE**2 * energy * outcome.floor**2)


def _coming_and_going(outcome: ChannelOutcome, after: float, most: float, levels: float) -> tuple[float, float, float]:
    """What is left of the transmission error, how much of it noise may be, and the variance of levels, where what comes
    and goes is asked as well.
    """
    assert outcome.altogether is not None
    # by as much as nature's forms may be other than the names say, more is left where the names act
    after = max(after, float(np.sqrt(max(outcome.altogether**2 - _of_forms(outcome), 0.0))))
    structure, usual = outcome.structure, criteria.MORE_THAN_NOISE
    if structure is not None and _rare(structure.bursts):
        most, levels = min(most, usual * outcome.floor), 0.0
    if structure is not None and _rare(structure.tone) and not outcome.discoveries:
        half = float(np.sqrt(1.0 + criteria.EITHER * (usual**2 - 1.0)))
        most, levels = min(most, half * outcome.floor), 0.0
    return after, most, levels


def _rare(p_value: float | None) -> bool:
    """Whether a chance is less than what is taken for noise in a channel."""
    return p_value is not None and p_value < criteria.ERROR_RATE_OF_A_CHANNEL


def _whole(discovery: Discovery, outcome: ChannelOutcome) -> Discovery:
    """A function without a name with what is left beside it, which is no noise: it follows a part of something that
    lies where both do.
    """
    if discovery.effect != UNNAMED or not np.any(discovery.added):
        return discovery
    left = averaged(np.where(outcome.usable, outcome.left, 0.0), outcome)
    everywhere = None if discovery.everywhere is None else np.hypot(discovery.everywhere, left)
    return replace(discovery, excess=np.hypot(discovery.beyond, left), everywhere=everywhere)


def _orders(outcome: ChannelOutcome, left: FloatArray) -> tuple[float, ...]:
    """Orders of the output shaft that what is left (n,) of the transmission error is made of, where it is: that hold
    nine tenths of it, or that scatter from one revolution to another by most of it.
    """
    if outcome.channel != TRANSMISSION_ERROR:
        return ()
    frame, number = outcome.rows.frame, np.where(outcome.usable, outcome.rows.number, 0.0)
    whole = windows.orders_of_each(frame.theta, left, number, frame.recording)
    orders, square = outcome.scattering
    if whole or not number.any():
        return whole
    # the noise of a row is that of a sample over the samples in it
    beyond = float(number @ left**2 - outcome.floor**2 * np.count_nonzero(number)) / float(number.sum())
    return orders if square > criteria.EITHER * beyond > 0.0 else ()


def _much(outcome: ChannelOutcome, after: float | None) -> bool:
    """Whether more than noise is left, ``after`` of the recordings held out, by its amount alone.

    Of an integral the floor says too little: slow noise adds up in it.
    """
    if after is None or outcome.floor_std is None or CHANNELS[outcome.channel].integral:
        return False
    return after > criteria.MORE_THAN_NOISE * outcome.floor


def _with_the_small(outcome: ChannelOutcome, after: float) -> None:
    """Where something without a name was found and more than noise is left all the same, put the names that are smaller
    than that with it. ``after``: what is left of the recordings held out.
    """
    part = _taken_out(outcome, float(np.sqrt(after**2 - outcome.floor**2)))
    number = next(k for k, d in enumerate(outcome.discoveries) if d.effect == UNNAMED)
    whole = outcome.discoveries[number]
    rows = (*whole.simulation_rows, *(row for d in part for row in d.simulation_rows))
    added = sum((d.added for d in part), whole.added)
    outcome.discoveries[number] = replace(whole, simulation_rows=rows, added=added)


def _taken_out(outcome: ChannelOutcome, left: float) -> list[Discovery]:
    """Take the names out of an outcome that are smaller than what is ``left`` (rms per sample) without an explanation,
    with a note each.
    """
    dwarfed = [_dwarfed(d, outcome, left) for d in outcome.discoveries]
    part = list(compress(outcome.discoveries, dwarfed))
    outcome.discoveries = [d for d, small in zip(outcome.discoveries, dwarfed, strict=True) if not small]
    outcome.notes += [
        f"{d.words} gained in likelihood, but is smaller than what is left without an explanation: a part of that"
        for d in part
    ]
    return part


def _dwarfed(discovery: Discovery, outcome: ChannelOutcome, left: float) -> bool:
    """Whether a name is smaller than what is ``left`` (rms per sample, the channel's unit) without an explanation.

    Its gain is then as likely a part of that, unless that depends on other quantities. Orders and pulses are told by
    lines and places of their own, which structure elsewhere does not touch.
    """
    term = LIBRARY.get(discovery.effect)
    if term is None or term.nominal or discovery.effect in LINES or discovery.independent:
        return False
    return bool(np.sqrt(strength(discovery, outcome)) * outcome.floor < left) and not _above_it(discovery, outcome)


def _above_it(discovery: Discovery, outcome: ChannelOutcome) -> bool:
    """Whether a name stands above what is left without an explanation where it acts: friction after reversals is large
    there, however little it is over all samples.

    What counts of it is what the recalibrated simulation does not have: friction that a reversal builds up is Coulomb
    friction everywhere else.
    """
    number = np.where(outcome.usable, outcome.rows.number, 0.0)
    acts = active(discovery.beyond, number)
    explained, left = (float(number[acts] @ values[acts] ** 2) for values in (discovery.beyond, outcome.left))
    return explained > criteria.OVER_THE_REST**2 * left


def averaged(left: FloatArray, outcome: ChannelOutcome) -> FloatArray:
    """What is left (n,) over :data:`LOOKED_AT_S` of each recording: its place is where that is large, and the noise of
    single rows, of which a long recording has most, says nothing of a place.

    It is the mean, but of the transmission error the root mean square less the noise: a wave over the angle has no mean
    where the gearbox turns fast.
    """
    frame, number = outcome.rows.frame, np.where(outcome.usable, outcome.rows.number, 0.0)
    block = np.floor(frame.elapsed / LOOKED_AT_S).astype(np.int64)
    first = np.append(True, (np.diff(block) != 0) | (np.diff(frame.recording) != 0))
    which = np.cumsum(first) - 1
    samples = np.maximum(np.bincount(which, number), 1e-300)
    if outcome.channel == TRANSMISSION_ERROR:
        beyond = np.bincount(which, number * left**2 - np.where(number > 0, outcome.floor**2, 0.0))
        return np.asarray(np.sqrt(np.maximum(beyond, 0.0) / samples)[which])
    return np.asarray((np.bincount(which, number * left) / samples)[which])
