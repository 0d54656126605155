"""The tables of the proof: every way counted alike, nothing claimed where nothing was run."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from bench.errors import BenchError
from bench.investigate.loop import reason_to_stop
from bench.investigate.proof.page import BEGIN, END, insert_tables, tables
from bench.investigate.proof.picture import draw
from bench.investigate.proof.run import OPEN, RIGHT, UNSEEN, WAYS, WRONG, judge_report, random_points
from bench.mismatch.report.candidates import Candidate

TRUTH = {"effects": [{"effect": "te.hysteresis", "also": ["te.lost_motion"], "channels": ["transmission_error"]}]}


def _finding(effect: str, status: str, channel: str = "transmission_error") -> dict[str, Any]:
    return {"effect": effect, "status": status, "channel": channel, "also_in": []}


def _row(way: str, result: str, first: str = OPEN, case: str = "ambiguous-000") -> dict[str, Any]:
    right = result == RIGHT
    return {
        "case": case, "seed": 1, "effect": "te.hysteresis", "also": ["te.lost_motion"], "strength": 1.2, "way": way,
        "first": first, "result": result, "experiments": 2, "needed": 1 if right else None, "hours": 2.0,
        "hours_to_name": 0.5 if right else None, "commit": "abc", "day": "2026-11-22",
    }  # fmt: skip


def test_a_report_is_right_wrong_or_open() -> None:
    def judgement(*findings: dict[str, Any]) -> str:
        return judge_report({"findings": list(findings)}, TRUTH)

    assert judgement(_finding("te.hysteresis", "named")) == RIGHT
    assert judgement(_finding("te.lost_motion", "named")) == WRONG
    assert judgement(_finding("te.lost_motion", "ambiguous")) == OPEN
    assert judgement(_finding("te.lost_motion", "named"), _finding("unknown", "unknown")) == OPEN
    assert judgement(_finding("friction.stribeck", "named", "motor_torque")) == UNSEEN
    assert judgement() == UNSEEN


def test_a_state_in_which_no_point_can_be_run_gives_way_to_another(monkeypatch: pytest.MonkeyPatch) -> None:
    """A campaign without points cannot be run: seen where the lubricant was as warm as the bench allows."""
    point = Candidate("constant_velocity", 0.0, 0.1)
    cooled = Candidate("cooling", 0.0, 0.0, 30.0)
    found = [SimpleNamespace(name="as found", before=None), SimpleNamespace(name="cooled down", before=cooled)]
    scene: Any = SimpleNamespace(covered=None, bench=None, celsius=60.0)
    monkeypatch.setattr("bench.investigate.proof.run.states", lambda *_: iter(found))

    def only(names: set[str]) -> None:
        points = [SimpleNamespace(point=point)]
        monkeypatch.setattr(
            "bench.investigate.proof.run.offered_points",
            lambda state, _: (points if state.name in names else [], ["warm"]),
        )

    for seed in range(8):
        only({"cooled down"})
        assert random_points(seed)(scene, 0, 4) == (cooled, point)
        only(set())
        assert random_points(seed)(scene, 0, 4) == ()


def test_plants_that_were_never_open_are_counted_and_not_in_the_shares() -> None:
    rows = [_row(way, RIGHT if way == "asked" else OPEN) for way in WAYS]
    rows += [_row(way, RIGHT, RIGHT, "ambiguous-001") for way in WAYS]
    text = tables({"campaigns": rows, "asked": 9, "command": "c"})
    assert "1 of 2 plants open" in text
    assert "| designed | 1 of 1" in text
    assert "| as many points at random | 0 of 1" in text
    assert "2 of 9 plants done" in text


def test_a_plant_in_which_nothing_was_found_is_no_question_but_one_of_all_plants() -> None:
    rows = [_row(way, RIGHT) for way in WAYS]
    rows += [_row(way, UNSEEN, UNSEEN, "ambiguous-001") for way in WAYS]
    text = tables({"campaigns": rows, "asked": 9, "command": "c"})
    assert "1 of 2 plants open" in text
    assert "in 1 nothing was found" in text
    cells = next(line for line in text.splitlines() if line.startswith("| designed |")).split(" | ")
    assert cells[1].startswith("1 of 1 ")
    assert cells[5].startswith("1 of 2 ")


def test_an_end_without_a_finding_does_not_say_that_all_is_named() -> None:
    assert reason_to_stop(1, "") == "all is named"
    assert reason_to_stop(0, "").startswith("nothing is found")
    assert reason_to_stop(0, "one recording only") == "undetermined: one recording only"


def test_nothing_run_claims_nothing_and_the_page_keeps_its_words() -> None:
    page = insert_tables(
        f"# Words\n\n{BEGIN}\noutdated\n{END}\n\nmore\n", {"campaigns": [], "asked": 9, "command": "c"}
    )
    assert "| designed | not run | not run | none | not run | not run | not run |" in page
    assert page.startswith("# Words")
    assert page.endswith("more\n")
    assert "outdated" not in page


def test_open_plants_are_drawn_and_none_is_refused(tmp_path: Path) -> None:
    rows = [_row(way, result) for way, result in zip(WAYS, (RIGHT, OPEN, WRONG), strict=True)]
    rows += [_row(WAYS[0], UNSEEN, OPEN, "ambiguous-001")]
    assert draw({"campaigns": rows}, tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(BenchError, match="no plant was left open"):
        draw({"campaigns": [_row(way, RIGHT, RIGHT) for way in WAYS]}, tmp_path / "b.png")
