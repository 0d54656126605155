from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.errors import RecordingError
from bench.recording import FAST_CHUNK_ROWS, ChannelSpec, Event, Recording, RecordingWriter, Segment
from bench.recording.repairing import repair
from bench.recording.validation import validate
from bench.recording.writing import sink
from tests.bench.recording import builders

_ENDLESS = """
import sys, time
from pathlib import Path
from bench.recording import RecordingWriter
from tests.bench.recording import builders
writer = RecordingWriter(Path(sys.argv[1]), builders.header("a"), builders.specs(), chunk_rows=int(sys.argv[2]))
writer.begin_segment("steady")
start = time.monotonic()
while True:
    rows = int((time.monotonic() - start) * float(sys.argv[3]))
    if rows > writer.rows:
        writer.append(builders.columns(writer.rows, rows))
        print(writer.rows, time.monotonic(), flush=True)
    time.sleep(0.02)
"""


def test_finished_recording_is_valid_and_as_written(tmp_path: Path) -> None:
    rows = 2 * FAST_CHUNK_ROWS + 77
    data = builders.columns(0, rows)
    with RecordingWriter(
        tmp_path / "a.h5", builders.header("a"), builders.specs(), chunk_rows=FAST_CHUNK_ROWS
    ) as writer:
        writer.begin_segment("ramp_up")
        for start in range(0, rows, 1000):
            if start == 3000:
                writer.begin_segment("steady")
            writer.append({name: values[start : start + 1000] for name, values in data.items()})
        writer.event(1.5, "warning", "lubricant: 31 °C")
        assert not (tmp_path / "a.h5").exists()
        path = writer.close(accepted=True, quality={"passed": True, "speed": 0.25})
    assert [file.name for file in tmp_path.iterdir()] == ["a.h5"]
    assert validate(path).violations == ()
    recording = Recording.open(path)
    assert (recording.complete, recording.accepted, recording.quality["speed"]) == (True, True, 0.25)
    assert recording.segments == (Segment("ramp_up", 0, 3000), Segment("steady", 3000, rows))
    assert recording.events == (Event(1.5, "warning", "lubricant: 31 °C"),)
    assert recording.channels == tuple(data)
    for name, values in data.items():
        assert recording.raw(name).dtype == values.dtype
        assert np.array_equal(recording.raw(name), values)


def test_xarray_opens_the_channels_as_one_labelled_dataset_in_si(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5", rows=500)
    recording = Recording.open(path)
    with xr.open_dataset(path, group="channels", engine="h5netcdf") as dataset:
        assert dict(dataset.sizes) == {"time": 500}
        for name in recording.channels:
            assert dataset[name].dims == ("time",)
            assert dataset[name].dtype == np.float64
            np.testing.assert_allclose(dataset[name].values, recording.si(name), rtol=1e-12)
        assert dataset["temperature"].attrs["units"] == "degC"
        assert dataset["time"].values[-1] == pytest.approx(499 / 2000)


def test_xarray_does_not_take_seconds_for_a_duration(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5", rows=10)
    with xr.open_dataset(path, group="channels", engine="h5netcdf") as dataset:
        assert dataset["time"].dtype.kind == "f"


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**31),
    blocks=st.lists(st.integers(0, 700), min_size=1, max_size=8),
    chunk_rows=st.integers(1, 600),
    dtypes=st.lists(st.sampled_from(["int8", "int16", "uint16", "int32", "int64", "uint64", "float64"]), max_size=4),
)
def test_write_read_round_trip(seed: int, blocks: list[int], chunk_rows: int, dtypes: list[str]) -> None:
    rng = np.random.default_rng(seed)
    rows = sum(blocks)
    specs = [ChannelSpec("time", "s", "int64", scale=1e-9)]
    data = {"time": np.cumsum(rng.integers(1, 10**6, rows))}
    for index, dtype in enumerate(["int16", *dtypes]):
        specs.append(ChannelSpec(f"c{index}", "1", dtype, float(rng.uniform(0.1, 2)), float(rng.uniform(-1, 1))))
        data[f"c{index}"] = rng.integers(0, 256, (rows, np.dtype(dtype).itemsize), dtype=np.uint8).view(dtype)[:, 0]
        if dtype == "float64":
            data[f"c{index}"] = rng.normal(size=rows)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.h5"
        with RecordingWriter(path, builders.header("a"), specs, chunk_rows=chunk_rows) as writer:
            start = 0
            for block in blocks:
                writer.append({name: values[start : start + block] for name, values in data.items()})
                start += block
        recording = Recording.open(path)
        assert recording.size == rows
        low, high = sorted(rng.integers(0, rows + 1, 2))
        for spec in specs:
            raw = recording.raw(spec.name)
            assert raw.dtype == spec.dtype
            assert np.array_equal(raw, data[spec.name])
            expected = data[spec.name][low:high].astype(np.float64) * spec.scale + spec.offset
            np.testing.assert_allclose(recording.si(spec.name, int(low), int(high)), expected, rtol=1e-15)


@pytest.mark.parametrize(("chunk_rows", "rate"), [(500, 2000.0), (FAST_CHUNK_ROWS, 2000.0), (FAST_CHUNK_ROWS, 2e5)])
def test_killed_process_leaves_all_but_half_a_second(tmp_path: Path, chunk_rows: int, rate: float) -> None:
    target = tmp_path / "a.h5"
    process = subprocess.Popen(
        [sys.executable, "-c", _ENDLESS, str(target), str(chunk_rows), str(rate)],
        stdout=subprocess.PIPE,
        text=True,
        cwd=Path(__file__).parents[3],
    )
    assert process.stdout is not None
    appended: list[tuple[int, float]] = []
    stalled = threading.Timer(60.0, process.kill)
    stalled.start()
    for line in process.stdout:
        if line.count(" "):
            rows, at = line.split()
            appended.append((int(rows), float(at)))
        # killed by its own clock: on a busy machine it may take seconds to begin
        if appended and appended[-1][1] - appended[0][1] > 1.5:
            process.send_signal(signal.SIGKILL)
    stalled.cancel()
    process.wait()
    process.stdout.close()
    recording = Recording.open(tmp_path / "a.h5.part")
    # The half second promised, and as much again for a machine that is busy with other tests.
    safe = [rows for rows, at in appended if at < appended[-1][1] - 1.0]
    assert not recording.complete
    assert recording.size >= safe[-1] > 0
    assert recording.segments == (Segment("steady", 0, recording.size),)
    data = builders.columns(0, recording.size)
    for name in recording.channels:
        assert np.array_equal(recording.raw(name), data[name])
    assert validate(recording.path).violations == ()


def test_a_stalled_source_is_flushed_and_goes_on(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    data = builders.columns(0, 2000)
    with RecordingWriter(path, builders.header("a"), builders.specs(), chunk_rows=1500) as writer:
        for start, stop in ((0, 100), (100, 900), (900, 2000)):
            writer.append({name: values[start:stop] for name, values in data.items()})
            deadline = time.monotonic() + 5
            while Recording.open(writer.part).size < stop and time.monotonic() < deadline:
                time.sleep(0.02)
            assert Recording.open(writer.part).size == stop
    recording = Recording.open(path)
    for name, values in data.items():
        assert np.array_equal(recording.raw(name), values)


def test_the_first_rows_are_flushed_at_once(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sink, "_MIN_FLUSH_SPACING_S", 1e9)
        with RecordingWriter(path, builders.header("a"), builders.specs(), chunk_rows=100) as writer:
            writer.begin_segment("steady")
            writer.append(builders.columns(0, 100))
            deadline = time.monotonic() + 5
            while Recording.open(writer.part).size < 100 and time.monotonic() < deadline:
                time.sleep(0.02)
            assert Recording.open(writer.part).size == 100


def test_an_exception_leaves_a_readable_part(tmp_path: Path) -> None:
    def fail_after_a_block() -> None:
        with RecordingWriter(tmp_path / "a.h5", builders.header("a"), builders.specs()) as writer:
            writer.append(builders.columns(0, 321))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail_after_a_block()
    assert not (tmp_path / "a.h5").exists()
    recording = Recording.open(tmp_path / "a.h5.part")
    assert (recording.size, recording.complete) == (321, False)


def test_a_run_cut_short_is_finished_as_such(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "a.h5", builders.header("a"), builders.specs()) as writer:
        writer.begin_segment("steady")
        writer.append(builders.columns(0, 321))
        path = writer.close(complete=False)
    recording = Recording.open(path)
    assert (recording.complete, recording.steady()) == (False, (slice(0, 321),))
    with h5py.File(path) as file:
        assert file["segments/stop"][0] == -1
    assert validate(path).valid


def test_a_full_disk_is_one_sentence_and_earlier_rows_stay(tmp_path: Path) -> None:
    code = """
import resource, signal, sys
from pathlib import Path
import numpy as np
from bench.errors import RecordingError
from bench.recording import RecordingWriter
from bench.recording.writing import sink
from tests.bench.recording import builders
sink._MIN_FLUSH_SPACING_S = 0.0
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
writer = RecordingWriter(Path(sys.argv[1]), builders.header("a"), builders.specs(), chunk_rows=500)
resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, resource.RLIM_INFINITY))
rng = np.random.default_rng(0)
try:
    for block in range(1000):
        data = builders.columns(block * 500, block * 500 + 500)
        data["load_angle"] = rng.integers(0, 2**60, 500)
        writer.append(data)
except RecordingError as error:
    print(error)
    try:
        writer.abandon()
    except RecordingError:
        sys.exit(7)
"""
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "a.h5")],
        capture_output=True,
        text=True,
        cwd=Path(__file__).parents[3],
        timeout=60,
        check=False,
    )
    assert done.returncode == 7, done.stderr
    assert "a.h5.part: writing failed after row" in done.stdout
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] == resource.RLIM_INFINITY
    recording = Recording.open(tmp_path / "a.h5.part")
    assert recording.size > 0
    assert np.array_equal(recording.raw("cycle"), builders.columns(0, recording.size)["cycle"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda block: block.pop("cycle"), "differs in cycle"),
        (lambda block: block.update(extra=block["time"]), "differs in extra"),
        (lambda block: block.update(cycle=block["cycle"][:-1]), "differ in shape"),
        (lambda block: block.update(motor_torque=block["cycle"] * 100), "do not fit int16"),
    ],
)
def test_blocks_that_do_not_fit_are_refused(tmp_path: Path, change: object, message: str) -> None:
    block = builders.columns(0, 1000)
    change(block)  # type: ignore[operator]
    with (
        RecordingWriter(tmp_path / "a.h5", builders.header("a"), builders.specs()) as writer,
        pytest.raises(RecordingError, match=message),
    ):
        writer.append(block)


def test_float32_is_refused_before_a_file_exists(tmp_path: Path) -> None:
    specs = [*builders.specs(), ChannelSpec("extra", "1", "float32")]
    with pytest.raises(RecordingError, match="float32"):
        RecordingWriter(tmp_path / "a.h5", builders.header("a"), specs)
    assert os.listdir(tmp_path) == []


def test_the_file_stays_small(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    rows = 3 * FAST_CHUNK_ROWS + 100
    rng = np.random.default_rng(0)
    data = builders.columns(0, rows)
    data["load_angle"] = data["load_angle"] + rng.normal(0, 8, rows).astype(np.int64)
    data["motor_torque"] = rng.normal(100, 3, rows).astype(np.int16)
    with RecordingWriter(path, builders.header("a"), builders.specs(), chunk_rows=FAST_CHUNK_ROWS) as writer:
        writer.append(data)
    assert path.stat().st_size / rows < 15


def test_nothing_recorded_is_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    for rows in (100, 200):
        writer = RecordingWriter(path, builders.header("a"), builders.specs())
        writer.append(builders.columns(0, rows))
        writer.abandon()
    assert Recording.open(tmp_path / "a.h5.part.1.part").size == 100
    assert Recording.open(tmp_path / "a.h5.part").size == 200
    builders.write(path)
    with pytest.raises(RecordingError, match="never overwritten"):
        RecordingWriter(path, builders.header("a"), builders.specs())
    assert Recording.open(path).size == 3000


def test_a_recording_in_the_making_belongs_to_its_writer(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    with RecordingWriter(path, builders.header("a"), builders.specs()) as writer:
        writer.append(builders.columns(0, 100))
        with pytest.raises(RecordingError, match="being written by a living process"):
            RecordingWriter(path, builders.header("a"), builders.specs())
        with pytest.raises(RecordingError, match="being written by a living process"):
            repair(writer.part)
    assert Recording.open(path).size == 100
