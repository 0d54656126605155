"""The record book is searched as a whole, remarked upon, and live values outlast the service."""

from __future__ import annotations

import json
from pathlib import Path

from bench.service.files.book import Book
from bench.service.files.disk import Disk
from bench.service.runs.history import COARSE_S, History
from tests.bench.service.conftest import Client


def test_every_word_has_to_stand_somewhere_and_the_newest_comes_first(tmp_path: Path) -> None:
    disk = Disk()
    book = Book(tmp_path / "log.jsonl", disk)
    for number in range(450):
        book.write("note", "Ann" if number % 2 else "Bob", f"oil looked at, {number}")
    assert disk.settled(10.0)
    book.write("alarm", "bench", "too hot")
    found = book.find("ann OIL")
    assert [entry["text"] for entry in found[:2]] == ["oil looked at, 449", "oil looked at, 447"]
    assert len(book.find("ann oil", limit=1000)) == 225
    assert [entry["text"] for entry in book.find(act="alarm")] == ["too hot"]
    assert len(book.find(limit=1000)) == 451
    disk.close(10.0)


def test_a_remark_needs_no_run_and_no_controls(client: Client) -> None:
    assert client.ask("book", name="Ann", text="oil\nchanged") == {"done": "written down: oil changed"}
    assert [entry["by"] for entry in client.get("book", params={"words": "oil changed", "act": "remark"})] == ["Ann"]
    assert client.get("book", params={"words": "unobtainium"}) == []
    assert len(client.get("book", params={"limit": 1})) == 1
    client.ask("book", 422, name="Ann", text="")


def bucket(start: float) -> dict[str, object]:
    return {"type": "live", "start": start, "end": start + 1.0, "values": {"load_torque": [0.0, 2.0, start, 1.0]}}


def test_hours_of_live_values_outlast_the_service(tmp_path: Path) -> None:
    disk, path = Disk(), tmp_path / "history.jsonl"
    before = History()
    before.keep_in(path, disk)
    for second in range(35):
        before.add(bucket(float(second)))
    assert disk.settled(10.0)
    disk.close(10.0)
    with path.open("a", encoding="utf-8") as file:
        file.write('[]\n{"start": 1}\n{"start": 35.0, "en')
    after = History()
    after.take_up(path, Disk())
    assert after.coarse() == before.coarse()[:3]
    assert after.coarse()[0]["end"] - after.coarse()[0]["start"] >= COARSE_S
    assert after.fine() == []
    after.clear()
    assert after.coarse() == []
    assert len(path.read_text("utf-8").splitlines()) == 6


def test_another_run_has_a_history_of_its_own(tmp_path: Path) -> None:
    disk = Disk()
    history = History()
    history.keep_in(tmp_path / "one.jsonl", disk)
    for second in range(12):
        history.add(bucket(float(second)))
    history.clear()
    history.keep_in(tmp_path / "two.jsonl", disk)
    for second in range(12):
        history.add(bucket(float(second)))
    assert disk.settled(10.0)
    for name in ("one.jsonl", "two.jsonl"):
        (line,) = (tmp_path / name).read_text("utf-8").splitlines()
        assert json.loads(line)["start"] == 0.0
    disk.close(10.0)
