"""Numbers that decide, changed one at a time: the analysis runs with them, and the table says what became of it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from bench.mismatch import criteria
from bench.proof import criteria_table
from bench.proof.analyse import Job
from bench.proof.results import ResultsError

PROVENANCE = {
    "command": "bench prove --criteria",
    "seeds": [3],
    "commit": "c0ffee",
    "analyser": "abc",
    "asked": {"null": 1},
    "seal": "1",
}


def test_every_number_of_the_module_is_asked_for_but_a_definition() -> None:
    told = criteria_table.numbers()
    assert told["LEAST_STRENGTH"] == criteria.LEAST_STRENGTH
    assert "REFERENCE_CELSIUS" not in told
    written = {name for name in dir(criteria) if name.isupper()} - set(criteria_table.FIXED)
    assert set(told) == written


def test_a_count_stays_whole_and_what_follows_a_number_follows_it() -> None:
    assert criteria_table.changed("FEWEST_TURNS", "half") == {"FEWEST_TURNS": round(0.5 * criteria.FEWEST_TURNS)}
    assert criteria_table.changed("LEAST_STRENGTH", "twice") == {"LEAST_STRENGTH": 2.0 * criteria.LEAST_STRENGTH}
    rates = criteria_table.changed("ERROR_RATE", "twice")
    assert rates["ERROR_RATE_OF_A_CHANNEL"] == pytest.approx(rates["ERROR_RATE"] / 4.0)


@pytest.mark.slow
def test_the_analysis_runs_with_the_changed_number(made: SimpleNamespace, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a thousand recordings asked for, nothing is told of a folder that has fewer, and the report says so."""
    monkeypatch.setitem(criteria_table.FACTORS, "twice", 1000.0 / criteria.FEWEST_RECORDINGS)
    job = Job("clear", made.clear.name, 3, False, made.out, keep=True)
    none = criteria_table._analysed(criteria_table.Change(job, "FEWEST_RECORDINGS", "twice"))
    assert not none["failed"]
    assert not none["told"]
    place = made.out / "criteria" / "FEWEST_RECORDINGS-twice" / made.clear.alias
    # a third more than asked for are wanted of its pieces
    assert "do not make 1333 blocks" in json.loads((place / "report.json").read_text("utf-8"))["notes"][0]
    # what was done is not done again
    note = place / "result.json"
    before = note.stat().st_mtime_ns
    assert criteria_table._analysed(criteria_table.Change(replace(job), "FEWEST_RECORDINGS", "twice")) == none
    assert note.stat().st_mtime_ns == before


def test_the_page_names_the_folders_that_are_reported_otherwise(tmp_path: Path) -> None:
    same = {"value": 1.5, "right": 2, "otherwise": []}
    rows = [
        {"name": "RICHER", "value": 3.0, "half": same, "twice": {"value": 6.0, "right": 1, "otherwise": ["null-000"]}},
        {"name": "SURE", "value": 3.0, "half": same, "twice": same},
    ]
    found = {"folders": ["null-000", "clear-001"], "right": ["null-000", "clear-001"], "rows": rows}
    path = tmp_path / "criteria.json"
    criteria_table.store(path, criteria_table.as_json(found, PROVENANCE))
    text = criteria_table.page(path)
    assert "| `RICHER` | 3 | 2/2 | – | 1/2 | null-000 |" in text
    assert "every point is right in 2 of 2. 1 of 2 numbers change no report at half or twice" in text
    path.write_text(json.dumps({"format": "something else", "format_version": "1.0"}))
    with pytest.raises(ResultsError, match=r"criteria\.json"):
        criteria_table.page(path)
