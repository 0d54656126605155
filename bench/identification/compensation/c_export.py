"""The transmission-error model as a plain C function, for a drive or a real-time target, with a test of its own.

C99 without allocation or library beyond ``math.h``; all tables are ``static const``. The function evaluates the very
polynomials of the simulation file in double precision.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.errors import ConfigurationError
from bench.simulation import TERM_COUNT, FourierSet, Simulation, TransmissionErrorModel
from bench.whole import write_whole

FloatArray = NDArray[np.float64]

TEST_POINTS = 200
TOLERANCE = 1e-12
"""rad; sums of some tens of terms of 1e-4 rad differ by rounding, and by the last bits of sin, only."""

_HEADER = """/* Transmission error of a gearbox, TE = q - theta, in rad: a Fourier series whose amplitudes, phases and
   offset are quadratic polynomials of load torque, velocity and temperature (Bauer et al., ICIT 2025). Generated from
   a simulation file.

   theta        input angle / ratio, rad        torque       load torque, N m
   velocity     rate of theta, rad/s            temperature  lubricant, degC
   direction    sign of the (last) motion: >= 0 positive, < 0 negative

   Feedforward: send the motor to theta_d = q_d - transmission_error(theta_d, ...). */
#ifndef TRANSMISSION_ERROR_H
#define TRANSMISSION_ERROR_H
double transmission_error(double theta, double torque, double velocity, double temperature, int direction);
/* Derivative by theta, for a velocity feedforward: theta_d' = q_d' / (1 + transmission_error_slope(...)). */
double transmission_error_slope(double theta, double torque, double velocity, double temperature, int direction);
#endif
"""

_BODY = """
static double polynomial(const double *p, const double *x)
{
    double sum = 0.0;
    for (int i = 0; i < TERMS; i++) sum += p[i] * x[i];
    return sum;
}

static void monomials(double *x, double torque, double velocity, double temperature)
{
    x[0] = torque * torque;
    x[1] = velocity * velocity;
    x[2] = temperature * temperature;
    x[3] = torque;
    x[4] = velocity;
    x[5] = temperature;
    x[6] = torque * velocity;
    x[7] = torque * temperature;
    x[8] = velocity * temperature;
    x[9] = 1.0;
}

double transmission_error(double theta, double torque, double velocity, double temperature, int direction)
{
    double x[TERMS];
    const int d = direction < 0;
    monomials(x, torque, velocity, temperature);
    double sum = polynomial(OFFSET[d], x);
    for (int k = 0; k < ORDERS; k++)
        sum += polynomial(AMPLITUDE[d][k], x) * sin(ORDER[k] * theta + polynomial(PHASE[d][k], x));
    return sum;
}

double transmission_error_slope(double theta, double torque, double velocity, double temperature, int direction)
{
    double x[TERMS];
    const int d = direction < 0;
    monomials(x, torque, velocity, temperature);
    double sum = 0.0;
    for (int k = 0; k < ORDERS; k++)
        sum += ORDER[k] * polynomial(AMPLITUDE[d][k], x) * cos(ORDER[k] * theta + polynomial(PHASE[d][k], x));
    return sum;
}
"""

_TEST_MAIN = """
int main(void)
{
    double worst = 0.0;
    for (int n = 0; n < POINTS; n++) {
        const double *p = POINT[n];
        const double off = fabs(transmission_error(p[0], p[1], p[2], p[3], p[4] < 0.0 ? -1 : 1) - p[5]);
        if (!(off <= worst)) worst = off;
    }
    printf("%.3e\\n", worst);
    return worst <= TOLERANCE ? 0 : 1;
}
"""


def _row(values: FloatArray) -> str:
    return "{" + ", ".join(float(v).hex() for v in values) + "}"


def _block(name: str, shape: str, sets: list[list[str]]) -> str:
    body = ",\n".join("  {" + ",\n   ".join(rows) + "}" for rows in sets)
    return f"static const double {name}{shape} = {{\n{body}\n}};\n"


def _sets(model: TransmissionErrorModel) -> tuple[FourierSet, FourierSet]:
    """Both directions on one list of orders; a direction that is missing is refused."""
    if model.positive is None or model.negative is None:
        missing = "positive" if model.positive is None else "negative"
        raise ConfigurationError(f"the model has no {missing} direction; a C function needs both")
    if not np.array_equal(model.positive.orders, model.negative.orders):
        raise ConfigurationError("the two directions of the model have different orders; a C function needs the same")
    return model.positive, model.negative


def c_source(model: TransmissionErrorModel) -> str:
    """Return the C source of the model; coefficients stand in hexadecimal, so no digit is lost."""
    sets = _sets(model)
    orders = sets[0].orders
    size = max(orders.size, 1)
    tables = [
        f"enum {{ TERMS = {TERM_COUNT}, ORDERS = {orders.size} }};\n",
        f"static const double ORDER[{size}] = {_row(orders) if orders.size else '{0}'};\n",
        "static const double OFFSET[2][TERMS] = {\n  " + ",\n  ".join(_row(s.offset) for s in sets) + "\n};\n",
    ]
    for name, attribute in (("AMPLITUDE", "amplitude"), ("PHASE", "phase")):
        rows = [[_row(r) for r in getattr(s, attribute)] or ["{0}"] for s in sets]
        tables.append(_block(name, f"[2][{size}][TERMS]", rows))
    return '#include "transmission_error.h"\n#include <math.h>\n\n' + "\n".join(tables) + _BODY


def c_test(model: TransmissionErrorModel, seed: int = 0) -> str:
    """Return a C program that compares the function with this model at random points; exit code 0 when it agrees."""
    _sets(model)
    rng = np.random.default_rng(seed)
    points = np.column_stack(
        [
            rng.uniform(-20.0, 20.0, TEST_POINTS),
            rng.uniform(-1000.0, 1000.0, TEST_POINTS),
            rng.uniform(-0.175, 0.175, TEST_POINTS),
            rng.uniform(20.0, 50.0, TEST_POINTS),
            np.where(np.arange(TEST_POINTS) % 2, -1.0, 1.0),
        ]
    )
    values = model.evaluate(*points.T)
    rows = ",\n  ".join(_row(np.append(p, v)) for p, v in zip(points, values, strict=True))
    return (
        '#include "transmission_error.h"\n#include <math.h>\n#include <stdio.h>\n\n'
        f"enum {{ POINTS = {TEST_POINTS} }};\n"
        f"static const double TOLERANCE = {TOLERANCE!r}; /* rad */\n"
        f"static const double POINT[POINTS][6] = {{\n  {rows}\n}};\n" + _TEST_MAIN
    )


def export_c(simulation: Simulation, folder: Path) -> tuple[Path, ...]:
    """Write header, source and test into ``folder``; returns their paths.

    Raises ConfigurationError where the simulation holds no transmission error of both directions.
    """
    model = simulation.transmission_error()
    if model is None:
        raise ConfigurationError("the model holds no transmission error; identify it first with 'bench identify'")
    contents = {
        "transmission_error.h": _HEADER,
        "transmission_error.c": c_source(model),
        "test_transmission_error.c": c_test(model),
    }
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in contents.items():
        write_whole(folder / name, text)
    return tuple(folder / name for name in contents)
