"""The sets of real recordings: their tables, the expert's formulas, and what is said of files that are not there."""

from __future__ import annotations

from fnmatch import fnmatch
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.errors import ConfigurationError
from bench.importing.mapping import load_mapping
from bench.proof.real import examine as module
from bench.proof.real.examine import Examined, examine, expected_of
from bench.proof.real.expert import Regression
from bench.proof.real.formula import evaluate
from bench.proof.real.page import page
from bench.proof.real.sets import Expert, ExpertTerm, RealSet, all_sets, load_set
from bench.recording.folder import Rejected


def test_every_set_has_a_mapping_that_can_be_read_and_an_expert_that_can_be_asked(tmp_path: Path) -> None:
    sets = all_sets()
    assert len(sets) >= 21
    apart = {
        "ar5",
        "dvrk3",
        "hoist",
        "kinova",
        "loader",
        "lugre",
        "openarm",
        "schunk",
        "tmotor",
        "ur3",
    }
    assert {own.name for own in sets if own.apart} == apart
    for own in sets:
        file = tmp_path / f"{own.name}.toml"
        file.write_text(own.mapping, encoding="utf-8")
        mapping, _ = load_mapping(file)
        patterns = {entry.file for entry in mapping.recordings}
        columns = [*mapping.channels.values(), *mapping.aux.values()]
        columns += [channel for entry in mapping.recordings for channel in entry.channels.values()]
        patterns |= {own_file for channel in columns if (own_file := channel.file) is not None}
        names = [f.name for f in own.files]
        assert all(any(fnmatch(name, pattern) for name in names) for pattern in patterns)
        assert all(any(fnmatch(name, pattern) for pattern in patterns) for name in names)
        known = {name: np.linspace(0.1, 1.0, 5) for name in ("t", "q", "v", "a", *mapping.channels)}
        known |= {name: np.ones(5) for entry in mapping.recordings for name in entry.channels}
        known |= {name: np.ones(5) for name in mapping.aux} | {f"d_{name}": np.ones(5) for name in mapping.aux}
        for term in own.expert.terms:
            assert evaluate(term.column, known).shape == (5,)


def test_a_formula_knows_arithmetic_and_refuses_the_rest() -> None:
    v = np.array([-2.0, 0.5])
    assert evaluate("sign(v)*exp(-abs(v)/2)", {"v": v}) == pytest.approx(np.sign(v) * np.exp(-np.abs(v) / 2))
    with pytest.raises(ConfigurationError, match="'w' is not known"):
        evaluate("v + w", {"v": v})
    with pytest.raises(ConfigurationError, match="not known"):
        evaluate("__import__('os')", {"v": v})


def test_files_that_are_not_fetched_are_told_with_where_to_get_them(tmp_path: Path) -> None:
    own = all_sets()[0]
    row = examine(own, tmp_path, tmp_path / "out")
    assert len(row.missing) == len(own.files)
    assert own.files[0].at in row.missing[0]
    text = page([row])
    assert "files are missing" in text
    assert own.files[0].sha256 in text


def test_another_file_of_the_same_name_is_not_taken(tmp_path: Path) -> None:
    own = all_sets()[0]
    (tmp_path / own.name).mkdir()
    (tmp_path / own.name / own.files[0].name).write_bytes(b"something else")
    assert "another file" in own.missing(tmp_path)[0]


def test_a_table_with_an_unknown_key_is_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"x\.toml: name"):
        load_set("nmae = 'x'", "x.toml")


def _first_seen_before() -> RealSet:
    """A set of whose first sight nothing was written down."""
    return next(own for own in all_sets() if own.first is None)


def test_a_set_that_failed_is_a_row_with_the_reason() -> None:
    text = page([Examined(_first_seen_before(), failed="it has no torque")], "Made at noon.")
    assert "false names 0.\n\nMade at noon." in text or "No set was examined.\n\nMade at noon." in text
    assert "Failed: it has no torque" in text


def test_an_analysis_that_breaks_is_a_row_that_names_the_error_and_the_next_set_is_examined(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second = (own.model_copy(update={"files": ()}) for own in all_sets()[:2])

    def broken(folder: Path, *_: object, **_more: object) -> object:
        if folder.parent.name == first.name:
            raise ZeroDivisionError("no sample at all")
        return SimpleNamespace(
            verdict="match",
            left_out=(),
            findings=(),
            outcomes=(),
            data=SimpleNamespace(linear=False),
            why="",
            skipped=[],
        )

    monkeypatch.setattr(module, "import_recordings", lambda *_: [])
    monkeypatch.setattr(module, "run", broken)
    rows = [examine(own, tmp_path, tmp_path / "out") for own in (first, second)]
    assert rows[0].failed == "the analysis ended in an error: ZeroDivisionError: no sample at all"
    assert rows[1].verdict == "match"
    assert "Failed: the analysis ended in an error: ZeroDivisionError" in page(rows)


def test_where_nothing_can_be_imported_the_first_reason_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = all_sets()[0].model_copy(update={"files": ()})
    refused = [Rejected(tmp_path / name, f"{name} is not there") for name in ("a.csv", "b.csv")]
    monkeypatch.setattr(module, "import_recordings", lambda *_: refused)
    row = examine(own, tmp_path, tmp_path / "out")
    assert row.failed == "nothing could be imported: a.csv is not there"
    assert row.broken
    assert row.notes == ["a.csv is not there", "b.csv is not there"]


@pytest.mark.parametrize("code", [1, 0])
def test_a_set_that_failed_is_no_success_and_one_that_cannot_be_judged_is_an_answer(
    code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        module, "examine", lambda own, *_, **_more: Examined(own, failed="something is wrong", broken=bool(code))
    )
    done = CliRunner().invoke(make_app(), ["prove", "--real", str(tmp_path), "--set", "emps", "--out", str(tmp_path)])
    assert done.exit_code == code, done.output
    assert ("emps: something is wrong" in done.output) is bool(code)


def test_what_stops_the_program_stops_the_examination(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*_: object, **_more: object) -> object:
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "import_recordings", stopped)
    with pytest.raises(KeyboardInterrupt):
        examine(all_sets()[0].model_copy(update={"files": ()}), tmp_path, tmp_path / "out")


def test_what_the_expert_does_not_tell_from_zero_is_not_asked_for() -> None:
    effects = ("friction.coulomb", "friction.viscous", "aux/p", "aux/p", "")
    terms = tuple(ExpertTerm(symbol="x", column="1", unit="1", effect=effect) for effect in effects)
    found = Regression(np.array([5.0, -3.0, 0.1, 4.0, 9.0]), np.ones(5) * [1.0, 10.0, 1.0, 1.0, 1.0], 0.0, 0.0)
    assert expected_of(Expert(derivative_hz=1.0, how="x", terms=terms), found) == ["friction.coulomb", "aux/p"]


def test_what_came_out_at_first_sight_stands_in_a_table_of_its_own() -> None:
    own = next(own for own in all_sets() if own.first is not None and own.first.ratio is not None)
    assert own.first is not None
    text = page([Examined(own, failed="it has no torque")])
    table = text[text.index("First sight, before anything was changed:") :]
    assert own.first.said in table
    assert f"| {own.first.ratio:.2f} |" in table
    assert "First sight, before" not in page([Examined(_first_seen_before(), failed="it has no torque")])


def test_what_the_import_said_of_many_recordings_is_told_once() -> None:
    own = all_sets()[0]
    row = Examined(own, notes=["a gives 1.5 kg", "a gives -2e+05 kg", "b is wrong"], verdict="match")
    values = np.zeros(len(own.expert.terms))
    row.regression = Regression(values, values, 1.0, 1.0)
    text = page([row])
    assert "At import: a gives 1.5 kg (1 more recordings: the same with other numbers)\nAt import: b is wrong\n" in text
