"""Unknown physics gets an equation: the shortest formula that is as good as a free function takes its place.

Shapes are proposed (:mod:`bench.mismatch.unnamed.formula_sought`); their constants are fitted and they are judged
beside the whole simulation refitted, as everything that the search finds: by the log density of operating points left
out. Recordings that are held out choose nothing here either; they score what was chosen.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.bank import Bank
from bench.mismatch.regression.folds import apart, predictive, squares
from bench.mismatch.regression.model import Block, Chosen, add_block, fit_blocks
from bench.mismatch.regression.refuted import worse_with
from bench.mismatch.regression.regressors import UNKNOWN, Free
from bench.mismatch.regression.slots import Slot
from bench.mismatch.regression.state import Search
from bench.mismatch.unnamed import formula_proposed as proposed
from bench.mismatch.unnamed.formula_fitted import bounded, tuned
from bench.mismatch.unnamed.formula_regressor import Equation
from bench.mismatch.unnamed.formula_sought import sought
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import label

ABSENT = "no formula was looked for: pyoperon is not installed (pip install 'gearbench[formula]')"
MOST_OVER = 3
"""quantities of a free function for which a formula is looked for"""
MOST_FITTED = 80
"""formulas that are fitted in the place of one free function"""
MOST_PARTS, MORE_NUMBERS = 4, 2
"""parts of a formula that is begun with, and numbers that it may have beyond the table's, before it is shortened"""


def in_formulas(search: Search, slots: Sequence[Slot], auxiliary: Mapping[str, str]) -> list[Slot]:
    """The slots with a formula in place of every free function without a name that it is as good as.

    ``auxiliary``: units of quantities recorded beside the bench, by name. The search's model is changed alike.
    """
    if all(_free(slot.chosen) is None for slot in slots):
        return list(slots)
    if not proposed.available():
        search.model.notes.append(ABSENT)
        return list(slots)
    return [_with_formula(search, slot, auxiliary) for slot in slots]


def _free(chosen: Chosen) -> Free | None:
    """The free function that a formula may replace."""
    regressor = chosen.main.regressor
    if chosen.effect != UNKNOWN or chosen.shape is not None or not isinstance(regressor, Free):
        return None
    if any(g.course or not 1 <= len(g.over) <= MOST_OVER for g in regressor.grids):
        return None
    return regressor


@dataclass(frozen=True, slots=True)
class _Judged:
    """A formula, its log density of each point left out (folds,), its description length in nats, the squares that it
    leaves of points left out.
    """

    equation: Equation
    density: FloatArray
    length: float
    squares: float


def _with_formula(search: Search, slot: Slot, auxiliary: Mapping[str, str]) -> Slot:
    free = _free(slot.chosen)
    if free is None:
        return slot
    model = search.model
    table = search.density(model.chosen)
    most = float(squares(model.bank, model.blocks(), model.folds, model.fit.variance).sum())
    judge = _Judge(search, slot.chosen)
    begun = [
        trial
        for trial in sought(model, slot.chosen, free, auxiliary, search.seed)
        if len(trial.formula.parts) <= MOST_PARTS * len(free.grids) and trial.numbers <= free.numbers + MORE_NUMBERS
    ]
    tried = [judge(equation) for equation in begun]
    judged = [trial for trial in tried if trial is not None]
    of_table = judge.length(table, free.numbers, 1 + max(len(g.over) for g in free.grids))
    # where one point left out decides, a formula is soon within a standard error: it has to predict them all as well
    safe = [trial for trial in judged if trial.squares <= most]
    good = [trial for trial in safe if as_good(table, trial.density) and trial.length <= of_table]
    over = " and ".join(dict.fromkeys(label(name) for g in free.grids for name in g.over))
    if not good:
        if judged:
            model.notes.append(
                f"no short formula of {over} serves as well as its table: {_why_not(judged, safe, table, of_table)}"
            )
        return slot
    best = min(good, key=lambda trial: trial.length)
    loss, error = apart(table, best.density)
    chosen = Chosen(add_block(model.problem, model.bank, best.equation))
    whole = [chosen if c is slot.chosen else c for c in model.chosen]
    ratio = worse_with(model, whole, chosen)
    if ratio is not None:
        model.notes.append(
            f"no formula of {over} is told: recordings held out are predicted {ratio:.3g} times as badly with it as "
            "without it"
        )
        return slot
    search.model = replace(model, chosen=whole, fit=model.refitted(whole))
    model.notes.append(
        f"a formula of {over} with {best.equation.numbers} numbers stands in place of a table of {free.numbers}: it "
        f"gives points left out {abs(loss):.1f} ± {error:.1f} {'less' if loss > 0.0 else 'more'} log density"
    )
    return replace(slot, chosen=chosen, gain=slot.gain - loss)


def _why_not(judged: Sequence[_Judged], safe: Sequence[_Judged], table: FloatArray, of_table: float) -> str:
    """What speaks against the formula that comes nearest to a table of the description length ``of_table``; ``safe``:
    those whose predictions of points left out are no further off than the table's.
    """
    if not safe:
        return "each is further off than it at points left out"
    best = min(safe, key=lambda trial: trial.length)
    if best.length > of_table:
        return f"the shortest description by one is {best.length - of_table:.1f} nats longer than the table's"
    loss, error = apart(table, best.density)
    return f"the best gives points left out {loss:.1f} ± {error:.1f} less log density"


def as_good(table: FloatArray, formula: FloatArray) -> bool:
    """Whether a formula predicts points left out (folds,) as well as a table, within the doubt of the difference."""
    loss, error = apart(table, formula)
    return bool(loss <= criteria.ONE_ERROR * error)


class _Judge:
    """Fits and judges formulas in the place of a free function, in a bank that holds no other candidates."""

    def __init__(self, search: Search, instead: Chosen) -> None:
        model = self.model = search.model
        problem = model.problem
        self.bank = Bank(problem.rows.y[problem.train], model.bank.whitening, problem.spec.integral)
        self.bank.likeliest = model.bank.likeliest
        others = [c for c in model.chosen if c is not instead]
        self.beside = [
            Block(b.regressor, self.bank.add(b.regressor.columns(problem.rows.frame)[problem.train]), b.precision)
            for b in model.blocks(others)
        ]
        self.rows = int(problem.train.sum())
        self.variance = model.fit.variance
        self.known: dict[str, _Judged | None] = {}

    def length(self, density: FloatArray, numbers: int, nodes: int) -> float:
        """Description length in nats: of the points left out, half a logarithm of the rows for each number, one for
        each node of the formula's tree.
        """
        return float(-density.sum() + 0.5 * numbers * np.log(max(self.rows, 2)) + nodes)

    def __call__(self, start: Equation) -> _Judged | None:
        """The formula with the constants that fit best, without parts that are not worth their length; None where it
        has poles, or constants that the recordings do not tell.
        """
        best = self._judged(start)
        while best is not None and len(best.equation.formula.parts) > 1:
            shorter = [self._judged(best.equation.without(k)) for k in range(len(best.equation.formula.parts))]
            kept = min((trial for trial in shorter if trial is not None), key=lambda trial: trial.length, default=None)
            if kept is None or kept.length > best.length:
                break
            best = kept
        if best is None or any(c.std is None for c in best.equation.constants):
            return None
        return best

    def _judged(self, start: Equation) -> _Judged | None:
        """A formula as it stands, its constants fitted; the same shape is fitted once."""
        if start.equation not in self.known:
            if len(self.known) >= MOST_FITTED:
                return None
            self.known[start.equation] = self._fitted(start)
        return self.known[start.equation]

    def _fitted(self, start: Equation) -> _Judged | None:
        if not start.formula.over or not bounded(self.model.problem, start):
            return None
        equation = tuned(self.model.problem, self.bank, self.beside, start, self.variance)
        if not bounded(self.model.problem, equation):
            return None
        blocks = [*self.beside, add_block(self.model.problem, self.bank, equation)]
        try:
            variance = fit_blocks(self.bank, blocks, self.model.variances).variance
            density = predictive(self.bank, blocks, self.model.folds, variance)
            left = float(squares(self.bank, blocks, self.model.folds, variance).sum())
        except np.linalg.LinAlgError:  # parts that these rows do not tell from each other
            return None
        return _Judged(equation, density, self.length(density, equation.numbers, equation.nodes), left)
