"""Whatever fails in a run with torque: the bench comes to rest by the ladder, is latched, and all is on record."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bench.campaigns import Block, Campaign, Stage
from bench.campaigns.execution import outcome, room, runner, sequence_call, session
from bench.campaigns.execution.sequence_call import SequenceFailed, Stopped
from bench.campaigns.listener import Silent
from bench.campaigns.operator.directions import Directions
from bench.campaigns.operator.remark import LONGEST, clean_remark
from bench.campaigns.records.journal import Journal
from bench.campaigns.records.recorder import Recorder
from bench.campaigns.taken import Status, Summary
from bench.configuration import load_bench
from bench.cycle.end import EndKind
from bench.cycle.rig import Rig
from bench.errors import ConfigurationError, DeviceError, LimitError
from bench.protocols import BenchFacts, Phase, Point
from bench.recording import Recording
from bench.recording.validation import validate
from bench.safety import Cause, Standing
from bench.safety.acts import latch_of
from bench.stop_button import StopButton
from sequences.thermal import Dwell

OPTIONS = (("duration", 0.3),)
CAMPAIGN = Campaign(
    "three", "three short rests", (Stage("all", (Block("dwell", (0.0, 20.0, 40.0), options=OPTIONS),)),)
)


class Notices(Silent):
    """Remembers what was said."""

    def __init__(self) -> None:
        self.notices: list[str] = []
        self.pauses: list[str] = []

    def noticed(self, text: str) -> None:
        self.notices.append(text)

    def paused(self, now: bool, why: str = "") -> None:
        if now:
            self.pauses.append(why)


def run(folder: Path, listener: Silent | None = None, **more: Any) -> Summary:
    return session.run_campaign(load_bench("rh380n"), CAMPAIGN, folder, listener, **more)


def from_call(number: int, then: Callable[[], None]) -> Callable[[Dwell, Point, BenchFacts], tuple[Phase, ...]]:
    """``Dwell.phases`` that does something else from a call on; the plan asks three times, the run once a point."""
    honest, calls = Dwell.phases, []

    def phases(self: Dwell, point: Point, bench: BenchFacts) -> tuple[Phase, ...]:
        calls.append(point)
        if len(calls) >= number:
            then()
        return honest(self, point, bench)

    return phases


def broken() -> None:
    raise ZeroDivisionError("of a sequence")


def check_stopped(folder: Path, summary: Summary, cause: Cause, sentence: str) -> None:
    assert (summary.end.kind, summary.end.cause) == (EndKind.TRIPPED, cause)
    assert sentence in summary.end.text
    assert "\n" not in summary.end.text
    assert latch_of(load_bench("rh380n"), folder).read().standing is Standing.STOPPED
    (written,) = folder.glob("stop-*.json")
    assert summary.stop_record == written.name
    record = json.loads(written.read_text())
    assert record["cause"] == cause.name
    assert sentence in record["text"]
    assert record["rungs"][0]["rung"] == "controlled ramp"
    assert set(record["drives"].values()) == {"SWITCH_ON_DISABLED"}
    assert not list(folder.glob("*.part"))
    assert all(validate(path).valid for path in folder.glob("*.h5"))
    assert json.loads((folder / "campaign.json").read_text())["end"]["text"] == summary.end.text


def test_a_sequence_that_fails_stops_the_bench_in_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Dwell, "phases", from_call(5, broken))
    summary = run(tmp_path)
    check_stopped(tmp_path, summary, Cause.PROGRAM, "ZeroDivisionError: of a sequence (test_failures.py, line ")
    assert 'sequence "dwell"' in summary.end.text
    assert [taken.status for taken in summary.taken] == [Status.DONE]
    with pytest.raises(LimitError, match="ZeroDivisionError"):
        run(tmp_path)


def test_a_failure_in_the_middle_of_a_recording_finishes_it(tmp_path: Path) -> None:
    class Failing(Silent):
        def advanced(self, bench_time_s: float, temperature: float) -> None:
            raise RuntimeError("a page that cannot draw")

    summary = run(tmp_path, Failing())
    check_stopped(tmp_path, summary, Cause.PROGRAM, "RuntimeError: a page that cannot draw")
    (taken,) = summary.taken
    assert taken.status is Status.FAILED
    recording = Recording.open(tmp_path / taken.file)
    assert not recording.complete
    assert any("a page that cannot draw" in event.text for event in recording.events)


def test_a_failure_after_the_motion_closes_the_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outcome, "judge", lambda *_: broken())
    summary = run(tmp_path)
    check_stopped(tmp_path, summary, Cause.PROGRAM, "ZeroDivisionError")
    assert [taken.status for taken in summary.taken] == [Status.FAILED]


def test_whatever_a_recorder_raises_is_a_stop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Recorder, "rows", lambda *_: broken())
    check_stopped(tmp_path, run(tmp_path), Cause.RECORDER, "the recording cannot be written: ZeroDivisionError")


@pytest.mark.parametrize("ask", ["signal", "page"])
def test_a_sequence_that_blocks_is_ended_by_a_stop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ask: str) -> None:
    released = threading.Event()
    directions, button = Directions(), StopButton("run")

    def block() -> None:
        threading.Timer(0.1, directions.stop if ask == "page" else lambda: button.press("SIGTERM")).start()
        released.wait(20.0)

    monkeypatch.setattr(Dwell, "phases", from_call(5, block))
    began = time.monotonic()
    summary = run(tmp_path, directions=directions, button=button)
    released.set()
    assert time.monotonic() - began < 15.0
    assert (summary.end.kind, summary.end.cause) == (EndKind.INTERRUPTED, Cause.OPERATOR)
    assert 'waiting for sequence "dwell"' in summary.end.text
    assert latch_of(load_bench("rh380n"), tmp_path).read().standing is Standing.CLEAR


def test_a_drive_that_cannot_be_enabled_is_an_error_and_no_stop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def enable(self: Rig) -> None:
        # one drive may follow, the other not
        self.link.drives.request("ENABLED")
        raise DeviceError("the input drive is in fault")

    monkeypatch.setattr(Rig, "enable", enable)
    with pytest.raises(DeviceError, match="in fault"):
        run(tmp_path)
    assert latch_of(load_bench("rh380n"), tmp_path).read().standing is Standing.CLEAR
    assert not list(tmp_path.glob("stop-*.json"))


class Clock:
    """A bench that only lets time pass."""

    is_real_time = True
    elapsed_s = 0.0

    def idle(self, duration_s: float = 0.0) -> None:
        time.sleep(0.001)


def test_a_question_has_an_answer_a_stop_or_an_end() -> None:
    never = threading.Event()
    assert sequence_call.call_sequence("three", lambda: 3, Clock(), lambda: False) == 3
    with pytest.raises(Stopped, match="while waiting for nothing"):
        sequence_call.call_sequence("nothing", lambda: never.wait(5), Clock(), lambda: True)
    with pytest.raises(SequenceFailed, match=r"nothing did not come within 0\.03 s"):
        sequence_call.call_sequence("nothing", lambda: never.wait(5), Clock(), lambda: False, patience_s=0.03)
    with pytest.raises(SequenceFailed, match="it failed: ZeroDivisionError: of a sequence"):
        sequence_call.call_sequence("it", broken, Clock(), lambda: False)
    never.set()


def test_a_tap_that_fails_is_dropped_and_the_run_goes_on(tmp_path: Path) -> None:
    class Failing:
        def opened(self, *_: Any) -> None: ...
        def begin(self, *_: Any) -> None: ...
        def segment(self, *_: Any) -> None: ...
        def rows(self, *_: Any) -> None:
            raise ValueError("cannot be shown")

    noted = Notices()
    assert run(tmp_path, noted, tap=Failing()).end.kind is EndKind.FINISHED
    assert "live values have stopped, the recording goes on: ValueError: cannot be shown" in noted.notices[0]


# -- remarks -----------------------------------------------------------------------------------------------------------


def test_a_remark_becomes_one_line_that_can_be_printed() -> None:
    assert clean_remark("oil\u0000 changed\r\n\x1b[31m now\u202e ") == "oil changed [31m now"
    assert clean_remark("half \ud800 a pair, 3 °C – Ω") == "half a pair, 3 °C – Ω"
    with pytest.raises(ConfigurationError, match=f"1000000 characters, {LONGEST} are the most"):
        clean_remark("x" * 1_000_000)
    with pytest.raises(ConfigurationError, match="no character that can be printed"):
        clean_remark("\u0000\n")


def test_what_an_operator_types_never_ends_a_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    directions = Directions()
    # past the edge, as if it were not there
    directions._notes += ["nul \u0000 here", "half \ud800", "y" * 1_000_000]
    assert run(tmp_path, directions=directions).end.kind is EndKind.FINISHED
    (first, *_) = sorted(tmp_path.glob("*.h5"))
    texts = [event.text for event in Recording.open(first).events if event.level == "note"]
    assert texts[0] == "nul \ufffd here"
    assert len(texts[2]) == 4000
    assert validate(first).valid


def test_a_remark_that_cannot_be_written_is_told_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    honest = Recorder.event

    def event(self: Recorder, level: str, text: str) -> None:
        if level == "note":
            raise OSError("no")
        honest(self, level, text)

    monkeypatch.setattr(Recorder, "event", event)
    noted, directions = Notices(), Directions()
    directions.note("oil changed")
    assert run(tmp_path, noted, directions=directions).end.kind is EndKind.FINISHED
    assert 'the remark "oil changed" could not be written: OSError: no' in noted.notices[0]


# -- a disk that fills -------------------------------------------------------------------------------------------------


def test_a_disk_that_fills_pauses_the_run_until_there_is_room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    full: list[bool] = []
    directions, noted = Directions(), Notices()
    monkeypatch.setattr(runner, "shortage", lambda *_: "no room" if full else None)

    class Filling(Notices):
        def finished(self, taken: Any) -> None:
            if not noted.pauses:
                full.append(True)

        def paused(self, now: bool, why: str = "") -> None:
            noted.paused(now, why)
            # going on without room holds again
            directions.go_on()
            if len(noted.pauses) == 3:
                full.clear()

    summary = run(tmp_path, Filling(), directions=directions)
    assert (summary.end.kind, len(summary.taken)) == (EndKind.FINISHED, 3)
    assert noted.pauses == ["no room; make room, then go on"] * 3


def test_a_run_nobody_talks_to_ends_and_says_what_was_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    looks: list[Path] = []

    def shortage(folder: Path, needed: float) -> str | None:
        # before the torque and before the first point there is room; a file is closed some time after its point
        looks.append(folder)
        return "no room" if len(looks) > 2 else None

    monkeypatch.setattr(runner, "shortage", shortage)
    so_far = r"(1 of 3 points are measured|0 of 3 points are measured, 1 being closed)"
    with pytest.raises(room.NoRoom, match=rf"no room; {so_far} and the bench is brought to rest"):
        run(tmp_path)
    assert latch_of(load_bench("rh380n"), tmp_path).read().standing is Standing.CLEAR
    assert json.loads((tmp_path / "campaign.json").read_text())["end"]["kind"] == "interrupted"
    # with room it goes on where it was
    monkeypatch.setattr(runner, "shortage", lambda *_: None)
    summary = run(tmp_path)
    assert (summary.end.kind, summary.earlier + len(summary.taken)) == (EndKind.FINISHED, 3)


@pytest.mark.parametrize("act", ["begin", "end"])
def test_a_journal_that_cannot_be_written_holds_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, act: str
) -> None:
    honest, directions, noted, failing = getattr(Journal, act), Directions(), Notices(), [True, True]

    def write(self: Journal, taken: Any) -> None:
        if failing:
            raise DeviceError("journal.sqlite cannot be written")
        honest(self, taken)

    class Answering(Notices):
        def paused(self, now: bool, why: str = "") -> None:
            noted.paused(now, why)
            failing.clear()
            directions.go_on()

    monkeypatch.setattr(Journal, act, write)
    summary = run(tmp_path, Answering(), directions=directions)
    assert (summary.end.kind, len(summary.taken)) == (EndKind.FINISHED, 3)
    assert noted.pauses == ["journal.sqlite cannot be written; make room, then go on"]
