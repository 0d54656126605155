"""What a simulation file says of a recording's channels: the file and the recording's inputs, and nothing else.

Inputs are the angle, the load torque, the temperature and, for the temperature itself, its first reading: the state
from which it starts. Nothing of the predicted channel is fitted.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.foreign.opening import base_of
from bench.mismatch.given import Given, Known, says_span, says_waves
from bench.mismatch.orders.shaken import INERTIA
from bench.mismatch.power_zeros import (
    CONSTANT,
    EFFECT,
    KEY,
    REPORTED,
    REST,
    Zeros,
    levels_of,
    of_recordings,
    reported_by,
)
from bench.mismatch.read_motion import without_misread_motion
from bench.mismatch.recordings.beginning import START_S, at_start, risen
from bench.mismatch.recordings.collected import Collected
from bench.mismatch.recordings.level import means_of_segments
from bench.mismatch.recordings.notch import notched
from bench.mismatch.recordings.prepared import Folder, Prepared, prepare
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.recordings.source import of_one_campaign
from bench.mismatch.regression.problem import CHANNELS, fixed_part, nominal_base
from bench.mismatch.regression.regressors import Free, Named, Regressor, remembers
from bench.mismatch.series_given import periodic_part, slope
from bench.mismatch.unnamed.formula_regressor import Equation
from bench.recording import Recording
from bench.simulation import waves
from bench.simulation.frame import FloatArray, Frame, concatenate, gone_through, recording_starts
from bench.simulation.model import Simulation
from bench.simulation.quantities import HELD, REMEMBERED, kind_of, quantity
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR

SLIGHT = 1e-12
"""largest column of a nominal term from which recordings depend on it"""


@dataclass(frozen=True, slots=True)
class Predictor:
    """Evaluates a simulation on frames; ``missing`` are nominal terms in force of whose coefficients it says
    nothing.
    """

    given: Given

    @property
    def remembers(self) -> bool:
        """Whether some state goes on from one recording to the next."""
        return any(remembers(k.regressor) for known in self.given.known.values() for k in known)

    @property
    def takes_zeros(self) -> tuple[str, ...]:
        """Which zeros of the torques the file takes off the loss."""
        term = self.given.simulation.terms.get(EFFECT)
        return () if term is None else tuple(term.extra.get(KEY, ()))

    def zeros(self, rows: Mapping[str, Rows]) -> Zeros:
        """Zeros of the torques that the file takes off the loss; ``rows`` by channel of all recordings."""
        which = self.takes_zeros
        if not which:
            return Zeros()
        constant = {}
        for channel, effect in CONSTANT.items():
            constant[channel] = self._number(effect)
        frames = {channel: part.frame for channel, part in rows.items()}
        torques = {
            channel: (part, (part.number > 0) & (part.frame.direction != 0))
            for channel, part in rows.items()
            if channel in CONSTANT and of_recordings(which, channel)
        }
        levels = levels_of(torques, lambda channel, frame: self.channel(channel, frame, None, frames))
        known = self.given.known.get(MOTOR_TORQUE, ())
        return Zeros(
            which,
            constant,
            levels,
            {name: reported_by(known, name) for name in REPORTED},
            self._number(INERTIA),
            lambda frame: self.channel(MOTOR_TORQUE, frame, None, frames),
        )

    def _number(self, effect: str) -> float:
        """The first number of a term in force; 0 where there is none."""
        term = self.given.simulation.terms.get(effect)
        values = [] if term is None or not term.enabled else list(term.parameters.values())
        return values[0].value if values else 0.0

    def moved(self, channel: str, frame: Frame, span: float) -> Frame:
        """A frame as a channel feels the motion: the motor torque without what the file says the motor's encoder
        misreads; ``span``: window of its rates, s.
        """
        return without_misread_motion(frame, self.given.misread_waves if channel == MOTOR_TORQUE else (), span)

    def missing(self, channel: str, frame: Frame) -> list[str]:
        """Nominal terms in force that matter on a frame and have no coefficients in the file."""
        given = self.given
        out = []
        for term in nominal_base(channel, given.switched_off):
            named = term.regressor
            assert isinstance(named, Named)
            if named.effect == "te.offset":
                if given.simulation.transmission_error() is None:
                    out.append(named.effect)
                continue
            if given.nominal_coefficients(named) is None and np.abs(named.columns(frame)).max(initial=0.0) > SLIGHT:
                out.append(named.effect)
        if channel == TRANSMISSION_ERROR and given.orders and given.simulation.transmission_error() is None:
            out.append("te.fourier")
        if channel == TEMPERATURE and REST in self.takes_zeros:
            out += self.missing(MOTOR_TORQUE, frame)  # the loss is what the model of the motor torque says
        return out

    def channel(
        self, channel: str, frame: Frame, start: FloatArray | None = None, campaign: Mapping[str, Frame] | None = None
    ) -> FloatArray:
        """A channel at the rows of a frame (n,).

        ``start`` (recordings,): temperature at each recording's beginning, the mean of its first seconds.
        ``campaign``: by channel, rows of all its recordings, through which states run that one recording hands on to
        the next; without it each begins afresh.
        """
        given = self.given
        rows = dict(campaign or {})
        sensor = given.known.get(LOAD_TORQUE, ())
        if channel != LOAD_TORQUE:
            frame = corrected(frame, sensor, rows.get(LOAD_TORQUE))
            if channel in rows and any(remembers(known.regressor) for known in given.known.get(channel, ())):
                rows[channel] = corrected(rows[channel], sensor, rows.get(LOAD_TORQUE))
        out = fixed_part(channel, frame, given.switched_off)
        for term in nominal_base(channel, given.switched_off):
            named = term.regressor
            assert isinstance(named, Named)
            coefficients = None if named.effect == "te.offset" else given.nominal_coefficients(named)
            if coefficients is not None:
                out = out + named.columns(frame) @ coefficients
        for known in given.known.get(channel, ()):
            if known.coefficients is not None:
                out = out + evaluated(known, frame, rows.get(channel))
        given_waves = given.waves.get(channel, ())
        if given_waves:
            angle = frame.theta if channel == TRANSMISSION_ERROR else frame.q
            out = out + waves.evaluate(given_waves, angle, frame)
        if given.ripples and channel == MOTOR_TORQUE:
            out = out + waves.evaluate(given.ripples, frame.theta, frame)
        if given.reaction and channel == MOTOR_TORQUE:
            out = out + given.reaction * frame.torque / frame.ratio * slope(given, frame)
        if channel == TRANSMISSION_ERROR:
            out = out + periodic_part(given, frame)
        if channel == TEMPERATURE:
            level = np.zeros(recording_starts(frame).size - 1) if start is None else start
            out = out + risen(frame, level - at_start(frame, out))
        return out


def evaluated(known: Known, frame: Frame, campaign: Frame | None) -> FloatArray:
    """What a regressor adds at the rows of a frame (n,); one that remembers runs through the ``campaign``.

    Rows average the noise of what drives a state; one that jumps with the motion's direction goes on from the rows
    before a recording through the recording's samples. Functions of states go through the rows aside as well.
    """
    assert known.coefficients is not None
    if campaign is None or not remembers(known.regressor):
        return np.asarray(known.regressor.columns(frame) @ known.coefficients)
    term = known.regressor if isinstance(known.regressor, Named) else None
    if term is None and not np.isin(frame.recording, campaign.recording).all():
        # of a recording aside: functions of states go through it, and everything else is asked of it there
        campaign = gone_through(campaign)
    if isinstance(known.regressor, Free | Equation) and known.regressor.channel != TEMPERATURE:
        gone_through_it = np.isin(frame.recording, campaign.recording)
        columns = known.regressor.columns(_with_states(known.regressor, frame, campaign))
        return np.where(gone_through_it, columns @ known.coefficients, 0.0)
    jumps = term is not None and term.form.jumps
    values = np.zeros(0) if jumps else known.regressor.columns(campaign) @ known.coefficients
    starts = recording_starts(frame)
    out = np.zeros(frame.size)
    for a, b in itertools.pairwise(starts):
        rows = np.flatnonzero(campaign.recording == frame.recording[a])
        if rows.size and jumps:
            gone_on = concatenate([campaign.take(slice(0, int(rows[0]))), frame.take(slice(int(a), int(b)))])
            out[a:b] = (known.regressor.columns(gone_on) @ known.coefficients)[rows[0] :]
        elif rows.size:
            out[a:b] = np.interp(frame.time[a:b], campaign.time[rows], values[rows])
    return out


def _with_states(regressor: Regressor, frame: Frame, campaign: Frame) -> Frame:
    """A frame that holds the states a function of them depends on, as they run through the ``campaign``."""
    states = {name: quantity(name, campaign) for name in regressor.variables if kind_of(name) in REMEMBERED}
    held = {name: np.zeros(frame.size) for name in states}
    for a, b in itertools.pairwise(recording_starts(frame)):
        rows = np.flatnonzero(campaign.recording == frame.recording[a])
        for name, values in states.items():
            if rows.size:
                held[name][a:b] = np.interp(frame.time[a:b], campaign.time[rows], values[rows])
    return replace(frame, aux={**frame.aux, **{f"{HELD}{name}": values for name, values in held.items()}})


def corrected(frame: Frame, known: Sequence[Known], campaign: Frame | None = None) -> Frame:
    """The frame with the load torque less the errors of its sensor, of what is ``known`` of that torque.

    Where the load is kept at a level, the torque is smoothed, and so is what is taken off it: the zero of a segment is
    one, however the temperature drifts in it. And what is known to turn the shaft there, such as an unbalance, is put
    back.
    ``campaign``: see :meth:`Predictor.channel`. Rows aside are corrected as well.
    """
    if frame.aside is not None:
        aside = corrected(frame.aside, known, campaign)
        frame = replace(frame, aside=None)
        return replace(corrected(frame, known, campaign), aside=aside)

    def sum_of(terms: Iterable[Known]) -> FloatArray:
        values = (evaluated(k, frame, campaign) for k in terms if k.coefficients is not None)
        return np.asarray(sum(values, np.zeros(frame.size)))

    read = sum_of(k for k in known if k.misread)
    real = sum_of(k for k in known if k.turns)
    if not (read.any() or real.any()):
        return frame
    mean = means_of_segments(read, frame)
    off = mean + frame.followed * (read - mean)
    back = real - means_of_segments(real, frame)
    # the loss follows the torque: its sign before it was taken is that of the power the motor puts in beyond the load's
    sign = np.sign(frame.motor_torque * frame.omega - frame.torque * frame.velocity)
    power = np.abs(sign * frame.power + off * frame.velocity)
    torque = frame.torque - off + (1.0 - frame.followed) * back
    return replace(frame, torque=torque, torque_level=frame.torque_level - mean + back, power=power)


@dataclass(frozen=True, slots=True)
class Compared:
    """A channel of one recording, sample by sample: what was ``measured``, which samples count, the frame."""

    measured: FloatArray
    counts: NDArray[np.bool_]
    frame: Frame
    start: FloatArray | None


def compared(prepared: Prepared, channel: str) -> Compared:
    """A channel of a recording that was prepared at its own rate."""
    measured, frame = prepared.measured[channel], prepared.frame
    counts = measured.valid & (measured.number > 0)
    if channel != TEMPERATURE:
        counts &= frame.direction != 0
    start = None
    if channel == TEMPERATURE:
        first = measured.samples[: max(1, round(START_S * prepared.sample_rate))]
        valid = measured.valid[: first.size]
        start = np.array([float(first[valid].mean()) if valid.any() else np.nan])
    return Compared(measured.samples, counts, frame, start)


def silent(side: Compared, values: FloatArray, notch: Sequence[float]) -> FloatArray:
    """What a recording's transmission error has at the orders of the load motor's ripple beyond a prediction (n,).

    The ripple twists the gearbox, more about zero load than elsewhere. It is read from what the prediction leaves:
    beside the gearbox' orders, in less than a revolution, it would not be told from these.
    """
    frame = side.frame
    return notched(frame.q, side.measured - values, frame.direction, ~side.counts | (frame.steady < 1.0), notch)


def predict(
    model: Simulation | Mapping[str, Any] | str | Path, recording: Recording, before: Sequence[Recording] = ()
) -> dict[str, FloatArray]:
    """Predict the compared channels of a recording that it has the inputs for, on its own samples.

    ``before``: recordings of the same campaign before it, in order; states that one hands on to the next (a
    hysteresis, a housing's temperature), the campaign's time and the distance run go through them. Raises
    RecordingError where a recording cannot be read, ConfigurationError for a wrong model.
    """
    *_, last = predict_all(model, [*before, recording], only=len(before))
    return last[1]


def predict_all(
    model: Simulation | Mapping[str, Any] | str | Path,
    recordings: Sequence[Recording],
    only: int | None = None,
    channels: Collection[str] = tuple(CHANNELS),
) -> Iterator[tuple[Recording, dict[str, FloatArray]]]:
    """Predict ``channels`` of the recordings of a campaign, in the order in which they began; or of the one of number
    ``only``.

    At the orders of the load motor's ripple the simulation is silent (bench-physics, "Nominal simulation" 1): what the
    recording has there stands in the prediction, so that it may be compared with the channel as it was measured.
    """
    for part, predictions in predictions_of(model, recordings, only, channels):
        yield part, {channel: prediction.values for channel, prediction in predictions.items()}


@dataclass(frozen=True, slots=True)
class ChannelPrediction:
    """A channel of one recording predicted by a simulation, sample by sample: ``values`` (n,), which samples are
    compared; ``missing`` terms in force without numbers, which the prediction lacks.
    """

    values: FloatArray
    counts: NDArray[np.bool_]
    missing: tuple[str, ...] = ()


def predictions_of(
    model: Simulation | Mapping[str, Any] | str | Path,
    recordings: Sequence[Recording],
    only: int | None = None,
    channels: Collection[str] = tuple(CHANNELS),
) -> Iterator[tuple[Recording, dict[str, ChannelPrediction]]]:
    """As :func:`predict_all`, with what a prediction lacks."""
    if isinstance(model, Mapping):
        simulation = Simulation.from_json(model)
    else:
        simulation = model if isinstance(model, Simulation) else Simulation.load(model)
    # a recording whose clock was not set is of no campaign
    whole = of_one_campaign(recordings) if only is None else list(recordings)
    beside = Path(model).resolve().parent if isinstance(model, str | Path) else Path.cwd()
    base = base_of(simulation.extra, beside)
    folder = Folder.of(whole, base).following(says_waves(simulation)).smoothed(says_span(simulation))
    predictor = Predictor(Given.of(simulation))
    travelled = [0.0]
    rows = Collected()
    if predictor.remembers or predictor.takes_zeros or only:
        for number, part in enumerate(whole):
            ready = prepare(part, number, folder, travelled[-1])
            travelled.append(float(ready.frame.travel[-1]))
            rows.add(ready, frozenset(CHANNELS), folder.manner)
    joined = {channel: rows.joined(channel) for channel in rows.rows}
    zeros = predictor.zeros(joined)
    campaign = zeros.of_campaign({channel: part.frame for channel, part in joined.items()})
    for number, part in enumerate(whole):
        if only is not None and number != only:
            continue
        ready = prepare(part, number, folder, travelled[number], group=1)
        if number + 1 >= len(travelled):
            travelled.append(float(ready.frame.travel[-1]))
        out = {}
        for channel, spec in CHANNELS.items():
            if channel not in channels:
                continue
            if channel in ready.measured and all(name in part.specs for name in spec.made_of):
                side = compared(ready, channel)
                frame = zeros.less(ready.frame) if channel == TEMPERATURE else ready.frame
                frame = predictor.moved(channel, frame, folder.manner.smoothing)
                values = predictor.channel(channel, frame, side.start, campaign)
                if channel in ready.ripple:  # the simulation is silent at these orders, as a notch is
                    values = values + ready.ripple[channel]
                elif channel == TRANSMISSION_ERROR:
                    values = values + silent(side, values, folder.notch)
                values = values + ready.simulated.get(channel, 0.0)
                out[channel] = ChannelPrediction(values, side.counts, tuple(predictor.missing(channel, ready.frame)))
        yield part, out
