"""The archive finds recordings by everything that stands in them or was noted, and its index can be thrown away."""

from __future__ import annotations

import json
import os
import sqlite3
from contextlib import closing
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.archive import Index, Note, Query, add_note, read_notes
from bench.archive import index as index_module
from bench.archive.benchmark import measure_archive
from bench.archive.notes import FILE
from bench.errors import ConfigurationError
from bench.recording import Setpoint
from tests.bench.recording.builders import write

AT = "2026-11-22T10:00:00+01:00"


@pytest.fixture
def root(tmp_path: Path) -> Path:
    root = tmp_path / "recordings"
    for folder, serial, day in (("spring", "RH-1", 3), ("autumn", "RH-2", 21)):
        (root / folder).mkdir(parents=True)
        for number, torque in enumerate((0.0, 300.0), 1):
            write(
                root / folder / f"000{number}-constant_velocity.h5",
                rows=200,
                campaign_id=folder,
                gearbox_serial=serial,
                started_at=datetime(2026, 11, day, 9, number, tzinfo=UTC),
                setpoint=Setpoint(torque, 0.1, 30.0),
                config='name = "bench-b"\n',
            )
    return root


@pytest.fixture
def index(root: Path) -> Index:
    made = Index(root, root / ".service" / "archive.sqlite")
    assert made.refresh() == 4
    return made


def names(index: Index, **query: Any) -> list[str]:
    return [f"{one['folder']}/{one['file'][:4]}" for one in index.search(Query(**query)).recordings]


@pytest.mark.parametrize(
    ("query", "found"),
    [
        ({}, ["autumn/0002", "autumn/0001", "spring/0002", "spring/0001"]),
        ({"gearbox": "rh-2"}, ["autumn/0002", "autumn/0001"]),
        ({"until": datetime(2026, 11, 10, tzinfo=UTC).timestamp()}, ["spring/0002", "spring/0001"]),
        ({"since": datetime(2026, 11, 21, 9, 2, tzinfo=UTC).timestamp()}, ["autumn/0002"]),
        ({"load_torque": 300.0, "gearbox": "RH-1"}, ["spring/0002"]),
        ({"load_torque": 301.0}, []),
        ({"velocity": 0.1004, "temperature": 30.04, "limit": 1}, ["autumn/0002"]),
        ({"words": "Lubricant AUTUMN"}, ["autumn/0002", "autumn/0001"]),
        ({"words": "100%"}, []),
        ({"kind": "validation"}, []),
        ({"result": "passed", "bench": "bench-b", "offset": 3}, ["spring/0001"]),
        ({"result": "cut short"}, []),
    ],
)
def test_recordings_are_found_by_what_stands_in_them(index: Index, query: dict[str, Any], found: list[str]) -> None:
    assert names(index, **query) == found


def test_every_recording_is_counted_by_folder(index: Index) -> None:
    found = index.search(Query(limit=1))
    assert found.total == 4
    assert [(one["name"], one["recordings"], one["gearbox"]) for one in found.folders] == [
        ("autumn", 2, "RH-2"),
        ("spring", 2, "RH-1"),
    ]
    assert json.dumps(found.recordings, allow_nan=False)


def test_notes_are_found_and_can_be_taken_back_and_nothing_is_deleted(index: Index, root: Path) -> None:
    add_note(root / "spring", Note(AT, "Ann", "tag", "reference"))
    add_note(root / "spring", Note(AT, "Ann", "comment", "oil was new", "0001-constant_velocity.h5"))
    add_note(root / "spring", Note(AT, "service", "person", "Bob"))
    assert index.refresh() == 0
    assert names(index, tag="reference") == ["spring/0002", "spring/0001"]
    assert names(index, tag="refer") == []
    assert names(index, words="oil new") == ["spring/0001"]
    assert names(index, person="bob") == ["spring/0002", "spring/0001"]
    (one,) = index.search(Query(words="oil")).recordings
    assert one["tags"] == ["reference"]
    assert "oil was new" in one["comments"][0]
    add_note(root / "spring", Note(AT, "Ann", "untag", "reference", "0002-constant_velocity.h5"))
    add_note(root / "spring", Note(AT, "Ann", "archive", "", "0001-constant_velocity.h5"))
    index.refresh()
    assert names(index, tag="reference") == []
    assert names(index, tag="reference", archived=True) == ["spring/0001"]
    add_note(root / "spring", Note(AT, "Ann", "restore", "", "0001-constant_velocity.h5"))
    index.refresh()
    assert names(index, tag="reference") == ["spring/0001"]
    assert len(list((root / "spring").glob("*.h5"))) == 2
    assert len(read_notes(root / "spring")) == 6


def test_a_recording_in_the_same_step_of_the_clock_is_seen(index: Index, root: Path, monkeypatch: Any) -> None:
    folder = root / "spring"
    changed = folder.stat().st_mtime_ns
    monkeypatch.setattr("bench.archive.index.time.time_ns", lambda: changed + 1_000_000)
    assert index.refresh() == 0
    write(folder / "0003-dwell.h5", rows=200, kind="dwell")
    os.utime(folder, ns=(changed, changed))
    assert index.refresh() == 1
    monkeypatch.setattr("bench.archive.index.time.time_ns", lambda: changed + 10_000_000_000)
    assert index.refresh() == 0
    assert names(index, kind="dwell") == ["spring/0003"]


def test_what_is_new_or_gone_or_no_use_is_seen(index: Index, root: Path) -> None:
    write(root / "spring" / "0003-dwell.h5", rows=200, kind="dwell")
    (root / "autumn" / "0001-constant_velocity.h5").write_bytes(b"no recording")
    (root / "autumn" / "0002-constant_velocity.h5").unlink()
    (root / "empty").mkdir()
    (root / "link").symlink_to(root / "spring")
    assert index.refresh() == 2
    assert names(index, kind="dwell") == ["spring/0003"]
    (lost,) = index.search(Query(result="no use")).recordings
    assert lost["file"] == "0001-constant_velocity.h5"
    assert "HDF5" in lost["words"]
    assert index.search(Query()).total == 4
    assert index.refresh() == 0


def test_an_index_is_made_anew_of_the_folders_alone(index: Index, root: Path) -> None:
    add_note(root / "autumn", Note(AT, "Ann", "tag", "kept"))
    index.refresh()
    before = index.search(Query())
    path = root / ".service" / "archive.sqlite"
    assert index.rebuild() == 4
    assert index.search(Query()) == before
    for content in (b"no database at all, but long enough to be looked at" * 50, b""):
        path.write_bytes(content)
        path.with_name(path.name + "-wal").unlink(missing_ok=True)
        index.refresh()
        assert index.search(Query()) == before
    with sqlite3.connect(path) as database:
        database.execute("PRAGMA user_version = 99")
    database.close()
    assert index.search(Query()) == before


@given(st.lists(st.text(max_size=30), max_size=3), st.binary(max_size=60))
def test_broken_lines_lose_no_note(tmp_path_factory: pytest.TempPathFactory, texts: list[str], junk: bytes) -> None:
    folder = tmp_path_factory.mktemp("notes")
    (folder / FILE).write_bytes(junk.replace(b"{", b"") + b"\n")
    kept = [text for text in texts if text.strip()]
    for text in kept:
        add_note(folder, Note(AT, "Ann", "comment", text))
    written = [text.encode("utf-8", "replace").decode() for text in kept]
    assert [note.text for note in read_notes(folder)] == written


@pytest.mark.parametrize(
    ("changes", "why"),
    [({"kind": "delete"}, "cannot be of kind"), ({"text": " "}, "needs a text"), ({"text": "x" * 3000}, "3000")],
)
def test_a_note_that_says_nothing_is_refused(tmp_path: Path, changes: dict[str, str], why: str) -> None:
    with pytest.raises(ConfigurationError, match=why):
        add_note(tmp_path, replace(Note(AT, "Ann", "comment", "well"), **changes))
    assert not (tmp_path / FILE).exists()


def test_the_benchmark_finds_what_it_made(tmp_path: Path) -> None:
    figures = measure_archive(tmp_path / "made", 30, repeats=1)
    assert figures.recordings == figures.found["everything"] == 30
    assert figures.found["words"] == 1
    assert figures.found["words nobody said"] == 0
    assert figures.found["result"] == 2
    assert figures.found["person and tag"] == 30
    assert set(figures.median_s) == set(figures.found)


def test_who_writes_the_index_takes_its_turn_before_reading(
    index: Index, root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A write between another's reading and writing would be refused at once, however long that one may wait."""
    annotate = index_module._annotate
    refused: list[str] = []

    def meanwhile(database: sqlite3.Connection, folder: str, notes: list[Note]) -> None:
        with closing(sqlite3.connect(root / ".service" / "archive.sqlite", timeout=0.0)) as other:
            try:
                other.execute("UPDATE folders SET notes = notes")
                other.commit()
            except sqlite3.OperationalError as error:
                refused.append(str(error))
        annotate(database, folder, notes)

    monkeypatch.setattr(index_module, "_annotate", meanwhile)
    add_note(root / "spring", Note(AT, "Ann", "comment", text="louder"))
    index.refresh()
    assert refused
    assert set(refused) == {"database is locked"}
    assert index.search(Query(words="louder")).total == 2
