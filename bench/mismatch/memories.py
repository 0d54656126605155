"""Whether the recordings exercise a memory: a stack of plays on a load that only ever rises is a curve, no hysteresis.

In a design of steady points such a stack follows any odd function of the load and would, with its several widths, win
over the few static forms without a trace of path dependence. It is then left out; a single play stays, which such a
design cannot tell from lost motion.
"""

from __future__ import annotations

from collections.abc import Sequence

from bench.mismatch.bank import Bank
from bench.mismatch.columns import Entry, Layout

LEAST_PATH = 0.1
"""share of a stack's energy beside the simulation that no function of the load alone explains"""
PATH, FRESH = "torque_path", "stack"


def exercised(bank: Bank, layout: Layout, entries: Sequence[Entry]) -> list[Entry]:
    """The entries without stacks of plays that are functions of the load alone in these recordings."""
    over_load = [i for e in layout.free if e.variables == ("torque",) for i in e.index]
    if not over_load:
        return list(entries)
    stacks = [e for e in entries if PATH in e.variables and len(e.index) > 1]
    # what was between the recordings nobody has seen: a state that is kept over them is no evidence by itself
    idle = {(e.effect, e.point) for e in stacks if e.form == FRESH and _static(bank, layout, e, over_load)}
    return [e for e in entries if e not in stacks or (e.effect, e.point) not in idle]


def _static(bank: Bank, layout: Layout, entry: Entry, over_load: Sequence[int]) -> bool:
    alone = bank.explained(entry.index, layout.base)
    beyond = bank.explained(entry.index, [*layout.base, *over_load])
    return beyond < LEAST_PATH * alone
