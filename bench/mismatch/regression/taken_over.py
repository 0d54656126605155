"""Effects that the others say as well, once those are refined without them.

An effect is found beside others whose numbers were refined before it was there. A step at a temperature that is placed
a little beside the true one leaves a residual, which something else follows. Removed with the others' numbers as they
are, that something is missed. Only when the others are refined again without it does it show that nothing is missing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from bench.mismatch.regression.beside import shaped
from bench.mismatch.regression.description import description
from bench.mismatch.regression.heredity import without
from bench.mismatch.regression.model import Chosen
from bench.mismatch.regression.pruning import no_mere_form
from bench.mismatch.regression.regressors import Named
from bench.mismatch.regression.state import Search


def without_taken_over(search: Search) -> None:
    """Remove from a search, one after another, effects that do not pay their price beside the others refined anew."""
    while len(search.model.chosen) > 1:
        model = search.model
        whole = float(search.density(model.chosen).sum())
        tried: list[tuple[float, list[Chosen]]] = []
        for effect in model.chosen:
            rest = _refined_anew(search, without(model.chosen, effect, model.problem.lacking))
            if rest is not None:
                loss = whole - float(search.to_be_beaten(rest).sum()) - description(model, effect)
                tried.append((loss, rest))
        least, rest = min(tried, key=lambda t: t[0], default=(float("inf"), []))
        if least > model.price:
            return
        rest = no_mere_form(search, rest)
        search.model = replace(model, chosen=rest, fit=model.refitted(rest))


def _refined_anew(search: Search, rest: Sequence[Chosen]) -> list[Chosen] | None:
    """Effects with their nonlinear numbers refined beside each other; None where that changes none, or where an effect
    is physically impossible beside the others.
    """
    out = list(rest)
    for k, effect in enumerate(rest):
        term = effect.main.regressor
        if isinstance(term, Named) and term.point:
            again = shaped(search, [c for i, c in enumerate(out) if i != k], term)
            if again is None:
                return None
            moved = isinstance(again.main.regressor, Named) and again.main.regressor.point != term.point
            out[k] = again if moved else effect
    return None if all(a is b for a, b in zip(out, rest, strict=True)) else out
