"""Refining the nonlinear parameters of terms between the points of their grids, whatever form nature took."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from bench.mismatch.columns import Entry
from bench.mismatch.select import Model, Search
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms import LIBRARY, Form

_STEPS = 30
_HOPELESS = 0.5
"""a form whose best grid point gains less than this share of the effect's best form is not refined"""
_OUTSIDE = 1e12
AT_THE_END = 0.01
"""of a parameter's range (of its lower end, where that is less)"""


def form_of(channel: str, entry: Entry) -> Form:
    """The form of the library an entry was made with."""
    return next(f for f in LIBRARY[entry.effect].forms[channel] if f.name == entry.form)


class Refiner:
    """Refines entries of one channel's search.

    ``frame`` has all rows (memories run through them), ``used`` marks those of the bank. The bank's columns of a
    refined entry are replaced in place, so the search goes on from the better point.
    """

    def __init__(self, channel: str, frame: Frame, used: NDArray[np.bool_], search: Search) -> None:
        self.channel, self.frame, self.used, self.search = channel, frame, used, search

    def model(self, model: Model) -> Model:
        """Give each chosen term the form and the parameters that predict best beside the others."""
        chosen = list(model.chosen)
        for place, entry in enumerate(chosen):
            if entry.effect not in self.search.repeated:
                chosen[place] = self.effect(chosen[:place] + chosen[place + 1 :], entry.effect) or entry
        return Model(tuple(chosen), self.search.fit(chosen))

    def effect(self, others: list[Entry], effect: str, without: Collection[str] = ()) -> Entry | None:
        """The best entry of an effect beside ``others``: every form at its best grid point, then refined.

        Forms in ``without`` are passed over; None where no form is left.
        """
        search = self.search
        best: dict[str, tuple[float, Entry]] = {}
        for entry in search.entries:
            if entry.effect == effect and entry.form not in without:
                total = search.fit([*others, entry]).total
                if (entry.form not in best or total > best[entry.form][0]) and search.admissible(others, entry):
                    best[entry.form] = (total, entry)
        if not best:
            return None
        start = search.fit(others).total
        most = max(total for total, _ in best.values()) - start
        ahead = [e for total, e in best.values() if total - start > _HOPELESS * most or len(best) == 1]
        refined = [self.entry(others, e) for e in ahead] or [max(best.values(), key=lambda pair: pair[0])[1]]
        refined = [e for e in refined if search.admissible(others, e)]
        if not refined:
            return None
        return max(refined, key=lambda e: search.fit([*others, e]).total)

    def strained(self, entry: Entry) -> bool:
        """Whether a nonlinear parameter of an entry stands at the end of the range it may be refined in."""
        if not entry.point or entry.effect in self.search.repeated:
            return False
        lower, upper = _bounds(form_of(self.channel, entry), self.frame)
        room = AT_THE_END * (upper - lower)
        point = np.asarray(entry.point)
        return bool(np.any((point < lower + np.minimum(room, AT_THE_END * np.abs(lower))) | (point > upper - room)))

    def entry(self, others: list[Entry], entry: Entry) -> Entry:
        """Move an entry's nonlinear parameters to where the predictive score beside ``others`` is highest."""
        if not entry.point or entry.effect in self.search.repeated:
            return entry
        form = form_of(self.channel, entry)
        beside = sorted({*self.search.base, *(i for e in others for i in e.index)} - set(entry.index))
        bank = self.search.bank.narrowed([*beside, *entry.index])
        own = range(len(beside), bank.size)
        positive = all(v > 0 for v in entry.point)
        lower, upper = _bounds(form, self.frame)

        def loss(x: FloatArray) -> float:
            point = tuple(float(v) for v in (np.exp(x) if positive else x))
            if any(v < a or v > b for v, a, b in zip(point, lower, upper, strict=True)):
                return _OUTSIDE
            columns = form.columns(self.frame, point)
            if not np.all(np.isfinite(columns)) or not np.any(columns):
                return _OUTSIDE
            bank.replace(own, columns[self.used])
            return -bank.fit(range(bank.size)).total

        start = np.log(entry.point) if positive else np.asarray(entry.point)
        found = minimize(
            loss,
            start,
            method="Nelder-Mead",
            options={"maxfev": _STEPS * start.size, "xatol": 2e-3, "fatol": 0.05, "initial_simplex": _simplex(start)},
        )
        spread = _spread(loss, found.x, float(found.fun))
        point = tuple(float(v) for v in (np.exp(found.x) if positive else found.x))
        deviation = tuple(float(s * (v if positive else 1.0)) for s, v in zip(spread, point, strict=True))
        self.search.bank.replace(entry.index, form.columns(self.frame, point)[self.used])
        better = replace(entry, point=point, deviation=deviation)
        self.search.entries = [better if e == entry else e for e in self.search.entries]
        self.search.forget(entry.index)
        return better


def _spread(loss: Callable[[FloatArray], float], at: FloatArray, least: float) -> FloatArray:
    """Standard deviations from the curvature of the score about its optimum, a parameter at a time."""
    out = np.full(at.size, np.inf)
    for i in range(at.size):
        for step in (0.02, 0.1, 0.4):
            rise = [loss(at + sign * step * np.eye(at.size)[i]) - least for sign in (1.0, -1.0)]
            known = [r for r in rise if r < 0.5 * _OUTSIDE]
            if known and np.mean(known) > 0.5:
                out[i] = step / np.sqrt(2.0 * np.mean(known))
                break
    return np.where(np.isfinite(out), out, 1.0)


def _simplex(start: FloatArray) -> FloatArray:
    size = start.size
    return np.vstack([start, *(start + 0.15 * np.eye(size)[i] for i in range(size))])


def _bounds(form: Form, frame: Frame) -> tuple[FloatArray, FloatArray]:
    """The range of the form's grid, a little widened: beyond it a term turns into something else."""
    grid = np.asarray(form.grid(frame))
    low, high = grid.min(axis=0), grid.max(axis=0)
    positive = low > 0
    margin = 0.1 * (high - low)
    return np.where(positive, low / 1.5, low - margin), np.where(positive, high * 1.5, high + margin)
