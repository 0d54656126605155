"""Equations are set, whole, and well-formed; values have units people use, and what is not known is a dash."""

from __future__ import annotations

import math
from xml.dom import minidom

import pytest

from bench.simulation.terms import LIBRARY
from bench.typeset import engineering, figure, mathml, names_of, symbol


@pytest.mark.parametrize("effect", LIBRARY)
def test_every_equation_of_the_library_is_typeset_and_well_formed(effect: str) -> None:
    text = mathml(LIBRARY[effect].equation)
    minidom.parseString(f"<p>{text}</p>")
    for form in (form for forms in LIBRARY[effect].forms.values() for form in forms):
        own = mathml(LIBRARY[effect].equation_of(form))
        minidom.parseString(f"<p>{own}</p>")
        assert own.startswith("<math>")
    # what is no formula may stay text, as "or a knee" does
    assert "<math>" in text or "(or" in text or "(+" in text or "the same" in text


@pytest.mark.parametrize(
    ("equation", "parts"),
    [
        ("tau_m += f_v*w_m", ("<msub><mi>τ</mi><mtext>m</mtext></msub>", "<mo>…</mo><mo>+</mo>", "<mi>ω</mi>")),
        ("a/(b + c)", ("<mfrac><mi>a</mi><mrow>", "<mo>+</mo>")),
        ("abs(x)**2", ("<mo>|</mo>", "<msup>", "<mn>2</mn>")),
        ("exp(-t/t_c)", ("<msup><mi>e</mi>", "<mfrac><mrow><mo>−</mo><mi>t</mi></mrow>")),
        ("J*dw_m/dt", ("<mover><msub><mi>ω</mi>", "˙")),
        ("J_L*d2q/dt2", ("<mover><mi>q</mi><mo>¨</mo></mover>",)),
        ("T - 25 degC", ("<mn>25</mn><mtext> °C</mtext>", "−")),
        ("sum_k A_k*sin(f_k*theta)", ("<munder><mo>∑</mo><mi>k</mi></munder>", "<mi>sin</mi>")),
        ("A_f -> A_f*2", ("<mo>→</mo>",)),
    ],
)
def test_a_formula_is_set_as_people_write_it(equation: str, parts: tuple[str, ...]) -> None:
    text = mathml(equation)
    assert text.startswith("<math>")
    assert text.endswith("</math>")
    for part in parts:
        assert part in text


def test_what_is_no_formula_stays_as_it_was() -> None:
    assert mathml("x = 1; or a <knee>").endswith("; or a &lt;knee&gt;")
    assert mathml("f(a, b") == "f(a, b"
    assert names_of("tau_m += d*f_s*exp(-(abs(w_m)/w_s)) + 25 degC")[:4] == ["tau_m", "d", "f_s", "abs"]
    assert "ω" not in symbol("w_h")


def test_values_have_units_people_use_and_what_is_not_known_is_a_dash() -> None:
    assert engineering(5e-6, 1e-7, "rad") == ("5", "0.1", "µrad")
    assert engineering(0.0123, None, "N*m") == ("12.3", "–", "mN·m")
    assert engineering(350.0, math.nan, "N*m") == ("350", "–", "N·m")
    assert engineering(2.0, 0.5, "m*s^2") == ("2", "0.5", "m·s²")
    assert figure(math.nan) == "–"
