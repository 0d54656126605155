"""A chance that a law through a few surrogates makes rare is counted before it decides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
import pytest

from bench.mismatch import criteria
from bench.mismatch.regression.scan import Scan
from bench.mismatch.unnamed import structure

GAIN = 13.0


@dataclass
class Asked:
    """A search of which only the seed counts."""

    seed: int = 0
    model: Any = field(default_factory=lambda: type("M", (), {"chosen": ()})())


def scans(values: Sequence[float]) -> list[Scan]:
    return [Scan(np.zeros(1), np.asarray(values, dtype=np.float64))]


@pytest.mark.parametrize(("heavy", "rare"), [(0.01, False), (0.0, True)])
def test_the_tail_is_counted_where_a_law_makes_it_rare(
    monkeypatch: pytest.MonkeyPatch, heavy: float, rare: bool
) -> None:
    drawn: list[int] = []

    def more(search: Asked, _beside: object) -> list[Scan]:
        drawn.append(search.seed)
        rng = np.random.default_rng(search.seed)
        return scans(np.where(rng.random(300) < heavy, GAIN + 1.0, rng.gumbel(3.0, 1.2, 300)))

    monkeypatch.setattr(structure, "shuffled", more)
    first = scans(np.minimum(np.random.default_rng(0).gumbel(3.0, 1.2, 300), GAIN - 1.0))
    p = structure._chance(cast(Any, Asked()), first, GAIN)
    assert len(set(drawn)) == structure.MORE_SURROGATES
    assert (p < criteria.ERROR_RATE_OF_A_CHANNEL) is rare
    if not rare:
        assert p == pytest.approx(heavy, rel=0.5)


@pytest.mark.parametrize("gain", [3.0, 200.0])
def test_no_more_are_drawn_where_the_first_say_enough(monkeypatch: pytest.MonkeyPatch, gain: float) -> None:
    def never(*_: object) -> list[Scan]:
        raise AssertionError("drawn again")

    monkeypatch.setattr(structure, "shuffled", never)
    first = scans(np.random.default_rng(0).gumbel(3.0, 1.2, 300))
    p = structure._chance(cast(Any, Asked()), first, gain)
    assert p == criteria.LEAST_P if gain > GAIN else p > 0.1


def test_where_no_candidate_has_anything_beside_the_model_nothing_is_rare() -> None:
    assert structure._chance(cast(Any, Asked()), scans([-np.inf] * 300), GAIN) == 1.0
