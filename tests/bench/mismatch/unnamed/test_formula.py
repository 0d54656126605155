"""Unknown physics gets an equation where a short one is as good as the free function, and keeps its table elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from bench.mismatch.given import Given
from bench.mismatch.prediction import evaluated
from bench.mismatch.regression.discoveries import discoveries, rows_of
from bench.mismatch.regression.regressors import Free
from bench.mismatch.regression.search import searched
from bench.mismatch.regression.slots import Slot
from bench.mismatch.regression.state import Search
from bench.mismatch.regression.succession import settle
from bench.mismatch.unnamed import formula, formula_proposed
from bench.mismatch.unnamed.formula_regressor import Equation
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.model import Simulation
from bench.simulation.terms import MOTOR_TORQUE
from tests.bench.exchange.samples import with_rows
from tests.bench.mismatch.regression.synthetic import EACH, campaign, problem

RECORDINGS, NOISE = 28, 0.01
Law = Callable[[FloatArray, FloatArray], FloatArray]


def found(law: Law) -> tuple[Search, list[Slot], Frame]:
    """A search of a motor torque with dry and viscous friction, and ``law`` of the direction and of a pressure."""
    search, slots, frame = _searched(law)
    return replace(search, model=replace(search.model, notes=[])), slots, frame


@lru_cache
def _searched(law: Law) -> tuple[Search, list[Slot], Frame]:
    rng = np.random.default_rng(5)
    frame = campaign(RECORDINGS)
    pressure = np.repeat(rng.uniform(0.5, 5.0, RECORDINGS), EACH) + 0.3 * np.sin(0.4 * frame.elapsed)
    frame = replace(frame, aux={"pressure": pressure})
    y = 0.4 * frame.direction + 0.01 * frame.omega + law(frame.direction, pressure)
    own = problem(frame, y + NOISE * rng.normal(size=frame.size))
    folds = np.arange(RECORDINGS)
    folds[3::7] = -1
    search = searched(replace(own, folds=folds))
    return search, settle(search), frame


def the_equation(search: Search) -> tuple[Equation, FloatArray]:
    own = [c for c in search.model.chosen if isinstance(c.main.regressor, Equation)]
    assert len(own) == 1
    equation = own[0].main.regressor
    assert isinstance(equation, Equation)
    return equation, search.model.fit.of(own[0].main.indices)[0]


LAWS: dict[str, tuple[Law, str, dict[str, tuple[float, str]]]] = {
    "straight": (lambda d, p: 0.1 * d * p, "motor_torque += d*c1*pressure", {"c1": (0.1, "N*m/bar")}),
    "square": (lambda d, p: 0.03 * p**2, "motor_torque += c1*pressure^2", {"c1": (0.03, "N*m/bar^2")}),
    # its constant is dry friction, which the simulation has
    "saturation": (
        lambda d, p: 0.5 * d * (1.0 - np.exp(-p / 1.2)),
        "motor_torque += d*c1*exp(-pressure/s1)",
        {"c1": (-0.5, "N*m"), "s1": (1.2, "bar")},
    ),
    "brake": (
        lambda d, p: 0.6 * d * p / (1.0 + (p / 1.5) ** 2),
        "motor_torque += d*c1*pressure/(1 + (pressure/s1)^2)",
        {"c1": (0.6, "N*m/bar"), "s1": (1.5, "bar")},
    ),
    "peak": (
        lambda d, p: 0.4 * d * np.exp(-(((p - 2.5) / 0.7) ** 2)),
        "motor_torque += d*c1*exp(-((pressure - m1)/s2)^2)",
        {"c1": (0.4, "N*m"), "m1": (2.5, "bar"), "s2": (0.7, "bar")},
    ),
}


@pytest.mark.parametrize("name", LAWS)
def test_the_law_itself_is_found_with_its_numbers_and_units(name: str) -> None:
    pytest.importorskip("pyoperon")
    law, text, numbers = LAWS[name]
    search, slots, _ = found(law)
    table = search.density(search.model.chosen)
    slots = formula.in_formulas(search, slots, {"pressure": "bar"})
    equation, coefficients = the_equation(search)
    assert equation.equation == text
    told = {p["symbol"]: p for p in equation.parameters(coefficients, np.zeros(coefficients.size))}
    assert {symbol: p["unit"] for symbol, p in told.items()} == {symbol: u for symbol, (_, u) in numbers.items()}
    for symbol, (value, _) in numbers.items():
        assert told[symbol]["value"] == pytest.approx(value, rel=0.05)
    whole = search.density(search.model.chosen)
    assert formula.as_good(table, whole)
    assert any(slot.chosen.main.regressor is equation for slot in slots)
    assert any("stands in place of a table" in note for note in search.model.notes)


def zigzag(d: FloatArray, p: FloatArray) -> FloatArray:
    """A course that no law of a few numbers has."""
    return 0.4 * d * np.interp(p, [0.0, 1.2, 2.4, 3.3, 4.2, 5.5], [0.0, 0.9, 0.2, 1.0, 0.1, 0.5])


def test_where_no_short_formula_serves_the_table_stays() -> None:
    pytest.importorskip("pyoperon")
    search, slots, _ = found(zigzag)
    before = search.model.chosen
    slots = formula.in_formulas(search, slots, {"pressure": "bar"})
    assert search.model.chosen == before
    assert any(isinstance(slot.chosen.main.regressor, Free) for slot in slots)
    assert any("no short formula of aux/pressure serves as well as its table" in n for n in search.model.notes)


def test_a_formula_with_which_recordings_held_out_are_predicted_worse_is_not_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("pyoperon")
    search, slots, _ = found(LAWS["square"][0])
    before = search.model.chosen
    monkeypatch.setattr(formula, "worse_with", lambda _model, _chosen, _own: 1.1)
    assert formula.in_formulas(search, slots, {"pressure": "bar"}) == slots
    assert search.model.chosen == before
    assert any("no formula of aux/pressure is told" in note for note in search.model.notes)


def test_the_same_recordings_give_the_same_formula() -> None:
    pytest.importorskip("pyoperon")
    rows = []
    # as the other tests have it, and once more
    for searching in (found, _searched.__wrapped__):
        search, slots, _ = searching(LAWS["saturation"][0])
        formula.in_formulas(search, slots, {"pressure": "bar"})
        equation, coefficients = the_equation(search)
        rows.append(equation.row(coefficients, np.zeros(coefficients.size)))
    assert rows[0] == rows[1]


def test_without_operon_a_sentence_says_so_and_the_table_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(formula_proposed, "available", lambda: False)
    search, slots, _ = found(LAWS["square"][0])
    assert formula.in_formulas(search, slots, {}) == slots
    assert search.model.notes == [formula.ABSENT]


def test_a_formula_is_as_good_within_one_standard_error() -> None:
    table = np.array([3.0, 1.0, 2.0, 2.0])
    worse = np.array([1.0, 0.0, -1.0, 0.0])
    assert not formula.as_good(table, table - 2.0 - 0.1 * worse)
    assert formula.as_good(table, table + worse - 0.1)


def test_a_file_with_the_formula_says_what_the_search_says() -> None:
    pytest.importorskip("pyoperon")
    search, slots, frame = found(LAWS["saturation"][0])
    slots = formula.in_formulas(search, slots, {"pressure": "bar"})
    own = next(c for c in search.model.chosen if isinstance(c.main.regressor, Equation))
    rows = rows_of(search.model, own)
    simulation = Simulation.from_json(with_rows(*rows).to_json())
    (known,) = Given.of(simulation).known[MOTOR_TORQUE]
    np.testing.assert_allclose(evaluated(known, frame, None), search.model.contribution(own, frame), rtol=1e-12)
    # and it stays the same row when it is given back, calibrated and written again
    assert isinstance(known.regressor, Equation)
    assert known.coefficients is not None
    again = known.regressor.row(known.coefficients, np.zeros(1))
    assert {k: v for k, v in again.items() if k != "parameters"} == {
        k: v for k, v in rows[0].items() if k not in ("parameters", "effect")
    }


def test_the_report_tells_the_equation_and_its_numbers() -> None:
    pytest.importorskip("pyoperon")
    search, slots, frame = found(LAWS["saturation"][0])
    slots = formula.in_formulas(search, slots, {"pressure": "bar"})
    told = discoveries(search, slots, search.model.predict(frame), frame.count)
    unknown = next(d for d in told if d.status == "unknown")
    assert unknown.equation == "motor_torque += d*c1*exp(-pressure/s1)"
    assert unknown.variables == ("aux/pressure",)
    assert [p["symbol"] for p in unknown.parameters] == ["c1", "s1"]
    assert all(p["std"] is not None for p in unknown.parameters)
