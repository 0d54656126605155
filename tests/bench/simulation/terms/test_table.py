"""Every term of the library keeps the promises on which calibration, selection and report rely."""

from __future__ import annotations

import re

import numpy as np
import pytest

from bench.simulation.model import NOMINAL_TERMS
from bench.simulation.terms import CHANNEL_UNITS, LIBRARY, for_channel, nominal_for
from tests.bench.simulation.terms.frames import frame

_VOCABULARY = """
te.harmonic te.sideband te.local_defect te.resonance te.lost_motion te.stiffness_nonlinear te.hysteresis te.drift_time
te.velocity_nonlinear te.temperature_nonlinear sensor.motor_encoder sensor.timing_skew friction.stribeck
friction.viscous_temperature friction.viscous_quadratic friction.position_dependent friction.run_in friction.presliding
motor.torque_ripple motor.torque_constant load.unbalance thermal.sensor_lag thermal.second_mass thermal.ambient_drift
thermal.convection_speed sensor.torque_zero_temperature sensor.torque_gain sensor.torque_nonlinearity
sensor.torque_hysteresis
"""
"""The vocabulary of the mismatch report, without ``unknown``."""

FORMS = [
    pytest.param(term, channel, form, id=f"{term.effect} {channel} {form.name}")
    for term in LIBRARY.values()
    for channel, forms in term.forms.items()
    for form in forms
]


def points_of(term, channel: str, form, rows) -> tuple:
    """The points of a form; of one that no search looks for those of the form that took its place."""
    own = form.grid(rows)
    return own or term.form(channel, form.name.replace("_kept", "_followed")).grid(rows)


def test_the_library_holds_the_whole_vocabulary() -> None:
    assert set(_VOCABULARY.split()) <= {term.effect for term in LIBRARY.values() if not term.nominal}


def test_the_library_holds_every_nominal_term() -> None:
    assert {term.effect for term in LIBRARY.values() if term.nominal} == set(NOMINAL_TERMS)


@pytest.mark.parametrize("term", LIBRARY.values(), ids=LIBRARY)
def test_a_term_says_what_it_is(term) -> None:
    for text in (term.name, term.equation, term.reference, term.where):
        assert len(text) > 3
    assert set(term.forms) <= set(CHANNEL_UNITS)
    for forms in term.forms.values():
        names = [form.name for form in forms]
        assert len(set(names)) == len(names)


@pytest.mark.parametrize(("term", "channel", "form"), FORMS)
def test_regressors_of_a_form_are_finite_and_as_many_as_its_parameters(term, channel: str, form) -> None:
    rows = frame()
    points = points_of(term, channel, form, rows)
    assert points
    for point in points:
        assert len(point) == len(form.nonlinear)
        for value, symbol in zip(point, form.nonlinear, strict=True):
            assert symbol.lower <= value <= symbol.upper
        columns = form.columns(rows, point)
        assert columns.shape == (rows.size, len(form.linear))
        assert np.isfinite(columns).all()


@pytest.mark.parametrize(("term", "channel", "form"), FORMS)
def test_a_form_shows_in_some_row_for_some_point(term, channel: str, form) -> None:
    rows = frame()
    assert any(np.any(form.columns(rows, point) != 0.0) for point in points_of(term, channel, form, rows))


@pytest.mark.parametrize(("term", "channel", "form"), FORMS)
def test_symbols_have_units_and_bounds_in_order(term, channel: str, form) -> None:
    symbols = [*form.linear, *form.nonlinear]
    assert len({symbol.symbol for symbol in symbols}) == len(symbols)
    for symbol in symbols:
        assert symbol.unit
        assert symbol.meaning
        assert symbol.lower < symbol.upper


@pytest.mark.parametrize("channel", CHANNEL_UNITS)
def test_channels_list_their_terms(channel: str) -> None:
    listed = {term.effect for term in (*for_channel(channel), *nominal_for(channel))}
    assert listed == {term.effect for term in LIBRARY.values() if channel in term.forms}


@pytest.mark.parametrize(("term", "channel", "form"), FORMS)
def test_the_equation_of_a_form_has_each_of_its_symbols(term, channel: str, form) -> None:
    shown = term.equation_of(form)
    missing = [s.symbol for s in (*form.linear, *form.nonlinear) if not stands_in(s.symbol, shown)]
    assert term.effect == "te.offset" or not missing


def stands_in(symbol: str, text: str) -> bool:
    """Whether a symbol is a whole word of a text."""
    return re.search(rf"(?<!\w){re.escape(symbol)}(?!\w)", text) is not None
