"""Which terms a channel needs: forward steps, swaps and pruning on gains that are predicted, never fitted.

The gain of a term is the predictive log-likelihood that all folds gain when it enters with everything else refitted. It
costs a term its own parameters (a useless one loses), and the thresholds below add the price of having looked at many.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from bench.mismatch.bank import Bank, Fit
from bench.mismatch.columns import Entry
from bench.simulation.frame import FloatArray

MINIMUM_GAIN = 22.0
"""log-likelihood a term has to gain: more than the best of some hundred useless columns gained in 100 folders"""
MINIMUM_SHARE = 0.004
"""of the strongest term's gain: below that the remainder is how far nature's form is from ours"""
PREFERRED_SHARE = 0.97
ECHO = 0.5
"""part of a term's energy beside the simulation that a chosen one leaves over, below which the two are alike"""
ECHO_SHARE = 0.1
"""of the chosen one's gain: what a term like it has to gain to be an effect of its own"""
BEYOND = 2.0
"""standard deviations by which a coefficient may lie on the wrong side of a physical bound"""
MINIMUM_T = 1.8
"""gain over its standard error between the folds that it touches"""


@dataclass(frozen=True, slots=True)
class Model:
    """Terms chosen, with the fit of the simulation and all of them."""

    chosen: tuple[Entry, ...]
    fit: Fit


@dataclass(slots=True)
class Search:
    """Searches models over a bank; remembers what it has scored."""

    bank: Bank
    base: tuple[int, ...]
    entries: Sequence[Entry]
    repeated: frozenset[str] = frozenset()
    """effects that may be chosen at several points (orders)"""
    credit: float = 0.0
    """gain of terms that the given simulation has beyond the nominal one"""
    preferred: frozenset[str] = frozenset()
    """nominal terms that the given simulation lacks: taken where they gain all but a little of what the best gains"""
    least: float = MINIMUM_GAIN
    """log-likelihood a term has to gain in this channel"""
    _cache: dict[tuple[int, ...], Fit] = field(default_factory=dict)

    def fit(self, chosen: Sequence[Entry]) -> Fit:
        """Fit the simulation with the terms chosen."""
        index = tuple(sorted({*self.base, *(i for entry in chosen for i in entry.index)}))
        if index not in self._cache:
            self._cache[index] = self.bank.fit(index)
        return self._cache[index]

    def best(self, given: Sequence[Entry], pool: Sequence[Entry]) -> tuple[Entry | None, float]:
        """The entry of ``pool`` that gains most beside ``given``, and its gain."""
        start = self.fit(given).total
        gains = [(self.fit([*given, entry]).total - start, k) for k, entry in enumerate(pool) if entry not in given]
        if not gains:
            return None, -np.inf
        most, place = max(gains)
        nominal = [(gain, k) for gain, k in gains if pool[k].effect in self.preferred and gain > PREFERRED_SHARE * most]
        if nominal and most > 0.0:
            most, place = max(nominal)
        if self.admissible(given, pool[place]):
            return pool[place], most
        for gain, k in sorted(gains, reverse=True):
            if gain <= 0.0:
                break
            if self.admissible(given, pool[k]):
                return pool[k], gain
        return None, -np.inf

    def admissible(self, given: Sequence[Entry], entry: Entry) -> bool:
        """Whether an entry's coefficients beside ``given`` are physically possible: a lag that leads is no lag."""
        if not entry.bounds:
            return True
        index = sorted({*self.base, *(i for e in (*given, entry) for i in e.index)})
        fit = self.bank.fit(index, leave_out=False)
        own = [index.index(i) for i in entry.index]
        value = fit.coefficients[own]
        doubt = BEYOND * np.sqrt(np.maximum(np.diag(fit.covariance)[own], 0.0))
        low, high = np.asarray(entry.bounds).T
        if np.any(value + doubt < low) or np.any(value - doubt > high):
            return False
        return not (entry.one_sign and np.any(value > doubt) and np.any(value < -doubt))

    def allowed(self, given: Sequence[Entry]) -> list[Entry]:
        """Entries whose effect is not in ``given`` yet (or may be repeated)."""
        taken = {e.effect for e in given if e.effect not in self.repeated}
        return [e for e in self.entries if e.effect not in taken]

    def accepted(self, before: Fit, after: Fit, price: float = MINIMUM_GAIN) -> bool:
        """Whether the gain is large, and shared by the folds rather than owed to one."""
        gain = after.likelihood - before.likelihood
        return bool(gain.sum() > price and (spread_t(gain) > MINIMUM_T or gain.sum() > 3 * price))

    def forget(self, columns: Sequence[int]) -> None:
        """Drop what was scored with columns that have changed."""
        gone = set(columns)
        self._cache = {index: fit for index, fit in self._cache.items() if not gone & set(index)}

    def price(self, chosen: Sequence[Entry]) -> float:
        """Gain asked of a further term."""
        so_far = self.fit(chosen).total - self.fit(()).total + self.credit
        return max(self.least, MINIMUM_SHARE * so_far)

    def step(self, chosen: Sequence[Entry]) -> list[Entry] | None:
        """Add the best term, let each chosen one change for a better, drop what is idle; None where none helps."""
        pool = list(self.allowed(chosen))
        while True:
            entry, gain = self.best(chosen, pool)
            if entry is None or not self.accepted(self.fit(chosen), self.fit([*chosen, entry]), self.price(chosen)):
                return None
            if not self.echoes(chosen, entry, gain):
                break
            pool = [e for e in pool if e.effect != entry.effect]
        after = self.pruned(self.swapped([*chosen, entry]))
        return after if self.fit(after).total > self.fit(chosen).total else None

    def echoes(self, chosen: Sequence[Entry], entry: Entry, gain: float) -> bool:
        """Whether an entry looks like a chosen one and gains little beside it: nature's form, said with two names."""
        alone = self.bank.explained(entry.index, self.base)
        for other in chosen:
            beside = self.bank.explained(entry.index, [*self.base, *other.index])
            rest = [e for e in chosen if e != other]
            if beside < ECHO * alone and gain < ECHO_SHARE * (self.fit(chosen).total - self.fit(rest).total):
                return True
        return False

    def swapped(self, chosen: Sequence[Entry], rounds: int = 3) -> list[Entry]:
        """Replace each term in turn by the entry (any effect, form, point) that serves best beside the others."""
        current = list(chosen)
        for _ in range(rounds):
            changed = False
            for place in range(len(current)):
                others = current[:place] + current[place + 1 :]
                entry, _ = self.best(others, self.allowed(others))
                if entry is not None and entry != current[place]:
                    gain = self.fit([*others, entry]).total - self.fit(current).total
                    if gain > 0.5:
                        current[place] = entry
                        changed = True
            if not changed:
                break
        return current

    def pruned(self, chosen: Sequence[Entry]) -> list[Entry]:
        """Drop terms that the others have made unnecessary."""
        current = list(chosen)
        while len(current) > 1:
            whole = self.fit(current)
            without = [(whole.total - self.fit(current[:i] + current[i + 1 :]).total, i) for i in range(len(current))]
            loss, place = min(without)
            if loss > max(self.least, MINIMUM_SHARE * (whole.total - self.fit(()).total + self.credit)):
                break
            current.pop(place)
        return current


def spread_t(gain: FloatArray) -> float:
    """Gain over its standard error, between the folds that carry it."""
    size = np.abs(gain)
    touched = gain[size > 0.02 * size.max()] if size.max() > 0 else gain
    if touched.size < 2:
        return 0.0
    error = np.std(touched, ddof=1) * np.sqrt(touched.size)
    return float(touched.sum() / error) if error > 0 else 0.0
