"""The tables count what was run, and nothing that was not."""

from __future__ import annotations

from typing import Any

from bench.twin.proof.campaigns import cases
from bench.twin.proof.page import BEGIN, END, insert_tables, tables


def row(change: str, level: str, noticed: int | None, began: int | None = 20) -> dict[str, Any]:
    return {
        "commit": "0123456789abcdef", "change": change, "level": level, "points": 40, "began": began,
        "noticed": noticed, "told_since": began, "channel": "load_torque", "true_channel": "load_torque",
        "strongest": 1.0, "look_s": 0.05, "longest_look_s": 0.2,
    }  # fmt: skip


def test_delays_misses_and_false_alarms_are_counted() -> None:
    rows = [
        row("a pin chips", "clear", 24), row("a pin chips", "clear", None), row("a pin chips", "clear", 10),
        row("none", "none", None, None), row("none", "none", 30, None),
    ]  # fmt: skip
    text = tables({"command": "bench benchmark twin", "campaigns": rows})
    assert "| without a change | 1 of 2 " in text
    assert "| with one, alarm before it began | 1 of 3 " in text
    assert "| clear | a pin chips | 5 (5 to 5) | 1 of 2 " in text
    assert "| faint | all | not run | not run |" in text
    assert "5 campaigns run of those of" in text


def test_only_what_stands_between_the_marks_is_replaced() -> None:
    content = {"command": "x", "campaigns": []}
    page = insert_tables(f"before\n{BEGIN}\nold\n{END}\nafter\n", content)
    assert page.startswith("before\n")
    assert page.endswith("\nafter\n")
    assert "old" not in page


def test_every_change_comes_clear_and_faint_spread_among_those_without() -> None:
    listed = cases(60, 100)
    assert len(listed) == len({case.key for case in listed}) == 160
    with_one = [(case.change, case.level) for case in listed if case.change != "none"]
    assert {with_one.count(one) for one in with_one} == {5}
    assert sum(case.change == "none" for case in listed[:80]) == 50


def test_the_cost_at_the_bench_s_rate_is_told_where_it_was_measured() -> None:
    content: dict[str, Any] = {"command": "x", "campaigns": [row("a pin chips", "clear", 24)]}
    assert "of a core" not in tables(content)
    cost = {"sample_rate": 2000.0, "recordings": 24, "recorded_s": 480.0, "share": 0.031}
    cost |= {"longest_s": 1.5, "first_s": 9.0}
    assert "At 2 kHz (24 recordings of the emulated bench, 8.0 min): 3.1 % of a core" in tables(
        content | {"cost": cost}
    )
