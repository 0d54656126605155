"""Waves over the output angle: harmonic orders whose amplitude may depend on direction, load, speed and temperature."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numba
import numpy as np

from bench.errors import ConfigurationError
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.quantities import FACTORS, factor
from bench.simulation.sines import cosine_sine

ROWS_AT_ONCE = 1 << 12
"""a hundred orders at these stay in a processor's cache"""


def kept_by_mean(order: Any, span: Any) -> FloatArray:
    """Share of a wave that its mean over an angle ``span`` (rad) keeps, for numbers or arrays that go together."""
    return np.asarray(np.sinc(order * span / (2.0 * np.pi)))


@dataclass(frozen=True, slots=True)
class Wave:
    """``factor * (cosine*cos(order*angle) + sine*sin(order*angle))``; ``order`` per output revolution."""

    order: float
    times: str
    cosine: float
    sine: float
    cosine_std: float | None = None
    sine_std: float | None = None

    @property
    def slope(self) -> Wave:
        """Its change with the angle, a wave as well."""
        return Wave(self.order, self.times, self.order * self.sine, -self.order * self.cosine)

    def to_json(self) -> dict[str, Any]:
        """The wave as a simulation file has it."""
        out: dict[str, Any] = {"order": self.order, "times": self.times, "c": self.cosine, "s": self.sine}
        if self.cosine_std is not None and self.sine_std is not None:
            out |= {"c_std": self.cosine_std, "s_std": self.sine_std}
        return out


def from_json(rows: Sequence[Mapping[str, Any]], where: str) -> tuple[Wave, ...]:
    """Read waves. Raises ConfigurationError, which begins with ``where``, for what is wrong with them."""
    out = []
    for number, row in enumerate(rows):
        try:
            std = (float(row["c_std"]), float(row["s_std"])) if "c_std" in row else (None, None)
            out.append(Wave(float(row["order"]), str(row.get("times", "1")), float(row["c"]), float(row["s"]), *std))
        except (KeyError, TypeError, ValueError) as error:
            raise ConfigurationError(
                f"{where}: waves[{number}] should have order, times, c and s ({error!r})"
            ) from error
        unknown = [part for part in out[-1].times.split("*") if part not in FACTORS]
        if unknown:
            known = ", ".join(FACTORS)
            raise ConfigurationError(
                f"{where}: waves[{number}] is in proportion to '{unknown[0]}', it should be one of {known}"
            )
    return tuple(out)


def evaluate(waves: Sequence[Wave], angle: FloatArray, frame: Frame, ahead: float = 0.0) -> FloatArray:
    """Sum of the waves at angles (n,) in rad, the rows of ``frame``; with their phases ``ahead`` (rad)."""
    out = np.zeros(angle.size)
    factors = sorted({wave.times for wave in waves})
    orders = np.array(sorted({wave.order for wave in waves}), dtype=np.float64)
    column = {float(f): k for k, f in enumerate(orders)}
    table = np.zeros((len(factors), orders.size, 2))
    for wave in waves:
        table[factors.index(wave.times), column[wave.order]] += (wave.cosine, wave.sine)
    rotation = np.array([[np.cos(ahead), np.sin(ahead)], [-np.sin(ahead), np.cos(ahead)]])
    table = table @ rotation.T
    for a in range(0, angle.size, ROWS_AT_ONCE):
        rows = slice(a, min(a + ROWS_AT_ONCE, angle.size))
        part = frame.take(rows)
        weights = np.array([factor(name, part) for name in factors])
        if weights.size:
            out[rows] = _sum(np.ascontiguousarray(angle[rows]), orders, table, weights)
    return out


def angle_from(angle: FloatArray | float, other: FloatArray | float) -> FloatArray:
    """Angles (n,) less another one, the short way round: -pi to pi."""
    out: FloatArray = np.mod(angle - other + np.pi, 2.0 * np.pi) - np.pi
    return out


def of_orders(angle: FloatArray, orders: FloatArray, cosine: FloatArray, sine: FloatArray) -> FloatArray:
    """Sum of cosine*cos(f*angle) + sine*sin(f*angle) over ``orders`` f (k,), each with its own coefficients (k,), at
    angles (n,).
    """
    table = np.ascontiguousarray(np.stack([cosine, sine], axis=1)[None])
    return _sum(np.ascontiguousarray(angle), orders, table, np.ones((1, angle.size)))


@numba.njit(cache=True)
def _sum(angle: FloatArray, orders: FloatArray, table: FloatArray, weights: FloatArray) -> FloatArray:
    out = np.zeros(angle.size)
    a, b = np.empty(angle.size), np.empty(angle.size)
    for k in range(orders.size):
        a[:] = 0.0
        b[:] = 0.0
        for f in range(table.shape[0]):
            of_cosine, of_sine, weight = table[f, k, 0], table[f, k, 1], weights[f]
            if of_cosine != 0.0 or of_sine != 0.0:
                for i in range(angle.size):
                    a[i] += weight[i] * of_cosine
                    b[i] += weight[i] * of_sine
        order = orders[k]
        for i in range(angle.size):
            cosine, sine = cosine_sine(order * angle[i])
            out[i] += a[i] * cosine + b[i] * sine
    return out
