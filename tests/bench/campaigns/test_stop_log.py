from datetime import UTC, datetime
from pathlib import Path

import pytest

from bench.campaigns.records.stop_log import StopLog
from bench.safety import Cause, StopRecord

STOP = StopRecord(Cause.MOTOR_SPEED, "too fast", datetime.now(UTC), 1, (), None, {}, None, None, (), {})


def test_a_record_that_cannot_be_written_is_told_and_written_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_: int) -> None:
        raise OSError(28, "No space left on device")

    log = StopLog(tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr("os.fsync", fail)
        log.write([STOP])
    assert "No space left" in str(log.trouble)
    assert log.last is None
    log.write([STOP])
    assert (log.trouble, log.last) == (None, "stop-0001.json")
    assert [path.name for path in tmp_path.iterdir()] == ["stop-0001.json"]


def test_a_file_of_another_name_does_not_keep_a_stop_from_being_written(tmp_path: Path) -> None:
    (tmp_path / "stop-of-ann.json").write_text("{}")
    log = StopLog(tmp_path)
    log.write([STOP])
    assert (tmp_path / "stop-0001.json").exists()
    assert log.trouble is None
