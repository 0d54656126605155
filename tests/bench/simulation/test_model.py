from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.errors import ConfigurationError
from bench.simulation import (
    NOMINAL_TERMS,
    FourierSet,
    Parameter,
    Simulation,
    Term,
    TransmissionErrorModel,
    basis,
    evaluate,
)
from bench.simulation.terms import LIBRARY


def _model() -> TransmissionErrorModel:
    rng = np.random.default_rng(1)

    def one() -> FourierSet:
        return FourierSet(
            np.array([1.0, 46.0]), rng.normal(size=(2, 10)), rng.normal(size=(2, 10)), rng.normal(size=10),
            np.ones((2, 10)), np.ones((2, 10)), np.ones(10), np.ones((2, 20, 20)), np.ones((10, 10)),
        )  # fmt: skip

    return TransmissionErrorModel(one(), one())


def test_series_of_polynomials_is_the_series_of_their_values() -> None:
    fourier = _model().positive
    assert fourier is not None
    theta, x = np.linspace(0, 7, 40), (np.linspace(-1, 1, 40), np.full(40, 0.1), np.full(40, 0.3))
    rows = basis(*x)
    direct = evaluate(theta, fourier.orders, rows @ fourier.amplitude.T, rows @ fourier.phase.T, rows @ fourier.offset)
    assert np.allclose(fourier.evaluate(theta, *x), direct)
    by_hand = rows @ fourier.offset
    for k, order in enumerate(fourier.orders):
        by_hand = by_hand + (rows @ fourier.amplitude[k]) * np.sin(order * theta + rows @ fourier.phase[k])
    assert np.allclose(direct, by_hand)


def test_direction_chooses_the_set_and_a_missing_one_gives_nan() -> None:
    model = _model()
    half = replace(model, negative=None)
    value = half.evaluate([0.1, 0.1], 0.0, 0.1, 30.0, [1.0, -1.0])
    assert np.isfinite(value[0])
    assert np.isnan(value[1])


def test_file_round_trip_keeps_everything(tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    simulation = Simulation.nominal().with_transmission_error(_model())
    simulation = simulation.with_term(Term("friction.stribeck", parameters={"f_s": Parameter(0.4, "N*m", 0.02)}))
    simulation = simulation.with_term(Term("unknown", extra={"table": [1, 2, 3]}))
    simulation.save(path)
    again = Simulation.load(path)
    assert again.to_json() == simulation.to_json()
    assert again.value("friction.stribeck", "f_s") == 0.4
    assert again.terms["unknown"].extra == {"table": [1, 2, 3]}


def test_the_specs_example_is_read() -> None:
    simulation = Simulation.from_json(
        {
            "format": "bench-simulation", "format_version": "1.0",
            "gearbox": {"ratio": 185.0, "z1": 24, "z2": 96, "z3": 45, "z4": 46},
            "terms": [
                {"effect": "friction.coulomb", "enabled": False},
                {"effect": "friction.stribeck", "parameters": {"f_s": {"value": 0.4, "unit": "N*m", "std": 0.02}}},
                {"effect": "te.fourier", "enabled": True, "orders": [1, 3, 46]},
            ],
            "remark": "kept",
        }
    )  # fmt: skip
    assert not simulation.enabled("friction.coulomb")
    assert simulation.value("friction.coulomb", "f_c") == 0.0
    assert simulation.value("friction.viscous", "f_v") is None
    assert simulation.enabled("thermal.convection")
    assert not simulation.enabled("thermal.second_mass")
    assert simulation.transmission_error() is None
    assert simulation.to_json()["remark"] == "kept"
    assert set(NOMINAL_TERMS) <= set(simulation.terms)


def test_what_is_switched_off_is_left_out() -> None:
    simulation = Simulation.nominal().with_transmission_error(_model())
    series = simulation.terms["te.fourier"]
    only = simulation.with_term(replace(series, orders=(46.0,))).transmission_error()
    assert only is not None
    assert only.positive is not None
    assert only.positive.orders.tolist() == [46.0]
    flat = simulation.with_term(replace(simulation.terms["te.offset"], enabled=False)).transmission_error()
    assert flat is not None
    assert flat.positive is not None
    assert not flat.positive.offset.any()


def test_offset_beside_the_orders_is_read_too() -> None:
    row = {"positive": {"1": {"A": [0] * 9 + [1e-5], "phi": [0] * 10}, "a0": [0] * 9 + [2e-4]}}
    simulation = Simulation.from_json(
        {"format": "bench-simulation", "format_version": "1.0", "terms": [{"effect": "te.fourier", "parameters": row}]}
    )
    model = simulation.transmission_error()
    assert model is not None
    assert model.evaluate([0.0], 0.0, 0.0, 0.0, 1.0)[0] == pytest.approx(2e-4)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"format": "x"}, "'format' should be"),
        ({"format_version": "2.0"}, "format_version"),
        ({"terms": {}}, "'terms' should be a list"),
        ({"terms": [{"enabled": True}]}, "'effect'"),
        ({"terms": [{"effect": "a", "enabled": 1}]}, "true or false"),
        ({"terms": [{"effect": "a", "enabledd": False}]}, "has the key 'enabledd', it should be 'enabled'"),
        ({"terms": [{"effect": "a", "parameters": {"p": "x"}}]}, "terms[0].parameters.p"),
        ({"terms": [{"effect": "te.fourier", "orders": "1"}]}, "list of numbers"),
        ({"terms": [{"effect": "te.fourier", "parameters": {"positive": {"1": {"A": [1], "phi": [1]}}}}]}, "(10,)"),
        ({"terms": [{"effect": "te.fourier", "parameters": {"positive": {"x": {}}}}]}, "harmonic order"),
        ({"gearbox": {"ratio": 0}}, "positive number"),
    ],
)
def test_bad_files_get_a_sentence_with_the_place(change: dict[str, Any], words: str, tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    path.write_text(json.dumps({"format": "bench-simulation", "format_version": "1.0", "terms": []} | change))
    with pytest.raises(ConfigurationError) as caught:
        Simulation.load(path)
    assert words in str(caught.value)
    assert str(path) in str(caught.value)


def test_missing_and_broken_files_get_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="no such file"):
        Simulation.load(tmp_path / "none.json")
    broken = tmp_path / "broken.json"
    broken.write_text("{")
    with pytest.raises(ConfigurationError, match="JSON"):
        Simulation.load(broken)


def test_orders_between_whole_ones_keep_all_their_digits() -> None:
    orders = np.array([46.0, 123.0 + 1.0 / 3.0])
    one = FourierSet(orders, np.full((2, 10), 1e-6), np.zeros((2, 10)), np.zeros(10))
    told = Simulation.nominal().with_transmission_error(TransmissionErrorModel(one, one)).to_json()
    again = Simulation.from_json(json.loads(json.dumps(told))).transmission_error()
    assert again is not None
    assert again.positive is not None
    assert again.positive.orders.tolist() == orders.tolist()


def test_rows_of_a_term_are_itself_and_those_beside_it() -> None:
    value = Parameter(2.0, "N*m")
    beside = {"channels": ["load_torque"], "parameters": {"c": {"value": 3.0, "unit": "N*m"}}}
    both = Term("sensor.torque_gain", parameters={"c": value}, orders=(46.0,), extra={"also": [beside]})
    assert list(both.rows()) == [
        {"orders": [46.0], "parameters": {"c": 2.0}},
        {"channels": ["load_torque"], "parameters": {"c": 3.0}},
    ]
    only_beside = Term("sensor.torque_gain", extra={"also": [beside]})
    assert list(only_beside.rows()) == [{"channels": ["load_torque"], "parameters": {"c": 3.0}}]
    assert list(Term("friction.coulomb").rows()) == [{"parameters": {}}]


def test_a_form_is_found_by_channel_and_name() -> None:
    for term in LIBRARY.values():
        for channel, forms in term.forms.items():
            for form in forms:
                assert term.form(channel, form.name) is form
    assert LIBRARY["friction.coulomb"].form("motor_torque", "no such form") is None
    assert LIBRARY["friction.coulomb"].form("no such channel", "sign") is None


@pytest.mark.parametrize("teeth", [{"z1": "18"}, {"z2": [3]}, {"z3": -5}, {"z4": 0}, {"z1": 18.5}, {"z1": True}])
def test_tooth_numbers_are_whole(teeth: dict[str, object]) -> None:
    (name,) = teeth
    with pytest.raises(ConfigurationError, match=f"{name} is .* it should be a number of teeth, or null"):
        Simulation.from_json(Simulation.nominal().to_json() | {"gearbox": {"ratio": 185.0, **teeth}})
