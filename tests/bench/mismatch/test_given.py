"""What a simulation file says of the comparison, and what is wrong with one is said."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bench.errors import ConfigurationError
from bench.mismatch.given import Given, Known
from bench.mismatch.prediction import corrected
from bench.mismatch.regression.regressors import Named, named
from bench.simulation.model import Simulation
from bench.simulation.terms import LIBRARY, LOAD_TORQUE, MOTOR_TORQUE
from bench.simulation.terms.nominal.transmission_error import PAPER_ORDERS
from tests.bench.simulation.terms.frames import at_loads_and_speeds


def given(*terms: dict[str, Any]) -> Given:
    return Given.of(Simulation.from_json({"format": "bench-simulation", "format_version": "1.0", "terms": list(terms)}))


def test_the_nominal_simulation_says_nothing_beyond_the_paper() -> None:
    nominal = Given.of(Simulation.nominal())
    assert nominal.orders == tuple(float(f) for f in PAPER_ORDERS)
    assert (nominal.switched_off, nominal.known, nominal.ripples) == ((), {}, ())
    assert nominal.pulses == nominal.laws == ()


def test_terms_switched_off_orders_chosen_and_added() -> None:
    told = given(
        {"effect": "friction.coulomb", "enabled": False},
        {"effect": "te.fourier", "orders": [1, 46]},
        {"effect": "te.harmonic", "parameters": {"c": 1e-6, "s": 0.0, "f": 37.0}},
        {"effect": "te.sideband", "orders": [43, 49]},
    )
    assert told.switched_off == ("friction.coulomb",)
    assert told.orders == (1.0, 37.0, 43.0, 46.0, 49.0)


def test_pulses_ripples_and_laws_keep_their_numbers() -> None:
    law = {"form": "linear", "point": [], "orders": [46], "strength": {"46": [0.1, 0.0]}, "reference": {"span": 3600.0}}
    ripple = {"parameters": {"a_rc": 0.1, "a_rs": -0.2, "n": 24.0}}
    told = given(
        {
            "effect": "te.local_defect",
            "parameters": {"p": 2e-5, "theta_p": 1.0, "w_p": 0.02},
            "also": [{"parameters": {"p": {"value": 1e-5, "unit": "rad"}, "theta_p": 2.0, "w_p": 0.03}}],
        },
        {"effect": "motor.torque_ripple", **ripple},
        {"effect": "te.drift_time", "law": law},
    )
    assert [p.height for p in told.pulses] == [2e-5, 1e-5]
    assert (told.ripples[0].order, told.ripples[0].cosine, told.ripples[0].sine) == (24 * 185.0, 0.1, -0.2)
    assert told.laws[0].reference.span == 3600.0
    assert told.known == {}


@pytest.mark.parametrize(
    ("term", "message"),
    [
        ({"effect": "friction.stribeck", "form": "cubic"}, "one of exponential, gaussian"),
        (
            {"effect": "friction.stribeck", "form": "gaussian", "channels": ["motor_torque"], "point": []},
            "one for each",
        ),
        ({"effect": "te.local_defect", "parameters": {"p": 1.0}}, "no theta_p, w_p"),
        ({"effect": "te.resonance"}, "neither orders nor a law"),
        ({"effect": "te.drift_time", "law": {"form": "cubic", "point": [], "orders": []}}, "should be one of"),
        ({"effect": "te.drift_time", "law": {"form": "linear"}}, "should have form, point"),
        ({"effect": "thermal.loss_heating", "less": ["gain"]}, "has 'gain' in 'less', it should be a list of some of"),
        ({"effect": "thermal.loss_heating", "less": "load zero"}, "has 'load zero' in 'less', it should be a list"),
    ],
)
def test_what_is_wrong_is_said(term: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        given(term)


def test_a_term_without_numbers_is_left_to_the_recordings() -> None:
    assert given({"effect": "friction.stribeck"}).unsettled == {"motor_torque": ("friction.stribeck",)}


def test_tables_and_waves_are_what_they_were() -> None:
    table = {"form": "table", "over": ["speed"], "times": "d", "knots": [[0.0, 0.1]], "values": [0.2, 0.0]}
    wave = {"order": 37.0, "times": "p*tau", "c": 1e-6, "s": -2e-6}
    told = given(
        {"effect": "unknown", **table, "channels": ["motor_torque"]},
        {"effect": "te.harmonic", "channels": ["transmission_error"], "waves": [wave]},
    )
    (known,) = told.known["motor_torque"]
    assert known.coefficients is not None
    assert known.coefficients.tolist() == [0.2, 0.0]
    assert [w.to_json() for w in told.waves["transmission_error"]] == [wave]


def test_a_torque_is_corrected_by_what_its_sensor_adds() -> None:
    """A sensor that reads 2 % too much read 1.02 of what there was."""
    rows = at_loads_and_speeds(np.linspace(0.1, 1.0, 50), (-600.0, 800.0), (0.1,))
    gain = Known(named("sensor.torque_gain", LOAD_TORQUE, "gain"), np.array([0.02]))
    read = replace(rows, torque=1.02 * rows.torque, torque_level=1.02 * rows.torque_level)
    read = replace(read, load_motor_level=rows.torque)
    assert corrected(read, [gain]).torque == pytest.approx(rows.torque)
    assert corrected(read, [gain]).torque_level == pytest.approx(rows.torque_level)
    assert corrected(read, []) is read


def test_the_torque_of_a_segment_has_the_zero_of_the_segment() -> None:
    """A sensor whose zero drifts by 0.5 N·m/K while the bench warms up: the load, which is kept, does not drift."""
    rows = at_loads_and_speeds(np.linspace(0.1, 1.0, 50), (400.0,), (0.1,))
    rows = replace(rows, recording=np.zeros(rows.size, dtype=np.int64), torque=np.full(rows.size, 400.0))
    temperature = np.linspace(25.0, 45.0, rows.size)
    zero = Known(named("sensor.torque_zero_temperature", LOAD_TORQUE, "linear"), np.array([0.5]))
    level = np.full(rows.size, 400.0 + 0.5 * 10.0)
    read = replace(rows, temperature=temperature, torque=level, torque_level=level, followed=np.zeros(rows.size))
    kept = corrected(replace(read, kept=np.ones(rows.size)), [zero])
    assert kept.torque == pytest.approx(400.0)
    assert kept.torque_level == pytest.approx(400.0)
    assert np.ptp(corrected(read, [zero]).torque) == pytest.approx(10.0)


def test_an_unbalance_turns_the_shaft_where_the_load_is_smoothed() -> None:
    """The load motor does not feel it, so the smoothed torque does not show it: it is put back about the level."""
    rows = at_loads_and_speeds(np.linspace(0.1, 1.0, 50), (400.0,), (0.1,))
    rows = replace(rows, recording=np.zeros(rows.size, dtype=np.int64), q=np.linspace(0.0, 4.0 * np.pi, rows.size))
    level = np.full(rows.size, 400.0)
    read = replace(rows, torque=level, torque_level=level, kept=np.ones(rows.size), followed=np.zeros(rows.size))
    unbalance = named("load.unbalance", LOAD_TORQUE, LIBRARY["load.unbalance"].forms[LOAD_TORQUE][0].name)
    known = Known(unbalance, np.array([5.0, 3.0]))
    wave = unbalance.columns(rows) @ np.array([5.0, 3.0])
    put_back = 400.0 + wave - np.average(wave, weights=rows.count)
    assert corrected(read, [known]).torque == pytest.approx(put_back)
    assert corrected(read, [known]).torque_level == pytest.approx(put_back)
    assert corrected(replace(read, followed=np.ones(rows.size)), [known]).torque == pytest.approx(400.0)


def test_an_error_of_the_sensor_is_taken_off_once() -> None:
    """The channels beyond its own are predicted from the corrected torque."""
    gain = {"effect": "sensor.torque_gain", "parameters": {"g_s": 0.02}}
    curved = {"effect": "sensor.torque_nonlinearity", "form": "odd_square", "parameters": {"c_1": 1.0, "c_2o": 2.0}}
    assert list(given(gain).known) == list(given(curved).known) == [LOAD_TORQUE]
    seen = given({**curved, "channels": [MOTOR_TORQUE]})
    assert list(seen.known) == [MOTOR_TORQUE]


@pytest.mark.parametrize(
    ("effect", "parameters", "form"),
    [
        ("sensor.torque_gain", {"g_s": 0.02}, "gain"),
        ("sensor.torque_gain", {"g_s": 0.02, "g_T": 1e-4}, "temperature"),
        ("friction.stribeck", {"f_s": 0.3, "w_s": 6.0}, "exponential"),
        ("friction.stribeck", {"f_s": 0.3, "w_s": 6.0, "beta": -0.03, "delta": 0.9}, "hersey"),
    ],
)
def test_a_row_without_a_form_is_the_one_that_has_all_of_its_parameters(
    effect: str, parameters: dict[str, float], form: str
) -> None:
    ((known,),) = given({"effect": effect, "parameters": parameters}).known.values()
    assert isinstance(known.regressor, Named)
    assert known.regressor.form.name == form
    assert known.coefficients is not None
    assert [*known.coefficients, *known.regressor.point] == list(parameters.values())


@pytest.mark.parametrize("form", [f.name for f in LIBRARY["sensor.torque_nonlinearity"].forms[MOTOR_TORQUE]])
def test_what_the_sensor_reads_too_much_the_motor_does_not_give(form: str) -> None:
    rows = at_loads_and_speeds(np.linspace(0.1, 1.0, 50), (-600.0, 800.0), (0.1,))
    rows = replace(rows, load_motor_level=rows.torque_level)
    sensor, motor = (LIBRARY["sensor.torque_nonlinearity"].form(c, form) for c in (LOAD_TORQUE, MOTOR_TORQUE))
    assert sensor is not None
    assert motor is not None
    for point in motor.grid(rows):
        assert motor.columns(rows, point) == pytest.approx(-sensor.columns(rows, point) / rows.ratio)


@pytest.mark.parametrize("form", [{}, {"form": "ripple"}])
def test_a_wave_in_proportion_to_nothing_known_says_where(form: dict[str, str]) -> None:
    document = Simulation.nominal().to_json()
    wave = {"order": 4440.0, "times": "p*sloth", "c": 1.0, "s": 0.0}
    own = {"effect": "motor.torque_ripple", "enabled": True, **form, "channels": ["motor_torque"], "waves": [wave]}
    document["terms"].append(own)
    said = r"term motor\.torque_ripple: waves\[0\] is in proportion to 'sloth', it should be one of 1, d, "
    with pytest.raises(ConfigurationError, match=said):
        Given.of(Simulation.from_json(document))
