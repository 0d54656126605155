"""From a recording to the quantities that physics terms ask for: smoothed rates, direction, travel, levels.

Rates come from a local quadratic over some tens of milliseconds: one count of a 13-bit encoder at 2 kHz is 1.5 rad/s,
so differences of single samples say nothing. Wild samples are found against a running median and left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.foreign.base import BY, Base
from bench.foreign.inputs import inputs_of
from bench.identification.samples.spikes import spikes
from bench.identification.samples.thermometer import PT100_RANGE, beyond_pt100
from bench.mismatch import criteria
from bench.mismatch.recordings.faulty import Faulty, stuck
from bench.mismatch.recordings.level import kept_segments, levelled, numbered
from bench.mismatch.recordings.motion import (
    Manner,
    away_from_turns,
    corners,
    directions,
    passing,
    resolved_speed,
    since_change,
)
from bench.mismatch.recordings.notch import notched
from bench.mismatch.recordings.ripple import Ripple, ripple_of
from bench.mismatch.recordings.runs import Runs, smoothed
from bench.mismatch.recordings.shaking import count_of, shaken
from bench.mismatch.recordings.smoothing import SHORTEST, WINDOWS_S, local_quadratic, repaired, window
from bench.mismatch.recordings.thinning import Measured, Thinning, group_of
from bench.mismatch.recordings.window import ANGLE, VELOCITY, Rates, motion
from bench.recording import SIMULATED, Recording
from bench.recording.times import not_increasing
from bench.simulation.composed import acceleration_of, rate_of
from bench.simulation.frame import FloatArray, Frame, IntArray
from bench.simulation.quantities import AUXILIARY

_READ = (
    "motor_angle",
    "load_angle",
    "motor_velocity",
    "motor_torque",
    "load_torque",
    "load_motor_torque",
    "temperature",
)


@dataclass(frozen=True, slots=True)
class Prepared:
    """One recording, at its own rate or in groups of samples (:mod:`bench.mismatch.recordings.thinning`).

    ``frame`` has a row a group; ``measured`` the compared channels in SI units (those the file has); ``swept`` variance
    of the input angle inside each group, times its valid samples; ``leaning`` the same of input angle and transmission
    error together, rad²; ``angle`` input angle of every sample, rad at the output; ``label`` number of each group's
    segment (-1: none); ``corner`` where the acceleration jumps or cannot be told, or the motor passes speeds at which
    one bench stands and another moves; ``dead`` channels that hold no number at all.
    """

    kind: str
    sample_rate: float
    frame: Frame
    thinning: Thinning
    measured: dict[str, Measured]
    swept: FloatArray
    leaning: FloatArray
    angle: FloatArray
    label: IntArray
    corner: NDArray[np.bool_]
    dead: frozenset[str]
    ripple: dict[str, FloatArray] = field(default_factory=dict)
    """the load motor's ripple that was taken off a channel, a value a group"""
    simulated: dict[str, FloatArray] = field(default_factory=dict)
    """what a simulation from elsewhere says of a channel, taken off it, a value a group"""
    faulty: dict[str, Faulty] = field(default_factory=dict)
    """by channel: what its sensor does instead of measuring, and at which share of the samples"""


STEADY_HEAT_S = 20.0
"""over which a parabola follows the temperature of a lubricant: a hundred watts warm a gearbox of 20 kJ/K by 0.1 K
in it, and the time constants of what takes heat from it are minutes
"""


@dataclass(frozen=True, slots=True)
class Folder:
    """What all recordings of a folder share while they are read.

    ``start``: POSIX time of the campaign's first sample; ``ripple``: of the load motor; ``base``: a simulation from
    elsewhere, whose channels are taken off those measured.
    """

    start: float
    manner: Manner
    ripple: Ripple = field(default_factory=Ripple)
    base: Base | None = None

    @classmethod
    def of(cls, recordings: Sequence[Recording], base: Base | None = None) -> Folder:
        """The folder of some recordings of one campaign, in the order in which they began."""
        return cls(recordings[0].started_at.timestamp(), Manner.of(recordings), ripple_of(recordings), base)

    def following(self, waves: bool) -> Folder:
        """The folder if its load torque follows the ``waves`` of the transmission error, or does not."""
        return replace(self, manner=replace(self.manner, follows_waves=waves))

    def smoothed(self, span: float | None) -> Folder:
        """The folder with rates smoothed over ``span`` s, where that is known and the motion follows no set speeds."""
        if span is None or not self.manner.free:
            return self
        return replace(self, manner=replace(self.manner, smoothing=span))

    @property
    def notch(self) -> tuple[float, ...]:
        """Orders of the load motor's ripple per output revolution."""
        return self.ripple.orders


class _Signals:
    """Channels of one recording in SI units, repaired, averaged over groups; with what is bad of them."""

    def __init__(self, recording: Recording, thinning: Thinning) -> None:
        names = [n for n in _READ if n in recording.specs]
        names += [n for n in recording.specs if n.startswith(AUXILIARY)]
        self._raw = recording.read_si(["time", *names])
        if (problem := not_increasing(self._raw["time"])) is not None:
            raise RecordingError(f"{recording.path.name}: time {problem}")
        self._size = recording.size
        self._thinning = thinning
        self.bad: dict[str, NDArray[np.bool_]] = {}
        self.samples: dict[str, FloatArray] = {}
        for name in names:
            self.bad[name] = spikes(self._raw[name])
        self.faulty = {**self._mark_stuck(recording.gearbox.ratio), **self._mark_open()}
        for name in names:
            self.samples[name] = repaired(self._raw[name], self.bad[name])

    def _mark(self, name: str, does: str, where: NDArray[np.bool_]) -> dict[str, Faulty]:
        """Mark samples of a channel as bad; what is wrong with it, by its name, if there are any."""
        self.bad[name] = self.bad[name] | where
        return {name: Faulty(does, float(where.mean()))} if where.any() else {}

    def _mark_open(self) -> dict[str, Faulty]:
        """Mark samples of a thermometer whose circuit is open or shorted as bad."""
        if "temperature" not in self._raw:
            return {}
        text = f"reads {PT100_RANGE[0]:g} or {PT100_RANGE[1]:g} °C or beyond, as a PT100 does that is open or shorted"
        return self._mark("temperature", text, beyond_pt100(self._raw["temperature"]))

    def _mark_stuck(self, ratio: float | None) -> dict[str, Faulty]:
        """Mark samples of an encoder that stays at one value while the other turns as bad."""
        out: dict[str, Faulty] = {}
        if ratio is None or not {"motor_angle", "load_angle"} <= self._raw.keys():
            return out
        names = ("motor_angle", "load_angle")
        motor, load = (repaired(self._raw[name], self.bad[name]) for name in names)
        motor = motor / ratio
        for name, angle, other in (("motor_angle", motor, load), ("load_angle", load, motor)):
            out |= self._mark(name, "stays at one value while the other encoder turns", stuck(angle, other))
        return out

    def __contains__(self, name: str) -> bool:
        return name in self.samples

    def time(self) -> FloatArray:
        return self._thinning.mean(self._raw["time"])

    def mean(self, name: str) -> FloatArray:
        """Means of the groups; zeros for a channel the file has not."""
        if name not in self.samples:
            return np.zeros(self._size // self._thinning.group)
        return self._thinning.mean(self.samples[name])

    def wild(self, name: str) -> NDArray[np.bool_]:
        """Groups with a bad sample."""
        return ~self._thinning.every(~self.bad[name])


def prepare(
    recording: Recording, index: int, folder: Folder, travelled: float = 0.0, group: int | None = None
) -> Prepared:
    """Read a recording and derive what the terms need.

    ``index``: its number in the folder; ``travelled``: distance run before it in this campaign, rad at the output;
    ``group``: samples averaged into one, chosen by the smoothing window where it is not given.
    Raises RecordingError where the file cannot be read or names no gear ratio, ConfigurationError where a simulation
    from elsewhere is mapped wrongly.
    """
    if recording.gearbox.ratio is None:
        raise RecordingError(f"{recording.path}: gearbox.ratio is missing; a linear axis has ratio 1")
    ratio, manner = float(recording.gearbox.ratio), folder.manner
    span = manner.smoothing
    thinning = Thinning(group_of(float(recording.sample_rate), span) if group is None else group)
    rate = float(recording.sample_rate) / thinning.group
    signals = _Signals(recording, thinning)
    time = signals.time()
    n = time.size
    motor, load = signals.mean("motor_angle"), signals.mean("load_angle")
    label, steady = _segments(recording, thinning)
    runs = runs_of(time, rate, span, steady, label)
    how = Rates(span, manner.source if "motor_velocity" in signals else ANGLE)
    if "motor_angle" not in signals:
        how = Rates(span, VELOCITY)
    omega, acceleration = motion(motor, signals.mean("motor_velocity"), how, runs)
    if "motor_angle" not in signals:
        motor = np.cumsum(omega) / rate
    theta = motor / ratio
    q = load if "load_angle" in signals else theta
    _, q_rate, q_acceleration = smoothed(q, span, runs)
    turning = [piece for piece in runs.pieces or [slice(0, n)] if np.all(steady[piece] > 0.5)]
    if not manner.follows_waves:
        q_acceleration = of_both_shafts(theta, runs)
    elif "motor_angle" in signals and "load_angle" in signals:
        chosen = _quieter(q_acceleration, acceleration / ratio)
        motor_moves = None if chosen is q_acceleration else theta
        q_acceleration = chosen + shaken(q, q_rate, turning, rate, span, count_of(recording), motor_moves)
    direction, last = directions(omega, resolved_speed(recording, manner))
    reversal_travel, reversal_time, reversed_before = since_change(theta, time, direction, last)
    if manner.free and window(rate, span) > SHORTEST:
        direction = away_from_turns(direction, 0.5 * span * rate)

    load_motor = signals.mean("load_motor_torque")
    load_torque, motor_torque = signals.mean("load_torque"), signals.mean("motor_torque")
    taken: dict[str, FloatArray] = {}
    if "load_torque" in signals:
        beside_ripple = [_evened(q_acceleration, turning)]
        beyond, wild = load_torque - load_motor, signals.wild("load_torque")
        moving = (direction != 0) & ~wild
        whole = kept_segments(load_torque, np.where(moving, 0, -1), moving, manner.torque, rate)
        driven = "load_motor_torque" not in signals and not whole
        # a sensor that tells the torque late has the ripple of where the shaft was
        told = q - folder.ripple.lag * q_rate
        taken["load_torque"] = notched(told, beyond, direction, wild, folder.notch, beside_ripple, driven)
        load_torque = load_torque - taken["load_torque"]
    # a bench without torque sensor takes what the load motor reports, or else what was asked for
    acting = load_torque if "load_torque" in signals else load_motor
    if "load_torque" not in signals and "load_motor_torque" not in signals:
        setpoint = recording.setpoint.load_torque
        acting = np.full(n, setpoint if np.isfinite(setpoint) else 0.0)
    # the rate of the sensor's noise looks like a delay of what has that noise, and so does friction that turns with the
    # motion: neither is in what the load motor reports
    changing = load_motor if "load_motor_torque" in signals else acting
    torque_rate = local_quadratic(changing, rate, span)[1]
    rests = _rests(recording, thinning, n)
    kept = kept_segments(acting, label, rests, manner.torque, rate)
    witness = load_torque if "load_torque" in signals else None
    beside = load_motor if "load_torque" in signals and "load_motor_torque" in signals else None
    torque, torque_level = levelled(acting, kept, rate, manner.confirmed, beside)
    # what the load motor reports knows nothing of the inertia that a ramp of speed adds to the torque
    reported = kept_segments(load_motor, label, np.ones(n, dtype=bool), manner.torque, rate)
    for rows in reported if "load_motor_torque" in signals else kept:
        # about a level most of the rate over a short span is the sensor's noise
        torque_rate[rows] = local_quadratic(changing[rows], rate, criteria.KEPT_LOAD_S)[1]
    load_motor, load_motor_level = levelled(load_motor, reported, rate, beside=witness)
    if "motor_torque" in signals and "load_torque" in signals:  # without it there is no load motor to ripple
        # the ripple acts on the gearbox, so the input motor sees it through the ratio
        wild = signals.wild("motor_torque")
        beside_ripple = [_evened(omega, turning), _evened(acceleration, turning)]
        taken["motor_torque"] = notched(q, motor_torque - torque / ratio, direction, wild, folder.notch, beside_ripple)
        motor_torque = motor_torque - taken["motor_torque"]
    # without a thermometer nothing can depend on temperature: the value to which the nominal terms are referred
    temperature = np.full(n, criteria.REFERENCE_CELSIUS)
    if "temperature" in signals and not signals.bad["temperature"].all():
        # what a thermometer's noise does no lubricant does: a curve over it would follow the noise
        temperature = _of_lubricant(signals.mean("temperature"), time, rate)
    frame = Frame(
        ratio=ratio,
        recording=np.full(n, index, dtype=np.int64),
        count=np.full(n, float(thinning.group)),
        time=time + (recording.started_at.timestamp() - folder.start),
        elapsed=time,
        theta=theta,
        q=q,
        velocity=omega / ratio,
        acceleration=acceleration,
        load_acceleration=q_acceleration,
        direction=direction,
        last_direction=last,
        torque=torque,
        torque_level=torque_level,
        kept=numbered(kept, n),
        followed=np.full(n, manner.confirmed),
        torque_rate=torque_rate,
        temperature=temperature,
        motor_torque=motor_torque,
        load_motor_torque=load_motor,
        load_motor_level=load_motor_level,
        power=np.abs(local_quadratic(motor_torque, rate, span)[0] * omega - torque * q_rate),
        lead=np.zeros(n),
        kinetic=omega * acceleration,
        travel=travelled + np.cumsum(np.abs(np.diff(theta, prepend=theta[0]))),
        reversal_travel=reversal_travel,
        reversal_time=reversal_time,
        reversed_before=reversed_before,
        steady=steady,
        step=np.diff(time, prepend=time[0]),
        aux=_auxiliary(signals, span, runs),
    )
    passed = passing(omega, steady, manner, ratio)
    corner = corners(acceleration, rate, span, manner.free) | passed | runs.unknown
    given = _base_prediction(recording, folder)
    by = {SIMULATED + name: thinning.mean(values) for name, values in given.items() if BY in name}
    frame = replace(frame, aux={**frame.aux, **by})
    measured, swept, leaning = _measured(signals, thinning, ratio, taken, corner, passed, given)
    simulated = {name: thinning.mean(values) for name, values in given.items() if name in measured}
    dead = frozenset(name for name, marked in signals.bad.items() if marked.all())
    angle = (
        signals.samples["motor_angle"] / ratio if "motor_angle" in signals else thinning.spread(theta, recording.size)
    )
    kind = recording.kind
    parts = (measured, swept, leaning, angle, label, corner, dead, taken, simulated, signals.faulty)
    return Prepared(kind, rate, frame, thinning, *parts)


def runs_of(time: FloatArray, rate: float, span: float, steady: FloatArray, label: IntArray) -> Runs:
    """Pieces of a recording in which angles may be smoothed over ``span`` s: between lost cycles, and within segments
    of steady motion (n,) by their ``label``.
    """
    return Runs.of(time, rate, span, np.where(steady > 0.5, label, -1))


def of_both_shafts(theta: FloatArray, runs: Runs) -> FloatArray:
    """Acceleration (n,), rad/s², that motor and output have together, without waves of the transmission error."""
    return smoothed(theta, WINDOWS_S[-1], runs)[2]


def _of_lubricant(read: FloatArray, time: FloatArray, rate: float) -> FloatArray:
    """A temperature that was ``read`` (n,) at times (n,) without the noise of its thermometer; each piece between lost
    cycles by itself. As it is where so short a parabola holds too few samples to smooth them.
    """
    out = read.astype(np.float64)
    if STEADY_HEAT_S * rate < SHORTEST:
        return out
    pieces = Runs.of(time, rate, STEADY_HEAT_S, np.zeros(time.size, dtype=np.int64)).pieces
    for piece in pieces or (slice(0, time.size),):
        out[piece] = local_quadratic(read[piece], rate, STEADY_HEAT_S)[0]
    return out


def _quieter(one: FloatArray, other: FloatArray) -> FloatArray:
    """The one of two measurements of an acceleration (n,) with less noise: what shafts do together changes little from
    sample to sample.

    A noisy one is mistaken for less of itself wherever it is fitted (Fuller, Measurement Error Models, 1987, ch. 1).
    """
    if one.size < 2:
        return one
    noise, of_other = (float(np.median(np.abs(np.diff(x)))) for x in (one, other))
    return one if noise <= of_other else other


def _evened(values: FloatArray, turning: Sequence[slice]) -> FloatArray:
    """A speed or an acceleration (n,) with its mean in each piece of steady motion: what it does there is noise, a
    control loop's answer to a ripple among it, and says nothing of a ripple.
    """
    out = values.copy()
    for piece in turning:
        out[piece] = values[piece].mean()
    return out


def _auxiliary(signals: _Signals, span: float, runs: Runs) -> dict[str, FloatArray]:
    """Quantities that are no channel of the bench, with their rates, by name."""
    out: dict[str, FloatArray] = {}
    for name in signals.samples:
        if name.startswith(AUXILIARY):
            quantity = name.removeprefix(AUXILIARY)
            out[quantity] = signals.mean(name)
            _, out[rate_of(quantity)], out[acceleration_of(quantity)] = smoothed(out[quantity], span, runs)
    return out


def _measured(
    signals: _Signals,
    thinning: Thinning,
    ratio: float,
    taken: dict[str, FloatArray],
    corner: NDArray[np.bool_],
    passed: NDArray[np.bool_],
    given: dict[str, FloatArray],
) -> tuple[dict[str, Measured], FloatArray, FloatArray]:
    """The compared channels, less what is ``given`` of them sample by sample; and how input angle and transmission
    error scatter together inside the groups.
    """
    out: dict[str, Measured] = {}
    swept = leaning = np.zeros(corner.size)
    if "motor_angle" in signals and "load_angle" in signals:
        angle = signals.samples["motor_angle"] / ratio
        error = signals.samples["load_angle"] - angle - given.get("transmission_error", 0.0)
        good = ~(signals.bad["motor_angle"] | signals.bad["load_angle"] | spikes(error))
        # an offset and a series of the one direction are not those of the other
        out["transmission_error"] = thinning.measured(error, good).without(passed)
        swept, leaning = thinning.inner(angle, angle, good), thinning.inner(angle, error, good)
    for name in ("motor_torque", "temperature", "load_torque"):
        if name in signals:
            means = thinning.measured(signals.samples[name] - given.get(name, 0.0), ~signals.bad[name])
            out[name] = means.less(taken.get(name), thinning).without(corner if name != "temperature" else None)
    return out, swept, leaning


def _base_prediction(recording: Recording, folder: Folder) -> dict[str, FloatArray]:
    """Prediction of the simulation from elsewhere of each sample, where there is one."""
    if folder.base is None:
        return {}
    plain = replace(folder, base=None)
    return folder.base.predict(recording, lambda: inputs_of(recording, prepare(recording, 0, plain, group=1).frame))


def _segments(recording: Recording, thinning: Thinning) -> tuple[IntArray, FloatArray]:
    """Number of the segment of each group's first sample (-1: none); and 1 where all its samples are steady."""
    label = np.full(recording.size, -1, dtype=np.int64)
    steady = np.zeros(recording.size, dtype=bool)
    for number, segment in enumerate(recording.segments):
        label[segment.start : segment.stop] = number
        steady[segment.start : segment.stop] |= segment.name == "steady"
    return thinning.first(label), thinning.every(steady).astype(np.float64)


def _rests(recording: Recording, thinning: Thinning, size: int) -> NDArray[np.bool_]:
    """Groups inside segments in which the load may rest at a level: no ramps."""
    out = np.zeros(recording.size, dtype=bool)
    for segment in recording.segments:
        if segment.name in ("steady", "heat", "dwell"):
            out[segment.start : segment.stop] = True
    return np.asarray(thinning.every(out)[:size])
