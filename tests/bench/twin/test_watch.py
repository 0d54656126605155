"""From recordings to an alarm: the watch itself, its process, what it says."""

from __future__ import annotations

import json
import threading
from pathlib import Path
from typing import Any

import pytest

from bench.errors import ConfigurationError
from bench.recording import RecordingFolder
from bench.simulation.terms import CHANNEL_UNITS
from bench.twin.companion import Companion
from bench.twin.finding import found
from bench.twin.job import Job
from bench.twin.names import likely
from bench.twin.process import RESULT, Watching
from bench.twin.watch import LIMIT, Watch
from tests.bench.twin.conftest import Known


def watched(known: Known, folder: Path) -> tuple[Watch, int | None]:
    """The watch after a campaign, and how many recordings had been seen at the alarm."""
    watch, at = Watch(known.model), None
    for number, recording in enumerate(sorted(RecordingFolder.open(folder).recordings, key=lambda r: r.started_at)):
        if watch.add(recording):
            at = number
    return watch, at


def test_two_warm_ups_that_the_model_has_raise_nothing(known: Known) -> None:
    watch, at = watched(known, known.without)
    assert at is None
    assert found(watch) is None
    assert watch.tested > 15
    assert {s.channel for s in watch.scales} == set(CHANNEL_UNITS)
    assert max(seen.evidence for seen in watch.seen) < LIMIT
    temperatures = [seen.recording.setpoint.temperature for seen in watch.seen]
    assert max(temperatures) - min(temperatures) >= 15.0


def test_a_zero_that_walks_is_seen_dated_placed_and_named(known: Known) -> None:
    watch, at = watched(known, known.walks)
    assert at is not None
    finding = found(watch)
    assert finding is not None
    ids = [seen.recording.recording_id for seen in watch.seen]
    assert ids.index(known.since) <= finding.noticed
    # it grows with a quarter of an hour as time constant: a few points may pass before it is more than noise
    assert -2 <= finding.since - ids.index(known.since) <= 8
    assert finding.streams[0].stream.channel == "load_torque"
    names = likely(watch, finding)
    assert "load.torque_offset" in {cause.effect for cause in names}
    assert all(cause.share is not None and 0.0 < cause.share <= 1.0 for cause in names)


def test_the_process_says_it_and_keeps_it_beside_the_recordings(known: Known) -> None:
    messages = Watching(Job(str(known.walks), str(known.model))).look()
    (alarm,) = (message for message in messages if message["type"] == "no_longer_holds")
    assert "likely since" in alarm["text"]
    assert "Quick look, not an analysis" in alarm["text"]
    looked = [message for message in messages if message["type"] == "looked"]
    assert len(looked) == len(list(known.walks.glob("*.h5")))
    assert looked[-1]["not_watched"] == {}
    kept = json.loads((known.walks / RESULT).read_text("utf-8"))
    assert kept["no_longer_holds"]["streams"][0]["channel"] == "load_torque"


def test_a_companion_ends_when_it_is_told_and_has_looked_at_everything(known: Known, tmp_path: Path) -> None:
    heard: list[dict[str, Any]] = []
    done = threading.Event()

    def hear(message: dict[str, Any]) -> None:
        heard.append(message)
        if message["type"] == "ended":
            done.set()

    folder = tmp_path / "few"
    folder.mkdir()
    for path in sorted(known.without.glob("*.h5"))[:3]:
        (folder / path.name).write_bytes(path.read_bytes())
    (folder / "broken.h5").write_bytes(b"no recording")
    companion = Companion(known.model, folder, tmp_path / "job.json", hear, nice=0)
    companion.finish()
    assert done.wait(120)
    assert heard[-1]["why"] == ""
    assert list(heard[-1]["unread"]) == ["broken"]
    looked = [message for message in heard if message["type"] == "looked"]
    assert len(looked) == 3
    companion.kill()


def test_a_wrong_model_is_refused_before_anything_moves(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="no such model"):
        Companion(tmp_path / "model.json", tmp_path, tmp_path / "job.json", print)
    (tmp_path / "model.json").write_text("{}")
    with pytest.raises(ConfigurationError):
        Companion(tmp_path / "model.json", tmp_path, tmp_path / "job.json", print)
