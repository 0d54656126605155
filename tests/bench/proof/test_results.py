"""Stored results come back as they were, and the pages say what they hold."""

from __future__ import annotations

import json
import math
import re
from dataclasses import asdict, replace
from pathlib import Path

import pytest

from bench.proof import figures
from bench.proof.results import Provenance, ResultsError, as_json, command_line, commit, load, plain, store
from bench.proof.score import CaseScore
from bench.proof.statistics import summarise
from bench.proof.table import _within
from tests.bench.proof.test_statistics import case
from tests.docs.commands import ROOT

HOW = Provenance("bench prove --set clear --seed 5", (5,), "0123456789abcdef", "fedcba98", {"clear": 4}, "seal")
SCORES = [
    case("good", True),
    case("bad", False, companions=("te.sideband",)),
    CaseScore("broken", "clear", False, (), (), math.nan, (), 1.0, "exit code 1", False),
]


def stored(folder: Path, name: str = "development", scores: list[CaseScore] = SCORES) -> Path:
    path = folder / f"{name}.json"
    store(path, as_json(scores, HOW))
    return path


def test_a_result_comes_back_as_it_was(tmp_path: Path) -> None:
    back = load(stored(tmp_path))
    assert back.provenance == HOW
    assert back.scores[:2] == tuple(SCORES[:2])
    assert math.isnan(back.scores[2].residual)
    assert replace(back.scores[2], residual=0.0) == replace(SCORES[2], residual=0.0)


def test_a_file_that_is_no_result_is_refused(tmp_path: Path) -> None:
    path = stored(tmp_path)
    path.write_text(path.read_text().replace('"1.1"', '"0.9"'))
    with pytest.raises(ResultsError, match=r"0\.9"):
        load(path)
    path.write_text("[]")
    with pytest.raises(ResultsError, match="no stored result"):
        load(path)


def test_the_command_is_told_without_what_changes_nothing() -> None:
    where = ["--jobs", "4", "--out=there", "--store", "x.json", "--done", "--keep"]
    told = ["prove", "--set", "null", *where, "--seed", "3"]
    assert command_line(told) == "bench prove --set null --seed 3"


def test_the_commit_is_that_of_the_work_tree(monkeypatch: pytest.MonkeyPatch) -> None:
    assert re.fullmatch(r"([0-9a-f]{40}(\+changes)?)?", commit())
    monkeypatch.setenv("PATH", "")
    assert re.fullmatch(r"([0-9a-f]{40})?", commit())
    assert "with changes" in replace(HOW, commit="0123456789abcdef+changes").summary


def test_a_table_says_how_it_came_about_and_how_much_of_it_is_done(tmp_path: Path) -> None:
    text = figures.table(load(stored(tmp_path)))
    assert "`bench prove --set clear --seed 5`; seed 5; commit `0123456789ab`; analyser `fedcba98`" in text
    assert "| clear | 4 | 2 | 1/3 |" in text  # asked for four, two done, one failed, one not yet
    assert "2 of 4 folders done" in figures.line(load(tmp_path / "development.json"))


def test_figures_follow_the_results(tmp_path: Path) -> None:
    page = "a <!-- proof development line --><!-- /proof --> b\n<!-- proof null table -->old<!-- /proof -->\n"
    first = figures.filled(page, tmp_path)
    assert "not run with this examination yet (`bench prove --set null --nulls 300" in first
    assert "old" not in first
    stored(tmp_path)
    second = figures.filled(first, tmp_path)
    assert "every point right in 1 of 3" in second
    assert figures.filled(second, tmp_path) == second
    stored(tmp_path, scores=[case("good", True)])
    assert figures.filled(second, tmp_path) != second


@pytest.mark.parametrize(("strength", "text"), [(0.1, "< 0.20"), (0.3, "0.30"), (0.9, "> 0.50")])
def test_a_strength_beyond_those_that_were_tried_is_a_bound(strength: float, text: str) -> None:
    assert _within(strength, [0.2, 0.5]) == text
    assert _within(strength, []) == "–"


def test_a_sweep_of_strengths_says_how_much_of_it_is_done(tmp_path: Path) -> None:
    path = tmp_path / "severity.json"
    store(path, as_json(SCORES[:2], HOW, severity=True))
    assert "2 of 4 folders done." in figures.table(load(path))


def test_the_table_of_peers_has_a_row_for_each_method(tmp_path: Path) -> None:
    other = plain(asdict(summarise("all", [case("good", True), case("bad", False)])))
    store(tmp_path / "peers.json", {**as_json(SCORES, HOW), "peers": {"lasso": other}})
    text = figures.filled("<!-- proof peers table --><!-- /proof -->", tmp_path)
    assert "| bench mismatch | 3 | 1/3 |" in text
    assert "| lasso | 2 | 1/2 |" in text


def test_a_figure_nobody_knows_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ResultsError, match="hearsay"):
        figures.filled("<!-- proof hearsay line --><!-- /proof -->", tmp_path)


def test_pages_are_written_where_they_differ(tmp_path: Path) -> None:
    (tmp_path / "docs" / "proof").mkdir(parents=True)
    (tmp_path / "README.md").write_text("<!-- proof quick line --><!-- /proof -->")
    (tmp_path / "docs" / "proof.md").write_text("no figures")
    (tmp_path / "docs" / "criteria.md").write_text("no figures")
    stored(tmp_path / "docs" / "proof", "quick")
    assert figures.write(tmp_path) == [tmp_path / "README.md"]
    assert figures.write(tmp_path) == []


@pytest.mark.parametrize("page", figures.PAGES, ids=str)
def test_the_documentation_quotes_what_is_stored(page: Path) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    assert "<!-- proof " in text
    assert figures.filled(text, ROOT / figures.RESULTS) == text, "bench prove --figures makes them anew"


def test_stored_results_are_json_without_nan(tmp_path: Path) -> None:
    content = json.loads(stored(tmp_path).read_text(), parse_constant=lambda word: pytest.fail(word))
    assert content["cases"][2]["residual"] is None
    assert [c["every_point_right"] for c in content["cases"]] == [True, False, False]


def test_figures_outside_a_checkout_say_so(tmp_path: Path) -> None:
    with pytest.raises(ResultsError, match=r"README\.md is not there: give the command in a checkout"):
        figures.write(tmp_path)
