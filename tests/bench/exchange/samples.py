"""Samples that move every quantity, and a simulation file with a term in a form."""

from __future__ import annotations

from typing import Any

import numpy as np

from bench.exchange.sample import frame_of
from bench.exchange.written import OUTPUT
from bench.mismatch.given import Given
from bench.mismatch.prediction import Predictor
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.model import Simulation
from bench.simulation.terms import LIBRARY, TEMPERATURE, Form, Term

RATIO, STEP, ROWS, STANDSTILL = 185.0, 0.05, 240, 1e-3


def inputs() -> dict[str, FloatArray]:
    """Forth, rest, back, forth; load, temperature and an oil pressure that go up and down."""
    time = STEP * np.arange(ROWS)
    speed = 20.0 * np.sin(0.9 * time + 0.3)
    speed = np.where(np.abs(speed) < 4.0, 0.0, speed)
    angle = np.cumsum(speed) * STEP
    load = 400.0 * np.sin(1.3 * time) + 100.0
    return {
        "time": time,
        "motor_angle": angle,
        "motor_velocity": speed,
        "motor_acceleration": np.gradient(speed, STEP),
        "motor_torque": load / RATIO + 0.4 * np.sign(speed),
        "load_angle": angle / RATIO - load / 4e6,
        "load_velocity": speed / RATIO,
        "load_acceleration": np.gradient(speed, STEP) / RATIO,
        "load_torque": load,
        "load_torque_rate": 520.0 * np.cos(1.3 * time),
        "load_motor_torque": 0.98 * load + 5.0,
        "temperature": 25.0 + 1.5 * time,
        "aux/pressure": 3.0 + np.cos(0.5 * time),
    }


def bare() -> Simulation:
    """Every nominal term switched off."""
    return Simulation.from_json(
        {
            "format": "bench-simulation",
            "format_version": "1.0",
            "terms": [{"effect": e, "enabled": False} for e, t in LIBRARY.items() if t.nominal],
        }
    )


def with_rows(*rows: dict[str, Any]) -> Simulation:
    """The bare simulation with rows of a simulation file."""
    content = bare().to_json()
    effects = {row["effect"] for row in rows}
    content["terms"] = [row for row in content["terms"] if row["effect"] not in effects] + list(rows)
    return Simulation.from_json(content)


def row_of(term: Term, channel: str, form: Form, frame: Frame) -> dict[str, Any]:
    """A row with a term in a form, coefficients of the order of one, at the middle of its grid."""
    # a form that these samples do not show stands at one
    grid = form.grid(frame) or ((1.0,) * len(form.nonlinear),)
    parameters = {s.symbol: {"value": 0.3 + 0.1 * k, "unit": s.unit} for k, s in enumerate(form.linear)}
    if term.nominal:
        return {"effect": term.effect, "parameters": parameters}
    point = list(grid[len(grid) // 2])
    return {
        "effect": term.effect,
        "form": form.name,
        "point": point,
        "channels": [channel],
        "parameters": parameters | {s.symbol: v for s, v in zip(form.nonlinear, point, strict=True)},
    }


def ours(simulation: Simulation, channel: str, start: float) -> FloatArray:
    """Our own prediction of the samples; the temperature from ``start`` on."""
    frame = frame_of(inputs(), RATIO, STANDSTILL)
    predictor = Predictor(Given.of(simulation))
    if channel != TEMPERATURE:
        return predictor.channel(channel, frame)
    rise = predictor.channel(channel, frame, np.zeros(1))
    return np.asarray(rise - rise[0] + start)


def name_of(channel: str) -> str:
    """Name of a channel among the outputs."""
    return OUTPUT + channel
