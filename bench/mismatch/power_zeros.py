"""Zeros of the two torque channels, as far as the heat says that they are sensors' and no torque.

The loss is the difference of two large powers, abs(τ_m·ω_m − τ·q̇) (bench-physics, "Nominal simulation" 3). A torque
sensor's zero of 3 N·m at heating speed is 3 W of 100; a drive's zero moves a little from recording to recording. The
simulation's constants τ_0 and z_0, and what the torque models leave of each recording's mean, tell these zeros. What
the motor torque's model leaves at every moment tells slow noise of its report as well. In that difference is the power
that speeds the motor up, J·ω_m·dω_m/dt, as well, which is no heat. A gain error or a saturation of the reported motor
torque, where one was found, makes the loss wrong in the same way; so may what was found there without a name, if it is
an error of the report and no torque; and what lifts an unbalanced mass is given back. Whether heat flows as if they
were taken off is asked of the temperature itself.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch import criteria
from bench.mismatch.given import Known
from bench.mismatch.orders.shaken import INERTIA
from bench.mismatch.recordings.beginning import at_start, risen
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.bank import RIDGE, Fit
from bench.mismatch.regression.folds import apart
from bench.mismatch.regression.model import Block, ChannelModel, Chosen
from bench.mismatch.regression.nameless_heat import REPORTED_GAIN
from bench.mismatch.regression.problem import NUISANCE, BaseTerm, ChannelProblem, fixed_part
from bench.mismatch.regression.regressors import UNKNOWN
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.heat_rates import HEATING, LESS, TAKEN_OFF
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE

EFFECT, KEY = HEATING, LESS
"""term of a simulation file that says what is taken off, and its key there"""
LOAD, MOTOR, RECORDINGS, LOADS_RECORDINGS, REST, STORED, GAIN, UNNAMED, LIFTED = TAKEN_OFF
WHICH = (LOAD, MOTOR, RECORDINGS, LOADS_RECORDINGS, REST, STORED)
SINGLE = (RECORDINGS, LOADS_RECORDINGS)
"""those that belong to single recordings: of both torques, or of the load torque alone"""
ONE_AT_MOST = (*SINGLE, REST)
"""those of which one is taken off at most: in what the motor torque's model leaves at every moment both of these are"""
REPORTED = {GAIN: REPORTED_GAIN, UNNAMED: UNKNOWN, LIFTED: "load.unbalance"}
"""effects that may be errors of the reported motor torque, or lift a mass: no part of it that is lost. They are asked
for only where they were found
"""
NO_LOSS = {STORED, *REPORTED}
"""parts of the loss, as the nominal simulation calculates it, that may be none"""
CONSTANT = {MOTOR_TORQUE: "motor.torque_offset", LOAD_TORQUE: "load.torque_offset"}
"""term whose constant is a channel's zero"""


class Modelled:
    """The motor torque at the rows of a frame (n,) as a model says it with a fit of some effects, whatever becomes of
    the model later. The frame that was asked last is kept with its values: many sets of zeros ask of the same.
    """

    def __init__(self, model: ChannelModel, fitted: Fit, chosen: Sequence[Chosen]) -> None:
        self._model, self._fitted, self._chosen = model, fitted, chosen
        self._last: tuple[Frame, FloatArray] | None = None

    def __call__(self, frame: Frame) -> FloatArray:
        """N·m at the rows of a frame (n,)."""
        if self._last is None or self._last[0] is not frame:
            fixed = fixed_part(MOTOR_TORQUE, frame, self._model.problem.switched_off)
            self._last = frame, fixed + self._model.predict(frame, self._chosen, self._fitted)
        return self._last[1]


@dataclass(frozen=True, slots=True)
class Zeros:
    """What is taken off (names of :data:`WHICH`, or of :data:`REPORTED`), the constants by channel, each recording's
    own level by channel, N·m; ``reported``: what may be wrong with the reported motor torque, by name of
    :data:`REPORTED`.
    """

    which: tuple[str, ...] = ()
    constant: Mapping[str, float] = field(default_factory=dict)
    levels: Mapping[str, Mapping[int, float]] = field(default_factory=dict)
    reported: Mapping[str, tuple[Known, ...]] = field(default_factory=dict)
    inertia: float = 0.0
    """kg·m² of the motor's shaft, whose energy is :data:`STORED`"""
    modelled: Callable[[Frame], FloatArray] | None = None
    """the motor torque at the rows of a frame (n,) as its model says, where there is one"""

    @property
    def effects(self) -> tuple[str, ...]:
        """Effects of the motor torque's model that are taken off themselves."""
        own = {MOTOR: CONSTANT[MOTOR_TORQUE], STORED: INERTIA, **REPORTED}
        return tuple(own[name] for name in self.which if name in own)

    def of(self, channel: str, constant: str, frame: Frame) -> FloatArray:
        """Zero of a channel at the rows of a frame (n,), N·m."""
        out = np.full(frame.size, self.constant.get(channel, 0.0) if constant in self.which else 0.0)
        if of_recordings(self.which, channel):
            out += _at_rows(self.levels.get(channel, {}), frame)
        if channel == MOTOR_TORQUE:
            if REST in self.which and self.modelled is not None:
                out += np.where(goes_on(frame), frame.motor_torque - self.modelled(frame), 0.0)
            for known in (k for name in self.which for k in self.reported.get(name, ())):
                assert known.coefficients is not None
                out += known.regressor.columns(frame) @ known.coefficients
        return out

    def of_campaign(self, frames: Mapping[str, Frame]) -> dict[str, Frame]:
        """Rows of a campaign by channel, those of the temperature with the loss that is left."""
        return {channel: self.less(f) if channel == TEMPERATURE else f for channel, f in frames.items()}

    def less(self, frame: Frame) -> Frame:
        """The frame with the loss that is left when the zeros are taken off."""
        if not self.which:
            return frame
        sign = np.sign(frame.motor_torque * frame.omega - frame.torque * frame.velocity)
        motor, load = self.of(MOTOR_TORQUE, MOTOR, frame), self.of(LOAD_TORQUE, LOAD, frame)
        stored = self.inertia * frame.kinetic if STORED in self.which else 0.0
        return replace(frame, power=np.abs(sign * frame.power - motor * frame.omega + load * frame.velocity - stored))


def chosen(models: Mapping[str, ChannelModel], problem: ChannelProblem, found: Sequence[Block] = ()) -> Zeros:
    """Which zeros the temperature of the training recordings wants taken off.

    ``models`` of the torque channels that there are; ``problem`` of the temperature with the whole loss; ``found``:
    effects that are fitted beside the simulation, for what is left without them may drown a zero. Each
    recording is left out in turn, and its temperature predicted by the others: fitted to all of them, the heat capacity
    and the cooling make up for a zero that was not taken off, and are wrong for the next recording.
    """
    known = measured(models)
    lacking = {STORED: known.inertia <= 0.0, REST: known.modelled is None}
    names = (*(name for name in WHICH if not lacking.get(name, False)), *known.reported)
    sets = [s for n in range(len(names) + 1) for s in itertools.combinations(names, n)]
    sets = [s for s in sets if len(set(ONE_AT_MOST) & set(s)) < 2]
    tried = [replace(known, which=which) for which in sets]
    return tried[_likeliest(sets, [left_out(problem, zeros, found) for zeros in tried])]


def measured(models: Mapping[str, ChannelModel]) -> Zeros:
    """All zeros as ``models`` of the torque channels tell them, of which none is taken off."""
    constant = {c: _constant(m, CONSTANT[c]) for c, m in models.items()}
    inertia = _constant(models[MOTOR_TORQUE], INERTIA) if MOTOR_TORQUE in models else 0.0
    torques = {c: (m.problem.rows, m.problem.usable) for c, m in models.items()}
    levels = levels_of(torques, lambda channel, frame: models[channel].predict(frame))
    if MOTOR_TORQUE not in models:
        return Zeros((), constant, levels, {}, inertia)
    motor = models[MOTOR_TORQUE]
    return Zeros((), constant, levels, _reported(motor), inertia, Modelled(motor, motor.fit, tuple(motor.chosen)))


def left_out(problem: ChannelProblem, zeros: Zeros, found: Sequence[Block]) -> FloatArray:
    """Weighted squares of each training recording's temperature (recordings,), predicted by the others where ``zeros``
    are taken off the loss and effects that were ``found`` are fitted beside the simulation.
    """
    beside = [BaseTerm(block.regressor, tuple(block.precision)) for block in found]
    rows = replace(problem.rows, frame=zeros.less(problem.rows.frame))
    return _energies(replace(problem, base=(*problem.base, *beside), rows=rows))


def _likeliest(sets: Sequence[Sequence[str]], energies: Sequence[FloatArray]) -> int:
    """Which of some sets of zeros is taken, by the squares that each leaves of the recordings (recordings,).

    Of those that leave no more than the best beyond the standard error of the difference, one with the zero of the load
    torque, which is the sensor's (bench-physics, "Nominal simulation" 4); of these one with the fewest parts of the
    nominal loss that are said to be none (errors of the report, the energy of the shaft); of these the one that leaves
    least: the zeros are measured already, and none is fitted here.
    """
    best = energies[int(np.argmin([energy.sum() for energy in energies]))]
    more = [apart(energy, best) for energy in energies]
    near = [k for k, (beyond, error) in enumerate(more) if beyond <= criteria.ONE_ERROR * error]
    return min(near, key=lambda k: (LOAD not in sets[k], len(set(sets[k]) & NO_LOSS), float(energies[k].sum())))


def of_recordings(which: Sequence[str], channel: str) -> bool:
    """Whether ``which`` zeros have a channel's own level of each recording."""
    return RECORDINGS in which or (channel == LOAD_TORQUE and LOADS_RECORDINGS in which)


def goes_on(frame: Frame) -> NDArray[np.bool_]:
    """Rows that move, and do not stop or turn before the next: of others no mean speed tells the friction."""
    following = np.append(frame.direction[1:], frame.direction[-1:])
    ends = np.append(frame.recording[1:] != frame.recording[:-1], True)
    uniform = ends | (following == frame.direction) | (frame.count <= 1)
    return np.asarray((frame.direction != 0) & uniform)


def of_model(which: Sequence[str]) -> bool:
    """Whether what is taken off depends on what the motor torque's model says, and so on its calibration."""
    return REST in which or of_recordings(which, MOTOR_TORQUE)


def levels_of(
    torques: Mapping[str, tuple[Rows, np.ndarray]], predict: Callable[[str, Frame], FloatArray]
) -> dict[str, dict[int, float]]:
    """Zeros of each recording by channel: what predictions leave of the means of the usable rows of some ``torques``.

    The motor torque is predicted from what the sensor of the load reads. It is asked for without that sensor's zero,
    which would be in its own over the ratio, and be taken off the loss a second time.
    """
    levels: dict[str, dict[int, float]] = {}
    for channel in (LOAD_TORQUE, MOTOR_TORQUE):
        if channel in torques:
            rows, usable = torques[channel]
            zero = _at_rows(levels.get(LOAD_TORQUE, {}), rows.frame)
            frame = replace(rows.frame, torque=rows.frame.torque - zero, torque_level=rows.frame.torque_level - zero)
            levels[channel] = left_of(rows, predict(channel, frame), usable)
    return levels


def _at_rows(levels: Mapping[int, float], frame: Frame) -> FloatArray:
    """Values of recordings at the rows of a frame (n,); 0 in recordings that have none."""
    out = np.zeros(max(int(frame.recording.max(initial=0)), *levels, 0) + 1)
    out[list(levels)] = list(levels.values())
    return np.asarray(out[frame.recording])


def left_of(rows: Rows, predicted: FloatArray, usable: np.ndarray) -> dict[int, float]:
    """Mean of what a prediction leaves of each recording's usable rows, by the recording's number."""
    weight = np.where(usable, rows.number, 0.0)
    count = np.bincount(rows.frame.recording, weight)
    mean = np.bincount(rows.frame.recording, weight * (rows.y - predicted)) / np.maximum(count, 1e-300)
    return {int(r): float(mean[r]) for r in np.flatnonzero(count > 0.0)}


def _constant(model: ChannelModel, effect: str) -> float:
    for block in model.base:
        if block.regressor.effect == effect:
            return float(model.fit.of(block.indices)[0][0])
    return 0.0


def _reported(model: ChannelModel) -> dict[str, tuple[Known, ...]]:
    """What a model of the motor torque says that may be an error of the report, found or given: names of
    :data:`REPORTED`, those that there are.
    """
    blocks = [*model.base, *(block for found in model.chosen for block in found.blocks)]
    known = [Known(block.regressor, model.fit.of(block.indices)[0]) for block in blocks]
    return {name: found for name in REPORTED if (found := reported_by(known, name))}


def reported_by(known: Iterable[Known], name: str) -> tuple[Known, ...]:
    """Those of some known terms that may be the error of a ``name`` of :data:`REPORTED`."""
    return tuple(k for k in known if k.regressor.effect == REPORTED[name] and k.coefficients is not None)


def _energies(problem: ChannelProblem) -> FloatArray:
    """Weighted squares of the training rows' temperatures, each recording predicted from its first readings by the
    simulation calibrated on the others.
    """
    rows, frame = problem.rows, problem.rows.frame
    columns = [t.regressor.columns(frame) for t in problem.base if t.regressor.effect != NUISANCE]
    values = np.column_stack([*columns, rows.y])
    begun = [risen(frame, at_start(frame, v)) for v in values.T]
    values = (values - np.column_stack(begun))[problem.train]
    values = values / np.maximum(np.sqrt(np.mean(values**2, axis=0)), 1e-300)
    weight, recording = rows.number[problem.train], frame.recording[problem.train]
    weighted = weight[:, None] * values
    parts = [values[chunk].T @ weighted[chunk] for chunk in (recording == r for r in np.unique(recording))]
    whole = sum(parts) + RIDGE * weight.sum() * np.eye(values.shape[1])
    out = []
    for part in parts:
        left = whole - part
        weights = np.append(np.linalg.solve(left[:-1, :-1], left[:-1, -1]), -1.0)
        out.append(float(weights @ part @ weights))
    return np.array(out)
