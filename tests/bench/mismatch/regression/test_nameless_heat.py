"""What the motor torque has without a name may be an error of its report: the heat is asked beside it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.model import Chosen, add_block
from bench.mismatch.regression.nameless import NamelessCourse
from bench.mismatch.regression.nameless_heat import gain_heat, nameless_heat, sensor_heat
from bench.mismatch.regression.problem import NUISANCE
from bench.mismatch.regression.regressors import Free, named
from bench.mismatch.regression.search import begun
from bench.simulation.tables import Grid
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE
from tests.bench.mismatch.regression.synthetic import campaign, problem


def test_heat_without_a_name_is_that_of_the_function_and_of_what_is_left() -> None:
    frame = campaign()
    report = 0.1 * np.sign(frame.temperature - 30.0)
    y = 0.5 * frame.direction + report + np.random.default_rng(1).normal(0.0, 0.001, frame.size)
    frame = replace(frame, motor_torque=y, torque=np.zeros(frame.size))
    own = problem(frame, y)
    search = begun(own)
    table = Free(MOTOR_TORQUE, (Grid(("temperature",), "1", ((22.0, 26.0, 29.9, 30.1, 34.0, 40.0),)),))
    function = Chosen(add_block(own, search.model.bank, table, 1e-3))
    churn = Chosen(add_block(own, search.model.bank, named("friction.viscous_quadratic", MOTOR_TORQUE, "square")))
    model = replace(search.model, chosen=[function, churn], fit=search.model.refitted([function, churn]))
    (term,) = nameless_heat(model, 2.0e4)
    assert term.regressor.effect == NUISANCE
    told, left = term.regressor.columns(frame).T
    sign = np.sign(y * frame.omega)
    course = NamelessCourse.of(model).at(frame)
    assert np.corrcoef(course, report)[0, 1] > 0.95
    for number in (0, 7, 23):
        rows = frame.recording == number
        power = (sign * course * frame.omega)[rows]
        heat = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * frame.step[rows][1:])])
        assert np.allclose(told[rows], heat)
    assert np.abs(left).max() < 0.1 * np.abs(told).max()
    assert nameless_heat(replace(model, chosen=[churn], fit=model.refitted([churn])), 2.0e4) == ()


def test_heat_of_a_gain_error_may_be_as_much_as_its_form_is_off() -> None:
    frame = campaign()
    y = 0.5 * frame.direction + 0.03 * frame.torque / 185.0
    frame = replace(frame, motor_torque=y)
    own = problem(frame, y)
    search = begun(own)
    gain = Chosen(add_block(own, search.model.bank, named("motor.torque_constant", MOTOR_TORQUE, "gain")))
    model = replace(search.model, chosen=[gain], fit=search.model.refitted([gain]))
    (term,) = gain_heat(model, 2.0e4)
    assert term.regressor.effect == NUISANCE
    assert term.precision == (2.0e4**2,) * 2
    unsure, form = term.regressor.columns(frame).T
    rows = frame.recording == 7
    power = np.sign(y * frame.omega - frame.torque * frame.velocity) * model.contribution(gain, frame) * frame.omega
    rises = 0.5 * (power[rows][1:] + power[rows][:-1]) * frame.step[rows][1:]
    assert np.allclose(form[rows], criteria.SHAPE * np.concatenate([[0.0], np.cumsum(rises)]))
    assert np.any(form[rows])
    value, covariance = model.fit.of(gain.main.indices)
    ratio = float(np.sqrt(covariance[0, 0])) / float(value[0])
    assert np.allclose(np.abs(unsure * criteria.SHAPE), np.abs(form * ratio))
    assert gain_heat(replace(model, chosen=[]), 2.0e4) == ()
    assert len(gain_heat(replace(model, chosen=[], base=[*model.base, gain.main]), 2.0e4)) == 1


def test_heat_of_an_error_of_the_torque_sensor_is_what_it_is_unsure_by_and_its_form_is_off_by() -> None:
    frame = campaign()
    frame = replace(frame, load_motor_torque=frame.torque, load_motor_level=frame.torque)
    rng = np.random.default_rng(3)
    own = replace(problem(frame, 0.03 * frame.torque + rng.normal(0.0, 0.5, frame.size)), channel=LOAD_TORQUE)
    search = begun(own)
    gain = Chosen(add_block(own, search.model.bank, named("sensor.torque_gain", LOAD_TORQUE, "gain")))
    model = replace(search.model, chosen=[gain], fit=search.model.refitted([gain]))
    (term,) = sensor_heat(model, [gain.main.regressor], 2.0e4)
    assert term.regressor.effect == NUISANCE
    assert term.precision == (2.0e4**2,) * 2
    unsure, form = term.regressor.columns(frame).T
    rows = frame.recording == 7
    power = (model.contribution(gain, frame) * frame.velocity)[rows]
    rises = 0.5 * (power[1:] + power[:-1]) * frame.step[rows][1:]
    assert np.any(form[rows])
    assert np.allclose(form[rows], criteria.SHAPE * np.concatenate([[0.0], np.cumsum(rises)]))
    value, covariance = model.fit.of(gain.main.indices)
    ratio = float(np.sqrt(covariance[0, 0])) / float(value[0])
    assert np.allclose(np.abs(unsure * criteria.SHAPE), np.abs(form * ratio))
    # an error of the load motor's report was taken off nothing
    assert sensor_heat(model, [], 2.0e4) == ()
