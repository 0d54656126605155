"""Is what is left noise? Looks at its mean, its variance over time and over the states, its spectrum, its levels.

The mean is asked of everything recorded at once: every term and every free function of one and two quantities is tried
on the final model's residual, and the best gain compared with the best that noise gives the same bank (signs of blocks
drawn at random). The variance is asked for loud blocks, for states that scatter more than others, and for tones; what
is left may jump between two levels.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.stats import norm

from bench.mismatch import criteria
from bench.mismatch.discovery import BURSTS, TONE, UNKNOWN, UNNAMED, ChannelOutcome, Discovery, Look, Structure
from bench.mismatch.recordings.rows import settled_rows
from bench.mismatch.recordings.vibration import Density, Run
from bench.mismatch.regression.candidates import PATH, PERIODIC
from bench.mismatch.regression.maxima import tail_probability
from bench.mismatch.regression.model import explained, of_start, unrefined
from bench.mismatch.regression.pruning import shuffled
from bench.mismatch.regression.scan import Scan
from bench.mismatch.regression.state import Search
from bench.mismatch.regression.strength import added
from bench.mismatch.unnamed.bursts import Bursts, bursts
from bench.mismatch.unnamed.ring_down import RingDown, Ringing
from bench.mismatch.unnamed.scatter import UNITS, Scatter, scatter
from bench.mismatch.unnamed.steps import Steps, steps
from bench.mismatch.unnamed.telegraph import Telegraph, telegraph
from bench.mismatch.unnamed.tone_frequency import MOST_RECORDINGS, frequency_of
from bench.mismatch.unnamed.tones import Tone, tone
from bench.simulation.frame import FloatArray, Frame, IntArray
from bench.simulation.terms import CHANNEL_UNITS, MOTOR_TORQUE, TRANSMISSION_ERROR

COMES_AND_GOES = "scatter that comes and goes"
MORE_SURROGATES = 9
"""times as many surrogates as at first where a chance is rare: a rate of 0.25 % over five looks is then counted"""
SURELY = 1e-6
"""chance by a law through the first surrogates, below which their number does not matter"""


def examine(
    outcome: ChannelOutcome,
    search: Search,
    densities: Sequence[Density],
    seed: int = 0,
    rings: RingDown | None = None,
) -> None:
    """Test what an outcome leaves, and add what the tests find to it, but for a tone (:func:`look_for_tone`).
    ``rings``: what was seen to ring after the load torque has crossed zero.
    """
    ringing = None if rings is None else rings.ringing
    if ringing is not None and ringing.size[0] < np.sqrt(2.0) * criteria.LEAST_STRENGTH * outcome.floor:
        ringing = None
    if rings is not None and ringing is not None:
        outcome.discoveries.append(_of_ring_down(ringing, rings.p_value, outcome))
    least = criteria.LEAST_STRENGTH * outcome.floor
    loud = bursts(search, None if ringing is None else ringing.on_rows(search.model.problem.rows.frame) > least)
    counts = loud is not None and _counts(loud, outcome, search)
    if loud is not None and counts and loud.p_value < criteria.ERROR_RATE_OF_A_LOOK:
        found = _of_bursts(loud, outcome, search)
        if found is not None:
            outcome.discoveries.append(found)
    louder = _scatter(search, densities, seed)
    bursting = any(d.words == COMES_AND_GOES for d in outcome.discoveries)
    if louder is not None and not bursting and louder.p_value < criteria.ERROR_RATE_OF_A_LOOK:
        outcome.discoveries.append(_of_scatter(louder, outcome))
    jumps = None if bursting else telegraph(search)
    jumping = jumps is not None and _rms(jumps.course) > criteria.LEAST_STRENGTH * outcome.floor
    if jumps is not None and jumping and jumps.p_value < criteria.ERROR_RATE_OF_A_LOOK:
        outcome.discoveries.append(_of_telegraph(jumps, outcome, search.model.problem.rows.frame))
    stepping = None if bursting or jumps is not None else steps(search, seed)
    stepped = stepping is not None and _rms(stepping.course) > criteria.LEAST_STRENGTH * outcome.floor
    if stepping is not None and stepped and stepping.p_value < criteria.ERROR_RATE_OF_A_LOOK:
        outcome.discoveries.append(_of_steps(stepping, outcome, search.model.problem.rows.frame))
    best, what, size = _mean(search)
    words = (
        f"chance that noise, with structure too small to report ({criteria.LEAST_OVERALL:g} of the noise over all, "
        f"{criteria.LEAST_STRENGTH:g} where it acts), gains as much in the best of "
        f"{len(search.blocks)} functions of everything recorded ({what}, {size:.2f} of the noise)"
    )
    looks = {"mean": Look(words, best, best)}
    if loud is not None:
        p = loud.p_value
        looks[BURSTS] = Look(f"loudest of the blocks in time (p {p:.2g})", p, p if counts else 1.0)
    if rings is not None:
        p = rings.p_value
        looks["rings"] = Look(
            f"ringing after the load torque changes its sign (p {p:.2g})", p, p if ringing or not rings.ringing else 1.0
        )
    if louder is not None:
        p = louder.p_value
        looks["scatter"] = Look(f"state that scatters most (p {p:.2g})", p, p)
    if jumps is not None:
        p = jumps.p_value
        looks["levels"] = Look(f"two levels with jumps between them (p {p:.2g})", p, p if jumping else 1.0)
    if stepping is not None:
        p = stepping.p_value
        looks["steps"] = Look(f"largest step up or down (p {p:.2g})", p, p if stepped else 1.0)
    outcome.structure = Structure.of(looks)


def look_for_tone(
    outcome: ChannelOutcome,
    densities: Sequence[Density],
    seed: int = 0,
    orders: Sequence[float] = (),
    unsteady: Sequence[Density] = (),
    *,
    felt: Sequence[float] | None = None,
    runs: Callable[[Sequence[int]], Sequence[Run]] = lambda _: (),
) -> Tone | None:
    """Ask an outcome that was examined for a tone, and add it; the tone, if there is one. ``orders`` that the channel
    feels are no tones: where recordings share their speeds an order is as much one. ``felt``: how much of each a torque
    feels. Recordings that are ``unsteady`` have a tone as well. ``runs`` of some recordings, by their numbers, in which
    its phase is followed.
    """
    assert outcome.structure is not None
    found = tone(densities, seed, orders, unsteady, felt=felt)
    if found is None:
        return None
    counts = matters(found, outcome.floor)
    told = counts and found.p_value < criteria.ERROR_RATE_OF_A_LOOK
    if told:
        sharper = frequency_of(runs(found.heard[:MOST_RECORDINGS]), found.frequency)
        if sharper is not None:
            found = replace(found, frequency=sharper.value, frequency_std=sharper.std)
        outcome.discoveries.append(_of_tone(found, outcome))
    look = Look(f"clearest tone (p {found.p_value:.2g})", found.p_value, found.p_value if counts else 1.0)
    outcome.structure = Structure.of({**outcome.structure.looks, TONE: look})
    return found if told else None


def _mean(search: Search) -> tuple[float, str, float]:
    """Chance of the best remaining gain, what it is of, and its size over a sample's noise.

    The chance is the larger one of noise that is alike for a block and of noise that is alike for a recording. Of the
    gain only what an effect of the least size that is told would not have counts: a gain grows with the square
    of the size.
    """
    model = search.model
    looks = shuffled(search, model.chosen)
    seen = looks[0]
    order = int(np.argmax(seen.gain))
    block = search.blocks[order]
    size = added(search.model, unrefined(search.bank, block))
    acts = max(criteria.LEAST_STRENGTH, size.trusted)
    least = max(criteria.LEAST_OVERALL / max(size.overall, 1e-300), acts / max(size.acts, 1e-300))
    beyond = 1.0 - min(1.0, least) ** 2
    gain = float(seen.gain[order]) * beyond if np.isfinite(seen.gain[order]) else 0.0
    return _chance(search, looks, gain), block.regressor.words, size.overall


def _chance(search: Search, looks: Sequence[Scan], gain: float) -> float:
    """Chance of a gain in noise: the larger one of noise that is alike for a block and of noise that is alike for a
    recording. Where a law through the first surrogates makes it rare, and not by far, more are drawn: what decides
    is then counted.
    """
    if not all(np.isfinite(look.surrogate).all() for look in looks):  # no candidate has anything beside the model
        return 1.0
    drawn = [[look.surrogate] for look in looks]
    rare = max(tail_probability(values[0], gain, 0.0) for values in drawn)
    if SURELY < rare < criteria.ERROR_RATE_OF_A_CHANNEL:
        for seed in np.random.default_rng([search.seed, 2]).integers(1 << 31, size=MORE_SURROGATES):
            further = shuffled(replace(search, seed=int(seed)), search.model.chosen)
            for values, look in zip(drawn, further, strict=True):
                values.append(look.surrogate)
    return max(tail_probability(np.concatenate(values), gain) for values in drawn)


def _counts(loud: Bursts, outcome: ChannelOutcome, search: Search) -> bool:
    """Whether loud blocks hold more than the least that is told of anything, and more than what nature's forms of the
    names that act there may differ by from the library's.

    What is above the noise of a sample is seen one by one, so that the mean over all samples is no measure: the least
    strength in the least share of samples that counts as where an effect acts is enough.
    """
    if not loud.rows.size:
        return False
    rows = search.model.problem.rows
    left = rows.y - of_start(search.model.problem, explained(search.model))
    number = rows.number[loud.rows]
    overall = float(np.sqrt(np.sum(left[loud.rows] ** 2 * number) / rows.number[search.model.problem.train].sum()))
    size = float(np.sqrt(np.mean(left[loud.rows] ** 2)))
    if size < _missed_by_names(outcome, rows.frame.take(loud.rows)):
        return False
    alone = size > outcome.floor
    least = criteria.LEAST_STRENGTH * np.sqrt(criteria.LEAST_ACTIVE) if alone else criteria.LEAST_OVERALL
    return bool(overall > least * outcome.floor)


def _missed_by_names(outcome: ChannelOutcome, loud: Frame) -> float:
    """Root mean square of what the names of a channel may miss at the rows of ``loud`` blocks: of what they add there
    beyond the calibrated simulation as much as nature's form may differ by, and all of a loop, which may be off by
    itself until it is turned, for nothing tells what it is like where a recording begins. What is periodic in the angle
    is in no block of the transmission error's offset.
    """
    at = _nearest(outcome.rows.frame, loud)
    absent = PERIODIC if outcome.channel == TRANSMISSION_ERROR else ()
    named = [d for d in outcome.discoveries if d.status != UNKNOWN and d.effect not in absent]
    shares = [1.0 if PATH in d.variables else criteria.SHAPE for d in named]
    missed = [share * d.beyond[at] for share, d in zip(shares, named, strict=True)]
    return float(np.sqrt(sum(np.mean(values**2) for values in missed)))


def _nearest(frame: Frame, rows: Frame) -> IntArray:
    """Row of a ``frame`` of the same recordings that is nearest in time to each of some ``rows`` (n,)."""
    # further apart than two rows of one recording, so that the next recording is never nearer
    apart = 2.0 * (1.0 + float(max(frame.elapsed.max(initial=0.0), rows.elapsed.max(initial=0.0))))
    times, wanted = (apart * of.recording + of.elapsed for of in (frame, rows))
    after = np.minimum(np.searchsorted(times, wanted), times.size - 1)
    before = np.maximum(after - 1, 0)
    return np.asarray(np.where(wanted - times[before] <= times[after] - wanted, before, after), dtype=np.int64)


def _as_compared(values: FloatArray, frame: Frame, outcome: ChannelOutcome) -> FloatArray:
    """Values of the rows of a ``frame`` at those in which a channel is compared: where these are others, of the nearest
    row in time.
    """
    return values if values.size == outcome.rows.size else values[_nearest(frame, outcome.rows.frame)]


def matters(found: Tone, floor: float) -> bool:
    """Whether a tone is as strong as what is told of anything, over the noise ``floor`` of a sample, and its amplitude
    differs from zero as the recordings differ: one that they do not share is the leakage of something else.
    """
    sure = found.amplitude > norm.isf(criteria.ERROR_RATE_OF_A_CHANNEL) * found.amplitude_std
    return bool(sure and found.amplitude / np.sqrt(2.0) > criteria.LEAST_STRENGTH * floor)


def _of_tone(found: Tone, outcome: ChannelOutcome) -> Discovery:
    unit = CHANNEL_UNITS[outcome.channel]
    # a tone has a phase of its own in every recording: nothing predicts it
    return Discovery(
        UNNAMED,
        UNKNOWN,
        1.0 - found.p_value,
        outcome.channel,
        f"a tone of {found.frequency:.3g} Hz, {'whatever the speed' if found.everywhere else 'in some recordings'}",
        f"{outcome.channel} += a*sin(2*pi*f*t + phase of each recording)",
        ("time",) if found.everywhere else ("speed", "torque", "temperature"),
        (
            {"symbol": "f", "value": found.frequency, "unit": "Hz", "std": found.frequency_std},
            {"symbol": "a", "value": found.amplitude, "unit": unit, "std": found.amplitude_std},
        ),
        np.zeros(outcome.rows.size),
        0.0,
        found.p_value,
        (),
        excess=_of_recordings(found, outcome),
        squares=_unchanged(outcome),
    )


def _of_ring_down(found: Ringing, p_value: float, outcome: ChannelOutcome) -> Discovery:
    """Ringing as a finding without a name: its phase is each crossing's own, nothing predicts it."""
    symbols = (
        ("f", *found.frequency, "Hz"),
        ("T", *found.decay, "s"),
        ("a", *found.size, CHANNEL_UNITS[outcome.channel]),
    )
    return Discovery(
        UNNAMED,
        UNKNOWN,
        1.0 - p_value,
        outcome.channel,
        f"ringing of {found.frequency[0]:.3g} Hz that fades after the load torque changes its sign",
        f"{outcome.channel} += a*exp(-t/T)*sin(2*pi*f*t + phase of each), t: since the load torque changed its sign",
        ("torque",),
        tuple({"symbol": s, "value": value, "unit": unit, "std": std} for s, value, std, unit in symbols),
        np.zeros(outcome.rows.size),
        0.0,
        p_value,
        (),
        excess=found.on_rows(outcome.rows.frame),
        squares=_unchanged(outcome),
    )


def _rms(course: FloatArray) -> float:
    """Root mean square of a course (n,) about its mean, where it was seen."""
    seen = course[course != 0.0]
    return float(np.sqrt(np.mean(seen**2))) if seen.size else 0.0


def _of_telegraph(jumps: Telegraph, outcome: ChannelOutcome, frame: Frame) -> Discovery:
    """Jumps between two levels at random; ``frame``: of the rows in which they were found."""
    unit = CHANNEL_UNITS[outcome.channel]
    by = "" if jumps.times == "1" else f"*{jumps.times}"
    described = (
        "jumps between two levels at random",
        f"{outcome.channel} += h*s(t){by}, s = 0 for T_0 and 1 for T_1 in the mean",
    )
    stays = (
        {"symbol": n, "value": v, "unit": "s", "std": None} for n, v in zip(("T_0", "T_1"), jumps.stays, strict=True)
    )
    parameters = ({"symbol": "h", "value": jumps.height, "unit": unit, "std": None}, *stays)
    return _at_random(jumps, described, parameters, outcome, frame)


def _of_steps(found: Steps, outcome: ChannelOutcome, frame: Frame) -> Discovery:
    """Steps up and down at random; ``frame``: of the rows in which they were found."""
    described = (
        "steps up and down at random",
        f"{outcome.channel} += h*s(t), s goes up or down by about 1 every T in the mean",
    )
    every = found.every / float(np.sqrt(found.number))
    parameters = (
        {"symbol": "h", "value": found.height, "unit": CHANNEL_UNITS[outcome.channel], "std": None},
        {"symbol": "T", "value": found.every, "unit": "s", "std": every},
    )
    return _at_random(found, described, parameters, outcome, frame)


def _at_random(
    found: Telegraph | Steps,
    described: tuple[str, str],
    parameters: tuple[dict[str, Any], ...],
    outcome: ChannelOutcome,
    frame: Frame,
) -> Discovery:
    """Jumps or steps as a finding without a name, ``described`` in words and as an equation: nothing recorded predicts
    when.
    """
    return Discovery(
        UNNAMED,
        UNKNOWN,
        1.0 - found.p_value,
        outcome.channel,
        *described,
        ("time",),
        parameters,
        np.zeros(outcome.rows.size),
        0.0,
        found.p_value,
        (),
        excess=_as_compared(np.abs(found.course), frame, outcome),
        squares=_unchanged(outcome),
    )


def _scatter(search: Search, densities: Sequence[Density], seed: int) -> Scatter | None:
    """The state that scatters most, if what the model leaves scatters there as well: a spectrum of the channel holds
    what the model says, too.
    """
    rows = search.model.problem.rows
    settled = search.model.problem.train & settled_rows(rows.frame)
    number = np.where(settled, rows.number, 0.0)
    found = scatter(densities, rows.frame, number, seed)
    if found is None:
        return None
    left = (rows.y - of_start(search.model.problem, explained(search.model))) ** 2
    recording = rows.frame.recording
    count = np.bincount(recording, settled)
    # of a mean of n samples as much as of one
    squares = np.bincount(recording, number * left) / np.maximum(count, 1.0)
    if search.model.channel == MOTOR_TORQUE:
        # no term is quicker than a row there, and most of what sticks and slips is: of all samples
        samples = np.bincount(recording, number)
        squares = np.bincount(recording, number * (left + rows.within)) / np.maximum(samples, 1.0)
    louder = np.isin(np.arange(count.size), found.recordings)
    others = np.median(squares[~louder & (count > 0)])
    return found if np.median(squares[louder & (count > 0)]) >= criteria.MORE_THAN_NOISE**2 * others else None


def _of_scatter(found: Scatter, outcome: ChannelOutcome) -> Discovery:
    """A state that scatters more than the others, as a finding without a name: nothing predicts a single sample."""
    unit = CHANNEL_UNITS[outcome.channel]
    where = f"the {found.quantity} is {found.side} {found.limit:.3g} {UNITS[found.quantity]}"
    sizes = np.array([np.sqrt(found.usual + s) for s in found.squares])
    rms = float(np.sqrt(np.mean(sizes**2)))
    recording = outcome.rows.frame.recording
    size = np.zeros(int(recording.max(initial=0)) + 1)
    size[list(found.recordings)] = np.sqrt(found.squares)
    samples = np.bincount(recording, np.where(outcome.usable, outcome.rows.number, 0.0), size.size)
    # a slow recording has more samples and is no more of a witness: each counts as much for the range of the state, all
    # together as much as they are
    usual = float(np.sum(samples * size**2) / max(float(np.sum(size**2)), 1e-300))
    alike = size * np.sqrt(usual / np.maximum(samples, 1.0))
    return Discovery(
        UNNAMED,
        UNKNOWN,
        1.0 - found.p_value,
        outcome.channel,
        f"scatter {found.louder:.2g} times as large where {where}",
        f"{outcome.channel} += scatter that no recorded quantity predicts, where {where}, rms: its root mean square",
        (found.quantity,),
        ({"symbol": "rms", "value": rms, "unit": unit, "std": float(np.std(sizes, ddof=1) / np.sqrt(sizes.size))},),
        np.zeros(outcome.rows.size),
        0.0,
        found.p_value,
        (),
        excess=np.asarray(alike[recording]),
        everywhere=np.asarray(size[recording]),
        squares=_unchanged(outcome),
        side=(found.quantity, found.side, found.limit),
    )


def _of_recordings(found: Tone, outcome: ChannelOutcome) -> FloatArray:
    """A tone's size at each row (n,): what its recording's spectrum says, nothing where none was looked at."""
    # the last recordings may have a spectrum and no rows that are compared
    size = np.zeros(1 + max(int(outcome.rows.frame.recording.max(initial=0)), *found.recordings))
    for recording, square in zip(found.recordings, found.squares, strict=True):
        size[recording] = np.sqrt(square)
    return np.asarray(size[outcome.rows.frame.recording])


def _unchanged(outcome: ChannelOutcome) -> tuple[float, float] | None:
    after = outcome.rmse.get("after")
    return None if after is None else (after**2, after**2)


def _of_bursts(loud: Bursts, outcome: ChannelOutcome, search: Search) -> Discovery | None:
    """The loud blocks as a finding without a name; None where they are no louder than what is told of anything."""
    rows = search.model.problem.rows
    left = rows.y - of_start(search.model.problem, explained(search.model))
    in_bursts = np.zeros(rows.size)
    in_bursts[loud.rows] = left[loud.rows]
    if float(np.sqrt(np.mean(left[loud.rows] ** 2))) < criteria.LEAST_STRENGTH * outcome.floor:
        return None
    time = rows.frame.time[loud.rows]
    unit = CHANNEL_UNITS[outcome.channel]
    size = float(np.sqrt(np.mean(left[loud.rows] ** 2)))
    fits = in_bursts.size == outcome.rows.size
    return Discovery(
        UNNAMED,
        UNKNOWN,
        1.0 - loud.p_value,
        outcome.channel,
        COMES_AND_GOES,
        f"{outcome.channel} += what nothing recorded predicts, in some blocks of time, rms: its root mean square",
        ("time",),
        ({"symbol": "rms", "value": size, "unit": unit, "std": size / np.sqrt(2.0 * loud.rows.size)},),
        in_bursts if fits else np.zeros(outcome.rows.size),
        0.0,
        loud.p_value,
        (),
        excess=_as_compared(in_bursts, rows.frame, outcome),
        time_window=(float(time.min()), float(time.max())),
        squares=_unchanged(outcome),
    )
