"""Free-form rivals: smooth functions of one or two quantities that compete with every named term.

A rival knows no physics. Where it explains clearly more than the best named term, the effect is called unknown and is
described by the rival; where nothing named is left but a rival still gains, something is missing that the library
lacks.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR
from bench.simulation.terms.memory import integral, settled

KNOTS = 8
SLIGHT = 0.3
"""rad/s² at the motor, above which accelerations count by their order of magnitude"""
ANGLE_ORDERS = (1, 2, 3, 4, 5, 6)


@dataclass(frozen=True, slots=True)
class Rival:
    """A free-form function: its name, the quantities it depends on, and its columns (n, k)."""

    name: str
    variables: tuple[str, ...]
    columns: FloatArray
    common: bool = True
    """whether it belongs to the flexible model that tells the noise"""


QUANTITIES: dict[str, Callable[[Frame], FloatArray]] = {
    "speed": lambda frame: settled(np.abs(frame.velocity), frame),
    "velocity": lambda frame: settled(frame.velocity, frame),
    "torque": lambda frame: settled(frame.torque, frame),
    "load_motor_torque": lambda frame: settled(frame.load_motor_torque, frame),
    "temperature": lambda frame: frame.temperature,
    "time": lambda frame: frame.time,
    "since_reversal": lambda frame: np.log10(frame.reversal_travel + 1e-5),
    "torque_rate": lambda frame: frame.torque_rate,
    "elapsed": lambda frame: np.log10(frame.elapsed + 1.0),
    # in steady motion the acceleration is the encoder's noise
    "speeding_up": lambda frame: np.where(
        frame.steady > 0.5, 0.0, np.arcsinh(frame.acceleration * frame.direction / SLIGHT)
    ),
}


def hats(values: FloatArray, reference: FloatArray | None = None, knots: int = KNOTS) -> FloatArray:
    """Piecewise linear basis (n, k) of ``values``; knots at quantiles of ``reference`` (default: the values
    themselves).

    (n, 0) where the reference hardly varies.
    """
    x = values if reference is None else reference
    rounded = np.unique(np.round(x, 10))
    if rounded.size < 3 or np.ptp(x) == 0:
        return np.zeros((values.size, 0))
    sample = np.quantile(x, np.linspace(0.01, 0.99, knots))
    even = np.linspace(sample[0], sample[-1], knots)
    at = _apart(np.unique(0.5 * sample + 0.5 * even))
    if at.size < 3:
        return np.zeros((values.size, 0))
    return np.column_stack([np.interp(values, at, np.eye(at.size)[i]) for i in range(at.size)])


def _apart(knots: FloatArray) -> FloatArray:
    """Knots at least a sixteenth of the range apart: finer ones would follow the noise of the quantity itself."""
    least = (knots[-1] - knots[0]) / 16.0
    kept = [float(knots[0])]
    for knot in knots[1:]:
        if knot - kept[-1] >= least:
            kept.append(float(knot))
    return np.asarray(kept)


def strongest_orders(coefficients: FloatArray) -> list[float]:
    """Orders that carry a free function of the output angle, by its coefficients (cosine and sine of each order)."""
    if coefficients.size != 2 * len(ANGLE_ORDERS):
        return []
    size = np.hypot(coefficients[0::2], coefficients[1::2])
    return [float(f) for f, a in zip(ANGLE_ORDERS, size, strict=True) if a > 0.4 * size.max()]


def _waves(frame: Frame) -> FloatArray:
    return np.column_stack([f(order * frame.q) for order in ANGLE_ORDERS for f in (np.cos, np.sin)])


# channel -> (name, quantity, modulators): 1 plain, d sign of motion, w motor speed, pos/neg direction apart
_TABLE: dict[str, tuple[tuple[str, str, tuple[str, ...]], ...]] = {
    MOTOR_TORQUE: (
        ("friction over speed", "speed", ("d",)),
        ("torque over velocity", "velocity", ("1",)),
        ("friction over load", "torque", ("d",)),
        ("torque over load", "torque", ("1",)),
        ("friction over temperature", "temperature", ("d",)),
        ("viscous friction over temperature", "temperature", ("w",)),
        ("offset over temperature", "temperature", ("1",)),
        ("friction over time", "time", ("d",)),
        ("viscous friction over time", "time", ("w",)),
        ("offset over time", "time", ("1",)),
        ("friction since reversal", "since_reversal", ("d",)),
        ("friction since start", "elapsed", ("d",)),
        ("friction over acceleration", "speeding_up", ("d",)),
        ("torque over load, each direction apart", "torque", ("p", "n")),
        ("torque over speed, each direction apart", "speed", ("p", "n")),
    ),
    LOAD_TORQUE: (
        ("torque over load", "load_motor_torque", ("1",)),
        ("friction over load", "load_motor_torque", ("d",)),
        ("friction over speed", "speed", ("d",)),
        ("torque over speed", "speed", ("1",)),
        ("offset over temperature", "temperature", ("1",)),
        ("gain over temperature", "temperature", ("tau",)),
        ("friction over temperature", "temperature", ("d",)),
        ("offset over time", "time", ("1",)),
        ("gain over time", "time", ("tau",)),
        ("friction over time", "time", ("d",)),
        ("offset since reversal", "since_reversal", ("d",)),
        ("offset since start", "elapsed", ("1",)),
        ("torque over acceleration", "speeding_up", ("d",)),
        ("torque over speed, each direction apart", "speed", ("p", "n")),
    ),
    TRANSMISSION_ERROR: (
        ("offset over load", "torque", ("p", "n")),
        ("offset over speed", "speed", ("p", "n")),
        ("offset over temperature", "temperature", ("p", "n")),
        ("offset over time", "time", ("1",)),
        ("offset since reversal", "since_reversal", ("d",)),
        ("offset since start", "elapsed", ("1",)),
    ),
    TEMPERATURE: (
        ("heat over speed", "speed", ("1",)),
        ("heat over temperature", "temperature", ("1",)),
        ("heat over time", "time", ("1",)),
        ("heat over load", "torque", ("1",)),
        ("heat since start", "elapsed", ("1",)),
    ),
}


def modulator(frame: Frame, name: str) -> FloatArray:
    """What a free function is multiplied with: see the table."""
    forward = frame.last_direction > 0
    values = {
        "1": np.ones(frame.size),
        "d": frame.last_direction,
        "w": frame.omega,
        "tau": frame.load_motor_torque / 1000.0,
        "p": forward.astype(np.float64),
        "n": (~forward).astype(np.float64),
    }
    return values[name]


def rivals(channel: str, frame: Frame, reference: Frame | None = None) -> Iterator[Rival]:
    """Free-form rivals of a channel whose quantity varies in the data, made one by one; knots from ``reference`` where
    given.
    """
    for name, quantity, modulators in _TABLE[channel]:
        value = QUANTITIES[quantity]
        basis = hats(value(frame), None if reference is None else value(reference))
        if basis.shape[1] == 0:
            continue
        parts = np.hstack([basis * modulator(frame, m)[:, None] for m in modulators])
        if channel == TEMPERATURE:
            parts = np.column_stack([integral(parts[:, i], frame) for i in range(parts.shape[1])])
        yield Rival(name, (quantity,), parts)
    if channel in (MOTOR_TORQUE, LOAD_TORQUE):
        waves = _waves(frame)
        load = settled(frame.load_motor_torque, frame)[:, None] / 1000.0
        turn = frame.last_direction[:, None]
        yield Rival("torque over the output angle", ("angle",), waves)
        yield Rival("friction over the output angle", ("angle",), waves * turn)
        yield Rival("torque over the output angle and the load", ("angle", "torque"), waves * load)
        for names, parts in _products(frame):
            yield Rival(f"friction over {' and '.join(names)} together", names, parts * turn)
            yield Rival(f"torque over {' and '.join(names)} together", names, parts)
        yield from _breathing(frame, reference or frame)
    if channel == TRANSMISSION_ERROR:
        turn = frame.last_direction[:, None]
        for names, parts in _products(frame, signed=True):
            # products of two first powers are the simulation's own
            beyond = parts[:, 1:] if len(names) == 2 else parts
            yield Rival(f"offset over {' and '.join(names)} together", names, np.hstack([beyond, beyond * turn]))


def _products(frame: Frame, signed: bool = False) -> list[tuple[tuple[str, ...], FloatArray]]:
    """Products of two or three of load (its size, or with its sign), speed and temperature, each to its second power,
    centred.
    """
    load = settled(frame.torque, frame) / 500.0
    values = {
        "load": load if signed else np.abs(load) - 1.0,
        "speed": np.minimum(settled(np.abs(frame.velocity), frame), 0.25) / 0.1 - 1.0,
        "temperature": (frame.temperature - 35.0) / 10.0,
    }
    own = {"load": "torque"}
    out: list[tuple[tuple[str, ...], FloatArray]] = []
    for pair in itertools.combinations(values, 2):
        a, b = (values[name] for name in pair)
        # what the simulation has of the quantities alone differs by channel: beside a product they stand, too
        alone = [] if signed else [a, b]
        out.append((tuple(own.get(n, n) for n in pair), np.column_stack([*alone, a * b, a**2 * b, a * b**2])))
    a, b, c = values.values()
    alone = [] if signed else [a, b, c, a * b, a * c, b * c]
    out.append((("torque", "speed", "temperature"), np.column_stack([*alone, a * b * c])))
    return out


def _breathing(frame: Frame, reference: Frame) -> list[Rival]:
    """Friction that waxes and wanes with a period of its own: from some recordings to a quarter of the campaign."""
    span = float(np.ptp(reference.time))
    number = max(int(np.unique(reference.recording).size), 1)
    shortest = 2.5 * span / number
    if span <= 0.0 or shortest > 0.25 * span:
        return []
    count = int(min(1.5 * span * (1.0 / shortest - 4.0 / span), 60.0))
    out = []
    for period in 1.0 / np.linspace(4.0 / span, 1.0 / shortest, max(count, 2)):
        phase = 2.0 * np.pi * frame.time / period
        turn = frame.last_direction
        columns = np.column_stack([turn * np.cos(phase), turn * np.sin(phase)])
        out.append(Rival(f"friction with a period of {period:.0f} s", ("time",), columns, common=False))
    return out
