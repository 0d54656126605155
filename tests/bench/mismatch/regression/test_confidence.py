"""How sure a finding is: the weight of all models that say the same of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.mismatch.discovery import AMBIGUOUS, NAMED
from bench.mismatch.discovery import UNKNOWN as UNKNOWN_STATUS
from bench.mismatch.regression.discoveries import _confidence
from bench.mismatch.regression.regressors import UNKNOWN
from bench.mismatch.regression.slots import Contender, Slot

NAME, OTHER = "friction.stribeck", "friction.viscous_quadratic"


def contender(effect: str, weight: float) -> Contender:
    """An alternative of such a weight that the recordings cannot tell from the effect."""
    chosen: Any = SimpleNamespace(effect=effect)
    return Contender(chosen, np.zeros(3), 0.0, 1.0, weight, True)


def confidence(status: str, weight: float, *alternatives: Contender, p_value: float = 0.0, sure: float = 1.0) -> Any:
    """Of an effect of a ``weight`` and its alternatives, of which those with a name are as good."""
    effect: Any = SimpleNamespace(effect=UNKNOWN if status == UNKNOWN_STATUS else NAME)
    slot = Slot(effect, 10.0, p_value, weight, alternatives)
    return _confidence(slot, status, [a for a in alternatives if a.chosen.effect != UNKNOWN], sure)


def test_something_without_a_name_has_none_where_a_name_is_likelier() -> None:
    assert confidence(UNKNOWN_STATUS, 0.3, contender(NAME, 0.6), contender(OTHER, 0.1)) is None


def test_something_without_a_name_has_the_weight_of_all_that_have_none() -> None:
    none = contender(UNKNOWN, 0.4)
    assert confidence(UNKNOWN_STATUS, 0.3, none, contender(NAME, 0.3)) == pytest.approx(0.7)


def test_forms_without_a_name_outweigh_a_name_together() -> None:
    assert confidence(UNKNOWN_STATUS, 0.3, contender(UNKNOWN, 0.2), contender(NAME, 0.45)) == pytest.approx(0.5)


def test_names_that_are_likelier_only_together_take_nothing_from_it() -> None:
    assert confidence(UNKNOWN_STATUS, 0.4, contender(NAME, 0.3), contender(OTHER, 0.3)) == pytest.approx(0.4)


def test_a_name_has_its_own_weight_and_that_of_names_not_told_apart() -> None:
    other = contender(OTHER, 0.6)
    assert confidence(NAMED, 0.3, other) == pytest.approx(0.3)
    assert confidence(AMBIGUOUS, 0.3, other) == pytest.approx(0.9)


def test_what_chance_explains_and_what_is_not_sure_is_taken_off() -> None:
    assert confidence(NAMED, 0.8, p_value=0.25, sure=0.5) == pytest.approx(0.3)
