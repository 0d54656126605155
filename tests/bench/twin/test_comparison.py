"""What is said of a comparison before and since, and how it is made of a folder."""

from __future__ import annotations

import json
import math
from datetime import UTC, datetime
from pathlib import Path

import pytest

from bench.errors import ConfigurationError
from bench.identification.comparison.compare import Change
from bench.recording import RecordingFolder
from bench.service.analyses.experiments import asked_of
from bench.service.analyses.work import Work, compare
from bench.service.models import NewAnalysis, NewInvestigation
from bench.service.settings import Settings
from bench.twin.comparison import BeforeSince, before_and_since, cells, not_judged
from bench.twin.comparison_page import write_comparison
from bench.twin.process import RESULT
from tests.bench.recording.builders import write
from tests.bench.twin.conftest import Known

FRICTION = Change("friction.coulomb f_c", "parameter", "N*m", 0.5, 0.6, 0.01, 1e-9, True)
SAME = Change("order 46, positive", "order", "rad", 2e-5, 2.01e-5, 1e-7, 0.4)
OPEN = Change("compliance, positive", "compliance", "rad/(N*m)", 3e-7, 3.3e-7, math.nan, math.nan)


def _found(*changes: Change) -> BeforeSince:
    return BeforeSince(Path("again"), "ab12", (12, 9), changes)


def test_the_sentence_has_what_changed_and_counts_what_was_judged() -> None:
    text = _found(FRICTION, SAME, OPEN).sentence
    assert text.startswith("1 of 2 quantities changed between 12 recordings before ab12 and 9 since: ")
    assert "friction.coulomb f_c" in text
    assert "order 46" not in text
    assert _found(SAME, OPEN).sentence.startswith("None of 1 quantities changed")
    assert "and 2 more" in _found(*[FRICTION] * 5).sentence


def test_both_values_of_a_row_have_one_unit() -> None:
    before, after, std, unit = cells(SAME)
    assert (float(before), float(after), float(std), unit) == (20.0, 20.1, 0.1, "µrad")
    # a value that is large enough for another unit stands beside one that is not
    grown = Change("thermal.capacity C", "parameter", "J/K", 900.0, 90000.0, 5.0, 1e-9, True)
    first, second, _, _ = cells(grown)
    assert float(second) == pytest.approx(100.0 * float(first))


def test_what_could_not_be_judged_is_named_and_nothing_else() -> None:
    assert not_judged([FRICTION, SAME]) == ""
    assert not_judged([FRICTION, OPEN]).endswith("both have measured: compliance, positive")


def test_the_page_has_the_changes_and_all_quantities(tmp_path: Path) -> None:
    page = write_comparison(_found(FRICTION, SAME, OPEN), tmp_path).read_text("utf-8")
    changed, every = page.split("All quantities")
    assert "friction.coulomb f_c" in changed
    assert "<td>order 46, positive</td>" not in changed
    assert "<td>order 46, positive</td>" in every
    assert "Not judged" in page
    content = json.loads((tmp_path / "comparison.json").read_text("utf-8"))
    assert (content["since"], content["recordings"]) == ("ab12", [12, 9])
    assert [c["changed"] for c in content["changes"]] == [True, False, False]


def test_a_watched_folder_is_split_where_the_twin_says_and_both_parts_are_identified(
    known: Known, tmp_path: Path
) -> None:
    ids = [r.recording_id for r in RecordingFolder.open(known.walks).recordings]
    place = tmp_path / "walks"
    place.mkdir()
    for path in known.walks.glob("*.h5"):
        (place / path.name).symlink_to(path)
    since = RecordingFolder.open(known.walks).recordings[len(ids) // 2].recording_id
    (place / RESULT).write_text(json.dumps({"no_longer_holds": {"since": since}}), "utf-8")
    out = tmp_path / "out"
    sentence = compare(Work("compare", str(place), str(out), asked={"since": ""}))
    assert f"{len(ids) // 2} recordings before {since} and {len(ids) - len(ids) // 2} since" in sentence
    content = json.loads((out / "comparison.json").read_text("utf-8"))
    assert content["since"] == since
    assert any(c["p_value"] is not None for c in content["changes"])
    assert "walks" in (out / "report.html").read_text("utf-8")


def test_parts_that_are_not_enough_say_so(tmp_path: Path) -> None:
    place = tmp_path / "few"
    place.mkdir()
    for day in (1, 2):
        write(place / f"000{day}_x.h5", rows=100, started_at=datetime(2026, 3, day, 9, tzinfo=UTC))
    assert before_and_since(place, "0002_x").sentence.startswith(
        "Nothing could be compared: 1 recordings before 0002_x"
    )
    with pytest.raises(ConfigurationError, match="is the first of"):
        before_and_since(place, "0001_x")


def test_what_does_not_go_with_a_comparison_is_refused() -> None:
    def asked(kind: str, **more: object) -> dict[str, object]:
        new = NewAnalysis.model_validate(
            {"request_id": "12345678", "name": "Ann", "folder": "again", "kind": kind, **more}
        )
        return asked_of(new, Settings(), None)

    assert asked("compare", since="0002-constant_velocity") == {"since": "0002-constant_velocity"}
    assert asked("compare") == {"since": ""}
    for kind, more, why in (
        ("mismatch", {"since": "ab12"}, "since goes with the kind compare"),
        ("compare", {"model": "one"}, "identifies both parts anew; leave model out"),
        ("investigate", {"model": "one"}, "nominal simulation; leave model out"),
        ("compare", {"investigation": NewInvestigation().model_dump()}, "goes with the kind investigate"),
    ):
        with pytest.raises(ConfigurationError, match=why):
            asked(kind, **more)
