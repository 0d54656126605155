"""The table of STOP's times says what was seen, and nothing that was not."""

from __future__ import annotations

import json
import os
import re
import sys
import threading
import time
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.configuration import load_bench
from bench.matrix import stop_scene, stop_times
from bench.matrix.disks import DISK_BYTES, disk
from bench.matrix.processes import as_hardware
from bench.matrix.stop_scene import CONDITIONS, PRESSES
from bench.matrix.stop_table import page, reason
from bench.matrix.stop_times import Row
from bench.stop_button import StopButton, listening


def test_every_press_is_tried_in_every_condition() -> None:
    assert set(PRESSES) == {"page", "second browser", "shell"}
    assert {"service dead", "service hung", "service's folder gone", "run hung"} < set(CONDITIONS)
    assert {kind for kind, _ in CONDITIONS.values()} == {"", "full", "frozen", "read-only"}


def test_the_table_has_no_figure_for_what_was_not_seen() -> None:
    seen = Row("all is well", "page", "service after 0.01 s", 0.61, 0.55, "disable voltage", 0.012, 0.014)
    unseen = Row("run hung", "shell", "the run hangs | and more", note="")
    text = page([seen, unseen], 25.0)
    assert "| all is well | page | 0.61 | 0.55 | disable voltage | 0.01 | 0.01 | service after 0.01 s |" in text
    assert "| run hung | shell | – | – | – | – | – | the run hangs / and more |" in text
    assert "within 25 s" in text
    assert "1 of 2 rows are as expected; the longest time from press to torque off is 0.61 s." in text
    assert "- run hung, shell: the drives were not seen without torque" in text
    assert "not as they should be\n" not in page([seen], 25.0)


def test_a_row_that_was_measured_is_not_struck_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    struck: list[str] = []

    def measure(condition: str, press: str, folder: Path) -> Row:
        struck.append(f"{condition}, {press}")
        seen = 0.5 if len(struck) > 1 else None
        return Row(condition, press, "told", seen, seen, "disable voltage", 0.01, 0.02, "" if seen else "not measured")

    monkeypatch.setattr(stop_times, "measure", measure)
    places = ["--table", str(tmp_path / "t.md"), "--store", str(tmp_path / "t.json")]
    command = ["benchmark", "stop", "--only", "service dead", *places]
    done = CliRunner().invoke(make_app(), command)
    assert done.exit_code == 6, done.output
    assert "2 of 3 rows" in (tmp_path / "t.md").read_text("utf-8")
    done = CliRunner().invoke(make_app(), command)
    assert done.exit_code == 0, done.output
    assert struck == [f"service dead, {press}" for press in PRESSES] + ["service dead, page"]
    text = (tmp_path / "t.md").read_text("utf-8")
    assert "3 of 3 rows" in text
    assert re.search(
        r"Rows are of \d{4}-\d\d-\d\d, commit .*processors.*Load of the machine .*: [\d.]+ to [\d.]+\.", text
    )


def test_a_row_is_right_only_if_the_torque_went_in_time() -> None:
    def row(off: float | None, later: float | None, note: str = "") -> Row:
        return Row("disk full", "page", "", off, 1.0, "disable voltage", later, 0.03, note)

    assert reason(row(5.0, 0.2)) is None
    assert reason(row(0.15, None)) is None
    assert "0.21 s after the rung (disable voltage); looks were up to 0.03 s apart" in str(reason(row(5.0, 0.21)))
    assert "5.00 s after the press, and nobody said" in str(reason(row(5.0, None)))
    assert reason(row(None, None)) == "the drives were not seen without torque"
    assert reason(row(None, None, "not measured: no wire")) == "not measured: no wire"


def test_the_rung_is_what_the_listener_says_else_the_record(tmp_path: Path) -> None:
    pressed = time.time()
    row = Row("all is well", "page", torque_off_s=0.9)
    stop_times._rung(row, {}, tmp_path, pressed)
    assert (row.rung, row.rung_to_off_s) == ("", None)
    rungs = [{"rung": "controlled ramp", "began_s": 0.0}, {"rung": "disable voltage", "began_s": 0.6}]
    at = datetime.fromtimestamp(pressed + 0.2, UTC).isoformat(timespec="milliseconds")
    (tmp_path / "stop-0001.json").write_text(json.dumps({"at": at, "rungs": rungs}))
    stop_times._rung(row, {}, tmp_path, pressed)
    assert row.rung == "disable voltage"
    assert row.rung_to_off_s == pytest.approx(0.1, abs=0.002)
    said = {"rung": "stop sending", "rung_at_ns": round(1e9 * (pressed + 0.4))}
    stop_times._rung(row, said, tmp_path, pressed)
    assert row.rung == "stop sending"
    assert row.rung_to_off_s == pytest.approx(0.5, abs=0.002)


def test_the_listener_is_asked_until_it_knows_the_rung_or_is_gone() -> None:
    button, said = StopButton("run-1"), dict[str, Any]()
    with listening(button) as there:
        assert there.port is not None
        button.press("Ann")
        rungs = [SimpleNamespace(rung="disable voltage", at_ns=time.time_ns())]
        record = SimpleNamespace(to_rest_s=0.2, rest_seen_at_ns=time.time_ns(), rungs=rungs)
        timer = threading.Timer(0.3, lambda: button.stopped(record))
        timer.start()
        stop_times._hear(there.port, time.monotonic() + 10.0, said)
        assert said["rung"] == "disable voltage"
        timer.join()
    began = time.monotonic()
    stop_times._hear(there.port, began + 10.0, said)
    assert time.monotonic() - began < 5.0


def test_the_bench_it_is_measured_on_is_one(tmp_path: Path) -> None:
    bench = stop_times._bench(tmp_path / "bench.toml", "gb0").configuration
    assert bench.bus.interface == "gb0"
    assert bench.bus.cycle_time == stop_times.CYCLE_S
    # the disks that are broken are small ones, and a run has to begin on them
    assert bench.storage.minimum_free < 0.5 * DISK_BYTES
    assert bench.limits.load_torque == load_bench("rh380n").configuration.limits.load_torque


def test_a_command_that_does_not_end_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stop_scene, "COMMAND", (sys.executable, "-c", "import time; time.sleep(60)"))
    monkeypatch.setattr(stop_scene, "SHELL_S", 0.5)
    scene: Any = None
    assert "had not ended after" in PRESSES["shell"](scene, "Ann", None)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root makes disks")
def test_a_disk_is_filled_and_has_room_again(tmp_path: Path) -> None:
    from bench.errors import DeviceError

    try:
        with disk("full", tmp_path / "disk") as one:
            one.break_()
            with pytest.raises(OSError, match="No space left"):
                (one.folder / "more").write_bytes(bytes(1 << 16))
            one.mend()
            (one.folder / "more").write_bytes(bytes(1 << 16))
    except DeviceError as error:
        pytest.skip(f"no disk can be made here: {error}")


def test_the_emulator_waits_for_no_processor_where_that_may_be(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    before = os.sched_getscheduler(0)
    monkeypatch.setattr(os, "sched_setscheduler", lambda pid, policy, parameter: asked.append(policy))
    assert as_hardware()[0] == "--priority"
    assert asked == [os.SCHED_FIFO, before], "the caller's own is left as it was"

    def refuse(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    assert as_hardware() == ()


def test_the_page_says_what_the_stored_rows_hold() -> None:
    docs = Path(__file__).parents[3] / "docs"
    stored = json.loads((docs / "stop-times.json").read_text("utf-8"))
    rows = [Row.of(entry) for entry in stored]
    assert [list(row.as_dict().items()) for row in rows] == [list(entry.items()) for entry in stored]
    assert [(row.condition, row.press) for row in rows] == [(one, way) for one in CONDITIONS for way in PRESSES]
    text = (docs / "stop-times.md").read_text("utf-8")
    assert text == page(rows, stop_times.WATCH_S), "run bench benchmark stop"
