"""Where torque sensor and load motor differ the motor torque tells which of them is wrong."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from bench.errors import ConfigurationError
from bench.mismatch import who_reads_wrong
from bench.mismatch.analysis import Analysis
from bench.mismatch.given import Given, Known
from bench.mismatch.prediction import corrected
from bench.mismatch.regression.problem import BaseTerm
from bench.mismatch.regression.regressors import Free, named
from bench.mismatch.regression.search import begun
from bench.mismatch.simulation_file import improved, recalibrated
from bench.simulation.frame import Frame
from bench.simulation.model import Simulation
from bench.simulation.tables import Grid
from bench.simulation.terms import LOAD_TORQUE
from tests.bench.exchange.samples import with_rows
from tests.bench.mismatch.regression.synthetic import RATIO, campaign, problem

ROW = {"effect": "sensor.torque_gain", "form": "gain", "parameters": {"g_s": {"value": 0.02, "unit": "1"}}}
WARM = ROW | {"form": "temperature", "parameters": {"g_s": 0.01, "g_T": 0.002}}

ZERO_DRIFT = {"value": 0.4, "unit": "N*m/K"}


def given_of(row: dict[str, Any]) -> Given:
    return Given.of(Simulation.from_json(with_rows(row).to_json()))


def loaded(recordings: int) -> Frame:
    frame = campaign(recordings)
    return replace(frame, load_motor_level=frame.torque)


def gain_error(row: dict[str, Any] = ROW) -> Known:
    (known,) = given_of(row).known[LOAD_TORQUE]
    return known


@pytest.mark.parametrize("row", [ROW, WARM], ids=["gain", "gain that grows with temperature"])
@pytest.mark.parametrize("wrong", ["sensor", "load motor", "neither"])
def test_the_motor_torque_tells_which_of_the_two_is_wrong(
    wrong: str, row: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    frame = loaded(40)
    known = gain_error(row)
    real = corrected(frame, [known]).torque if wrong == "sensor" else frame.torque
    noise = np.random.default_rng(2).normal(0.0, 0.005 if wrong != "neither" else 3.0, frame.size)
    y = 0.5 * frame.direction + 0.01 * frame.omega + real / RATIO + noise

    def problem_of(_data: object, _given: object, _channel: str, rows: Any, _banned: object) -> Any:
        return problem(rows.frame, y - rows.frame.torque / RATIO)

    monkeypatch.setattr(who_reads_wrong, "problem_of", problem_of)
    rows = problem(frame, y).rows
    folder = SimpleNamespace(manner=SimpleNamespace(free=False))
    data = SimpleNamespace(rows={"motor_torque": rows}, simulated=frozenset(), folder=folder)
    found = who_reads_wrong.of_load_motor(cast("Any", data), cast("Any", SimpleNamespace(known={})), [known])
    assert (found is not None) is (wrong == "load motor")


def test_an_error_of_the_sensor_stays_one_where_something_else_makes_up_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """The zero of the sensor drifts with the temperature, and so does a drag that the simulation lacks: together they
    are less than either, and the simulation alone follows the torque as read.
    """
    frame = loaded(40)
    zero = {"effect": "sensor.torque_zero_temperature", "form": "linear", "parameters": {"z_T": ZERO_DRIFT}}
    (known,) = given_of(zero).known[LOAD_TORQUE]
    drag = 0.0017 * (frame.temperature - 25.0)
    noise = np.random.default_rng(2).normal(0.0, 0.005, frame.size)
    y = 0.5 * frame.direction + 0.01 * frame.omega + corrected(frame, [known]).torque / RATIO + drag + noise

    def problem_of(_data: object, _given: object, _channel: str, rows: Any, _banned: object) -> Any:
        return problem(rows.frame, y - rows.frame.torque / RATIO)

    monkeypatch.setattr(who_reads_wrong, "problem_of", problem_of)
    folder = SimpleNamespace(manner=SimpleNamespace(free=False))
    data = cast(
        "Any",
        SimpleNamespace(rows={"motor_torque": problem(frame, y).rows}, simulated=frozenset(), folder=folder),
    )
    given = cast("Any", SimpleNamespace(known={}))
    assert who_reads_wrong._better(data, given, who_reads_wrong.as_reported([known]), [known]) is not None
    assert who_reads_wrong.of_load_motor(data, given, [known]) is None


def test_an_error_of_the_load_motor_leaves_the_torque_as_read() -> None:
    frame = loaded(6)
    known = gain_error()
    (reported,) = who_reads_wrong.as_reported([known])
    assert np.ptp(corrected(frame, [known]).torque - frame.torque) > 1.0
    assert np.array_equal(corrected(frame, [reported]).torque, frame.torque)


def test_a_simulation_file_says_whose_error_it_is() -> None:
    (sensor,), (motor,) = (given_of(row).known[LOAD_TORQUE] for row in (ROW, ROW | {"reported_by": "load_motor"}))
    assert sensor.misread
    assert not motor.misread
    with pytest.raises(ConfigurationError, match="'reported_by': 'nobody' in a row, it should be 'load_motor'"):
        given_of(ROW | {"reported_by": "nobody"})


def test_it_is_no_question_where_no_error_is_known() -> None:
    friction = Known(named("friction.stribeck", "motor_torque", "exponential"), np.zeros(1))
    folder = SimpleNamespace(manner=SimpleNamespace(free=False))
    data = SimpleNamespace(rows={"motor_torque": object()}, simulated=frozenset(), folder=folder)
    assert who_reads_wrong.of_load_motor(cast("Any", data), cast("Any", SimpleNamespace(known={})), [friction]) is None


def wound_up(frame: Frame) -> Known:
    """Something without a name in the load torque that grows in each recording, N·m."""
    grid = Grid(("seconds",), "1", ((0.0, float(frame.elapsed.max())),))
    return Known(Free(LOAD_TORQUE, (grid,)), np.array([-6.0, 6.0]))


@pytest.mark.parametrize("is_load", [True, False])
def test_the_motor_torque_tells_whether_what_has_no_name_is_a_load(
    is_load: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the load is kept it is taken as its mean: the motor torque follows a load there, and no error."""
    frame = replace(loaded(40), kept=np.ones(loaded(40).size), followed=np.zeros(loaded(40).size))
    own = wound_up(frame)
    real = corrected(frame, who_reads_wrong.on_shaft([own])).torque
    assert np.ptp(real - frame.torque) > 10.0
    assert np.array_equal(corrected(frame, [own]).torque, frame.torque)
    noise = np.random.default_rng(2).normal(0.0, 0.005, frame.size)
    y = 0.5 * frame.direction + 0.01 * frame.omega + (real if is_load else frame.torque) / RATIO + noise

    def problem_of(_data: object, _given: object, _channel: str, rows: Any, _banned: object) -> Any:
        return problem(rows.frame, y - rows.frame.torque / RATIO)

    monkeypatch.setattr(who_reads_wrong, "problem_of", problem_of)
    folder = SimpleNamespace(manner=SimpleNamespace(free=False))
    rows = {"motor_torque": problem(frame, y).rows}
    data = cast("Any", SimpleNamespace(rows=rows, simulated=frozenset(), folder=folder))
    given = cast("Any", SimpleNamespace(known={}))
    assert (who_reads_wrong.of_shaft(data, given, [], [own]) is not None) is is_load


def test_a_load_without_a_name_is_one_in_the_file_as_well() -> None:
    row = Free(LOAD_TORQUE, (Grid(("seconds",), "1", ((0.0, 60.0),)),)).row(np.array([-6.0, 6.0]), np.zeros(2))
    row = {"effect": "unknown", **row}
    outcome = cast(
        "Any", SimpleNamespace(notes=[], discoveries=[Found("unknown", w, (row,)) for w in ("hose", "zero")])
    )
    who_reads_wrong.mark_load(outcome, "hose", 1.0)
    assert outcome.notes[0].startswith("hose in the load torque is a load that turns the shaft")
    (marked,), (other,) = (d.simulation_rows for d in outcome.discoveries)
    assert other == row
    assert [k.turns for k in given_of(row).known[LOAD_TORQUE]] == [False]
    assert [k.turns for k in given_of(marked).known[LOAD_TORQUE]] == [True]
    with pytest.raises(ConfigurationError, match="'acts_on': 'sensor' in a row, it should be 'shaft'"):
        given_of(row | {"acts_on": "sensor"})
    with pytest.raises(ConfigurationError, match=r"sensor.torque_gain has 'acts_on' in a row of load_torque; only a"):
        given_of(ROW | {"acts_on": "shaft"})
    with pytest.raises(ConfigurationError, match=r"unknown has 'acts_on' in a row of motor_torque; only a function"):
        given_of(row | {"acts_on": "shaft", "channels": ["motor_torque"]})


@dataclass(frozen=True)
class Found:
    """What is asked of a discovery."""

    effect: str
    words: str
    simulation_rows: tuple[dict[str, Any], ...]


@pytest.mark.parametrize("key", [{"reported_by": "load_motor"}, {}])
def test_a_file_that_is_calibrated_anew_keeps_whose_error_it_is(key: dict[str, str]) -> None:
    frame = loaded(6)
    given = given_of(ROW | key)
    (term,) = given.known[LOAD_TORQUE]
    y = 0.02 * frame.load_motor_level + np.random.default_rng(3).normal(0.0, 0.5, frame.size)
    own = replace(problem(frame, y), channel=LOAD_TORQUE, base=(BaseTerm(term.regressor),))
    search = begun(own)
    analysis = Analysis(given, {LOAD_TORQUE: search})
    for made in (recalibrated(analysis, None), improved(analysis, None)):
        (again,) = Given.of(made).known[LOAD_TORQUE]
        assert again.misread is (not key)
        assert again.coefficients == pytest.approx(search.model.fit.of(search.model.base[0].indices)[0])
