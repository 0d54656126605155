"""What the load torque has without a name may be an error of its sensor: the transmission error is asked beside it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from bench.mismatch.regression.model import ChannelModel, Chosen, add_block
from bench.mismatch.regression.nameless import NamelessCourse
from bench.mismatch.regression.nameless_load import nameless_load
from bench.mismatch.regression.problem import NUISANCE, BaseTerm, Untold
from bench.mismatch.regression.regressors import Free, named
from bench.mismatch.regression.search import begun, searched
from bench.mismatch.unnamed.formula_regressor import Equation
from bench.simulation.formulas import Formula
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.tables import Grid
from bench.simulation.terms import MOTOR_TORQUE
from tests.bench.mismatch.regression.synthetic import campaign, problem


@dataclass(frozen=True, slots=True, eq=False)
class Nuisance(Untold):
    """A course that another channel has without a name."""

    course: FloatArray

    def columns(self, _: Frame) -> FloatArray:
        return self.course[:, None]


def test_the_twist_of_what_has_no_name_is_a_column_of_its_own() -> None:
    frame = campaign()
    jump = 3.0 * (frame.temperature > 30.0)
    own = problem(frame, jump + np.random.default_rng(1).normal(0.0, 0.01, frame.size))
    search = begun(own)
    table = Free(MOTOR_TORQUE, (Grid(("temperature",), "1", ((22.0, 29.9, 30.1, 40.0),)),))
    function = Chosen(add_block(own, search.model.bank, table, 1e-3))
    churn = Chosen(add_block(own, search.model.bank, named("friction.viscous_quadratic", MOTOR_TORQUE, "square")))
    model = replace(search.model, chosen=[function, churn], fit=search.model.refitted([function, churn]))
    (term,) = nameless_load(model)
    assert term.regressor.effect == NUISANCE
    column, averaged = term.regressor.columns(frame).T
    assert np.all(averaged == 0.0)  # nowhere is the load kept at a level
    course = model.contribution(function, frame)
    said = np.hstack([b.regressor.columns(frame) for b in model.base])
    assert np.allclose(column, course - said @ np.linalg.lstsq(said, course, rcond=None)[0], atol=1e-6)
    assert np.ptp(column) > 2.0
    assert nameless_load(replace(model, chosen=[churn], fit=model.refitted([churn]))) == ()


def test_what_changes_where_the_load_is_kept_shows_a_load_and_the_mean_an_error() -> None:
    """The torque that the simulation is given there is the segment's mean: an error of the sensor is its own mean."""
    frame = campaign()
    drift = 3.0 * frame.elapsed / frame.elapsed.max()
    own = problem(frame, drift + np.random.default_rng(1).normal(0.0, 0.01, frame.size))
    search = begun(own)
    table = Free(MOTOR_TORQUE, (Grid(("seconds",), "1", ((0.0, float(frame.elapsed.max())),)),))
    function = Chosen(add_block(own, search.model.bank, table, 1e-3))
    model = replace(search.model, chosen=[function], fit=search.model.refitted([function]))
    (term,) = nameless_load(model, 1.0 / 185.0)
    assert term.precision == (185.0**2,) * 2
    kept = replace(frame, kept=np.ones(frame.size), followed=np.zeros(frame.size))
    mean, averaged = term.regressor.columns(kept).T
    whole = NamelessCourse.of(model).at(kept)
    assert mean + averaged == pytest.approx(whole, abs=1e-12)
    for number in np.unique(frame.recording):
        rows = frame.recording == number
        assert np.ptp(mean[rows]) < 1e-9
        assert np.average(averaged[rows], weights=frame.count[rows]) == pytest.approx(0.0, abs=1e-9)
    assert np.ptp(averaged) > 2.0
    # where the torque follows all that the sensor reads nothing is averaged out, not even by rounding
    assert np.all(term.regressor.columns(replace(kept, followed=np.ones(frame.size)))[:, 1] == 0.0)


def test_a_part_that_the_simulation_has_is_no_part_of_it() -> None:
    """A formula with a constant beside Coulomb friction: nothing tells the one from the other."""
    frame = campaign()
    speed = np.abs(frame.velocity)
    brake = 8.0 * speed / (1.0 + (speed / 0.3) ** 2)
    own = problem(frame, frame.direction * (0.6 + brake) + np.random.default_rng(1).normal(0.0, 0.01, frame.size))
    search = begun(own)
    formula = Formula(("speed",), ((0.0, 2.0),), (("d", "1"), ("d", "x1/(1 + (x1/s1)**2)")), (("s1", 0.3),))
    function = Chosen(add_block(own, search.model.bank, Equation(MOTOR_TORQUE, formula, ("N*m", "N*m*s/rad"))))
    model = replace(search.model, chosen=[function], fit=search.model.refitted([function]))
    friction = frame.direction.astype(float)
    constant = model.fit.of(function.main.indices)[0][0]
    assert constant > 0.1  # as much of the constant as the fit happens to give it
    column = NamelessCourse.of(model).at(frame)
    said = np.hstack([b.regressor.columns(frame) for b in model.base])
    left = brake * friction
    left = left - said @ np.linalg.lstsq(said, left, rcond=None)[0]
    assert np.allclose(column, left, atol=0.1 * np.abs(left).max())


def test_what_has_no_name_elsewhere_and_is_nothing_here_does_not_calibrate_the_simulation() -> None:
    """It stands in no file: beside it the simulation would be calibrated, and used without it."""
    frame = campaign()
    known = problem(frame, 2.0 * frame.direction + 0.1 * frame.omega)
    rng = np.random.default_rng(3)
    table = Free(MOTOR_TORQUE, (Grid(("speed",), "d", ((0.003, 0.05, 0.17),)),))
    course = table.columns(frame) @ np.array([0.0, 0.4, 1.0])

    def found(size: float) -> ChannelModel:
        y = known.rows.y + size * course + rng.normal(0.0, 0.01, frame.size)
        extra = BaseTerm(Nuisance(course))
        return searched(replace(known, rows=replace(known.rows, y=y), base=(*known.base, extra))).model

    assert NUISANCE not in {b.regressor.effect for b in found(0.0).base}
    assert NUISANCE in {b.regressor.effect for b in found(0.5).base}
