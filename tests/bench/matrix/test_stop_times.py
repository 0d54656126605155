"""The table of STOP's times says what was seen, and nothing that was not."""

from __future__ import annotations

import json
import os
import time
from datetime import UTC, datetime
from pathlib import Path

import pytest

from bench.configuration import load_bench
from bench.matrix import stop_times
from bench.matrix.disks import disk
from bench.matrix.stop_table import page
from bench.matrix.stop_times import CONDITIONS, PRESSES, Row


def test_every_press_is_tried_in_every_condition() -> None:
    assert set(PRESSES) == {"page", "second browser", "shell"}
    assert {"service dead", "service hung", "service's folder gone", "run hung"} < set(CONDITIONS)
    assert {kind for kind, _ in CONDITIONS.values()} == {"", "full", "frozen", "read-only"}


def test_the_table_has_no_figure_for_what_was_not_seen() -> None:
    seen = Row("all is well", "page", "service after 0.01 s", 0.61, 0.55, "disable voltage", 0.012)
    unseen = Row("run hung", "shell", "the run hangs | and more", note="")
    text = page([seen, unseen], 25.0, ["Measured."])
    assert "| all is well | page | 0.61 | 0.55 | disable voltage | 0.01 | service after 0.01 s |" in text
    assert "| run hung | shell | – | – | – | – | the run hangs / and more |" in text
    assert "within 25 s" in text


def test_the_rung_is_taken_from_the_record_of_the_stop(tmp_path: Path) -> None:
    pressed = time.time()
    row = Row("all is well", "page", torque_off_s=0.9)
    stop_times._rung(row, tmp_path, pressed)
    assert (row.rung, row.rung_to_off_s) == ("no record", None)
    rungs = [{"rung": "controlled ramp", "began_s": 0.0}, {"rung": "disable voltage", "began_s": 0.6}]
    at = datetime.fromtimestamp(pressed + 0.2, UTC).isoformat(timespec="milliseconds")
    (tmp_path / "stop-0001.json").write_text(json.dumps({"at": at, "rungs": rungs}))
    stop_times._rung(row, tmp_path, pressed)
    assert row.rung == "disable voltage"
    assert row.rung_to_off_s == pytest.approx(0.1, abs=0.002)


def test_the_bench_it_is_measured_on_is_one(tmp_path: Path) -> None:
    bench = stop_times._bench(tmp_path / "bench.toml", "gb0").configuration
    assert bench.bus.interface == "gb0"
    assert bench.bus.cycle_time == stop_times.CYCLE_S
    assert bench.limits.load_torque == load_bench("rh380n").configuration.limits.load_torque


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
