"""Equations as programs write them (``tau_m += f_v*w_m*(T - 25 degC)``) set as people do, in MathML.

What is no formula (``or a knee``) stays text, so that nothing of an equation is ever lost.
"""

from __future__ import annotations

import html
import re
from collections.abc import Callable

GREEK = {
    "tau": "τ",
    "theta": "θ",
    "phi": "φ",
    "zeta": "ζ",
    "beta": "β",
    "delta": "δ",
    "omega": "ω",
    "pi": "π",
}
_SPEEDS = frozenset({"w_m", "w_s"})
"""Written with a w by programs, and with an ω by people."""
_UNIT = re.compile(r"(\d+(?:\.\d+)?) (degC|kN\*m|N\*m|rad/s|rad|s|K)(?![\w*])")
_UNITS = {"degC": "°C", "kN*m": "kN·m", "N*m": "N·m"}
_TOKEN = re.compile(
    r"\s*(?:(?P<unit>\d+(?:\.\d+)? (?:degC|kN\*m|N\*m|rad/s|rad|s|K)(?!\w))"
    r"|(?P<number>\d+(?:\.\d+)?(?:e[+-]?\d+)?j?)"
    r"|(?P<rate>d2?[A-Za-z]\w*/dt2?(?!\w))"
    r"|(?P<name>[^\W\d]\w*)"
    r"|(?P<sign>\*\*|\+=|-=|->|[-+*/=(),]))"
)
_RELATIONS = {
    "=": "<mo>=</mo>",
    "+=": "<mo>=</mo><mo>…</mo><mo>+</mo>",
    "-=": "<mo>=</mo><mo>…</mo><mo>−</mo>",
    "->": "<mo>→</mo>",
}
_PARTS = re.compile(r"(, or |; or |, | or |; |: )")
_FUNCTIONS = frozenset({"sin", "cos", "tanh", "exp", "max", "min", "sgn", "log"})


class _NoFormula(ValueError):
    """A text that is none."""


def mathml(equation: str) -> str:
    """Return an equation as MathML, ``<math>`` elements and the text between them; safe to put into HTML."""
    out = []
    for number, part in enumerate(_split(equation)):
        if number % 2:
            out.append(html.escape(part))
            continue
        try:
            out.append(f"<math>{_Formula(part).whole()}</math>")
        except _NoFormula:
            out.append(html.escape(part))
    return "".join(out)


def symbol(name: str) -> str:
    """Return the MathML of one symbol, ``f_vT`` or ``tau``."""
    return f"<math>{_name(name)}</math>"


def names_of(equation: str) -> list[str]:
    """Names an equation uses, in their order, each once; those of its functions are left out."""
    found = re.findall(r"[^\W\d]\w*", _UNIT.sub("", equation))
    # "d" before a name is a differential, and words of the text are none of its names
    return [name for name in dict.fromkeys(found) if name not in _FUNCTIONS]


def _split(text: str) -> list[str]:
    """Parts of a text and what is between them, by turns; inside brackets nothing is split."""
    parts, depth, start = [], 0, 0
    position = 0
    while position < len(text):
        depth += {"(": 1, ")": -1}.get(text[position], 0)
        between = _PARTS.match(text, position)
        if between and depth == 0:
            parts += [text[start:position], between[0]]
            position = start = between.end()
            continue
        position += 1
    return [*parts, text[start:]]


def _name(name: str) -> str:
    if name == "degC":
        return "<mi>°C</mi>"
    if name in _SPEEDS:
        name = f"omega{name[1:]}"
    stem, _, below = name.partition("_")
    dotted = stem.startswith("d") and stem[1:] in GREEK
    stem = stem[1:] if dotted else stem
    sign = GREEK.get(stem, stem)
    # what begins with a letter alone may carry its number: a0
    if not below and (found := re.fullmatch(r"([A-Za-z])(\d+)", sign)):
        sign, below = found[1], found[2]
    element = f"<mi>{html.escape(sign)}</mi>"
    if dotted:
        element = f"<mover>{element}<mo>˙</mo></mover>"
    if not below:
        return element
    below = ",".join(GREEK.get(part, part) for part in below.split("_"))
    return f"<msub>{element}<mtext>{html.escape(below)}</mtext></msub>"


class _Formula:
    """A parser that writes while it reads: relation, sum, product, power, atom."""

    def __init__(self, text: str) -> None:
        self._tokens: list[tuple[str, str]] = []
        position = 0
        text = text.strip()
        while position < len(text):
            found = _TOKEN.match(text, position)
            if found is None or found.lastgroup is None:
                raise _NoFormula(text)
            self._tokens.append((found.lastgroup, found[found.lastgroup]))
            position = found.end()
        self._next = 0

    def whole(self) -> str:
        """The whole text as a relation."""
        out = [self._sum()]
        while self._sign() in _RELATIONS:
            out += [_RELATIONS[self._take()[1]], self._sum()]
        if self._next < len(self._tokens):
            raise _NoFormula(self._tokens[self._next][1])
        return f"<mrow>{''.join(out)}</mrow>"

    def _sign(self) -> str:
        kind, text = self._tokens[self._next] if self._next < len(self._tokens) else ("", "")
        return text if kind == "sign" else ""

    def _take(self) -> tuple[str, str]:
        if self._next >= len(self._tokens):
            raise _NoFormula("it ends too early")
        self._next += 1
        return self._tokens[self._next - 1]

    def _expect(self, sign: str) -> None:
        if self._take() != ("sign", sign):
            raise _NoFormula(f"{sign} is missing")

    def _sum(self) -> str:
        out = [self._product()]
        while self._sign() in ("+", "-"):
            out += [f"<mo>{'+' if self._take()[1] == '+' else '−'}</mo>", self._product()]
        return f"<mrow>{''.join(out)}</mrow>"

    def _product(self) -> str:
        out = self._power()
        while self._sign() in ("*", "/"):
            if self._take()[1] == "*":
                out = f"<mrow>{out}<mo>·</mo>{self._power()}</mrow>"
            else:
                out = f"<mfrac>{out}{self._power(bare=True)}</mfrac>"
        return out

    def _power(self, bare: bool = False) -> str:
        if self._sign() == "-":
            self._take()
            return f"<mrow><mo>−</mo>{self._power()}</mrow>"
        out = self._atom(bare)
        if self._sign() == "**":
            self._take()
            out = f"<msup>{out}{self._power(bare=True)}</msup>"
        return out

    def _atom(self, bare: bool) -> str:
        kind, text = self._take()
        if kind == "unit":
            value, unit = text.split(" ", 1)
            return f"<mrow><mn>{value}</mn><mtext> {_UNITS.get(unit, unit)}</mtext></mrow>"
        if kind == "number":
            return f"<mn>{text[:-1]}</mn><mi>j</mi>" if text.endswith("j") else f"<mn>{text}</mn>"
        if kind == "rate":
            return _rate(text)
        if kind == "name":
            return self._name_or_call(text)
        if text != "(":
            raise _NoFormula(text)
        inside = self._sum()
        self._expect(")")
        # below a line, or as an exponent, brackets say nothing
        return inside if bare and self._sign() != "**" else f"<mrow><mo>(</mo>{inside}<mo>)</mo></mrow>"

    def _name_or_call(self, name: str) -> str:
        if name.startswith("sum_"):
            return f"<mrow><munder><mo>∑</mo>{_name(name[4:])}</munder>{self._product()}</mrow>"
        if self._sign() != "(":
            return _name(name)
        self._take()
        inside = [self._sum()]
        while self._sign() == ",":
            self._take()
            inside.append(self._sum())
        self._expect(")")
        return _CALLS.get(name, _call)(name, "<mo>,</mo>".join(inside))


def _rate(text: str) -> str:
    """``dw_m/dt`` and ``d2q/dt2`` as the symbol with its dots."""
    above, _, _ = text.partition("/")
    twice = above.startswith("d2")
    return f"<mover>{_name(above[2 if twice else 1 :])}<mo>{'¨' if twice else '˙'}</mo></mover>"


def _call(name: str, inside: str) -> str:
    head = f"<mi>{name}</mi>" if name in _FUNCTIONS else _name(name)
    return f"<mrow>{head}<mo>(</mo>{inside}<mo>)</mo></mrow>"


_CALLS: dict[str, Callable[[str, str], str]] = {
    "abs": lambda _, inside: f"<mrow><mo>|</mo>{inside}<mo>|</mo></mrow>",
    "exp": lambda _, inside: f"<msup><mi>e</mi><mrow>{inside}</mrow></msup>",
    "sqrt": lambda _, inside: f"<msqrt>{inside}</msqrt>",
}
"""Functions that are written in a way of their own."""
