"""Formulas that go out are those the analysis evaluates: every form of every term, tables, waves, laws, pulses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bench.errors import ConfigurationError
from bench.exchange.sample import frame_of
from bench.exchange.to_python import to_python
from bench.exchange.written import formulas_of
from bench.mismatch.given import Given
from bench.mismatch.power_zeros import REPORTED, SINGLE, Zeros, reported_by
from bench.mismatch.prediction import Predictor
from bench.mismatch.series_given import swinging
from bench.simulation.heat_rates import TAKEN_OFF
from bench.simulation.model import Simulation
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR
from tests.bench.exchange.samples import RATIO, STANDSTILL, inputs, name_of, ours, row_of, with_rows

FRAME = frame_of(inputs(), RATIO, STANDSTILL)
FORMS = [
    (term, channel, form)
    for term in LIBRARY.values()
    for channel, forms in term.forms.items()
    for form in forms
    if not term.effect.startswith(("te.harmonic", "te.sideband", "te.resonance", "te.local_defect", "te.fourier"))
    and term.effect != "te.offset"
]
LAW = {"orders": [3.0], "strength": {"3": [0.3, 0.2]}, "reference": {"largest": 500.0}}
MADE: dict[str, list[dict[str, Any]]] = {
    "series": [
        {
            "effect": "te.fourier",
            "parameters": {
                side: {
                    "a0": [0.0] * 9 + [size],
                    "1": {"A": [0.0] * 9 + [3e-5], "phi": [0.0] * 9 + [0.4]},
                    "3": {"A": [1e-11, 0, 0, 1e-8, 0, 0, 0, 0, 0, size], "phi": [0.0] * 8 + [0.02, -0.7]},
                }
                for side, size in (("positive", 1e-5), ("negative", 2e-5))
            },
        }
    ],
    "table": [
        {
            "effect": "unknown",
            "channels": ["motor_torque"],
            "form": "table",
            "over": ["aux/pressure", "temperature"],
            "times": "d*abs_tau",
            "knots": [[2.0, 3.0, 3.5], [20.0, 35.0]],
            "values": [[0.1, 0.2], [0.4, 0.3], [0.5, 0.9]],
        }
    ],
    "formula": [
        {
            "effect": "unknown",
            "channels": ["motor_torque"],
            "form": "formula",
            "over": ["aux/pressure", "temperature"],
            "within": [[2.2, 3.8], [26.0, 40.0]],
            "parts": [
                {"times": "d", "text": "exp(-x1/s1)*x2"},
                {"times": "1", "text": "1/(1 + x1**3/s2)"},
                {"times": "d*abs_tau", "text": "tanh((x2 - m3)/s4)*abs(x1)"},
            ],
            "parameters": {"c1": 0.1, "c2": 2.0, "c3": -0.4, "s1": 1.5, "s2": 4.0, "m3": 30.0, "s4": 6.0},
        }
    ],
    "states": [
        {
            "effect": "unknown",
            "channels": ["motor_torque"],
            "form": "table",
            "over": [name],
            "times": "d",
            "knots": [sorted((0.0, size))],
            "values": [0.1, 0.4],
        }
        for name, size in {
            "recent_speed_2s": 0.2,
            "recent_load_1s": 0.5,
            "recent_torque_3s": 400.0,
            "recent_loss_1s": 40.0,
            "recent_load_motor_2s": 400.0,
            "taken_along_50mrad": 0.05,
            "impulse_300Nms": 300.0,
            "worked_in_4s_50s": 0.3,
            "film_40Nm": -1.0,
        }.items()
    ],
    "waves": [
        {"effect": "unknown", "channels": ["load_torque"], "waves": [{"order": 6, "times": "d*tau", "c": 0.3, "s": 1}]}
    ],
    "pulse": [{"effect": "te.local_defect", "parameters": {"theta_p": 0.1, "w_p": 0.02, "p": 1e-5}}],
    "ripple": [{"effect": "motor.torque_ripple", "parameters": {"n": 6.0, "a_rc": 0.1, "a_rs": 0.2, "tau_r": 3.0}}],
    "reading": [
        {
            "effect": "unknown",
            "channels": ["temperature"],
            "form": "table",
            "over": ["velocity"],
            "times": "read",
            "knots": [[-0.2, 0.0, 0.2]],
            "values": [-0.1, 0.0, 0.2],
        },
        {
            "effect": "unknown",
            "channels": ["temperature"],
            "form": "formula",
            "over": ["torque"],
            "within": [[-900.0, 900.0]],
            "parts": [{"times": "read", "text": "tanh(x1/s1)"}, {"times": "1", "text": "1/(1 + (x1/s1)**2)"}],
            "parameters": {"c1": 0.1, "c2": 0.01, "s1": 300.0},
        },
    ],
    "sensor": [
        {"effect": "sensor.torque_zero_temperature", "channels": ["load_torque"], "parameters": {"z_T": 3.0}},
        {"effect": "friction.load_dependent", "parameters": {"f_l": 0.2}},
    ],
}  # fmt: skip
MADE["reaction"] = [
    *MADE["series"],
    *MADE["pulse"],
    {"effect": "te.harmonic", "waves": [{"order": 7.5, "times": "d*tau", "c": 2e-5, "s": 1e-5}]},
    {"effect": "sensor.motor_encoder", "orders": [3.0]},
    {"effect": "motor.load_reaction", "parameters": {"k_te": 0.8}},
]
CHANNEL = {
    "reaction": "motor_torque",
    "table": "motor_torque",
    "formula": "motor_torque",
    "states": "motor_torque",
    "waves": "load_torque",
    "ripple": "motor_torque",
    "reading": "temperature",
    "sensor": "motor_torque",
}


def run(simulation: Simulation, name: str) -> np.ndarray[Any, Any]:
    formulas = formulas_of(simulation, STANDSTILL)
    scope: dict[str, Any] = {}
    exec(to_python(formulas), scope)  # what was written is what is tested
    model, given = scope["Model"](), inputs()
    rows = [model.step(float(t), {n: float(given[n][k]) for n in formulas.inputs}) for k, t in enumerate(given["time"])]
    return np.array([row[name] for row in rows])


def same(simulation: Simulation, channel: str) -> None:
    # of a resonance only the steady response is written, and a note says so
    predicted = ours(simulation, channel, 25.0) - swinging(Given.of(simulation), FRAME) * (
        channel == TRANSMISSION_ERROR
    )
    assert np.abs(predicted).max() > 0
    np.testing.assert_allclose(
        run(simulation, name_of(channel)), predicted, rtol=1e-9, atol=1e-11 * np.abs(predicted).max()
    )


@pytest.mark.parametrize(
    ("term", "channel", "form"), FORMS, ids=lambda v: getattr(v, "effect", None) or getattr(v, "name", v)
)
def test_every_form_is_written_as_it_is_evaluated(term: Any, channel: str, form: Any) -> None:
    if form.name == "nominal" and term.effect in ("load.reaction", "motor.load_reaction"):
        same(with_rows({"effect": term.effect}), channel)  # by geometry, without a number
    else:
        same(with_rows(row_of(term, channel, form, FRAME)), channel)


@pytest.mark.parametrize("what", [*MADE])
def test_what_is_no_term_of_the_bank_is_written_too(what: str) -> None:
    same(with_rows(*MADE[what]), CHANNEL.get(what, TRANSMISSION_ERROR))


@pytest.mark.parametrize(
    "law",
    [
        {"effect": "te.velocity_nonlinear", "law": {**LAW, "form": "exponential", "point": [0.05]}},
        {"effect": "te.drift_time", "law": {**LAW, "form": "creep", "point": [0.3]}},
        {"effect": "te.resonance", "law": {"form": "second_order", "point": [0.2, 0.1, 0.7], "orders": [3.0]}},
        {"effect": "te.resonance", "law": {"form": "second_order_of_base", "point": [0.2, 0.1, 0.7], "orders": [3.0]}},
        {"effect": "te.resonance", "law": {"form": "second_order_unsigned", "point": [0.2, 0.1, 0.7], "orders": [3.0]}},
        {"effect": "te.resonance", "law": {**LAW, "form": "second_order_of_base_each", "point": [0.2, 0.1]}},
    ],
    ids=[
        "film",
        "drift",
        "resonance",
        "resonance of the base",
        "resonance of the size",
        "resonance that each order moves as it will",
    ],
)
def test_laws_that_orders_follow_are_written(law: dict[str, Any]) -> None:
    same(with_rows(*MADE["series"], law), TRANSMISSION_ERROR)


def test_a_resonance_is_written_as_its_steady_response_and_says_so() -> None:
    law = {"effect": "te.resonance", "law": {"form": "second_order", "point": [0.2, 0.1, 0.7], "orders": [3.0]}}
    simulation = with_rows(*MADE["series"], law)
    assert np.abs(swinging(Given.of(simulation), FRAME)).max() > 0.0
    assert any("swings by freely" in note for note in formulas_of(simulation).notes)
    unsigned = {**law, "law": {**law["law"], "form": "second_order_unsigned"}}
    assert np.abs(swinging(Given.of(with_rows(*MADE["series"], unsigned)), FRAME)).max() == 0.0
    assert not any("swings" in note for note in formulas_of(with_rows(*MADE["series"], unsigned)).notes)
    assert not any("swings" in note for note in formulas_of(with_rows(*MADE["series"])).notes)


LOSS: tuple[dict[str, Any], ...] = (
    {"effect": "motor.torque_offset", "parameters": {"tau_0": {"value": 0.2, "unit": "N*m"}}},
    {"effect": "load.torque_offset", "parameters": {"z_0": {"value": 30.0, "unit": "N*m"}}},
    {"effect": "motor.inertia", "parameters": {"J": {"value": 0.5, "unit": "kg*m^2"}}},
    {"effect": "motor.torque_constant", "form": "gain", "channels": ["motor_torque"], "parameters": {"g": 0.3}},
    {
        "effect": "load.unbalance",
        "form": "gravity",
        "channels": ["motor_torque"],
        "parameters": {"m_s": {"value": 40.0, "unit": "N*m"}, "m_c": {"value": -25.0, "unit": "N*m"}},
    },
    {
        "effect": "unknown",
        "channels": ["motor_torque"],
        "form": "table",
        "over": ["speed"],
        "times": "d",
        "knots": [[0.0, 0.5]],
        "values": [0.4, 0.1],
    },
)


@pytest.mark.parametrize("which", [[], *([name] for name in TAKEN_OFF), [*TAKEN_OFF]])
def test_what_is_taken_off_the_loss_is_taken_off_in_a_formula(which: list[str]) -> None:
    heating = {"effect": "thermal.loss_heating", "parameters": {"1/C": {"value": 2e-4, "unit": "K/J"}}, "less": which}
    simulation = with_rows(heating, *LOSS)
    predictor = Predictor(Given.of(simulation))
    frame = Zeros(
        tuple(name for name in which if name not in SINGLE),
        {"motor_torque": 0.2, "load_torque": 30.0},
        {},
        {name: reported_by(predictor.given.known["motor_torque"], name) for name in REPORTED},
        0.5,
        lambda frame: predictor.channel(MOTOR_TORQUE, frame),
    ).less(FRAME)
    rise = predictor.channel(TEMPERATURE, frame, np.zeros(1))
    formulas = formulas_of(simulation, STANDSTILL)
    np.testing.assert_allclose(run(simulation, name_of(TEMPERATURE)), rise - rise[0] + 25.0, rtol=1e-9)
    assert any("zeros of single recordings" in note for note in formulas.notes) is bool(set(SINGLE) & set(which))
    if set(which) - set(SINGLE):
        plain = predictor.channel(TEMPERATURE, FRAME, np.zeros(1))
        assert np.abs(plain - plain[0] - rise + rise[0]).max() > 1e-6


def test_what_cannot_go_out_is_said() -> None:
    with pytest.raises(ConfigurationError, match=r"no numbers for friction.coulomb"):
        formulas_of(Simulation.nominal())
    with pytest.raises(ConfigurationError, match="stands on one from elsewhere"):
        formulas_of(Simulation(extra={"base": {"kind": "fmu"}}))
