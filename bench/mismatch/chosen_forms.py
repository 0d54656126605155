"""Terms that a simulation names without numbers: their form and nonlinear parameters are chosen on the recordings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.errors import ConfigurationError
from bench.mismatch.bank import Bank
from bench.mismatch.columns import layout
from bench.mismatch.given import KnownTerm
from bench.mismatch.linear import starts_and_folds
from bench.mismatch.noise import estimate
from bench.mismatch.refine import Refiner
from bench.mismatch.rows import Rows
from bench.mismatch.select import Search
from bench.simulation.frame import IntArray
from bench.simulation.terms import LIBRARY, Form, Point, Term

Known = tuple[Term, Form, Point]


def chosen_forms(
    channel: str, rows: Rows, fold_of: IntArray, switched_off: Sequence[str], terms: Sequence[KnownTerm]
) -> tuple[Known, ...]:
    """Forms and points of a channel's terms in force; those without are chosen one by one where they fit ``rows`` best.

    ``rows``: those of the training recordings the channel is compared on. Raises ConfigurationError where a term
    cannot act in any of them.
    """
    known: list[Known] = [(t.term, t.form, t.point) for t in terms if t.form is not None and t.point is not None]
    for open_term in (t for t in terms if t.point is None):
        whole = layout(channel, rows.frame, switched_off, known)
        starts, folds = starts_and_folds(rows.frame, fold_of)
        noise = estimate(channel, rows, whole, starts)
        bank = Bank(rows.y, starts, folds, whole.columns, whole.prior, noise, whole.precision, spend=True)
        entries = [e for e in whole.named if e.effect == open_term.term.effect]
        if not entries:
            raise ConfigurationError(
                f"the simulation's term {open_term.term.effect} has no parameters and cannot be calibrated in {channel}"
            )
        everywhere = np.ones(rows.frame.size, dtype=bool)
        refiner = Refiner(channel, rows.frame, everywhere, Search(bank, whole.base, entries))
        best = refiner.effect([], open_term.term.effect) or entries[0]
        form = next(f for f in LIBRARY[best.effect].forms[channel] if f.name == best.form)
        known.append((open_term.term, form, best.point))
    return tuple(known)


def training(rows: Rows, fold_of: IntArray) -> Rows:
    """Rows of the training recordings."""
    used = (fold_of[rows.frame.recording] >= 0) & (rows.number > 0)
    return rows.take(used)
