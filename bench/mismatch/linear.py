"""Search of one channel for what the simulation lacks: named terms first, then free-form rivals to judge them by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch import bands
from bench.mismatch.bank import Bank, Fit, Noise
from bench.mismatch.columns import Entry, Layout, layout
from bench.mismatch.judge import Found, judge
from bench.mismatch.memories import exercised
from bench.mismatch.noise import estimate
from bench.mismatch.refine import Refiner
from bench.mismatch.rivals import rivals
from bench.mismatch.rows import Rows
from bench.mismatch.select import MINIMUM_GAIN, Model, Search
from bench.mismatch.spreads import settle
from bench.simulation.frame import FloatArray, Frame, IntArray, recording_starts
from bench.simulation.terms import LIBRARY, TEMPERATURE, TRANSMISSION_ERROR, Form, Point, Term

REPEATED = frozenset({"friction.position_dependent"})
MOST_TERMS = 6
LEAST_GAIN = {TRANSMISSION_ERROR: 45.0, TEMPERATURE: 50.0}
"""log-likelihood asked of a term where the simulation itself fits no better than that: its polynomials are clipped by
nature, a heat balance has one mass for a whole gearbox
"""


@dataclass(slots=True)
class ChannelModel:
    """A channel's calibrated simulation with what was found beside it."""

    channel: str
    rows: Rows
    """all rows of all recordings: memories run through every one of them"""
    used: NDArray[np.bool_]
    """rows the search was made on"""
    layout: Layout
    noise: Noise
    search: Search
    chosen: list[Entry]
    correction: list[Entry]
    fit: Fit
    found: list[Found]
    switched_off: tuple[str, ...]
    known: tuple[tuple[Term, Form, Point], ...]
    base_coefficients: FloatArray

    def index(self, entries: Sequence[Entry]) -> list[int]:
        """Columns of the simulation and some entries, in the fit's order."""
        return sorted({*self.layout.base, *(i for entry in entries for i in entry.index)})


def starts_and_folds(frame: Frame, fold_of: IntArray) -> tuple[IntArray, IntArray]:
    """Row ranges of the recordings in a frame, and the fold of each (numbered from 0 without gaps)."""
    starts = recording_starts(frame)
    own = fold_of[frame.recording[starts[:-1]]]
    return starts, np.unique(own, return_inverse=True)[1].astype(np.int64)


def analyse(
    channel: str,
    rows: Rows,
    usable: NDArray[np.bool_],
    fold_of: IntArray,
    switched_off: Sequence[str] = (),
    known: Sequence[tuple[Term, Form, Point]] = (),
    banned: Sequence[str] = (),
    beside: Sequence[Entry] = (),
) -> ChannelModel:
    """Find the terms a channel needs on the usable rows of the training recordings (fold ≥ 0).

    ``fold_of[recording]`` is the fold of each recording of the data set; ``banned`` effects are not tried. Terms found
    before stand ``beside`` the simulation while the noise is estimated, which they would else be taken for.
    """
    used = usable & (fold_of[rows.frame.recording] >= 0) & (rows.number > 0)
    own = rows.take(used)
    whole = layout(channel, rows.frame, switched_off, known, reference=own.frame, used=used, slots=bands.slots(channel))
    starts, folds = starts_and_folds(own.frame, fold_of)
    blocks = [columns_of(channel, entry, rows.frame)[used] for entry in beside if entry.effect in LIBRARY]
    noise = estimate(channel, own, whole, starts, blocks)
    candidates, whole = whole.columns, whole.of_the_simulation()
    bank = Bank(own.y, starts, folds, candidates, whole.prior, noise, whole.precision, spend=True)
    settle(bank, whole)
    entries = exercised(bank, whole, [e for e in whole.named if e.effect not in banned])
    search = Search(
        bank,
        whole.base,
        entries,
        REPEATED,
        known_gain(bank, whole, len(known)),
        frozenset(switched_off),
        LEAST_GAIN.get(channel, MINIMUM_GAIN),
    )
    refiner = Refiner(channel, rows.frame, used, search)
    model = Model((), search.fit(()))
    for _ in range(MOST_TERMS):
        step = search.step(model.chosen)
        if step is None:
            break
        settle(bank, whole, [i for entry in step for i in entry.index])
        search.forget(whole.base)
        model = refiner.model(Model(tuple(step), search.fit(step)))
    base = bank.fit(whole.base, leave_out=False).coefficients
    result = ChannelModel(
        channel,
        rows,
        used,
        whole,
        noise,
        search,
        list(model.chosen),
        [],
        model.fit,
        [],
        tuple(switched_off),
        tuple(known),
        base,
    )
    models = [result.index([]), *([result.index(result.chosen)] if result.chosen else [])]
    free = [*whole.free, *bands.fill(channel, rows.frame, used, bank, whole.slots, models)]
    verdict = judge(search, refiner, list(model.chosen), free, channel, [term.variables for term, _, _ in known])
    result.chosen, result.correction, result.found = verdict.chosen, verdict.correction, verdict.found
    result.fit = bank.fit(result.index([*result.chosen, *result.correction]), leave_out=False)
    _coefficients(result)
    return result


def released(model: ChannelModel) -> ChannelModel:
    """The model with the columns of all candidates let go that nothing will ask for again."""
    others = [a.entry for found in model.found for a in found.alternatives]
    entries = [*model.chosen, *model.correction, *others]
    bank = model.search.bank.only({*model.layout.base, *(i for entry in entries for i in entry.index)})
    model.search = replace(model.search, bank=bank, _cache={})
    return model


def _known_columns(whole: Layout, number: int) -> list[tuple[int, ...]]:
    """Columns of the given simulation's further terms, of which there are ``number``: they follow the nominal ones."""
    nominal = sum(effect in LIBRARY and LIBRARY[effect].nominal for effect, _, _ in whole.base_effects)
    return [index for _, _, index in whole.base_effects[nominal : nominal + number]]


def known_gain(bank: Bank, whole: Layout, number: int) -> float:
    """Log-likelihood that the given simulation's further terms gain: what is left beside them is judged against it."""
    own = {i for index in _known_columns(whole, number) for i in index}
    if not own:
        return 0.0
    rest = [i for i in whole.base if i not in own]
    return max(bank.fit(whole.base).total - bank.fit(rest).total, 0.0)


def known_coefficients(model: ChannelModel) -> list[FloatArray]:
    """Coefficients of the given simulation's further terms, in their order, as calibrated beside what was found."""
    place = {column: k for k, column in enumerate(model.index([*model.chosen, *model.correction]))}
    columns = _known_columns(model.layout, len(model.known))
    return [model.fit.coefficients[[place[i] for i in index]] for index in columns]


def columns_of(channel: str, entry: Entry, frame: Frame) -> FloatArray:
    """Regressors of a named entry on any rows."""
    form = next(f for f in LIBRARY[entry.effect].forms[channel] if f.name == entry.form)
    return form.columns(frame, entry.point)


def predict(model: ChannelModel, frame: Frame, whole: bool = True) -> FloatArray:
    """The channel as the simulation (and, with ``whole``, everything found) says, on the rows of ``frame``.

    Free-form parts are functions of the training rows' knots: their layout is evaluated on the new rows again.
    """
    again = layout(model.channel, frame, model.switched_off, model.known, with_free=False, with_named=False)
    if not whole:
        return np.asarray(again.columns[:, list(again.base)] @ model.base_coefficients[: len(again.base)])
    return _sum_of(model, frame, again.columns, [*model.chosen, *model.correction], model.fit)


def predict_named(model: ChannelModel, frame: Frame, left_out: Entry | None = None) -> FloatArray:
    """The channel as the model says without corrections of forms, and without one entry, refitted on the training rows.

    A free-form correction could take the place of what is left out.
    """
    rest = [e for e in model.chosen if e != left_out]
    fit = model.search.bank.fit(model.index(rest), leave_out=False)
    again = layout(model.channel, frame, model.switched_off, model.known, with_free=False, with_named=False)
    return _sum_of(model, frame, again.columns, rest, fit)


def dropped(model: ChannelModel, entry: Entry) -> None:
    """Take an entry out of a model again (it did not hold on recordings that selected nothing), and refit."""
    model.chosen = [e for e in model.chosen if e != entry]
    model.found = [f for f in model.found if f.entry != entry]
    if not model.found:
        model.correction = []
    final = model.index([*model.chosen, *model.correction])
    model.fit = model.search.bank.fit(final, leave_out=False)
    _coefficients(model)


def _coefficients(model: ChannelModel) -> None:
    """Coefficients of what was found; a named term's without free-form parts beside it, which would share its work."""
    named = [e for e in model.chosen if e.effect != "unknown"]
    for entries in (named, [*model.chosen, *model.correction]):
        index = model.index(entries)
        fit = model.search.bank.fit(index, leave_out=False)
        place = {column: k for k, column in enumerate(index)}
        for found in model.found:
            if (found.entry.effect != "unknown") == (entries is named):
                own = [place[i] for i in found.entry.index]
                found.coefficients = fit.coefficients[own]
                found.covariance = fit.covariance[np.ix_(own, own)]


def _sum_of(model: ChannelModel, frame: Frame, columns: FloatArray, entries: Sequence[Entry], fit: Fit) -> FloatArray:
    coefficient = dict(zip(model.index(entries), fit.coefficients, strict=True))
    out = columns[:, list(model.layout.base)] @ np.array([coefficient[i] for i in model.layout.base])
    for entry in entries:
        own = np.array([coefficient[i] for i in entry.index])
        out = out + columns_at(model, entry, frame) @ own
    return np.asarray(out)


def columns_at(model: ChannelModel, entry: Entry, frame: Frame) -> FloatArray:
    """Regressors of an entry, named or free, on any rows."""
    if entry.effect != "unknown":
        return columns_of(model.channel, entry, frame)
    if entry.point:
        return bands.column(model.channel, entry.form, entry.point, frame)
    for rival in rivals(model.channel, frame, model.rows.frame.take(model.used)):
        if rival.name == entry.form:
            return rival.columns
    return np.zeros((frame.size, len(entry.index)))


__all__ = [
    "ChannelModel",
    "Found",
    "analyse",
    "columns_of",
    "dropped",
    "known_coefficients",
    "predict",
    "predict_named",
    "released",
    "starts_and_folds",
]
