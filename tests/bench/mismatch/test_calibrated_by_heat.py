"""The heat tells the friction more exactly than a motor torque whose zero differs from recording to recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.calibrated_by_heat import CalibrationHeat, calibrated
from bench.mismatch.power_zeros import MOTOR, RECORDINGS, REST, STORED, Zeros, left_out, measured
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.model import ChannelModel
from bench.mismatch.regression.problem import ChannelProblem, nominal_base
from bench.mismatch.regression.search import begun
from bench.simulation.terms import MOTOR_TORQUE
from tests.bench.mismatch.test_power_zeros import CAPACITY, LOSS, RATIO, RECORDINGS_MADE, heated, problem

COULOMB, BY_LOAD = 0.3, 1e-3
"""N·m, and N·m at the motor per N·m of the load"""
ZERO = 0.03
"""N·m, root mean square of the zeros of recordings"""


def recorded(seed: int = 3) -> Rows:
    """Heating runs whose loss is friction that grows with the load, with a zero of the motor torque in each."""
    rows, zeros = heated(0.0), np.random.default_rng(seed).normal(0.0, ZERO, RECORDINGS_MADE)
    frame = rows.frame
    # at one speed alone Coulomb friction would be a constant power, as warmer surroundings are
    frame = replace(frame, velocity=frame.velocity * np.linspace(0.4, 1.0, RECORDINGS_MADE)[frame.recording])
    friction = LOSS[frame.recording] / np.abs(frame.omega)
    torque = (friction - COULOMB) / BY_LOAD
    read = frame.direction * friction + torque / RATIO + zeros[frame.recording]
    power = np.abs(read * frame.omega - torque * frame.velocity)
    return replace(rows, frame=replace(frame, torque=torque, motor_torque=read, power=power))


def calibrated_torque(rows: Rows) -> ChannelModel:
    """The model of the motor torque: two laws of friction, calibrated beside the zeros."""
    base = [t for t in nominal_base(MOTOR_TORQUE, ()) if t.regressor.effect.endswith(("coulomb", "load_dependent"))]
    noise = np.random.default_rng(6).normal(0.0, 1e-3, rows.size)
    own = replace(rows, y=rows.frame.motor_torque - rows.frame.torque / RATIO + noise)
    folds = np.arange(RECORDINGS_MADE) % 5
    model = begun(ChannelProblem(MOTOR_TORQUE, own, np.ones(rows.size, dtype=bool), folds, tuple(base))).model
    model.compare_recordings()
    return model


def heat_balance(rows: Rows, zeros: Zeros, torque: ChannelModel) -> ChannelModel:
    """The model of the temperature beside what the calibration of a torque is unsure by, less some zeros."""
    own = problem(replace(rows, frame=zeros.less(rows.frame)))
    asked = CalibrationHeat(torque, whole=REST in zeros.which, less=zeros.effects)
    return begun(replace(own, base=(*own.base, asked.term(CAPACITY)))).model


def growth(model: ChannelModel) -> float:
    """By what share of Coulomb friction the friction grows with the load, 1/(N·m)."""
    coulomb, by_load = (float(model.fit.of(b.indices)[0][0]) for b in model.base)
    return by_load / RATIO / coulomb


@pytest.mark.parametrize("less", [RECORDINGS, REST])
def test_the_heat_moves_the_calibration_to_where_it_is(less: str) -> None:
    rows = recorded()
    torque = calibrated_torque(rows)
    before, own = growth(torque), torque.fit
    models = {MOTOR_TORQUE: torque}
    levels = replace(measured(models), which=(less,))
    heat = heat_balance(rows, levels, torque)
    moved = calibrated(heat, problem(rows), levels, models)
    assert moved is not None
    # the heat tells how the friction is divided; all of it may as well be another heat capacity
    off = abs(before - BY_LOAD / COULOMB), abs(growth(torque) - BY_LOAD / COULOMB)
    assert off[1] < 0.2 * off[0]
    assert left_out(problem(rows), moved, ()).sum() < left_out(problem(rows), levels, ()).sum()
    # what the torque alone says is kept: its residual is tested on that
    assert np.array_equal(torque.by_itself().fit.coefficients, own.coefficients)
    assert torque.refitted([]).coefficients == pytest.approx(torque.fit.coefficients)


def test_a_model_without_some_of_what_was_moved_follows_the_moved_prediction() -> None:
    """Coulomb friction alone, of two laws that were moved against each other."""
    rows = recorded()
    torque = calibrated_torque(rows)
    coulomb, by_load = torque.base
    moves = np.array([0.2, -0.3])
    columns = np.hstack([b.regressor.columns(rows.frame) for b in torque.base])
    torque.moved = dict(zip([*coulomb.indices, *by_load.indices], moves.tolist(), strict=True))
    own = replace(torque.problem.rows, y=torque.problem.rows.y + columns @ moves)
    other = begun(replace(torque.problem, rows=own)).model
    expected = replace(other, base=[other.base[0]]).refitted([]).coefficients
    assert replace(torque, base=[coulomb]).refitted([]).coefficients == pytest.approx(expected, rel=1e-4)
    assert replace(torque, moved={}, base=[coulomb]).refitted([]).coefficients != pytest.approx(expected, rel=1e-2)


def test_what_is_taken_off_itself_moves_nothing() -> None:
    """The constant of the motor torque is in its model, and taken off the loss beside it."""
    rows = recorded()
    zeros = replace(measured({MOTOR_TORQUE: calibrated_torque(rows)}), which=(MOTOR, REST, STORED))
    assert set(zeros.effects) == {"motor.torque_offset", "motor.inertia"}
    torque = calibrated_torque(rows)
    asked = CalibrationHeat(torque, whole=True, less=("friction.coulomb",))
    assert asked.indices == list(torque.base[1].indices)


def test_heat_that_says_nothing_moves_nothing() -> None:
    """Without the zeros of recordings no loss depends on the calibration."""
    rows = recorded()
    torque = calibrated_torque(rows)
    models = {MOTOR_TORQUE: torque}
    assert calibrated(begun(problem(rows)).model, problem(rows), measured(models), models) is None
    assert not torque.moved


def test_a_calibration_stays_where_recordings_left_out_are_predicted_worse() -> None:
    """Zeros that are none: the loss as read is right, and what the calibration says of the means takes from it."""
    rows = recorded()
    torque = calibrated_torque(rows)
    models = {MOTOR_TORQUE: torque}
    levels = replace(measured(models), which=(RECORDINGS,))
    heat = heat_balance(rows, levels, torque)
    block = next(b for b in heat.base if isinstance(b.regressor, CalibrationHeat))
    wrong = heat.fit.coefficients.copy()
    wrong[[heat.fit.index.index(i) for i in block.indices]] *= -20.0
    heat.fit = replace(heat.fit, coefficients=wrong)
    own = growth(torque)
    assert calibrated(heat, problem(rows), levels, models) is None
    assert growth(torque) == own
