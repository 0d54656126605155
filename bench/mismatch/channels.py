"""The four compared channels: what is taken off before the regression, which rows count, and what one channel tells
another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.bank import Bank
from bench.mismatch.columns import layout
from bench.mismatch.dataset import Dataset
from bench.mismatch.linear import ChannelModel, analyse, columns_of, predict, starts_and_folds
from bench.mismatch.motor_ripple import Ripple
from bench.mismatch.motor_ripple import search as search_ripples
from bench.mismatch.noise import estimate
from bench.mismatch.rows import Rows
from bench.mismatch.transmission import TransmissionModel, analyse_transmission
from bench.simulation.frame import FloatArray, IntArray
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR, Form, Point, Term

SENSOR_ERRORS = (
    "sensor.torque_gain",
    "sensor.torque_zero_temperature",
    "sensor.torque_nonlinearity",
    "sensor.torque_hysteresis",
)
Known = tuple[Term, Form, Point]


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


def analyse_channels(
    data: Dataset,
    orders: Sequence[float],
    switched_off: Sequence[str],
    known: dict[str, tuple[Known, ...]],
    channels: Sequence[str],
) -> Analysis:
    """Search every channel asked for; the load torque first, because the others use it."""
    fold_of = np.array([m.fold for m in data.members], dtype=np.int64)
    index = np.array([m.index for m in data.members])
    lookup = np.full(int(index.max()) + 1, -1, dtype=np.int64)
    lookup[index] = fold_of
    out = Analysis()
    error: FloatArray | None = None
    if LOAD_TORQUE in channels and LOAD_TORQUE in data.slow:
        rows = data.slow[LOAD_TORQUE]
        off = np.zeros(rows.y.size) if "load.reaction" in switched_off else rows.frame.load_motor_torque
        model = analyse(
            LOAD_TORQUE,
            replace(rows, y=rows.y - off),
            rows.frame.direction != 0,
            lookup,
            switched_off,
            known.get(LOAD_TORQUE, ()),
        )
        out.models[LOAD_TORQUE] = model
        error = _sensor_error(model)
    if MOTOR_TORQUE in channels and MOTOR_TORQUE in data.slow:
        _motor_torque(out, data, lookup, switched_off, known.get(MOTOR_TORQUE, ()), error)
        train = {m.index for m in data.members if not m.held_out}
        out.ripples = search_ripples(data.shaft, train)
    if TEMPERATURE in channels and data.heat is not None:
        _temperature(out, data, lookup, switched_off, known.get(TEMPERATURE, ()))
    if TRANSMISSION_ERROR in channels and data.angle is not None:
        out.transmission = analyse_transmission(
            _corrected(out, data.angle), lookup, orders, switched_off, known.get(TRANSMISSION_ERROR, ())
        )
        out.models[TRANSMISSION_ERROR] = out.transmission.offset
    return out


def _sensor_error(model: ChannelModel) -> FloatArray | None:
    """The torque sensor's error at the model's rows, as far as named terms say it."""
    terms = [f for f in model.found if f.entry.effect in SENSOR_ERRORS]
    if not terms:
        return None
    return np.asarray(
        sum(columns_of(LOAD_TORQUE, f.entry, model.rows.frame) @ f.coefficients for f in terms), dtype=np.float64
    )


def _corrected(out: Analysis, rows: Rows) -> Rows:
    """Rows whose torque is what acts at the gearbox: the sensor's reading less its error, where that has been found."""
    load = out.models.get(LOAD_TORQUE)
    sensor = [f for f in load.found if f.entry.effect in SENSOR_ERRORS] if load is not None else []
    if not sensor or not (out.traced or out.trace is None):
        return rows
    error = np.asarray(sum(columns_of(LOAD_TORQUE, f.entry, rows.frame) @ f.coefficients for f in sensor))
    power = np.abs(rows.frame.power + error * rows.frame.velocity)
    return replace(rows, frame=replace(rows.frame, torque=rows.frame.torque - error, power=power))


def _motor_torque(
    out: Analysis,
    data: Dataset,
    fold_of: IntArray,
    switched_off: Sequence[str],
    known: tuple[Known, ...],
    error: FloatArray | None,
) -> None:
    rows = data.slow[MOTOR_TORQUE]
    frame = rows.frame
    off = np.zeros(rows.y.size) if "motor.load_reaction" in switched_off else frame.torque / frame.ratio
    moving = frame.direction != 0
    banned = [e for e in SENSOR_ERRORS]
    if error is not None and error.size == frame.size:
        out.trace = _trace(replace(rows, y=rows.y - off), moving, fold_of, switched_off, known, -error / frame.ratio)
        coefficient, deviation = out.trace
        out.traced = abs(coefficient - 1.0) < max(0.4, 3.0 * deviation) and abs(coefficient) > 2.5 * deviation
        if out.traced:
            # the torque at the gearbox is what the sensor reads less its error
            off = off - error / frame.ratio
            rows = replace(rows, frame=replace(frame, torque=frame.torque - error))
    out.models[MOTOR_TORQUE] = analyse(
        MOTOR_TORQUE, replace(rows, y=rows.y - off), moving, fold_of, switched_off, known, banned
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
    whole = layout(MOTOR_TORQUE, own.frame, switched_off, known)
    starts, folds = starts_and_folds(own.frame, fold_of)
    noise = estimate(MOTOR_TORQUE, own, whole, starts, folds)
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
    return np.asarray(np.where(total > 0, mean, 0.0))


def _temperature(
    out: Analysis, data: Dataset, fold_of: IntArray, switched_off: Sequence[str], known: tuple[Known, ...]
) -> None:
    assert data.heat is not None
    rows = data.heat
    rows = _corrected(out, rows)
    motor = out.models.get(MOTOR_TORQUE)
    if motor is not None:
        power = np.abs(rows.frame.power - _wandering_zero(motor)[rows.frame.recording] * rows.frame.omega)
        rows = replace(rows, frame=replace(rows.frame, power=power))
    everywhere = np.ones(rows.y.size, dtype=bool)
    out.models[TEMPERATURE] = analyse(TEMPERATURE, rows, everywhere, fold_of, switched_off, known)
