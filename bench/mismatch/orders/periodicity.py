"""A torque's revolutions and rows, and what waves over an angle make of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.mismatch.orders.lines import Line, Revolutions
from bench.mismatch.recordings.output_orders import OutputSpectrum
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.recordings.vibration import ShaftSpectrum
from bench.simulation.frame import FloatArray, IntArray
from bench.simulation.quantities import in_words
from bench.simulation.waves import Wave, evaluate, kept_by_mean

Parts = Sequence[tuple[Line, tuple[int, ...]]]
"""orders, with the numbers of those of their factors that belong to an effect"""


MOST_WAVES = 4
"""that an equation shows of many orders: a table has them all"""
LOW_ORDERS = 12
"""orders over the output angle that the rows of a torque show: those are found among them"""


@dataclass(frozen=True, slots=True)
class Periodicity:
    """A torque's revolutions and its rows: what :func:`torque_discoveries` looks at.

    ``output`` of :attr:`Dataset.output`, ``shaft`` of :attr:`Dataset.shaft` (the motor's torque alone), ``rows`` of the
    channel, ``folds`` of each recording by its index, ``ratio`` u, ``floor`` noise of a sample, N·m; ``followed``:
    orders of the shaft that the motor's encoder misreads.
    """

    channel: str
    output: Sequence[OutputSpectrum]
    shaft: Sequence[ShaftSpectrum]
    rows: Rows
    folds: IntArray
    ratio: float
    floor: float
    followed: frozenset[int] = frozenset()


def wave_of(line: Line, k: int) -> Wave:
    """An order in proportion to the k-th of its factors."""
    vector, std = complex(line.amplitude[k]), float(np.sqrt(line.variance[k]))
    return Wave(float(line.order), line.model[k], vector.real, vector.imag, std, std)


def times(name: str, text: str) -> str:
    """A sum times a factor, as equations have it."""
    return f"{in_words(name)}*({text})" if in_words(name) else f"({text})"


def equation(waves: Sequence[Wave], over: str = "q") -> str:
    """Waves as an equation, for people, over the angle of that name."""

    def text(wave: Wave) -> str:
        angle = f"{wave.order:g}*{over}"
        return times(wave.times, f"{wave.cosine:.3g}*cos({angle}) + {wave.sine:.3g}*sin({angle})")

    return "+= " + " + ".join(map(text, waves))


def on_rows(waves: Sequence[Wave], rows: Rows, angle: FloatArray | None = None) -> FloatArray:
    """Waves of a torque averaged over the rows (n,); over the output angle, or over an ``angle`` (n,) that is given."""
    out = np.zeros(rows.size)
    angle_of_row = np.abs(rows.frame.velocity) * rows.frame.step
    for wave in waves:
        out += evaluate([wave], rows.frame.q if angle is None else angle, rows.frame) * kept_by_mean(
            wave.order, angle_of_row
        )
    return out


def loudness(waves: Sequence[Wave], rows: Rows) -> FloatArray:
    """Root mean square of waves too quick for the rows, over a period, at each row (n,)."""
    squares = np.zeros(rows.size)
    for order in {wave.order for wave in waves}:
        of_order = [wave for wave in waves if wave.order == order]
        for ahead in (0.0, 0.5 * np.pi):
            squares += 0.5 * evaluate(of_order, rows.frame.q, rows.frame, ahead) ** 2
    return np.sqrt(squares)


def power(revolutions: Revolutions, parts: Parts) -> float:
    """Mean square that some orders add to the training revolutions."""
    total = 0.0
    for line, members in parts:
        x = np.column_stack([revolutions.factors[line.model[k]][revolutions.train] for k in members])
        total += 0.5 * float(np.mean(np.abs(x @ line.amplitude[list(members)]) ** 2))
    return total


def squares_of(seen: Periodicity, revolutions: Revolutions, parts: Parts) -> tuple[float, float] | None:
    """Mean square of a held-out sample without and with some orders, from the held-out revolutions."""
    out = ~revolutions.train
    if not out.any():
        return None
    gone = 0.0
    for line, members in parts:
        vectors = revolutions.vectors[out, line.order]
        whole = np.column_stack([revolutions.factors[t][out] for t in line.model]) @ line.amplitude
        part = (
            np.column_stack([revolutions.factors[line.model[k]][out] for k in members]) @ line.amplitude[list(members)]
        )
        ok = np.isfinite(vectors)
        if ok.any():
            gone += 0.5 * float(np.mean(np.abs((vectors - whole + part)[ok]) ** 2 - np.abs((vectors - whole)[ok]) ** 2))
    return seen.floor**2 + gone, seen.floor**2
