"""The archive over HTTP: what was recorded is found, noted, put aside and taken away as files; nothing is deleted."""

from __future__ import annotations

import io
import tarfile
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from bench.archive import read_notes
from bench.recording import Recording
from bench.service.data.downloads import moment
from tests.bench.recording.builders import write
from tests.bench.service.conftest import Client

FILE = "0001-constant_velocity.h5"


@pytest.fixture
def folder(client: Client, tmp_path: Path) -> Path:
    folder = tmp_path / "recordings" / "spring"
    folder.mkdir()
    write(folder / FILE, rows=300, gearbox_serial="RH-1", started_at=datetime(2026, 11, 3, 9, tzinfo=UTC))
    (folder / "campaign.json").write_text("{}")
    return folder


def found(client: Client, **query: Any) -> list[str]:
    return [one["file"] for one in client.get("archive", params=query)["recordings"]]


def test_what_was_recorded_is_found_by_date_and_gearbox(client: Client, folder: Path) -> None:
    assert found(client, gearbox="rh-1", since="2026-11-03", until="2026-11-03") == [FILE]
    assert found(client, until="2026-11-01") == []
    assert found(client, velocity=0.1, load_torque=500.0) == [FILE]
    refused = client.http.get("/api/archive", params={"since": "2026-13-40"})
    assert refused.status_code == 422
    assert "write it as" in refused.json()["problem"]


def test_the_end_of_a_day_is_included_and_a_time_is_taken_as_it_is() -> None:
    assert moment("2026-11-03T00:00+00:00", True) == datetime(2026, 11, 3, tzinfo=UTC).timestamp()
    day, end = moment("2026-11-03", False), moment("2026-11-03", True)
    assert day is not None
    assert end == pytest.approx(day + 86400.0, abs=3600.0)
    assert moment(" ", True) is None


def test_comments_tags_and_what_is_put_aside(client: Client, folder: Path) -> None:
    client.ask("archive/notes", name="Ann", folder="spring", file=FILE, kind="comment", text="loud\nbearing")
    client.ask("archive/notes", name="Ann", folder="spring", kind="tag", text="reference")
    assert found(client, words="loud bearing", tag="reference") == [FILE]
    client.ask("archive/notes", name="Ann", folder="spring", kind="archive")
    assert found(client) == []
    assert found(client, archived=True) == [FILE]
    assert client.get("folders")[0]["archived"]
    assert (folder / FILE).exists()
    client.ask("archive/notes", name="Ann", folder="spring", kind="restore")
    assert found(client) == [FILE]
    assert not client.get("folders")[0]["archived"]
    client.ask("archive/notes", 422, name="Ann", folder="spring", kind="comment", text=" ")
    client.ask("archive/notes", 404, name="Ann", folder="winter", kind="tag", text="x")
    assert [entry["by"] for entry in client.get("book") if entry["act"] == "note"] == ["Ann"] * 4


def test_a_recording_is_downloaded_as_it_is_and_exported(client: Client, folder: Path, tmp_path: Path) -> None:
    answer = client.http.get(f"/api/folders/spring/{FILE}/download")
    assert answer.content == (folder / FILE).read_bytes()
    assert FILE in answer.headers["content-disposition"]
    csv = client.http.get(f"/api/folders/spring/{FILE}/download", params={"form": "csv"})
    assert csv.status_code == 200, csv.text
    lines = [line for line in csv.text.splitlines() if not line.startswith("#")]
    assert len(lines) == 301
    assert "load_torque" in lines[0]
    refused = client.http.get("/api/folders/spring/campaign.json/download")
    assert refused.status_code == 422
    assert "no recording" in refused.json()["problem"]


def test_a_campaign_is_downloaded_as_one_file(client: Client, folder: Path, tmp_path: Path) -> None:
    (folder / "link").symlink_to("/etc/hostname")
    answer = client.http.get("/api/folders/spring/download")
    with tarfile.open(fileobj=io.BytesIO(answer.content)) as archive:
        assert archive.getnames() == [f"spring/{FILE}", "spring/campaign.json"]
        archive.extraction_filter = getattr(tarfile, "data_filter", None)
        archive.extractall(tmp_path / "out")
    assert Recording.open(tmp_path / "out" / "spring" / FILE).gearbox_serial == "RH-1"


def test_the_folder_of_a_run_knows_who_had_it_made(client: Client, tmp_path: Path) -> None:
    client.take("Ann")
    run = client.ask("runs", name="Ann", secret=client.secret, campaign="quick")
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "running")
    made = Path(run["folder"])
    made.mkdir(parents=True)
    client.launcher.end_all()
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "ended")
    deadline = time.monotonic() + 10.0
    while not read_notes(made):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    (note,) = read_notes(made)
    assert (note.kind, note.text) == ("person", "Ann")
