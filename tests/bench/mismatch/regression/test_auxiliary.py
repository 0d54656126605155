"""A dependence on a quantity that is no channel of the bench is found, told by its name, and written as a table."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.errors import ConfigurationError
from bench.mismatch.given import Given
from bench.mismatch.prediction import Predictor
from bench.mismatch.regression.auxiliary import auxiliary_candidates
from bench.mismatch.regression.discoveries import rows_of
from bench.mismatch.regression.regressors import UNKNOWN, Free
from bench.mismatch.regression.search import searched
from bench.simulation.frame import FloatArray, Frame, concatenate
from bench.simulation.model import Simulation
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE
from tests.bench.mismatch.regression.synthetic import EACH, RATIO, campaign, problem
from tests.bench.mismatch.regression.test_free_motion import asked, swinging

CONTENT = {"format": "bench-simulation", "format_version": "1.0", "gearbox": {"ratio": RATIO}}
SIGMA = 0.02
SLOPE = 0.12e-5
"""N·m of drag a pascal"""


def under_pressure(seed: int = 3) -> tuple[Frame, FloatArray, FloatArray]:
    """The made-up campaign with an oil pressure, its motor torque, and what of that the pressure makes (n,)."""
    frame = campaign(12)
    rng = np.random.default_rng(seed)
    pressure = 3e5 + 1e5 * np.sin(0.21 * np.arange(frame.size))
    frame = replace(frame, aux={"oil": pressure, "idle": np.full(frame.size, 7.0)})
    drag = SLOPE * (pressure - 3e5) * frame.direction
    friction = 0.5 * frame.direction + 0.006 * frame.omega
    return frame, friction + drag + rng.normal(0.0, SIGMA, frame.size), drag


def test_each_that_varies_is_asked_straight_and_free_with_every_factor() -> None:
    frame, _, _ = under_pressure()
    found = list(auxiliary_candidates(MOTOR_TORQUE, frame))
    assert {f.variables for f in found} == {("aux/oil",)}  # the idle one never varies
    assert {(f.grids[0].times, f.grids[0].size) for f in found} >= {("d", 2), ("w", 2), ("1", 2), ("d", 6)}
    assert found[0].words == "a straight line over aux/oil, times d"


def test_a_quantity_without_a_number_is_not_asked() -> None:
    frame, _, _ = under_pressure()
    assert not list(auxiliary_candidates(MOTOR_TORQUE, replace(frame, aux={"oil": np.full(frame.size, np.nan)})))


def test_a_factor_that_never_changes_is_not_asked() -> None:
    frame, _, _ = under_pressure()
    alike = replace(frame, torque_level=np.full(frame.size, 300.0))
    assert all("abs_tau" not in f.grids[0].times for f in auxiliary_candidates(MOTOR_TORQUE, alike))


def test_drag_that_grows_with_a_pressure_is_found_and_predicted_from_the_file() -> None:
    frame, torque, drag = under_pressure()
    search = searched(replace(problem(frame, torque), banned=tuple(LIBRARY)))
    (own,) = search.model.chosen
    regressor = own.main.regressor
    assert isinstance(regressor, Free)
    assert own.effect == UNKNOWN
    assert regressor.variables == ("aux/oil",)
    assert regressor.grids[0].times == "d"
    (row,) = rows_of(search.model, own)
    assert row["over"] == ["aux/oil"]
    predictor = Predictor(Given.of(Simulation.from_json(CONTENT | {"terms": [row]})))
    said = predictor.channel(MOTOR_TORQUE, frame)
    plain = predictor.channel(MOTOR_TORQUE, replace(frame, aux={"oil": np.full(frame.size, 3e5)}))
    assert np.std(said - plain - drag) < 0.1 * np.std(drag)
    with pytest.raises(ConfigurationError, match="no quantity 'aux/oil'"):
        predictor.channel(MOTOR_TORQUE, replace(frame, aux={}))


def test_a_cylinder_whose_seals_grip_with_the_pressure_has_an_area_and_a_friction() -> None:
    """The pressure falls a little where the rod goes in: inside a recording it tells the direction, not the area."""
    parts = []
    rng = np.random.default_rng(5)
    for number, pressure in enumerate(np.repeat([1e5, 3e5, 5e5, 7e5], 3)):
        own = swinging(pieces=6, seed=number)
        own = replace(own, recording=np.full(own.size, number, dtype=np.int64), time=own.time + 100.0 * number)
        own = replace(own, aux={"pressure": pressure - 4e3 * own.direction + rng.normal(0.0, 200.0, own.size)})
        parts.append(own)
    frame = concatenate(parts)
    pressure = frame.aux["pressure"]
    friction = (4.0 + 5e-6 * pressure) * frame.direction + 0.5 * frame.omega
    y = 5e-4 * pressure + friction + rng.normal(0.0, 0.5, frame.size)
    terms = ("friction.coulomb", "friction.viscous", "motor.inertia", "motor.torque_offset")
    search = searched(replace(asked(frame, y, *terms), cut=False))
    found = {own.main.regressor.grids[0].times: own for own in search.model.chosen if own.effect == UNKNOWN}
    assert set(found) == {"1", "d"}
    assert all(own.main.regressor.variables == ("aux/pressure",) for own in found.values())
    said = search.model.contribution(found["1"], frame)
    slope = np.polyfit(pressure, said, 1)[0]
    assert slope == pytest.approx(5e-4, rel=0.02)


def test_gravity_that_a_neighbouring_joint_turns_is_found() -> None:
    own = campaign(16, 5)
    rng = np.random.default_rng(6)
    own = replace(own, aux={"q2": np.repeat(rng.uniform(-2.0, 2.0, 16), EACH) + 0.3 * np.sin(own.elapsed)})
    y = 2.0 * np.sin(own.q + own.aux["q2"]) + rng.normal(0.0, 0.1, own.size)
    found = searched(problem(own, y)).model.chosen
    assert "sin(angle + q2)" in " ".join(found[0].main.regressor.variables)
