from __future__ import annotations

import csv
import json
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io

from bench.errors import RecordingError
from bench.recording import Recording, RecordingFolder, Setpoint
from bench.recording.exporting import export_csv, export_mat
from bench.recording.manifest import rebuild, write_manifest
from tests.bench.recording import builders


def test_manifest_is_rebuilt_from_the_files_and_what_is_pending_is_kept(tmp_path: Path) -> None:
    builders.write(tmp_path / "a.h5", setpoint=Setpoint(load_torque=100.0))
    cut = builders.write(tmp_path / "b.h5")
    with h5py.File(cut, "r+") as file:
        file.attrs["complete"] = False
    old = {
        "campaign_id": "c1",
        "created_at": "2026-11-21T08:00:00Z",
        "bench": "rh380n",
        "plan": {"points": 3},
        "recordings": [
            {"recording_id": "a", "status": "failed"},
            {"recording_id": "x", "status": "done"},
            {"recording_id": "y", "status": "pending"},
        ],
    }
    write_manifest(tmp_path, old)
    manifest = rebuild(tmp_path)
    assert {key: manifest[key] for key in ("bench", "plan", "created_at")} == {
        key: old[key] for key in ("bench", "plan", "created_at")
    }
    # x was done but its file is gone; y is still to do.
    assert [(entry["recording_id"], entry["status"]) for entry in manifest["recordings"]] == [
        ("a", "done"),
        ("b", "failed"),
        ("y", "pending"),
    ]
    assert manifest["recordings"][0]["setpoint"] == {"load_torque": 100.0, "velocity": None, "temperature": None}
    assert manifest["recordings"][0]["quality"] == {"passed": True}
    path = write_manifest(tmp_path, manifest)
    assert json.loads(path.read_text()) == manifest
    assert RecordingFolder.open(tmp_path).manifest == manifest
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a.h5", "b.h5", "campaign.json"]


def test_manifest_of_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="no usable recording"):
        rebuild(tmp_path)


def test_mat_holds_every_channel_in_si(tmp_path: Path) -> None:
    recording = Recording.open(builders.write(tmp_path / "a.h5", rows=500))
    export_mat(recording, tmp_path / "a.mat")
    contents = scipy.io.loadmat(tmp_path / "a.mat", simplify_cells=True)
    for name in recording.channels:
        assert np.array_equal(contents[name], recording.si(name))
        assert contents["units"][name] == recording.specs[name].unit
    assert list(contents["segments"]["name"]) == ["ramp_up", "steady"]
    assert list(contents["segments"]["first"]) == [1, 101]
    assert list(contents["segments"]["last"]) == [100, 500]
    assert contents["header"]["gearbox"]["ratio"] == 185.0
    assert contents["events"]["text"] == "operator: lubricant topped up"


def test_csv_reads_back_to_the_same_numbers(tmp_path: Path) -> None:
    recording = Recording.open(builders.write(tmp_path / "a.h5", rows=300))
    export_csv(recording, tmp_path / "a.csv")
    lines = [line for line in (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines() if line[0] != "#"]
    table = list(csv.reader(lines))
    assert table[0] == [*(f"{name} [{spec.unit}]" for name, spec in recording.specs.items()), "segment"]
    assert [row[-1] for row in table[1:]] == ["ramp_up"] * 100 + ["steady"] * 200
    for index, name in enumerate(recording.channels):
        assert np.array_equal(np.array([row[index] for row in table[1:]], dtype=float), recording.si(name))
