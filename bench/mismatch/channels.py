"""The four compared channels: what is taken off before the regression, which rows count, and what one channel tells
another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.bank import Bank
from bench.mismatch.chosen_forms import Known, chosen_forms, training
from bench.mismatch.columns import ZERO_TORQUE, layout
from bench.mismatch.dataset import Dataset
from bench.mismatch.given import Given
from bench.mismatch.harmonics import Harmonics
from bench.mismatch.linear import (
    ChannelModel,
    analyse,
    columns_at,
    known_coefficients,
    predict,
    released,
    starts_and_folds,
)
from bench.mismatch.motor_ripple import Ripple, without
from bench.mismatch.motor_ripple import search as search_ripples
from bench.mismatch.noise import estimate
from bench.mismatch.rows import Rows
from bench.mismatch.transmission import TransmissionModel, analyse_transmission
from bench.mismatch.wander import wander
from bench.simulation.frame import FloatArray, Frame, IntArray
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR

SENSOR_ERRORS = (
    "sensor.torque_gain",
    "sensor.torque_zero_temperature",
    "sensor.torque_nonlinearity",
    "sensor.torque_hysteresis",
)

ANGULAR = ("load.unbalance", "friction.position_dependent")
"""terms periodic in the output angle: a linear axis has none"""


@dataclass(slots=True)
class Analysis:
    """Models of the channels, and what the torque sensor's error leaves in the motor torque (coefficient, standard
    deviation).
    """

    models: dict[str, ChannelModel] = field(default_factory=dict)
    transmission: TransmissionModel | None = None
    trace: tuple[float, float] | None = None
    traced: bool = False
    ripples: list[Ripple] = field(default_factory=list)

    @property
    def harmonics(self) -> Harmonics | None:
        """What is periodic in the transmission error, where that was compared and revolutions calibrate it."""
        return None if self.transmission is None else self.transmission.harmonics


def analyse_channels(
    data: Dataset,
    given: Given,
    channels: Sequence[str],
) -> Analysis:
    """Search every channel asked for; the load torque first, because the others use it."""
    switched_off = given.switched_off
    fold_of = np.array([m.fold for m in data.members], dtype=np.int64)
    index = np.array([m.index for m in data.members])
    lookup = np.full(int(index.max()) + 1, -1, dtype=np.int64)
    lookup[index] = fold_of
    out = Analysis()
    if LOAD_TORQUE in channels and LOAD_TORQUE in data.slow:
        rows = data.slow[LOAD_TORQUE]
        off = np.zeros(rows.y.size) if "load.reaction" in switched_off else rows.frame.load_motor_torque
        model = analyse(
            LOAD_TORQUE,
            replace(rows, y=rows.y - off),
            rows.frame.direction != 0,
            lookup,
            switched_off,
            _known(LOAD_TORQUE, data.slow[LOAD_TORQUE], lookup, given, off),
        )
        out.models[LOAD_TORQUE] = released(model)
    if MOTOR_TORQUE in channels and MOTOR_TORQUE in data.slow:
        _motor_torque(out, data, lookup, given)
        train = {m.index for m in data.members if not m.held_out}
        shaft = [] if data.linear else data.shaft
        out.ripples = search_ripples([without(s, given.ripples) for s in shaft], train)
    if TEMPERATURE in channels and data.heat is not None:
        _temperature(out, data, lookup, given)
    if TRANSMISSION_ERROR in channels and data.angle is not None:
        angle = _corrected(out, data.angle)
        known = _known(TRANSMISSION_ERROR, angle, lookup, given)
        out.transmission = analyse_transmission(angle, lookup, given.orders, switched_off, known, given.periodic)
        out.models[TRANSMISSION_ERROR] = out.transmission.offset
    return out


def _known(
    channel: str, rows: Rows, fold_of: IntArray, given: Given, taken_off: FloatArray | None = None
) -> tuple[Known, ...]:
    """Terms of the given simulation in a channel, those without numbers chosen on the recordings."""
    terms = given.known.get(channel, ())
    if channel == MOTOR_TORQUE:
        terms = tuple(t for t in terms if t.term.effect not in SENSOR_ERRORS)
    y = rows.y if taken_off is None else rows.y - taken_off
    return chosen_forms(channel, training(replace(rows, y=y), fold_of), fold_of, given.switched_off, terms)


def _sensor_error(model: ChannelModel, frame: Frame) -> FloatArray | None:
    """The torque sensor's error at the rows of a frame, as far as the model of the load torque says it, found or of the
    simulation.
    """
    named = [f for f in model.found if f.entry.effect in SENSOR_ERRORS]
    # a named term's coefficients are fitted without the free function that may stand beside it
    chosen = named or [f for f in model.found if f.entry.effect == "unknown"]
    parts = [columns_at(model, f.entry, frame) @ f.coefficients for f in chosen]
    for (term, form, point), coefficients in zip(model.known, known_coefficients(model), strict=True):
        if term.effect in SENSOR_ERRORS:
            parts.append(form.columns(frame, point) @ coefficients)
    return np.asarray(np.sum(parts, axis=0)) if parts else None


def _corrected(out: Analysis, rows: Rows) -> Rows:
    """Rows whose torque is what acts at the gearbox: the sensor's reading less its error, where that has been found."""
    load = out.models.get(LOAD_TORQUE)
    error = _sensor_error(load, rows.frame) if load is not None else None
    if error is None or not (out.traced or out.trace is None):
        return rows
    power = np.abs(rows.frame.power + error * rows.frame.velocity)
    return replace(rows, frame=replace(rows.frame, torque=rows.frame.torque - error, power=power))


def _motor_torque(
    out: Analysis,
    data: Dataset,
    fold_of: IntArray,
    given: Given,
) -> None:
    switched_off = given.switched_off
    rows = data.slow[MOTOR_TORQUE]
    frame = rows.frame
    off = np.zeros(rows.y.size) if "motor.load_reaction" in switched_off else frame.torque / frame.ratio
    moving = frame.direction != 0
    known = _known(MOTOR_TORQUE, rows.take(moving), fold_of, given, off[moving])
    banned = [*SENSOR_ERRORS, *(ANGULAR if data.linear else ())]
    load = out.models.get(LOAD_TORQUE)
    error = _sensor_error(load, frame) if load is not None else None
    if error is not None:
        out.trace = _trace(replace(rows, y=rows.y - off), moving, fold_of, switched_off, known, -error / frame.ratio)
        coefficient, deviation = out.trace
        out.traced = abs(coefficient - 1.0) < max(0.4, 3.0 * deviation) and abs(coefficient) > 2.5 * deviation
        if out.traced:
            # the torque at the gearbox is what the sensor reads less its error
            off = off - error / frame.ratio
            rows = replace(rows, frame=replace(frame, torque=frame.torque - error))
    out.models[MOTOR_TORQUE] = released(
        analyse(MOTOR_TORQUE, replace(rows, y=rows.y - off), moving, fold_of, switched_off, known, banned)
    )


def _trace(
    rows: Rows,
    usable: NDArray[np.bool_],
    fold_of: IntArray,
    switched_off: Sequence[str],
    known: tuple[Known, ...],
    column: FloatArray,
) -> tuple[float, float]:
    """How much of the sensor's error the motor torque carries (1: all of it), and the standard deviation of that."""
    used = usable & (fold_of[rows.frame.recording] >= 0) & (rows.number > 0)
    own = rows.take(used)
    whole = layout(MOTOR_TORQUE, own.frame, switched_off, known, with_named=False)
    starts, folds = starts_and_folds(own.frame, fold_of)
    noise = estimate(MOTOR_TORQUE, own, whole, starts)
    columns = np.column_stack([whole.columns[:, list(whole.base)], column[used]])
    size = columns.shape[1]
    prior = np.append(whole.prior[list(whole.base)], 0.0)
    fit = Bank(own.y, starts, folds, columns, prior, noise).fit(range(size), leave_out=False)
    return float(fit.coefficients[-1]), float(np.sqrt(fit.covariance[-1, -1]))


def _wandering_zero(model: ChannelModel) -> FloatArray:
    """Zero of the motor torque in each recording (by index), from what the model leaves of it on the mean; shrunk by
    its noise.
    """
    rows = model.rows
    left = np.where(rows.frame.direction != 0, rows.y - predict(model, rows.frame), 0.0)
    weight = np.where((rows.frame.direction != 0) & (rows.number > 0), rows.number, 0.0)
    size = int(rows.frame.recording.max()) + 1
    total = np.bincount(rows.frame.recording, weight, size)
    mean = np.bincount(rows.frame.recording, left * weight, size) / np.maximum(total, 1.0)
    # more than a zero can wander is torque that no term explains, and it heats
    return np.asarray(np.where(total > 0, np.clip(mean, -3.0 * ZERO_TORQUE, 3.0 * ZERO_TORQUE), 0.0))


def _wanders(model: ChannelModel) -> bool:
    """Whether something slow is left in a channel: a torque that comes and goes is felt, and no zero that is off."""
    rows = model.rows
    variance = float(np.median(rows.within[model.used]))
    return wander(rows.y - predict(model, rows.frame), rows.frame, model.used, variance) is not None


def _temperature(out: Analysis, data: Dataset, fold_of: IntArray, given: Given) -> None:
    assert data.heat is not None
    rows = data.heat
    rows = _corrected(out, rows)
    motor = out.models.get(MOTOR_TORQUE)
    if motor is not None and not _wanders(motor):
        power = np.abs(rows.frame.power - _wandering_zero(motor)[rows.frame.recording] * rows.frame.omega)
        rows = replace(rows, frame=replace(rows.frame, power=power))
    everywhere = np.ones(rows.y.size, dtype=bool)
    known = _known(TEMPERATURE, rows, fold_of, given)
    out.models[TEMPERATURE] = released(analyse(TEMPERATURE, rows, everywhere, fold_of, given.switched_off, known))
