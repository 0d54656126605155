"""Free functions as tables: linear between knots of one, two or three quantities, times a factor.

A table is what a simulation file holds where no equation serves. Beyond its outermost knots it keeps their value.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.errors import ConfigurationError
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.quantities import factor, quantity, require_known


@dataclass(frozen=True, slots=True)
class Grid:
    """Knots of the quantities ``over``, ascending; ``times`` the factor (:mod:`bench.simulation.quantities`).

    Over no quantity it is a number times the factor.
    """

    over: tuple[str, ...]
    times: str
    knots: tuple[tuple[float, ...], ...]

    @property
    def size(self) -> int:
        """Number of knots altogether: coefficients of the function."""
        return int(np.prod([len(k) for k in self.knots]))

    @property
    def course(self) -> str:
        """What it does over the campaign's time, for people; empty of an ordinary table."""
        return ""

    @property
    def formula(self) -> str:
        """Its equation without the factor; empty of a table."""
        return ""

    @property
    def symbols(self) -> list[str]:
        """A symbol for each coefficient."""
        if not self.over:
            return ["c"]
        points = (zip(self.over, point, strict=True) for point in self.knot_points())
        return [f"f({', '.join(f'{name}={value:.4g}' for name, value in point)})" for point in points]

    def knot_points(self) -> FloatArray:
        """Knots of all quantities together (size, quantities), as the values of the function are given."""
        if not self.over:
            return np.zeros((1, 0))
        return np.stack(np.meshgrid(*self.knots, indexing="ij"), axis=-1).reshape(-1, len(self.over))

    def columns(self, frame: Frame) -> FloatArray:
        """Regressors (n, size): one hat function a knot (products of hats for several quantities), last fastest."""
        out = factor(self.times, frame)[:, None]
        for name, knots in zip(self.over, self.knots, strict=True):
            hat = hats(quantity(name, frame), np.asarray(knots))
            out = (out[:, :, None] * hat[:, None, :]).reshape(frame.size, -1)
        return np.asarray(out)

    def to_json(self, values: FloatArray) -> dict[str, Any]:
        """A row of a simulation file: the function with its values (size,) at the knots."""
        return {
            "form": "table",
            "over": list(self.over),
            "times": self.times,
            "knots": [list(k) for k in self.knots],
            "values": np.asarray(values, dtype=np.float64).reshape([len(k) for k in self.knots]).tolist(),
        }


def hats(values: FloatArray, knots: FloatArray) -> FloatArray:
    """Piecewise linear basis (n, k) with the knots (k,) ascending; constant beyond the outermost."""
    interval = np.clip(np.searchsorted(knots, values, side="right") - 1, 0, knots.size - 2)
    share = np.clip((values - knots[interval]) / (knots[interval + 1] - knots[interval]), 0.0, 1.0)
    out = np.zeros((values.size, knots.size))
    rows = np.arange(values.size)
    out[rows, interval] = 1.0 - share
    out[rows, interval + 1] += share
    return out


def from_json(row: Mapping[str, Any], where: str) -> tuple[Grid, FloatArray]:
    """Read a table. Raises ConfigurationError, which begins with ``where``, for what is wrong with it."""
    try:
        knots = tuple(tuple(float(v) for v in axis) for axis in row["knots"])
        grid = Grid(tuple(str(name) for name in row["over"]), str(row.get("times", "1")), knots)
        values = np.asarray(row["values"], dtype=np.float64)
    except (KeyError, TypeError, ValueError) as error:
        raise ConfigurationError(f"{where}: a table should have over, times, knots and values ({error!r})") from error
    if len(grid.over) != len(knots) or any(len(k) < 2 or np.any(np.diff(k) <= 0.0) for k in knots):
        raise ConfigurationError(f"{where}: a table should have two or more ascending knots for each of its quantities")
    require_known(grid.over, [grid.times], where)
    shape = tuple(len(k) for k in knots)
    if values.shape != shape or not np.isfinite(values).all():
        raise ConfigurationError(f"{where}: the table's values have shape {values.shape}, they should have {shape}")
    return grid, values.ravel()
