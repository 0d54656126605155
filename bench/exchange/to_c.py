"""A simulation as C99 without allocation: one file of source, one header; nothing but ``math.h``."""

from __future__ import annotations

from bench.exchange.formula import Written
from bench.exchange.written import STATES, Formulas, identifier

_INFIX = {
    "add": "+", "sub": "-", "mul": "*", "div": "/", "gt": ">", "ge": ">=", "lt": "<", "le": "<=", "eq": "==",
    "ne": "!=",
}  # fmt: skip
_CALLS = {
    "abs": "fabs", "sin": "sin", "cos": "cos", "exp": "exp", "tanh": "tanh", "atan": "atan", "asinh": "asinh",
    "log": "log", "log1p": "log1p", "log10": "log10", "sqrt": "sqrt", "max": "fmax", "min": "fmin", "sign": "sign",
    "pow": "pow", "mod": "modulo",
}  # fmt: skip
CELLS = 3
"""doubles that a state keeps: a mark that it has begun, and two numbers"""

_RUNTIME = """
static double sign(double x) { return (x > 0.0) - (x < 0.0); }

static double modulo(double x, double period)
{
    double rest = fmod(x, period);
    return rest != 0.0 && (rest < 0.0) != (period < 0.0) ? rest + period : rest;
}

/* Linear between knots of n quantities, constant beyond the outermost; the last quantity runs fastest. */
static double table(int n, const int *sizes, const double *const *knots, const double *values, const double *at)
{
    if (n == 0) return values[0];
    int k = 0, step = 1;
    for (int i = 1; i < n; i++) step *= sizes[i];
    double x = fmin(fmax(at[0], knots[0][0]), knots[0][sizes[0] - 1]);
    while (k < sizes[0] - 2 && knots[0][k + 1] <= x) k++;
    double share = (x - knots[0][k]) / (knots[0][k + 1] - knots[0][k]);
    return (1.0 - share) * table(n - 1, sizes + 1, knots + 1, values + k * step, at + 1)
        + share * table(n - 1, sizes + 1, knots + 1, values + (k + 1) * step, at + 1);
}

/* States: z[0] is 1 once they have begun; each is called once a sample, dt is the time since the sample before. */
static double relaxing(double *z, double dt, double x, double rate, double height, double scale,
                       double from_zero)
{
    if (z[0] == 0.0) { z[0] = 1.0; z[1] = from_zero != 0.0 ? 0.0 : x; z[2] = 0.0; }
    double step = x - z[1];
    z[1] = x;
    double push = fabs(step) / scale, loss = push / height + rate * dt;
    if (loss != 0.0) {
        double target = sign(step) * push / loss;
        z[2] = target + (z[2] - target) * exp(-loss);
    }
    return z[2];
}

static double play(double *z, double dt, double x, double half_width)
{
    (void)dt;
    z[1] = fmin(fmax(z[1], x - half_width), x + half_width);
    return z[1];
}

static double lag(double *z, double dt, double x, double constant)
{
    if (z[0] == 0.0) { z[0] = 1.0; z[1] = x; }
    z[1] = x + (z[1] - x) * exp(-dt / constant);
    return z[1];
}

static double integral(double *z, double dt, double x)
{
    if (z[0] == 0.0) { z[0] = 1.0; z[1] = x; z[2] = 0.0; }
    z[2] += 0.5 * (x + z[1]) * dt;
    z[1] = x;
    return z[2];
}

static double limited_integral(double *z, double dt, double x, double limit)
{
    if (z[0] == 0.0) { z[0] = 1.0; z[1] = x; z[2] = 0.0; }
    z[2] = fmin(fmax(z[2] + 0.5 * (x + z[1]) * dt, -limit), limit);
    z[1] = x;
    return z[2];
}

static double campaign_lag(double *z, double dt, double x, double constant)
{
    if (z[0] == 0.0) { z[0] = 1.0; z[1] = x; z[2] = x; }
    if (dt > 0.0) {
        double slope = (x - z[1]) / dt;
        double steady = x - slope * constant, begin = z[1] - slope * constant;
        z[2] = steady + (z[2] - begin) * exp(-dt / constant);
    }
    z[1] = x;
    return z[2];
}

static double worked_up(double *z, double dt, double x, double rest, double motion)
{
    if (z[0] == 0.0) { z[0] = 1.0; z[1] = x; z[2] = 0.0; }
    const double moves[2] = {z[1], x};
    for (int i = 0; i < 2; i++)
        z[2] = moves[i] > 0.5 ? 1.0 + (z[2] - 1.0) * exp(-0.5 * dt / motion) : z[2] * exp(-0.5 * dt / rest);
    z[1] = x;
    return z[2];
}

static double held(double *z, double dt, double x)
{
    (void)dt;
    if (x != 0.0) z[1] = x;
    return z[1];
}

static double distance(double *z, double dt, double x)
{
    (void)dt;
    if (z[0] == 0.0) { z[0] = 1.0; z[1] = x; }
    z[2] += fabs(x - z[1]);
    z[1] = x;
    return z[2];
}

static double begun(double *z, double dt, double x, double direction)
{
    (void)dt;
    if (z[0] == 0.0) { z[0] = 1.0; z[1] = x; }
    if (direction != 0.0 && direction != z[2]) z[1] = x;
    z[2] = direction;
    return z[1];
}

static double reversals(double *z, double dt, double x)
{
    (void)dt;
    if (x != z[1] && z[1] != 0.0) z[2] = 1.0;
    z[1] = x;
    return z[2];
}
"""


def number(value: float) -> str:
    """A double as C reads it again without loss."""
    text = repr(float(value))
    return text if any(c in text for c in ".en") else text + ".0"


def header(formulas: Formulas) -> str:
    """The header: numbers of inputs, outputs and parameters, what is kept, and the function."""

    def places(kind: str, names: list[str]) -> list[str]:
        return [f"#define {kind}_{identifier(name).upper()} {k}" for k, name in enumerate(names)]

    states = sum(step.op in STATES for step in formulas.steps)
    return "\n".join(
        [
            "/* A simulation, written by `bench export-model` from a simulation file. "
            f"{formulas.words('SI units, rad, degC')}. */",
            "#ifndef MODEL_H",
            "#define MODEL_H",
            *places("INPUT", list(formulas.inputs)),
            *places("OUTPUT", list(formulas.outputs)),
            *places("PARAMETER", [p.name for p in formulas.parameters]),
            f"#define INPUTS {len(formulas.inputs)}",
            f"#define OUTPUTS {len(formulas.outputs)}",
            f"#define PARAMETERS {len(formulas.parameters)}",
            f"#define STATES {states}",
            "",
            "typedef struct {",
            "    double p[PARAMETERS + 1];",
            f"    double z[STATES + 1][{CELLS}];",
            "    double time;",
            "    int begun;",
            "} Model;",
            "",
            "/* Parameters as they were found, states as at the beginning. */",
            "void model_begin(Model *m);",
            "/* Outputs y at a time in s from inputs u; samples are given in their order, each once. */",
            "void model_step(Model *m, double time, const double *u, double *y);",
            "#endif",
            "",
        ]
    )


def source(formulas: Formulas) -> str:
    """Source of ``model.c``."""
    steps = formulas.steps
    name_of = {id(step): f"v{k}" for k, step in enumerate(steps)}
    tables: list[str] = []
    lines: list[str] = []
    state = 0
    for step in steps:
        if step.op == "const":
            continue
        args = [_operand(a, name_of) for a in step.args]
        if step.op == "table":
            tables += _table(name_of[id(step)], step)
            expression = _look_up(name_of[id(step)], step, args)
        elif step.op in STATES:
            more = ", ".join([*args, *(number(c) for c in step.extra)])
            expression = f"{step.op}(m->z[{state}], dt, {more})"
            state += 1
        else:
            expression = _expression(step, args, formulas)
        lines.append(f"    const double {name_of[id(step)]} = {expression};")
    for k, output in enumerate(formulas.outputs.values()):
        lines.append(f"    y[{k}] = {_operand(output, name_of)};")
    defaults = ", ".join([*(number(p.value) for p in formulas.parameters), "0.0"])
    return "\n".join(
        [
            '#include "model.h"',
            "#include <math.h>",
            "#include <string.h>",
            "#if defined(__GNUC__)",
            '#pragma GCC diagnostic ignored "-Wunused-function"',
            "#endif",
            _RUNTIME,
            *tables,
            "",
            "void model_begin(Model *m)",
            "{",
            f"    static const double found[PARAMETERS + 1] = {{{defaults}}};",
            "    memset(m, 0, sizeof *m);",
            "    memcpy(m->p, found, sizeof m->p);",
            "}",
            "",
            "void model_step(Model *m, double time, const double *u, double *y)",
            "{",
            "    const double dt = m->begun ? time - m->time : 0.0;",
            "    (void)dt; (void)u;",
            "    m->begun = 1;",
            "    m->time = time;",
            *lines,
            "}",
            "",
        ]
    )


def _operand(expression: Written, name_of: dict[int, str]) -> str:
    return f"({number(expression.extra[0])})" if expression.op == "const" else name_of[id(expression)]


def _expression(expression: Written, args: list[str], formulas: Formulas) -> str:
    if expression.op == "input":
        return "time" if expression.extra[0] == "time" else f"u[{formulas.inputs.index(expression.extra[0])}]"
    if expression.op == "parameter":
        return f"m->p[{[p.name for p in formulas.parameters].index(expression.extra[0])}]"
    if expression.op in _INFIX:
        return f"{args[0]} {_INFIX[expression.op]} {args[1]}"
    if expression.op == "neg":
        return f"-{args[0]}"
    if expression.op == "where":
        return f"{args[0]} != 0.0 ? {args[1]} : {args[2]}"
    return f"{_CALLS[expression.op]}({', '.join(args)})"


def _table(name: str, expression: Written) -> list[str]:
    knots, values = expression.extra

    def array(kind: str, numbers: tuple[float, ...]) -> str:
        return f"static const double {name}_{kind}[] = {{{', '.join(number(v) for v in numbers)}}};"

    return [
        *(array(f"knots{k}", one) for k, one in enumerate(knots)),
        array("values", values),
        f"static const double *const {name}_knots[] = {{{', '.join(f'{name}_knots{k}' for k in range(len(knots)))}}};",
        f"static const int {name}_sizes[] = {{{', '.join(str(len(one)) for one in knots)}}};",
    ]


def _look_up(name: str, expression: Written, args: list[str]) -> str:
    at = f"(const double[]){{{', '.join(args)}}}"
    return f"table({len(expression.extra[0])}, {name}_sizes, {name}_knots, {name}_values, {at})"
