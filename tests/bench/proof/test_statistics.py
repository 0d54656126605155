from __future__ import annotations

import math

import numpy as np
import pytest

from bench.proof.results import Provenance
from bench.proof.score import CaseScore, EffectScore
from bench.proof.statistics import brier, clopper_pearson, reliability, strength_of_naming, summarise
from bench.proof.table import markdown


def case(name: str, right: bool, group: str = "clear", companions: tuple[str, ...] = ()) -> CaseScore:
    effect = EffectScore("te.harmonic", "named", 1.0, right, right, right, (0.02,), (True,))
    told = ((0.9, right), *((0.6, False) for _ in companions))
    return CaseScore(name, group, True, (effect,), companions, 1.01, told, 2.0)


def test_clopper_pearson_against_published_values() -> None:
    assert clopper_pearson(0, 300) == pytest.approx((0.0, 0.012221), abs=1e-5)
    assert clopper_pearson(10, 10)[1] == 1.0
    assert clopper_pearson(1, 10) == pytest.approx((0.002529, 0.445016), abs=1e-5)
    assert clopper_pearson(0, 0) == (0.0, 1.0)


def test_brier_rewards_honesty() -> None:
    assert brier([(1.0, True), (0.0, False)]) == 0.0
    assert brier([(1.0, False)]) == 1.0
    assert math.isnan(brier([]))


def test_summary_counts() -> None:
    row = summarise("clear", [case("a", True), case("b", False), case("c", True, companions=("te.sideband",))])
    assert row.every_point == (1, 3)
    assert row.status == (2, 3)
    assert row.located == (2, 2)
    # of the findings one answers nothing; in "b" none answers the effect
    assert row.precision == (2, 3)
    assert row.alarms == (1, 3)
    assert row.residual_right == (3, 3)


def test_a_false_finding_counts_that_tells_no_confidence() -> None:
    nothing = CaseScore("null", "null", False, (), ("unknown",), 1.01, (), 2.0)
    assert summarise("null", [nothing]).precision == (0, 1)


def test_reliability_bins_hold_every_finding() -> None:
    rows = reliability([case("a", True), case("b", False, companions=("te.sideband",))])
    assert sum(row["findings"] for row in rows) == 3
    assert rows[-1]["right"] == pytest.approx(0.5)


def test_strength_of_naming_recovers_a_threshold() -> None:
    rng = np.random.default_rng(1)
    effects = []
    for strength in np.repeat([0.05, 0.1, 0.2, 0.4, 0.8, 1.6], 60):
        chance = 1.0 / (1.0 + (0.3 / strength) ** 4)
        named = bool(rng.random() < chance)
        effects.append(EffectScore("te.harmonic", "named", float(strength), named, named, named))
    s50, s90 = strength_of_naming(effects, 0.5), strength_of_naming(effects, 0.9)
    assert s50 == pytest.approx(0.3, rel=0.15)
    assert s90 == pytest.approx(0.3 * 9.0**0.25, rel=0.25)


def test_never_named_lies_beyond_the_range() -> None:
    effects = [EffectScore("te.harmonic", "named", s, False, False, False) for s in (0.1, 0.4, 1.6)]
    assert strength_of_naming(effects, 0.5) > 1.6


HOW = Provenance("bench prove", (1,), "", "a", {"clear": 2}, "abc")


def test_table_names_what_is_wrong() -> None:
    text = markdown([case("good", True), case("bad", False, companions=("te.sideband",))], HOW)
    assert "| clear | 2 | 2 | 1/2 |" in text
    assert "te.harmonic not told (named); false: te.sideband" in text
    assert "| good |" not in text.split("not right")[1]
    assert "abc" in text
    assert "commit not known" in text
    assert "te.harmonic" in markdown([case("good", True)], HOW, severity=True)


def test_forms_in_the_library_are_kept_apart_from_those_not_in_it() -> None:
    def one(name: str, right: bool, inside: bool, status: str = "named") -> CaseScore:
        effect = EffectScore("te.harmonic", status, 1.0, right, right, right, in_library=inside)
        return CaseScore(name, "clear", True, (effect,), (), 1.0, (), 1.0)

    scores = [one("a", True, True), one("b", False, True), one("c", False, False), one("d", True, False, "unknown")]
    text = markdown(scores, HOW)
    assert "| in the library | 2 | 1/2 |" in text
    assert "| not in the library | 1 | 0/1 |" in text
    assert "| unknown kind with a state or several quantities | 1 | 1/1 |" in text


def test_alarms_of_a_cluttered_null_are_what_stands_beside_the_weak_orders() -> None:
    weak = EffectScore("te.harmonic", "named", 5.0, False, False, False)
    missed = CaseScore("null-000", "null", False, (weak,), (), 2.0, (), 1.0)
    false = CaseScore("null-001", "null", True, (weak,), ("te.sideband",), 1.0, (), 1.0)
    assert "False alarms on folders without effect: 1 of 2" in markdown([missed, false], HOW)
    told = CaseScore("null-002", "null", False, (), (), 1.0, (), 1.0)
    assert "1 of 1" in markdown([told], HOW)
