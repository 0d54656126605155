from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.errors import RecordingError
from bench.recording import Recording, RecordingWriter, Segment
from bench.recording.repairing import repair
from bench.recording.validation import validate
from bench.recording.writing import sink
from tests.bench.recording import builders

_ROWS = 4000


def _part(folder: Path) -> Path:
    writer = RecordingWriter(folder / "a.h5", builders.header("a"), builders.specs(), chunk_rows=100)
    writer.begin_segment("ramp_up")
    for start in range(0, _ROWS, 100):
        if start == 300:
            writer.begin_segment("steady")
        writer.append(builders.columns(start, start + 100))
    writer.abandon()
    return writer.part


@pytest.fixture(scope="module")
def whole_part(tmp_path_factory: pytest.TempPathFactory) -> Path:
    spacing, sink._MIN_FLUSH_SPACING_S = sink._MIN_FLUSH_SPACING_S, 0.0
    try:
        return _part(tmp_path_factory.mktemp("part"))
    finally:
        sink._MIN_FLUSH_SPACING_S = spacing


def test_part_becomes_a_valid_recording_that_was_cut_short(tmp_path: Path, whole_part: Path) -> None:
    source = Path(shutil.copy(whole_part, tmp_path))
    done = repair(source)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a.h5", "a.h5.part.repaired"]
    assert done.source.read_bytes() == whole_part.read_bytes()
    assert (done.rows, done.rows_lost, done.complete) == (_ROWS, 0, False)
    recording = Recording.open(done.path)
    assert not recording.complete
    assert recording.segments == (Segment("ramp_up", 0, 300), Segment("steady", 300, _ROWS))
    assert recording.events[-1].text == f"cut short after {_ROWS} rows; valid prefix restored by repair"
    assert (recording.take, recording.zero_id, recording.config) == (1, "zero-1", builders.header().config)
    assert validate(done.path).violations == ()
    for name, values in builders.columns(0, _ROWS).items():
        assert np.array_equal(recording.raw(name), values)


@settings(max_examples=30, deadline=None)
@given(share=st.floats(0.0, 1.0))
def test_part_cut_at_random_gives_a_valid_prefix_or_one_sentence(share: float, whole_part: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        source = Path(shutil.copy(whole_part, folder))
        size = int(share * source.stat().st_size)
        with source.open("r+b") as file:
            file.truncate(size)
        refused = None
        try:
            done = repair(source)
        except RecordingError as error:
            refused = str(error)
        if refused is not None:
            assert refused.startswith(f"{source}: ")
            assert source.stat().st_size == size
            assert share < 0.9
            assert sorted(file.name for file in Path(folder).iterdir()) == [source.name]
            return
        assert validate(done.path).violations == ()
        recording = Recording.open(done.path)
        for name, values in builders.columns(0, recording.size).items():
            assert np.array_equal(recording.raw(name), values)


def test_much_of_a_part_cut_in_the_middle_is_saved(tmp_path: Path, whole_part: Path) -> None:
    source = Path(shutil.copy(whole_part, tmp_path))
    with source.open("r+b") as file:
        file.truncate(source.stat().st_size * 7 // 10)
    done = repair(source)
    assert 0.2 * _ROWS < done.rows < _ROWS
    assert done.rows + done.rows_lost == _ROWS


def test_finished_but_not_renamed_stays_complete(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5")
    done = repair(path.rename(tmp_path / "a.h5.part"))
    assert done.complete
    assert validate(path) == validate(path)
    recording = Recording.open(path)
    assert (recording.complete, recording.accepted, recording.quality) == (True, True, {"passed": True})


def test_prefix_ends_where_time_stops_increasing(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path, "r+") as file:
        file["channels/time"][1234] = 5
        del file.attrs["complete"]
    done = repair(path.rename(tmp_path / "a.h5.part"))
    assert (done.rows, done.rows_lost) == (1234, 3000 - 1234)


def test_further_attributes_are_kept_and_keep_leaves_the_source(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path, "r+") as file:
        file.attrs["operator"] = "AM"
    source = path.rename(tmp_path / "a.h5.part")
    done = repair(source, keep=True)
    assert source.exists()
    with h5py.File(done.path) as file:
        assert file.attrs["operator"] == "AM"


def test_nothing_is_overwritten(tmp_path: Path, whole_part: Path) -> None:
    source = Path(shutil.copy(whole_part, tmp_path))
    (tmp_path / "a.h5").write_bytes(b"precious")
    with pytest.raises(RecordingError, match="would be overwritten"):
        repair(source)
    assert (tmp_path / "a.h5").read_bytes() == b"precious"


@pytest.mark.parametrize(("content", "message"), [(b"", "not a readable HDF5"), (b"nonsense" * 100, "not a readable")])
def test_no_recording_at_all(tmp_path: Path, content: bytes, message: str) -> None:
    source = tmp_path / "a.h5.part"
    source.write_bytes(content)
    with pytest.raises(RecordingError, match=message):
        repair(source)
    assert source.exists()


def test_a_finished_file_needs_a_target(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="name the file"):
        repair(builders.write(tmp_path / "a.h5"))


def test_an_invalid_result_is_said_and_the_source_keeps_its_name(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5", config="this is [not TOML")
    source = path.rename(tmp_path / "a.h5.part")
    before = source.read_bytes()
    done = repair(source)
    assert not done.valid
    assert "is not TOML" in done.violations[0]
    assert source.read_bytes() == before


def test_a_repaired_file_is_set_aside_beside_an_earlier_one(tmp_path: Path) -> None:
    (tmp_path / "a.h5.part.repaired").write_bytes(b"precious")
    builders.write(tmp_path / "a.h5").rename(tmp_path / "a.h5.part")
    assert repair(tmp_path / "a.h5.part").source.name == "a.h5.part.repaired.2"
    assert (tmp_path / "a.h5.part.repaired").read_bytes() == b"precious"


def test_a_complete_file_that_lacks_a_chunk_becomes_its_prefix(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5", rows=20_000)
    with h5py.File(path, "r+") as file:
        file["channels/load_angle"].resize((8192,))
        file["channels/load_angle"].resize((20_000,))
    with pytest.raises(RecordingError, match="those from index 8192 on were never stored"):
        Recording.open(path)
    done = repair(path, tmp_path / "b.h5", keep=True)
    assert (done.rows, done.rows_lost, done.complete) == (8192, 20_000 - 8192, False)
