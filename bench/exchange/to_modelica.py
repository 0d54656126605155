"""A simulation as Modelica source: one block that samples its inputs.

Everything is worked out at the samples, as the analysis does; between them outputs are held.
"""

from __future__ import annotations

from bench.exchange.formula import Written
from bench.exchange.written import STATES, Formulas, identifier

_INFIX = {
    "add": "+", "sub": "-", "mul": "*", "div": "/", "gt": ">", "ge": ">=", "lt": "<", "le": "<=", "eq": "==",
    "ne": "<>", "pow": "^",
}  # fmt: skip
_COMPARISONS = ("gt", "ge", "lt", "le", "eq", "ne")
_CALLS = {
    "abs": "abs", "sin": "sin", "cos": "cos", "exp": "exp", "tanh": "tanh", "atan": "atan", "log": "log",
    "log10": "log10", "sqrt": "sqrt", "max": "max", "min": "min", "sign": "sign", "mod": "mod",
}  # fmt: skip
_VALUE = {"lag": 2, "play": 2, "held": 2, "begun": 2}
"""where a state's value stands among its three numbers, if not last"""

_FUNCTIONS = """
  function look_up "Linear between knots of several quantities, constant beyond; the last quantity runs fastest"
    input Integer sizes[:];
    input Real knots[:];
    input Real values[:];
    input Real at[:];
    output Real y;
  protected
    Integer k;
    Integer step;
    Real x;
    Real share;
  algorithm
    if size(at, 1) == 0 then
      y := values[1];
      return;
    end if;
    step := div(size(values, 1), sizes[1]);
    x := min(max(at[1], knots[1]), knots[sizes[1]]);
    k := 1;
    while k < sizes[1] - 1 and knots[k + 1] <= x loop
      k := k + 1;
    end while;
    share := (x - knots[k])/(knots[k + 1] - knots[k]);
    y := (1 - share)*look_up(sizes[2:end], knots[sizes[1] + 1:end], values[(k - 1)*step + 1:k*step], at[2:end])
      + share*look_up(sizes[2:end], knots[sizes[1] + 1:end], values[k*step + 1:(k + 1)*step], at[2:end]);
  end look_up;

  partial function State "From the state before, the time since and the input to the state; z[1] is 1 once it began"
    input Real z[3];
    input Real dt;
    input Real x;
    output Real y[3];
  end State;

  function relaxing
    extends State;
    input Real rate;
    input Real height;
    input Real scale;
    input Real from_zero;
  protected
    Real step;
    Real push;
    Real loss;
    Real target;
  algorithm
    y := if z[1] > 0 then z else {1, if from_zero > 0 then 0 else x, 0};
    step := x - y[2];
    y[2] := x;
    push := abs(step)/scale;
    loss := push/height + rate*dt;
    if loss > 0 then
      target := sign(step)*push/loss;
      y[3] := target + (y[3] - target)*exp(-loss);
    end if;
  end relaxing;

  function play
    extends State;
    input Real half_width;
  algorithm
    y := {1, min(max(z[2], x - half_width), x + half_width), 0};
  end play;

  function lag
    extends State;
    input Real constant_s;
  algorithm
    y := {1, if z[1] > 0 then x + (z[2] - x)*exp(-dt/constant_s) else x, 0};
  end lag;

  function integral
    extends State;
  algorithm
    y := {1, x, if z[1] > 0 then z[3] + 0.5*(x + z[2])*dt else 0};
  end integral;

  function limited_integral
    extends State;
    input Real limit;
  algorithm
    y := {1, x, if z[1] > 0 then min(max(z[3] + 0.5*(x + z[2])*dt, -limit), limit) else 0};
  end limited_integral;

  function campaign_lag
    extends State;
    input Real constant_s;
  protected
    Real slope;
    Real begin;
  algorithm
    y := if z[1] > 0 then z else {1, x, x};
    if dt > 0 then
      slope := (x - y[2])/dt;
      begin := y[2] - slope*constant_s;
      y[3] := x - slope*constant_s + (y[3] - begin)*exp(-dt/constant_s);
    end if;
    y[2] := x;
  end campaign_lag;

  function worked_up
    extends State;
    input Real rest_s;
    input Real motion_s;
  protected
    Real moves[2];
  algorithm
    y := if z[1] > 0 then z else {1, x, 0};
    moves := {y[2], x};
    for i in 1:2 loop
      y[3] := if moves[i] > 0.5 then 1 + (y[3] - 1)*exp(-0.5*dt/motion_s) else y[3]*exp(-0.5*dt/rest_s);
    end for;
    y[2] := x;
  end worked_up;

  function held
    extends State;
  algorithm
    y := {1, if abs(x) > 0 then x else z[2], 0};
  end held;

  function distance
    extends State;
  algorithm
    y := {1, x, if z[1] > 0 then z[3] + abs(x - z[2]) else 0};
  end distance;

  function begun
    extends State;
    input Real direction;
  algorithm
    y := {1, if z[1] < 1 or (abs(direction) > 0 and abs(direction - z[3]) > 0) then x else z[2], direction};
  end begun;

  function reversals
    extends State;
  algorithm
    y := {1, x, if abs(x - z[2]) > 0 and abs(z[2]) > 0 then 1 else z[3]};
  end reversals;
"""


_SI = "SI, rad, degC"


def to_modelica(formulas: Formulas, name: str = "Simulation") -> str:
    """Source of a block; inputs, outputs and parameters bear the names of those of other forms."""
    steps = formulas.steps
    name_of = {id(step): f"v{k}" for k, step in enumerate(steps)}
    declared, lines = [], []
    for step in steps:
        if step.op in ("const", "input", "parameter"):
            continue
        var = name_of[id(step)]
        if step.op in STATES:
            declared.append(f"  discrete Real z_{var}[3](each start = 0, each fixed = true);")
            more = ", ".join([*(_operand(a, name_of) for a in step.args), *(_number(c) for c in step.extra)])
            lines.append(f"    z_{var} := {step.op}(pre(z_{var}), dt, {more});")
            lines.append(f"    {var} := z_{var}[{_VALUE.get(step.op, 3)}];")
            declared.append(f"  discrete Real {var};")
        else:
            declared.append(f"  discrete {'Boolean' if step.op in _COMPARISONS else 'Real'} {var};")
            lines.append(f"    {var} := {_expression(step, name_of)};")
    return "\n".join(
        [
            f'block {name} "A simulation, written by bench export-model from a simulation file; {formulas.words(_SI)}"',
            '  parameter Real period(unit = "s") = 0.001 "time between samples";',
            *(
                f'  parameter Real {p.name} = {_number(p.value)} "{_text(p.meaning)} [{p.unit}]";'
                for p in formulas.parameters
            ),
            *(f'  input Real {identifier(n)} "{_text(_meaning(n, formulas))}";' for n in formulas.inputs),
            *(f"  output Real {n}(start = 0, fixed = true);" for n in formulas.outputs),
            "protected",
            "  discrete Real begun_at(start = -1, fixed = true);",
            "  discrete Real dt(start = 0, fixed = true);",
            *declared,
            _FUNCTIONS,
            "algorithm",
            "  when sample(0, period) then",
            "    dt := if pre(begun_at) < 0 then 0 else time - pre(begun_at);",
            "    begun_at := time;",
            *lines,
            *(f"    {n} := {_operand(output, name_of)};" for n, output in formulas.outputs.items()),
            "  end when;",
            f"end {name};",
            "",
        ]
    )


def _meaning(name: str, formulas: Formulas) -> str:
    unit, meaning = formulas.input(name)
    return f"{meaning} [{unit}]" if unit else meaning


def _text(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"')


def _number(value: float) -> str:
    return repr(float(value)) if value >= 0 else f"({float(value)!r})"


def _operand(expression: Written, name_of: dict[int, str]) -> str:
    if expression.op == "const":
        return _number(expression.extra[0])
    if expression.op == "input":
        return identifier(expression.extra[0]) if expression.extra[0] != "time" else "time"
    return str(expression.extra[0]) if expression.op == "parameter" else name_of[id(expression)]


def _expression(expression: Written, name_of: dict[int, str]) -> str:
    args = [_operand(a, name_of) for a in expression.args]
    if expression.op in _INFIX:
        return f"{args[0]} {_INFIX[expression.op]} {args[1]}"
    if expression.op == "neg":
        return f"-{args[0]}"
    if expression.op == "where":
        return f"if {args[0]} then {args[1]} else {args[2]}"
    if expression.op == "asinh":
        return f"log({args[0]} + sqrt({args[0]}^2 + 1))"
    if expression.op == "log1p":
        return f"log(1 + {args[0]})"
    if expression.op == "table":
        knots, values = expression.extra
        sizes = ", ".join(str(len(k)) for k in knots)
        flat = ", ".join(_number(v) for k in knots for v in k)
        return f"look_up({{{sizes}}}, {{{flat}}}, {{{', '.join(_number(v) for v in values)}}}, {{{', '.join(args)}}})"
    return f"{_CALLS[expression.op]}({', '.join(args)})"
