import sqlite3
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from bench.campaigns import Block, Campaign, Stage
from bench.campaigns.records.journal import NAME, Journal
from bench.campaigns.taken import Status, Taken, point_id
from bench.configuration import BenchFile, load_bench
from bench.errors import ConfigurationError
from bench.protocols import Point
from bench.recording import ChannelSpec, RecordingHeader, RecordingWriter

CAMPAIGN = Campaign("c", "title", (Stage("s", (Block("dwell"),)),))


@pytest.fixture(scope="module")
def file() -> BenchFile:
    return load_bench("rh380n")


def take(number: int, point: str = "p", status: Status = Status.PENDING) -> Taken:
    name = f"{point}-{number}"
    setpoint = {"load_torque": 0.0, "velocity": None, "temperature": None}
    return Taken(name, f"{name}.h5", "dwell", "a dwell", setpoint, point, number, status)


def write(folder: Path, taken: Taken, rows: int, finish: bool, accepted: bool | None = None) -> None:
    header = RecordingHeader(taken.recording_id, "c", "dwell", datetime.now(UTC), 2000.0, "emulator")
    writer = RecordingWriter(
        folder / taken.file, header, [ChannelSpec.of("time", scale=5e-4), ChannelSpec.of("motor_angle")]
    )
    if rows:
        writer.append({"time": np.arange(rows), "motor_angle": np.arange(rows)})
    if finish:
        writer.close(accepted=accepted, quality={"travel": {"passed": True}})
    else:
        writer.abandon()


def test_takes_come_back_as_they_were(tmp_path: Path, file: BenchFile) -> None:
    ended = [take(1, status=Status.FAILED), take(2, status=Status.DONE), take(1, "q", Status.FAILED)]
    with Journal(tmp_path, CAMPAIGN, file) as journal:
        for taken in ended:
            journal.begin(replace(taken, status=Status.PENDING))
            journal.end(taken)
    with Journal(tmp_path, CAMPAIGN, file) as journal:
        assert journal.takes() == ended
        assert journal.done() == {"p"}
        assert (journal.next_take("p"), journal.next_take("q"), journal.next_take("new")) == (3, 2, 1)


def test_what_is_remembered_first_stays(tmp_path: Path, file: BenchFile) -> None:
    with Journal(tmp_path, CAMPAIGN, file) as journal:
        assert journal.remember("start_temperature", "21.5") == "21.5"
    with Journal(tmp_path, CAMPAIGN, file) as journal:
        assert journal.remember("start_temperature", "30.0") == "21.5"


def test_another_campaign_is_refused_but_another_title_is_not(tmp_path: Path, file: BenchFile) -> None:
    Journal(tmp_path, CAMPAIGN, file).close()
    Journal(tmp_path, replace(CAMPAIGN, title="other", text="# comment"), file).close()
    with pytest.raises(ConfigurationError, match="--out"):
        Journal(tmp_path, replace(CAMPAIGN, stages=(Stage("s", (Block("dwell", repeats=2),)),)), file)


@pytest.mark.parametrize("accepted", [True, False])
def test_a_file_finished_just_before_a_kill_is_adopted(tmp_path: Path, file: BenchFile, accepted: bool) -> None:
    with Journal(tmp_path, CAMPAIGN, file) as journal:
        journal.begin(take(1))
    write(tmp_path, take(1), 5000, finish=True, accepted=accepted)
    with Journal(tmp_path, CAMPAIGN, file) as journal:
        (found,) = journal.takes()
    assert found.status is (Status.DONE if accepted else Status.FAILED)
    assert found.samples == 5000
    assert found.quality == {"travel": {"passed": True}}


def test_an_unfinished_file_becomes_a_recording_cut_short(tmp_path: Path, file: BenchFile) -> None:
    with Journal(tmp_path, CAMPAIGN, file) as journal:
        journal.begin(take(1))
    write(tmp_path, take(1), 5000, finish=False)
    (tmp_path / f"{take(1).file}.repair.part.1.part").write_bytes(b"a repair that was killed")
    with Journal(tmp_path, CAMPAIGN, file) as journal:
        (found,) = journal.takes()
        assert (found.status, found.note, found.samples) == (Status.FAILED, "cut short", 5000)
        assert journal.next_take("p") == 2
    assert (tmp_path / take(1).file).exists()
    # the recording lacks channels of the bench and is not valid: the unfinished file keeps its name
    assert [path.name for path in tmp_path.glob("*.part")] == [f"{take(1).file}.part"]


def test_a_file_that_cannot_be_read_is_a_failed_take(tmp_path: Path, file: BenchFile) -> None:
    with Journal(tmp_path, CAMPAIGN, file) as journal:
        journal.begin(take(1))
    (tmp_path / take(1).file).write_bytes(b"not a recording")
    with Journal(tmp_path, CAMPAIGN, file) as journal:
        (found,) = journal.takes()
    assert found.status is Status.FAILED
    assert take(1).file in found.note


def test_a_take_that_never_reached_the_disk_is_forgotten(tmp_path: Path, file: BenchFile) -> None:
    for rows in (None, 0):
        with Journal(tmp_path, CAMPAIGN, file) as journal:
            journal.begin(take(1))
        if rows is not None:
            write(tmp_path, take(1), rows, finish=False)
        with Journal(tmp_path, CAMPAIGN, file) as journal:
            assert journal.takes() == []
            assert journal.next_take("p") == 1
    assert not list(tmp_path.glob("*.h5.part"))


def test_the_journal_is_in_wal_mode(tmp_path: Path, file: BenchFile) -> None:
    Journal(tmp_path, CAMPAIGN, file).close()
    database = sqlite3.connect(tmp_path / NAME)
    assert database.execute("PRAGMA journal_mode").fetchone() == ("wal",)
    database.close()


points = st.builds(
    Point,
    st.sampled_from(["dwell", "reversal"]),
    st.floats(-1e3, 1e3),
    st.floats(-1, 1),
    st.none() | st.floats(20, 60),
    st.integers(1, 3),
    st.sampled_from(["", "a"]),
)


@given(points, points, st.sampled_from(["x", "y"]), st.sampled_from(["x", "y"]))
@hypothesis_settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_points_are_known_by_content(a: Point, b: Point, digest_a: str, digest_b: str) -> None:
    same = repr(a) == repr(b) and digest_a == digest_b
    assert (point_id(a, digest_a) == point_id(b, digest_b)) is same
