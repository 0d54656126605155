"""The equation of a finding of several parts names every parameter, and no symbol stands for two of them."""

from __future__ import annotations

import re
from typing import Any

import pytest

from bench.mismatch.equations import renamed, together
from bench.mismatch.orders.discoveries import PAIR
from bench.mismatch.regression.regressors import Free
from bench.simulation.laws import EQUATIONS, FUNCTIONS
from bench.simulation.tables import Grid
from bench.typeset import mathml


def rows(*symbols: str) -> list[dict[str, Any]]:
    return [{"symbol": s, "value": float(k), "unit": "1", "std": None} for k, s in enumerate(symbols)]


def test_parts_of_one_effect_have_symbols_of_their_own() -> None:
    stack = "TE += h_1*y_1/w_1, w_1 = 0.4*w, w_2 = w"
    equation, parameters = together([(stack, rows("h_1", "w")), ("TE += h*z, dz = dx/w", rows("h", "w"))])
    assert equation == f"{stack}; TE += h*z, dz = dx/w_3"
    assert [p["symbol"] for p in parameters] == ["h_1", "w", "h", "w_3"]
    assert [p["value"] for p in parameters] == [0.0, 1.0, 0.0, 1.0]


def test_tables_of_one_effect_are_functions_of_their_own() -> None:
    first, second = ("tau_m += d*f(angle), f a table", rows("f(angle=1)*d")), ("tau_m += f(speed)", rows("f(speed=1)"))
    equation, parameters = together([first, second])
    assert equation == "tau_m += d*f(angle), f a table; tau_m += f_2(speed)"
    assert [p["symbol"] for p in parameters] == ["f(angle=1)*d", "f_2(speed=1)"]


def test_parts_that_are_the_same_stand_once_and_numbers_are_no_names() -> None:
    assert together([("x += 1e-05*r", rows()), ("x += 1e-05*r", rows())])[0] == "x += 1e-05*r"
    assert renamed("1e-05*e + e_f", {"e": "k"}) == "1e-05*k + e_f"


def test_tables_of_one_function_are_told_apart_as_in_its_equation() -> None:
    both = Free("transmission_error", tuple(Grid(("speed",), times, ((0.1, 0.2),)) for times in ("p", "n")))
    zeros = [0.0] * 4
    assert [p["symbol"] for p in both.parameters(zeros, zeros)][::2] == [
        "f_1(speed=0.1)*[d > 0]",
        "f_2(speed=0.1)*[d < 0]",
    ]
    assert both.equation == "transmission_error += [d > 0]*f_1(speed) + [d < 0]*f_2(speed), f a table"


@pytest.mark.parametrize("law", FUNCTIONS, ids=" ".join)
def test_every_law_of_the_orders_has_its_equation(law: tuple[str, str]) -> None:
    text = EQUATIONS[law].format(start="0 s", span="3600 s", coldest="14.2 degC", largest="500 N*m")
    assert re.fullmatch("<math>.*</math>", mathml(f"g = {text}"))


def test_sidebands_have_all_their_symbols() -> None:
    assert all(re.search(rf"\b{s}\b", PAIR) for s in ("f", "m", "a_lower", "a_upper", "c_upper"))
