"""How the bench moves: directions, distance since a reversal, corners of the speed profile, and when it stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.mismatch import criteria
from bench.mismatch.recordings.level import confirmed
from bench.mismatch.recordings.smoothing import WINDOWS_S, local_quadratic, repaired, span_for, window
from bench.mismatch.recordings.window import ANGLE, RECORDED, Rates, best_rates
from bench.recording import Recording
from bench.simulation.frame import FloatArray, Frame

RECORDINGS_FOR_SPAN = 15
"""recordings that are asked for the window of the rates: their middle needs no more"""
SHARE_OF_FASTEST = 0.1
"""of the largest speed that was set, up to which a motor may be passing a crawl"""
OF_LARGEST = 0.1
"""of the largest acceleration, by which it jumps at a corner at least"""
CRAWLS = 0.1
"""of the speed below which the bench stands, from which a motor crawls and does not stand"""
FASTER = 10.0
"""times the speed of standstill, from which a motion is fast"""
SLOW = 0.02
"""of the fastest speed, below which motion counts as standing"""
SURELY = 4.0
"""standard deviations of the noise of a speed, beyond which its sign is that of the motion"""
LONGER = 4
"""times the window of the rates: over so long what is slow by intent has hardly changed, and noise is averaged out"""
ENCODER_STEPS = 1.5
"""of the encoder in a window, which a shaft at rest may seem to turn: one that comes and goes, and what rounds it"""
SMALLEST = 0.05
"""of the steps of an angle that moves: one of a coarse encoder, and next to nothing of a fine one"""
FEWEST_SAMPLES = 100
"""of a recording, from which its noise is told"""
NEARLY_ALL = 0.95
"""of the compared motion that goes one way: the rest is how recordings start"""
NOTED = 0.05
"""of the samples in motion, from which it is said that they are not compared"""


@dataclass(frozen=True, slots=True)
class Manner:
    """How a folder's motion is read.

    ``standstill``: motor speed below which the bench stands, rad/s (a linear axis: m/s); ``smoothing``: window of the
    rates in s; ``torque``: largest load torque of the folder, N·m, to which "hardly moves" is referred; ``confirmed``:
    share of what the torque sensor reads about a level that the load motor confirms
    (:func:`bench.mismatch.recordings.level.confirmed`); ``speed``: largest speed of the output, rad/s, by whose parts
    rows end; ``free``: no recording says what speed it was set to; ``source``: of the rates
    (:mod:`bench.mismatch.recordings.window`); ``follows_waves``: whether the load torque follows those of the
    transmission error (:mod:`bench.mismatch.recordings.followed_waves`).
    """

    standstill: float
    smoothing: float
    torque: float
    confirmed: float = 1.0
    speed: float = 1.0
    free: bool = False
    source: str = ANGLE
    follows_waves: bool = True

    @classmethod
    def of(cls, recordings: Sequence[Recording]) -> Manner:
        """Read it from a folder's recordings.

        The bench stands below the speed of a geared motor's crawl, unless nothing in the folder ever moves ten times
        as fast: then below a fiftieth of the fastest speed.
        """
        standstill = standstill_speed(recordings)
        rates = Rates(_usual_span(recordings, standstill))
        free = not any(np.isfinite(r.setpoint.velocity) for r in recordings)
        if free:
            # noise of the speed says what window steady motion wants; a motion of its own kind wants its own
            rates = best_rates(recordings, standstill) or rates
        loads = [abs(r.setpoint.load_torque) for r in recordings if np.isfinite(r.setpoint.load_torque)]
        largest = max(loads, default=0.0)
        fastest = max((abs(r.setpoint.velocity) for r in recordings if np.isfinite(r.setpoint.velocity)), default=0.0)
        if free:
            largest = largest or max((_usual_load(r) for r in recordings), default=0.0)
            fastest = max((_fastest(r) / float(r.gearbox.ratio or 1.0) for r in recordings), default=0.0)
        level = confirmed(recordings, largest)
        return cls(standstill, rates.span, largest, level, fastest or 1.0, free, rates.source)


def _usual_span(recordings: Sequence[Recording], standstill: float) -> float:
    """Window in s for the rates of a folder: the middle one of those that recordings in motion want, of the sample rate
    that most of them have. An angle that stands shows no steps of its encoder.
    """
    angles = [r for r in recordings if "motor_angle" in r.specs and r.size > 1]
    spans: dict[float, list[float]] = {}
    for recording in angles[:: max(1, -(-len(angles) // RECORDINGS_FOR_SPAN))]:
        angle, rate = _angle(recording), float(recording.sample_rate)
        if _hardly_exceeded(_speed(angle, rate)) > standstill:
            spans.setdefault(rate, []).append(span_for(angle, rate, standstill))
    if not spans:
        return WINDOWS_S[-1]
    usual = max(spans.values(), key=len)
    return sorted(usual)[len(usual) // 2]


def _fastest(recording: Recording) -> float:
    """Speed of the motor in rad/s (a linear axis: m/s) that a recording hardly ever exceeds; 0 where none was seen."""
    if recording.size < 2:
        return 0.0
    if "motor_angle" in recording.specs:
        speed = _speed(_angle(recording), float(recording.sample_rate))
    elif "motor_velocity" in recording.specs:
        speed = recording.si("motor_velocity")
    else:
        return 0.0
    return _hardly_exceeded(speed)


def _speed(angle: FloatArray, rate: float) -> FloatArray:
    """Speed (n,) of an angle at a sample ``rate`` in Hz, smoothed as of a coarse encoder."""
    return local_quadratic(angle, rate, WINDOWS_S[-1])[1]


def _hardly_exceeded(values: FloatArray) -> float:
    """Size that values hardly ever exceed; 0 where none is a number."""
    return float(np.nan_to_num(np.nanpercentile(np.abs(values), 99.0)))


def _usual_load(recording: Recording) -> float:
    """Load torque in N·m that a recording hardly ever exceeds; 0 where it has none."""
    if "load_torque" not in recording.specs or recording.size == 0:
        return 0.0
    return _hardly_exceeded(recording.si("load_torque"))


def _angle(recording: Recording) -> FloatArray:
    angle = recording.si("motor_angle")
    return repaired(angle, ~np.isfinite(angle))


def standstill_speed(recordings: Sequence[Recording]) -> float:
    """Motor speed in rad/s (a linear axis: m/s) below which the bench counts as standing."""
    fastest = 0.0
    for recording in recordings:
        velocity, ratio = recording.setpoint.velocity, float(recording.gearbox.ratio or 1.0)
        if np.isfinite(velocity) and velocity != 0.0:
            fastest = max(fastest, abs(velocity) * ratio)
        else:
            fastest = max(fastest, _fastest(recording))
        if fastest > FASTER * criteria.STANDSTILL_RAD_S:
            return criteria.STANDSTILL_RAD_S
    return max(SLOW * fastest, 1e-9) if fastest > 0.0 else criteria.STANDSTILL_RAD_S


def resolved_speed(recording: Recording, manner: Manner) -> float:
    """Speed in rad/s (a linear axis: m/s) below which the direction of one recording's motion is not told.

    That of the folder, but for a recording in free motion that never moves ten times as fast, which is slow by intent:
    a fiftieth of its fastest speed, where the rates resolve that.
    """
    fastest = _fastest(recording) if manner.free else np.inf
    if not 0.0 < fastest <= FASTER * manner.standstill or recording.size < FEWEST_SAMPLES:
        return manner.standstill
    return min(manner.standstill, max(SLOW * fastest, _resolution(recording, manner)))


def _resolution(recording: Recording, manner: Manner) -> float:
    """Speed in rad/s (a linear axis: m/s) whose sign the rates of a recording surely tell: beyond what they differ from
    rates of a longer window, which a motion that is slow by intent has as well, and beyond a step of the encoder.
    """
    rate = float(recording.sample_rate)
    width = window(rate, manner.smoothing)
    step, slow = 0.0, None
    if "motor_angle" in recording.specs:
        angle = _angle(recording)
        steps = np.abs(np.diff(angle))
        steps = steps[steps > 0.0]
        # without its mean: after many revolutions sums of squares would lose the last digits
        slow = local_quadratic(angle - angle.mean(), rate, LONGER * width / rate)[1]
        step = ENCODER_STEPS * (float(np.quantile(steps, SMALLEST)) if steps.size else 0.0) * rate / width
    if manner.source == ANGLE and slow is not None:
        quick = local_quadratic(angle - angle.mean(), rate, manner.smoothing)[1]
    elif "motor_velocity" in recording.specs:
        speed = recording.si("motor_velocity")
        quick = repaired(speed, ~np.isfinite(speed))
        slow = local_quadratic(quick, rate, LONGER * width / rate)[0] if slow is None else slow
        quick = quick if manner.source == RECORDED else local_quadratic(quick, rate, manner.smoothing)[0]
    else:
        return np.inf
    return max(SURELY * float(np.sqrt(np.mean((quick - slow) ** 2))), step)


def corners(acceleration: FloatArray, rate: float, span: float, free: bool = False) -> NDArray[np.bool_]:
    """Mark the surroundings of jumps of the acceleration: rates smoothed over a corner say nothing of the moment.

    ``free``: whether the motion follows no set speeds. Then its acceleration is never still, so what it does by itself
    is no measure of what it does at the ends of a recording.
    """
    half = max(1, window(rate, span) // 2 + 1)
    # a recording that begins or ends while the speed changes has a corner there: what was before is not known
    padded = np.pad(acceleration, half)
    jump = np.abs(padded[2 * half :] - padded[: -2 * half])
    noise = 1.4826 * float(np.median(jump))
    least = OF_LARGEST * float(np.percentile(np.abs(acceleration), 99.5))
    marked = jump > max(6.0 * noise, least, 0.5)
    ends = np.ones(acceleration.size, dtype=bool)
    ends[half:-half] = False
    if marked.mean() > 0.3:  # no trapezoids here: a speed that never rests has no corners, but at its ends
        marked &= ends
    if free:
        marked |= ends & (jump > least)
    near = half // 2
    spread = np.convolve(marked.astype(np.float64), np.ones(2 * near + 1))[near : near + acceleration.size]
    return np.asarray(spread > 0.5)


def passing(omega: FloatArray, steady: FloatArray, manner: Manner, ratio: float) -> NDArray[np.bool_]:
    """Mark samples that pass the speeds at which one bench counts as standing and another as moving; a steady motion
    that slow is meant to be one. Only where speeds were set, and no more than a tenth of the largest (a linear axis:
    m/s): other motions may be no faster.
    """
    if manner.free or manner.standstill < criteria.STANDSTILL_RAD_S:
        return np.zeros(omega.size, dtype=bool)
    limit = min(criteria.SURELY_MOVING_RAD_S, SHARE_OF_FASTEST * manner.speed * ratio)
    return np.asarray((np.abs(omega) < limit) & (steady < 0.5))


def directions(omega: FloatArray, standstill: float) -> tuple[FloatArray, FloatArray]:
    """Sign of the motion, 0 at standstill; and of the last motion, which at standstill is the one before."""
    direction = np.where(np.abs(omega) > standstill, np.sign(omega), 0.0)
    moving = np.flatnonzero(direction)
    if moving.size == 0:
        return direction, direction
    before = np.maximum.accumulate(np.where(direction != 0, np.arange(direction.size), -1))
    return direction, direction[np.where(before >= 0, before, moving[0])]


def away_from_turns(direction: FloatArray, half: float) -> FloatArray:
    """Directions (n,), 0 as well where the motion turns within ``half`` a window of the rates (samples).

    There a smoothed speed does not say which way the shaft turns, nor whether it sticks: dry friction, which goes with
    the direction, may be anything between its two values.
    """
    if half < 1.0 or direction.size == 0:
        return direction
    moving = np.flatnonzero(direction)
    turns = np.flatnonzero(direction[moving[1:]] != direction[moving[:-1]])
    # in the middle between the last sample of one direction and the first of the other
    middle = 0.5 * (moving[turns] + moving[turns + 1])
    edges = np.zeros(direction.size + 1, dtype=np.int64)
    np.add.at(edges, np.maximum(np.ceil(middle - int(half)).astype(np.int64), 0), 1)
    np.add.at(edges, np.minimum(np.floor(middle + int(half)).astype(np.int64) + 1, direction.size), -1)
    return np.where(np.cumsum(edges[:-1]) > 0, 0.0, direction)


def share_of_one_way(direction: FloatArray, number: FloatArray) -> float | None:
    """Share of the samples in motion, ``number`` (n,) of each row, that go the way most of them go; None where nothing
    moves.
    """
    ways = [float(number[direction == side].sum()) for side in (1.0, -1.0)]
    return max(ways) / sum(ways) if any(ways) else None


def slowly(frame: Frame, manner: Manner) -> list[str]:
    """What is said of rows whose direction is not told though the motor turns: torques are not compared there."""
    speed = np.abs(frame.omega)
    moving = speed > CRAWLS * manner.standstill
    all_of_it = float(frame.count[moving].sum())
    share = float(frame.count[moving & (frame.direction == 0)].sum()) / all_of_it if all_of_it > 0.0 else 0.0
    if share < NOTED:
        return []
    less = " (less in slow recordings)" if manner.free else ""
    return [
        f"in {share:.2g} of the samples in motion the motor is slower than {manner.standstill:.2g} rad/s{less} or turns"
        " round: which way it turns is not told there, and what friction depends on is not compared"
    ]


def since_change(
    theta: FloatArray, time: FloatArray, direction: FloatArray, last: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Travel and time since the motion last began, and 1 where it went the other way before (else 0)."""
    moving = direction != 0
    begins = moving & ~np.concatenate(([False], moving[:-1] & (direction[:-1] == direction[1:])))
    start = np.maximum.accumulate(np.where(begins, np.arange(theta.size), 0))
    run = np.cumsum(np.abs(np.diff(theta, prepend=theta[0])))
    # a start without a change of direction (after a stop) is no reversal
    reversed_at = np.cumsum(np.concatenate(([False], last[1:] != last[:-1])))
    return run - run[start], time - time[start], (reversed_at > 0).astype(np.float64)
