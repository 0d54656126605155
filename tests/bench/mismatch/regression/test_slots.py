"""A name that a free function leaves no probability is not told."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest

from bench.mismatch.regression.model import Block, Chosen
from bench.mismatch.regression.regressors import Free, Named, Regressor
from bench.mismatch.regression.slots import Contender, Slot, _disowned
from bench.simulation.terms import LIBRARY, TEMPERATURE


def chosen(effect: str) -> Chosen:
    """An effect of the temperature's, or a function without a name."""
    regressor: Regressor
    if effect == "unknown":
        regressor = Free(TEMPERATURE, ())
    else:
        term = LIBRARY[effect]
        regressor = Named(term, TEMPERATURE, term.forms[TEMPERATURE][0])
    return Chosen(Block(regressor, (), np.zeros(0)))


def contender(effect: str, weight: float) -> Contender:
    """A rival of that weight."""
    return Contender(chosen(effect), np.zeros(0), 0.0, 1.0, weight, True)


@pytest.mark.parametrize(
    ("effect", "weight", "others", "disowned"),
    [
        ("thermal.convection_speed", 0.04, (("unknown", 0.96),), True),
        ("thermal.convection_speed", 0.30, (("unknown", 0.70),), False),
        # two names that share their probability are still names
        ("thermal.convection_speed", 0.10, (("thermal.second_mass", 0.30), ("unknown", 0.60)), False),
        ("unknown", 0.04, (("unknown", 0.96),), False),
        # a term of the nominal simulation that was switched off is known to be there
        ("thermal.convection", 0.04, (("unknown", 0.96),), False),
    ],
)
def test_who_is_disowned(effect: str, weight: float, others: tuple[Any, ...], disowned: bool) -> None:
    rivals = tuple(contender(name, share) for name, share in others)
    slot = Slot(chosen(effect), 10.0, 0.001, weight, rivals)
    nameless = max((r for r in rivals if r.chosen.effect == "unknown"), key=lambda r: cast("float", r.weight))
    assert _disowned(slot, nameless) is disowned
    assert not _disowned(slot, None)
