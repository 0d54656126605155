"""A simulation as a Python file that needs nothing but Python."""

from __future__ import annotations

from bench.exchange.formula import Written
from bench.exchange.written import STATES, Formulas

_INFIX = {
    "add": "+", "sub": "-", "mul": "*", "div": "/", "gt": ">", "ge": ">=", "lt": "<", "le": "<=", "eq": "==",
    "ne": "!=",
}  # fmt: skip
_CALLS = {
    "abs": "abs", "sin": "math.sin", "cos": "math.cos", "exp": "math.exp", "tanh": "math.tanh", "atan": "math.atan",
    "asinh": "math.asinh", "log": "math.log", "log1p": "math.log1p", "log10": "math.log10", "sqrt": "math.sqrt",
    "max": "max", "min": "min", "sign": "_sign", "pow": "_power", "mod": "_mod",
}  # fmt: skip

_RUNTIME = """

def _sign(x):
    return float(x > 0) - float(x < 0)


def _mod(x, period):
    return x % period


def _power(x, exponent):
    return x**exponent


def _table(knots, values, places):
    if not places:
        return values[0]
    own, step = knots[0], len(values) // len(knots[0])
    at = min(max(places[0], own[0]), own[-1])
    k = 0
    while k < len(own) - 2 and own[k + 1] <= at:
        k += 1
    share = (at - own[k]) / (own[k + 1] - own[k])
    low = _table(knots[1:], values[k * step : (k + 1) * step], places[1:])
    high = _table(knots[1:], values[(k + 1) * step : (k + 2) * step], places[1:])
    return (1.0 - share) * low + share * high


# States: each is called once a sample with what it keeps (a list), the step of time, and its input.


def _relaxing(s, dt, x, rate, height, scale, from_zero):
    if not s:
        s += [0.0 if from_zero else x, 0.0]
    step, s[0] = x - s[0], x
    push = abs(step) / scale
    loss = push / height + rate * dt
    if loss != 0.0:
        target = math.copysign(push, step) / loss
        s[1] = target + (s[1] - target) * math.exp(-loss)
    return s[1]


def _play(s, dt, x, half_width):
    if not s:
        s.append(0.0)
    s[0] = min(max(s[0], x - half_width), x + half_width)
    return s[0]


def _lag(s, dt, x, constant):
    if not s:
        s.append(x)
    s[0] = x + (s[0] - x) * math.exp(-dt / constant)
    return s[0]


def _integral(s, dt, x):
    if not s:
        s += [x, 0.0]
    s[1] += 0.5 * (x + s[0]) * dt
    s[0] = x
    return s[1]


def _limited_integral(s, dt, x, limit):
    if not s:
        s += [x, 0.0]
    s[1] = min(max(s[1] + 0.5 * (x + s[0]) * dt, -limit), limit)
    s[0] = x
    return s[1]


def _campaign_lag(s, dt, x, constant):
    if not s:
        s += [x, x]
    if dt > 0.0:
        slope = (x - s[0]) / dt
        steady, begin = x - slope * constant, s[0] - slope * constant
        s[1] = steady + (s[1] - begin) * math.exp(-dt / constant)
    s[0] = x
    return s[1]


def _worked_up(s, dt, x, rest, motion):
    if not s:
        s += [x, 0.0]
    for moves in (s[0], x):
        if moves > 0.5:
            s[1] = 1.0 + (s[1] - 1.0) * math.exp(-0.5 * dt / motion)
        else:
            s[1] *= math.exp(-0.5 * dt / rest)
    s[0] = x
    return s[1]


def _held(s, dt, x):
    if not s:
        s.append(0.0)
    if x != 0.0:
        s[0] = x
    return s[0]


def _distance(s, dt, x):
    if not s:
        s += [x, 0.0]
    s[1] += abs(x - s[0])
    s[0] = x
    return s[1]


def _begun(s, dt, x, direction):
    if not s:
        s += [x, 0.0]
    if direction != 0.0 and direction != s[1]:
        s[0] = x
    s[1] = direction
    return s[0]


def _reversals(s, dt, x):
    if not s:
        s += [x, 0.0]
    if x != s[0] and s[0] != 0.0:
        s[1] = 1.0
    s[0] = x
    return s[1]
"""


def to_python(formulas: Formulas, name: str = "Model") -> str:
    """Source of a class that is asked sample by sample: ``Model().step(time, {input: value})`` gives the outputs."""
    lines = [
        '"""A simulation, written by `bench export-model` from a simulation file; '
        f'{formulas.words("SI units, angles in rad, degC")}."""',
        "",
        "import math",
        _RUNTIME,
        "",
        f"class {name}:",
        f"    INPUTS = {list(formulas.inputs)!r}",
        f"    OUTPUTS = {list(formulas.outputs)!r}",
        f"    PARAMETERS = {{{', '.join(f'{p.name!r}: {p.value!r}' for p in formulas.parameters)}}}",
        "",
        "    def __init__(self, **parameters):",
        "        self.p = {**self.PARAMETERS, **parameters}",
        "        self.states = {}",
        "        self.before = None",
        "",
        "    def step(self, time, u):",
        '        """Outputs by name at a time in s; samples are given in their order, each once."""',
        "        dt = 0.0 if self.before is None else time - self.before",
        "        self.before = time",
        "        p, z = self.p, self.states",
    ]
    name_of = {id(step): f"v{k}" for k, step in enumerate(formulas.steps)}
    for step in formulas.steps:
        if step.op != "const":
            lines.append(f"        {name_of[id(step)]} = {_expression(step, name_of)}")
    ends = ", ".join(f"{output!r}: {_operand(expression, name_of)}" for output, expression in formulas.outputs.items())
    lines += [f"        return {{{ends}}}", ""]
    return "\n".join(lines)


def _operand(expression: Written, name_of: dict[int, str]) -> str:
    return f"({expression.extra[0]!r})" if expression.op == "const" else name_of[id(expression)]


def _expression(expression: Written, name_of: dict[int, str]) -> str:
    args = [_operand(a, name_of) for a in expression.args]
    if expression.op == "input":
        return "time" if expression.extra[0] == "time" else f"u[{expression.extra[0]!r}]"
    if expression.op == "parameter":
        return f"p[{expression.extra[0]!r}]"
    if expression.op in _INFIX:
        return f"{args[0]} {_INFIX[expression.op]} {args[1]}"
    if expression.op == "neg":
        return f"-{args[0]}"
    if expression.op == "where":
        return f"{args[1]} if {args[0]} else {args[2]}"
    if expression.op == "table":
        return f"_table({expression.extra[0]!r}, {expression.extra[1]!r}, [{', '.join(args)}])"
    if expression.op in STATES:
        more = [*args, *(repr(c) for c in expression.extra)]
        return f"_{expression.op}(z.setdefault({name_of[id(expression)]!r}, []), dt, {', '.join(more)})"
    return f"{_CALLS[expression.op]}({', '.join(args)})"
