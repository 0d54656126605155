"""Refining the nonlinear parameters of chosen terms between the points of their grids."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from bench.mismatch.columns import Entry
from bench.mismatch.select import Model, Search
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms import LIBRARY

_STEPS = 35


def _form_columns(channel: str, entry: Entry, frame: Frame, point: tuple[float, ...]) -> FloatArray:
    form = next(f for f in LIBRARY[entry.effect].forms[channel] if f.name == entry.form)
    return form.columns(frame, point)


def refined(channel: str, frame: Frame, used: NDArray[np.bool_], search: Search, model: Model) -> Model:
    """Move each chosen term's nonlinear parameters to where the predictive score is highest, one term after another.

    ``frame`` has all rows (memories run through them), ``used`` marks those of the bank. The bank's columns of a
    refined term are replaced in place, so the search goes on from the better point.
    """
    chosen = list(model.chosen)
    for place, entry in enumerate(chosen):
        if not entry.point or entry.effect in search.repeated:
            continue
        positive = all(v > 0 for v in entry.point)
        lower, upper = _bounds(channel, entry, frame)
        start = np.log(entry.point) if positive else np.asarray(entry.point)

        def loss(
            x: FloatArray,
            entry: Entry = entry,
            positive: bool = positive,
            lower: FloatArray = lower,
            upper: FloatArray = upper,
        ) -> float:
            point = tuple(float(v) for v in (np.exp(x) if positive else x))
            if any(v < a or v > b for v, a, b in zip(point, lower, upper, strict=True)):
                return 1e12
            columns = _form_columns(channel, entry, frame, point)
            if not np.all(np.isfinite(columns)) or not np.any(columns):
                return 1e12
            search.bank.replace(entry.index, columns[used])
            index = sorted({*search.base, *(i for e in chosen for i in e.index)})
            return -search.bank.fit(index).total

        found = minimize(
            loss,
            start,
            method="Nelder-Mead",
            options={"maxfev": _STEPS, "xatol": 2e-3, "fatol": 0.05, "initial_simplex": _simplex(start)},
        )
        point = tuple(float(v) for v in (np.exp(found.x) if positive else found.x))
        search.bank.replace(entry.index, _form_columns(channel, entry, frame, point)[used])
        better = replace(entry, point=point)
        search.entries = [better if e == entry else e for e in search.entries]
        search.forget(entry.index)
        chosen[place] = better
    return Model(tuple(chosen), search.fit(chosen))


def _simplex(start: FloatArray) -> FloatArray:
    size = start.size
    return np.vstack([start, *(start + 0.15 * np.eye(size)[i] for i in range(size))])


def _bounds(channel: str, entry: Entry, frame: Frame) -> tuple[FloatArray, FloatArray]:
    """The range of the form's grid, a little widened: beyond it a term turns into something else."""
    form = next(f for f in LIBRARY[entry.effect].forms[channel] if f.name == entry.form)
    grid = np.asarray(form.grid(frame))
    low, high = grid.min(axis=0), grid.max(axis=0)
    positive = low > 0
    margin = 0.1 * (high - low)
    return np.where(positive, low / 1.5, low - margin), np.where(positive, high * 1.5, high + margin)
