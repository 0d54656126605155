"""Quantities that are no channel of the bench stand under ``aux/``; a linear axis says that it is one."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray

from bench.recording import ChannelSpec, Recording, write_recording
from bench.recording.exporting import export_csv, export_mat
from bench.recording.repairing import repair
from bench.recording.validation import validate
from tests.bench.recording import builders


def _write(path: Path, **changes: object) -> Recording:
    time = np.arange(100) / 100
    channels = {
        "time": (time, ChannelSpec("time", "s", description="t", origin="x")),
        "motor_angle": (time**2, ChannelSpec("motor_angle", "m", description="x", origin="x")),
        "aux/oil_pressure": (np.cos(time), ChannelSpec("aux/oil_pressure", "Pa", description="p", origin="x")),
    }
    changes = {"kind": "free", "sample_rate": 100.0, "source": "import", "gearbox": builders.Gearbox(1.0)} | changes
    write_recording(path, builders.header(path.stem, **changes), channels)
    return Recording.open(path)


def test_aux_is_written_read_checked_repaired_and_exported(tmp_path: Path) -> None:
    recording = _write(tmp_path / "a.h5")
    assert recording.channels == ("time", "motor_angle", "aux/oil_pressure")
    assert recording.specs["aux/oil_pressure"].unit == "Pa"
    assert recording.problems == ()
    np.testing.assert_array_equal(recording.si("aux/oil_pressure", 5, 50), np.cos(np.arange(5, 50) / 100))
    assert validate(recording.path).violations == ()
    with xarray.open_dataset(recording.path, group="channels", engine="h5netcdf") as data:
        assert set(data.variables) == {"time", "motor_angle"}
    with xarray.open_dataset(recording.path, group="channels/aux", engine="h5netcdf") as data:
        assert data["oil_pressure"].dims == ("time",)
    export_mat(recording, tmp_path / "a.mat")
    export_csv(recording, tmp_path / "a.csv")
    assert "aux/oil_pressure [Pa]" in (tmp_path / "a.csv").read_text()
    part = recording.path.rename(tmp_path / "b.h5.part")
    with h5py.File(part, "r+") as file:
        file.attrs["recording_id"] = "b"
    assert "aux/oil_pressure" in Recording.open(repair(part).path).channels


def test_what_is_wrong_with_aux_is_said(tmp_path: Path) -> None:
    recording = _write(tmp_path / "a.h5")
    with h5py.File(recording.path, "r+") as file:
        file["channels/aux/table"] = np.zeros((3, 3))
        del file["channels/aux/oil_pressure"].attrs["unit"]
    sentences = " ".join(validate(recording.path).violations)
    assert "/channels/aux/table is not a readable one-dimensional numeric dataset" in sentences
    assert "/channels/aux/oil_pressure attribute 'unit' is missing" in sentences
    assert any("/channels/aux/table" in problem for problem in Recording.open(recording.path).problems)


@pytest.mark.parametrize(("axis", "linear"), [("linear", True), ("rotary", False), (None, True)])
def test_a_linear_axis_is_told_by_attribute_or_by_its_units(tmp_path: Path, axis: str | None, linear: bool) -> None:
    assert _write(tmp_path / "a.h5", axis=axis).linear is linear
    assert not Recording.open(builders.write(tmp_path / "b.h5")).linear


def test_an_axis_of_another_kind_is_not_valid(tmp_path: Path) -> None:
    recording = _write(tmp_path / "a.h5", axis="curved")
    assert "'axis' is 'curved', it should be one of rotary, linear" in " ".join(validate(recording.path).violations)
