"""A disk that stands still while rows come in real time."""

import threading
import time
from pathlib import Path

import pytest

from bench.campaigns.records.recorder import Recorder
from bench.configuration import load_bench
from bench.errors import BacklogError
from bench.protocols import Segment
from bench.recording import Recording, RecordingWriter
from bench.recording.validation import validate
from bench.recording.writing.ordered_file import OrderedFile
from tests.bench.recording import builders

LONGEST_S = 1.0
"""A machine with much else to do; the disk stands still for as long as anybody waits for it."""


@pytest.fixture
def freeze(monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """Set: the disk works. Cleared: whoever commits to it waits."""
    works, commit = threading.Event(), OrderedFile.commit
    works.set()

    def wait(file: OrderedFile) -> None:
        assert works.wait(60.0)
        commit(file)

    monkeypatch.setattr(OrderedFile, "commit", wait)
    return works


def test_nobody_waits_and_all_rows_taken_are_in_the_file(tmp_path: Path, freeze: threading.Event) -> None:
    path, taken_s = tmp_path / "a.h5", [0.0]
    writer = RecordingWriter(path, builders.header("a"), builders.specs(), chunk_rows=100, wait=False)
    writer.begin_segment("steady")
    freeze.clear()

    def record_for_ever() -> None:
        while True:
            began = time.monotonic()
            writer.append(builders.columns(writer.rows, writer.rows + 100))
            writer.event(writer.rows / builders.SAMPLE_RATE, "info", "waits for nothing either")
            taken_s.append(time.monotonic() - began)

    with pytest.raises(BacklogError, match="has not kept up"):
        record_for_ever()
    assert max(taken_s) < LONGEST_S
    with pytest.raises(BacklogError):
        writer.event(0.0, "info", "too late")
    freeze.set()
    writer.close(complete=False, accepted=False)
    assert Recording.open(path).size == writer.rows > 5000
    assert validate(path).valid


def test_a_recorder_says_once_that_it_has_ended_and_drops_the_rest(tmp_path: Path, freeze: threading.Event) -> None:
    from bench.cycle.rig import Rig

    with Rig(load_bench("rh380n")) as rig:
        scaling = rig.scaling
        raw = {name: values[:10] for name, values in (rig.link.last or rig.link.hold(0.1)).raw.items()}
    recorder = Recorder(tmp_path / "a.h5", builders.header("a"), scaling, fast=False, ratio=185.0)
    freeze.clear()
    began = time.monotonic()
    for _ in range(400):
        recorder.segment(Segment.STEADY)
        recorder.event("info", "one more")
    recorder.rows(raw)
    assert time.monotonic() - began < LONGEST_S
    assert "has not kept up" in str(recorder.ended)
    freeze.set()
    recorder.close(complete=False, accepted=False, quality=None)
