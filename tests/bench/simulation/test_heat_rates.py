"""A heat balance as identification tells it is what predictions read."""

from __future__ import annotations

import pytest

from bench.mismatch.given import Given
from bench.mismatch.prediction import Predictor
from bench.mismatch.regression.regressors import Named
from bench.simulation.heat_rates import with_rates
from bench.simulation.model import Parameter, Simulation, Term
from bench.simulation.terms import LIBRARY, TEMPERATURE

CAPACITY, RESISTANCE, AMBIENT = 25_000.0, 0.25, 21.0


def identified(capacity: float = CAPACITY) -> Simulation:
    """A simulation whose heat balance is told by its physical numbers."""
    own = {
        "thermal.loss_heating": {"C": Parameter(capacity, "J/K")},
        "thermal.convection": {"R": Parameter(RESISTANCE, "K/W"), "T_amb": Parameter(AMBIENT, "degC")},
    }
    out = Simulation.nominal()
    for effect, parameters in own.items():
        out = out.with_term(Term(effect, True, parameters))
    return out


def test_numbers_become_rates() -> None:
    terms = with_rates(identified()).terms
    assert terms["thermal.loss_heating"].parameters["1/C"].value == pytest.approx(1.0 / CAPACITY)
    slow = terms["thermal.convection"].parameters["1/(R*C)"].value
    assert slow == pytest.approx(1.0 / (RESISTANCE * CAPACITY))
    at = terms["thermal.convection"].parameters["(T_amb-25)/(R*C)"].value
    assert at / slow + 25.0 == pytest.approx(AMBIENT)
    # a calibration that follows is told once, not beside numbers that it no longer is
    assert not {"C", "R", "T_amb"} & {s for t in terms.values() for s in t.parameters}


def test_predictions_have_all_they_need() -> None:
    predictor = Predictor(Given.of(identified()))
    for effect in ("thermal.loss_heating", "thermal.convection"):
        term = LIBRARY[effect]
        assert predictor.given.nominal_coefficients(Named(term, TEMPERATURE, term.forms[TEMPERATURE][0])) is not None
    # identification takes the zeros of both torques off the loss
    assert predictor.takes_zeros


def test_what_cannot_be_is_left_as_it_is() -> None:
    wrong = identified(-1.0)
    assert with_rates(wrong) is wrong
    assert with_rates(Simulation.nominal()) == Simulation.nominal()
