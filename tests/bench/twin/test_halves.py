"""Before and since: split where the twin says, or where it is told."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path

import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.errors import ConfigurationError
from bench.recording import RecordingFolder
from bench.twin.halves import halves
from bench.twin.process import RESULT
from tests.bench.recording.builders import write


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    place = tmp_path / "again"
    place.mkdir()
    for number in range(1, 5):
        write(place / f"000{number}.h5", rows=100, started_at=datetime(2026, 3, number, 9, tzinfo=UTC))
    return place


def _ids(folder: Path) -> list[str]:
    return [r.recording_id for r in RecordingFolder.open(folder).recordings]


def _write_alarm(folder: Path, since: str | None) -> None:
    alarm = None if since is None else {"since": since}
    (folder / RESULT).write_text(json.dumps({"no_longer_holds": alarm}), "utf-8")


def test_the_twin_s_recording_is_the_first_since(folder: Path, tmp_path: Path) -> None:
    ids = _ids(folder)
    _write_alarm(folder, ids[2])
    before, since = halves(folder, tmp_path / "a")
    assert (_ids(before), _ids(since)) == (ids[:2], ids[2:])
    before, since = halves(folder, tmp_path / "b", ids[1])
    assert (_ids(before), _ids(since)) == (ids[:1], ids[1:])


def test_where_nothing_can_be_split_it_says_why(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="was not watched"):
        halves(folder, tmp_path / "a")
    _write_alarm(folder, None)
    with pytest.raises(ConfigurationError, match="saw no change"):
        halves(folder, tmp_path / "b")
    with pytest.raises(ConfigurationError, match="is the first of"):
        halves(folder, tmp_path / "c", _ids(folder)[0])
    (folder / RESULT).write_text("{", "utf-8")
    with pytest.raises(ConfigurationError, match="not as a twin leaves it"):
        halves(folder, tmp_path / "d")


def test_two_folders_are_not_split(folder: Path) -> None:
    done = CliRunner().invoke(make_app(), ["compare", str(folder), str(folder), "--since", "x"])
    assert isinstance(done.exception, ConfigurationError)
