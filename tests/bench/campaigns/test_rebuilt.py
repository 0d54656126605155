"""A damaged journal is put aside and made anew from the recordings; nothing that was measured is measured again."""

from __future__ import annotations

import random
import sqlite3
from contextlib import closing, suppress
from dataclasses import replace
from pathlib import Path

import pytest

from bench.campaigns import Block, Campaign, Stage
from bench.campaigns.execution.session import run_campaign
from bench.campaigns.records.journal import NAME, Journal, require_same
from bench.campaigns.records.rebuilt import rebuild
from bench.campaigns.taken import Taken
from bench.configuration import BenchFile, load_bench, parse_bench
from bench.cycle.end import EndKind
from bench.errors import ConfigurationError, DeviceError
from tests.bench.campaigns.test_failures import CAMPAIGN, Notices


@pytest.fixture(scope="module")
def file() -> BenchFile:
    return load_bench("rh380n")


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory, file: BenchFile) -> Path:
    folder = tmp_path_factory.mktemp("measured")
    assert run_campaign(file, CAMPAIGN, folder).end.kind is EndKind.FINISHED
    return folder


@pytest.fixture
def folder(measured: Path, tmp_path: Path) -> Path:
    """The folder as a run left it, with recordings that are not written to."""
    for path in measured.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    return tmp_path


def takes(folder: Path, file: BenchFile) -> tuple[list[Taken], dict[str, str], list[str]]:
    with Journal(folder, CAMPAIGN, file) as journal:
        kept = {key: journal.remember(key, "unknown") for key in ("id", "start_temperature", "zero")}
        return journal.takes(), kept, journal.notes


@pytest.mark.parametrize("damage", ["no database", "", "header only", "\0" * 8192])
def test_a_journal_that_is_none_is_made_anew(folder: Path, file: BenchFile, damage: str) -> None:
    before, kept, notes = takes(folder, file)
    assert not notes
    content = (folder / NAME).read_bytes()
    broken = content[:100] if damage == "header only" else damage.encode()
    (folder / NAME).write_bytes(broken)
    after, kept_after, notes = takes(folder, file)
    assert "made anew from 3 recordings" in notes[0]
    # the time a take took is counted in its samples now
    assert [replace(taken, duration_s=0.0) for taken in after] == [replace(taken, duration_s=0.0) for taken in before]
    assert kept_after == kept
    assert [path.read_bytes() for path in folder.glob(f"{NAME}.broken-*[0-9]")] == ([broken] if damage else [])


def test_the_next_run_repeats_nothing_and_says_so(folder: Path, file: BenchFile) -> None:
    (folder / NAME).write_bytes(b"no database")
    noted = Notices()
    summary = run_campaign(file, CAMPAIGN, folder, noted)
    assert (summary.earlier, summary.taken) == (3, [])
    assert "made anew from 3 recordings" in noted.notices[0]


def test_another_campaign_is_still_refused(folder: Path, file: BenchFile) -> None:
    (folder / NAME).write_bytes(b"no database")
    other = Campaign("three", "t", (Stage("all", (Block("dwell", (1.0,)),)),))
    require_same(folder, other, file)
    with pytest.raises(ConfigurationError, match="campaign"):
        Journal(folder, other, file)
    with pytest.raises(ConfigurationError, match="configuration"):
        Journal(folder, CAMPAIGN, parse_bench(f"{file.text}\n# changed", "b"))


def test_a_row_that_names_a_file_elsewhere_is_damage(folder: Path, file: BenchFile) -> None:
    with closing(sqlite3.connect(folder / NAME)) as database:
        (content,) = database.execute("SELECT content FROM takes LIMIT 1").fetchone()
        name = content.split('"file": "')[1].split('"')[0]
        database.execute("UPDATE takes SET content = ?", (content.replace(name, f"../{name}"),))
        database.commit()
    after, _, notes = takes(folder, file)
    assert len(notes) == 1
    assert len(after) == 3


def test_a_recording_that_cannot_be_read_is_told(folder: Path, file: BenchFile) -> None:
    (folder / NAME).write_bytes(b"no database")
    victim = sorted(folder.glob("*.h5"))[0]
    victim.write_bytes(b"no recording")
    after, _, notes = takes(folder, file)
    assert len(after) == 2
    assert victim.name in notes[1]


def test_a_disk_that_refuses_is_no_damage(folder: Path, file: BenchFile, monkeypatch: pytest.MonkeyPatch) -> None:
    error = sqlite3.OperationalError("database or disk is full")
    error.sqlite_errorcode = sqlite3.SQLITE_FULL

    def connect(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(sqlite3, "connect", connect)
    with pytest.raises(DeviceError, match="cannot be opened: database or disk is full"):
        Journal(folder, CAMPAIGN, file)
    assert not list(folder.glob("*.broken-*"))


def test_whatever_is_done_to_a_journal_nothing_measured_is_lost(
    folder: Path, file: BenchFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = rebuild(folder)
    monkeypatch.setattr("bench.campaigns.records.journal.rebuild", lambda _: found)
    dice, content = random.Random(12), (folder / NAME).read_bytes()
    points = {taken.point_id for taken in found.takes}
    for _ in range(60):
        damaged = bytearray(content)
        start = dice.randrange(len(damaged))
        match dice.randrange(4):
            case 0:
                damaged[start] ^= 1 << dice.randrange(8)
            case 1:
                del damaged[start:]
            case 2:
                damaged[start : start + 512] = bytes(len(damaged[start : start + 512]))
            case _:
                damaged[start:start] = dice.randbytes(64)
        for old in folder.glob(f"{NAME}*"):
            old.unlink()
        (folder / NAME).write_bytes(damaged)
        # a digest with a flipped letter is another campaign, as far as anybody can know
        with suppress(ConfigurationError), Journal(folder, CAMPAIGN, file) as journal:
            assert journal.done() <= points
            assert len(journal.takes()) == 3
