from __future__ import annotations

import json
import os
import pickle
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.errors import RecordingError
from bench.recording import ChannelSpec, Event, Recording, RecordingFolder, Segment, reader, write_recording
from bench.recording.missing import consequences
from tests.bench.recording import builders


def test_everything_written_is_read(tmp_path: Path) -> None:
    recording = Recording.open(builders.write(tmp_path / "a.h5"))
    header = builders.header("a")
    for name in ("recording_id", "campaign_id", "kind", "started_at", "sample_rate", "source", "setpoint", "gearbox"):
        assert getattr(recording, name) == getattr(header, name)
    for name in ("point_id", "take", "zero_id", "config", "software", "gearbox_serial"):
        assert getattr(recording, name) == getattr(header, name)
    assert recording.complete
    assert recording.accepted is True
    assert recording.quality == {"passed": True}
    assert recording.segments == (Segment("ramp_up", 0, 100), Segment("steady", 100, 3000))
    assert recording.steady() == (slice(100, 3000),)
    assert recording.events == (Event(0.5, "info", "operator: lubricant topped up"),)
    assert recording.specs == {spec.name: spec for spec in builders.specs()}
    assert recording.problems == ()
    assert pickle.loads(pickle.dumps(recording)) == recording


@pytest.mark.parametrize("teeth", [0, -45])
def test_what_is_no_number_of_teeth_is_used_for_nothing(tmp_path: Path, teeth: int) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path, "r+") as file:
        file["gearbox"].attrs["z3"] = teeth
    gearbox = Recording.open(path).gearbox
    assert gearbox.z3 is None
    assert gearbox.z4 == builders.header("a").gearbox.z4


def test_si_is_raw_times_scale_plus_offset(tmp_path: Path) -> None:
    recording = Recording.open(builders.write(tmp_path / "a.h5"))
    for spec in builders.specs():
        raw = recording.raw(spec.name, 7, 1000)
        values = recording.si(spec.name, 7, 1000)
        assert values.dtype == np.float64
        np.testing.assert_allclose(values, raw * spec.scale + spec.offset, rtol=1e-15)
    assert recording.si("time", 5, 5).size == 0


def test_missing_velocity_is_derived_alike_for_any_rows(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5", rows=500)
    with h5py.File(path, "r+") as file:
        del file["channels/motor_velocity"]
    recording = Recording.open(path)
    assert "motor_velocity" not in recording.channels
    assert "motor_velocity" in recording
    assert recording.is_derived("motor_velocity")
    assert not recording.is_derived("motor_angle")
    whole = recording.si("motor_velocity")
    assert whole == pytest.approx(np.full(500, 185 * 2.0 * 2 * np.pi), rel=0.05)
    assert np.mean(whole) == pytest.approx(185 * 2.0 * 2 * np.pi, rel=1e-3)
    for start, stop in ((0, 500), (0, 1), (0, 2), (10, 20), (499, 500), (498, 500)):
        assert np.array_equal(recording.si("motor_velocity", start, stop), whole[start:stop])
    with pytest.raises(RecordingError, match="no channel 'motor_velocity'"):
        recording.raw("motor_velocity")


@settings(max_examples=20, deadline=None)
@given(rate=st.floats(-50, 50), acceleration=st.floats(-20, 20), rows=st.integers(3, 60))
def test_derived_velocity_is_exact_for_constant_acceleration(
    tmp_path_factory: pytest.TempPathFactory, rate: float, acceleration: float, rows: int
) -> None:
    time = np.arange(rows) / 100
    path = tmp_path_factory.mktemp("derived") / "a.h5"
    channels = {"time": time, "load_angle": rate * time + acceleration / 2 * time**2}
    write_recording(
        path,
        builders.header("a", source="import"),
        {name: (values, ChannelSpec.of(name, dtype="float64")) for name, values in channels.items()},
    )
    derived = Recording.open(path).si("load_velocity")
    assert derived[1:-1] == pytest.approx((rate + acceleration * time)[1:-1], abs=1e-9)


def _change(where: str, name: str, value: object) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        if value is None:
            del file[where].attrs[name]
        else:
            file[where].attrs[name] = value

    return change


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (_change("/", "format", None), "not a recording, root attribute 'format' is missing"),
        (_change("/", "format", "other"), "'format' is 'other', it should be 'bench-recording'"),
        (_change("/", "format_version", "2.0"), "'format_version' is '2.0', this reader knows 1.x"),
        (_change("/", "kind", None), "root attribute 'kind' is missing, it should be text"),
        (_change("/", "started_at", "soon"), "'started_at' is 'soon'"),
        (_change("/", "sample_rate", -1.0), "'sample_rate' is -1.0, it should be above 0 Hz"),
        (lambda file: file.pop("channels"), "there is no group /channels"),
        (lambda file: file["channels"].pop("time"), "there is no usable channel /channels/time"),
        (lambda file: [file["channels"].pop(n) for n in list(file["channels"]) if n != "time"], "nothing was measured"),
        (lambda file: file["channels/motor_angle"].resize((2999,)), "/channels/motor_angle has 2999 rows"),
    ],
)
def test_what_no_reader_can_use_is_one_sentence(
    tmp_path: Path, change: Callable[[h5py.File], object], sentence: str
) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises(RecordingError) as caught:
        Recording.open(path)
    assert sentence in str(caught.value)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda file: file.pop("segments"), "there is no group /segments"),
        (lambda file: file.pop("events"), "there is no group /events"),
        (lambda file: file.pop("setpoint"), "there is no group /setpoint"),
        (lambda file: file.pop("gearbox"), "there is no group /gearbox"),
        (lambda file: file["segments"].pop("stop"), "/segments/stop cannot be read"),
        (_change("/", "take", "first"), "'take' is 'first', it should be a whole number"),
        (_change("gearbox", "ratio", 0.0), "'ratio' is 0.0"),
        (_change("channels/cycle", "scale", "x"), "the channel is left out"),
        (_change("channels/motor_torque", "scale", 0.0175000001), "'scale_factor' 0.0175, one is wrong"),
        (lambda file: file["segments/stop"].__setitem__(1, 9999), "outside rows 0 to 3000"),
        (lambda file: file["channels"].create_dataset("table", data=np.zeros((3, 3))), "/channels/table is not a one-"),
    ],
)
def test_what_a_reader_can_live_with_is_a_problem(
    tmp_path: Path, change: Callable[[h5py.File], object], sentence: str
) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path, "r+") as file:
        change(file)
    recording = Recording.open(path)
    assert [problem for problem in recording.problems if sentence in problem], recording.problems
    assert recording.si("load_angle").size == 3000


def test_files_of_others_may_lack_all_that_is_ours(tmp_path: Path) -> None:
    path = tmp_path / "other.h5"
    with h5py.File(path, "w") as file:
        file.attrs["format"] = np.bytes_(b"bench-recording")
        file.attrs["format_version"] = np.array([b"1.0"])
        file.attrs.update(recording_id="other", campaign_id="c", kind="free", source="import", complete=1)
        file.attrs["started_at"] = "2026-11-21T10:00:00"
        file.attrs["sample_rate"] = 1000
        file["channels/time"] = np.arange(10) * 0.001
        file["channels/motor_torque"] = np.arange(10, dtype=">i4")
        file["channels/motor_torque"].attrs["scale"] = np.array([0.5], dtype=np.float32)
    recording = Recording.open(path)
    assert recording.started_at == datetime(2026, 11, 21, 10, tzinfo=UTC)
    assert recording.complete
    assert recording.gearbox.ratio is None
    assert recording.segments == ()
    assert np.array_equal(recording.si("motor_torque"), np.arange(10) * 0.5)
    sentences = consequences(recording)
    assert any("no channel 'load_angle', so there is no transmission error" in sentence for sentence in sentences)
    assert not any("'motor_torque'" in sentence for sentence in sentences)


def test_cut_short_recording_is_as_long_as_its_shortest_channel(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path, "r+") as file:
        del file.attrs["complete"]
        file["channels/motor_angle"].resize((2500,))
        file["segments/stop"][1] = -1
    recording = Recording.open(path)
    assert (recording.complete, recording.size) == (False, 2500)
    assert recording.steady() == (slice(100, 2500),)
    assert recording.si("load_angle").size == 2500


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), damages=st.integers(1, 12))
def test_damaged_bytes_never_raise_anything_but_one_sentence(
    tmp_path_factory: pytest.TempPathFactory, seed: int, damages: int
) -> None:
    rng = np.random.default_rng(seed)
    path = tmp_path_factory.mktemp("damaged") / "a.h5"
    content = bytearray(builders.write(path, rows=200).read_bytes())
    for _ in range(damages):
        start = int(rng.integers(0, len(content)))
        content[start : start + 8] = rng.bytes(len(content[start : start + 8]))
    if seed % 3 == 0:
        del content[int(rng.integers(0, len(content))) :]
    path.write_bytes(content)
    with pytest.MonkeyPatch.context() as patch:
        # some send the library round in circles; the whole file takes some milliseconds
        patch.setattr(reader.guarded, "CPU_S", 1.0)
        try:
            recording = Recording.open(path)
            recording.read_si(recording.channels)
        except RecordingError as error:
            refused = str(error)
        else:
            refused = f"{path}: usable"
        folder = RecordingFolder.open(path.parent)
    assert refused.startswith(f"{path}: ")
    assert len(folder.recordings) + len(folder.rejected) == 1


def test_an_address_that_no_file_has_is_a_chunk_that_was_never_stored(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path) as file:
        stored = file["channels/motor_angle"].id.get_chunk_info(0).byte_offset
    beyond = (1 << 64) - 256  # all ones would be HDF5's own mark of a chunk that is nowhere
    path.write_bytes(path.read_bytes().replace(stored.to_bytes(8, "little"), beyond.to_bytes(8, "little")))
    with pytest.raises(RecordingError, match="/motor_angle claims 3000 rows, those from index 0 on were never"):
        Recording.open(path)


def test_rows_out_of_range_are_refused(tmp_path: Path) -> None:
    recording = Recording.open(builders.write(tmp_path / "a.h5"))
    with pytest.raises(RecordingError, match="the recording has rows 0 to 3000"):
        recording.si("time", 0, 3001)


def test_folder_keeps_order_and_names_what_is_of_no_use(tmp_path: Path) -> None:
    builders.write(tmp_path / "b.h5", started_at=datetime(2026, 1, 1, tzinfo=UTC))
    builders.write(tmp_path / "a.h5", started_at=datetime(2026, 1, 2, tzinfo=UTC))
    (tmp_path / "c.h5").write_text("no")
    (tmp_path / "d.h5.part").write_bytes(b"")
    (tmp_path / "notes.txt").write_text("not looked at")
    (tmp_path / "campaign.json").write_text("{")
    folder = RecordingFolder.open(tmp_path)
    assert [recording.recording_id for recording in folder.recordings] == ["b", "a"]
    assert [rejected.file.name for rejected in folder.rejected] == ["c.h5", "d.h5.part", "campaign.json"]
    assert all(rejected.why.startswith(str(rejected.file)) for rejected in folder.rejected)
    assert folder.manifest is None
    (tmp_path / "campaign.json").write_text(json.dumps({"campaign_id": "c1"}))
    assert RecordingFolder.open(tmp_path).manifest == {"campaign_id": "c1"}
    with pytest.raises(RecordingError, match="no such folder"):
        RecordingFolder.open(tmp_path / "none")


def test_reading_beside_xarray_in_one_process(tmp_path: Path) -> None:
    import xarray as xr

    path = builders.write(tmp_path / "a.h5", rows=50)
    with xr.open_dataset(path, group="channels", engine="h5netcdf") as dataset:
        assert Recording.open(path).si("time").size == dataset.sizes["time"]


@pytest.mark.parametrize(
    ("values", "dtype", "message"),
    [
        (np.array([0, 40000]), "int16", "do not fit int16"),
        (np.array([0.0, 0.5]), "int64", "do not fit int64"),
        (np.array([0, 1, 2]), "int16", "differ in shape"),
    ],
)
def test_values_that_would_change_are_refused(tmp_path: Path, values: np.ndarray, dtype: str, message: str) -> None:
    channels = {
        "time": (np.arange(2), ChannelSpec.of("time", dtype="int64", scale=1.0)),
        "motor_torque": (values, ChannelSpec.of("motor_torque", dtype=dtype)),
    }
    with pytest.raises(RecordingError, match=message):
        write_recording(tmp_path / "a.h5", builders.header("a"), channels)
    assert not (tmp_path / "a.h5").exists()


def test_a_reader_that_began_before_a_flush_looks_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, looks = builders.write(tmp_path / "a.h5"), list[Path]()

    def torn(file: Any, of: Path, *, prefix: bool) -> dict[str, Any]:
        looks.append(of)
        if len(looks) < 3:
            os.utime(of)
            raise OSError("addr overflow")
        return real(file, of, prefix=prefix)

    real = reader.read_header
    monkeypatch.setattr(reader, "read_header", torn)
    monkeypatch.setattr(reader.guarded, "_inside", True)
    assert Recording.open(path).complete
    assert len(looks) == 3


def test_a_file_that_nobody_writes_is_looked_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, looks = builders.write(tmp_path / "a.h5"), list[Path]()

    def damaged(file: Any, of: Path, *, prefix: bool) -> dict[str, Any]:
        looks.append(of)
        raise OSError("addr overflow")

    monkeypatch.setattr(reader, "read_header", damaged)
    monkeypatch.setattr(reader.guarded, "_inside", True)
    with pytest.raises(RecordingError, match="addr overflow"):
        Recording.open(path)
    assert len(looks) == 1


def test_a_folder_is_said_to_be_one_and_a_recording_in_it_is_named(tmp_path: Path) -> None:
    with pytest.raises(
        RecordingError, match=r"is a folder, it should be a recording; no file in it is called NAME\.h5"
    ):
        Recording.open(tmp_path)
    builders.write(tmp_path / "r002.h5", rows=60)
    builders.write(tmp_path / "r001.h5", rows=60)
    with pytest.raises(RecordingError, match=r"is a folder.*name a file in it, such as .*r001\.h5\.$"):
        Recording.open(tmp_path)


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (KeyError("Unable to open object (unable to determine object type)"), "unable to determine object type"),
        (OSError("Unable to open file (truncated file)."), "truncated file"),
    ],
)
def test_the_reason_of_an_hdf5_error_has_no_marks_around_it(error: Exception, reason: str) -> None:
    assert reader.hdf5_reason(error) == reason
