"""The library for scripts: connect, plan, run, iterate, identify, find what is left out."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import bench
from bench import campaign, connect, recordings, steady
from bench.errors import DeviceError, LimitError
from bench.locks import bus_in_use, serving
from bench.recording import RecordingFolder
from bench.simulation import Simulation

SWEEP = campaign("sweep", steady(load_torques=(0.0, 300.0), speeds_deg_s=(60.0, -60.0)))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("api") / "sweep"
    done = connect("rh380n").run(SWEEP, made)
    assert done.summary is not None
    assert len(done.summary.taken) == 4
    return made


def test_a_plan_says_what_a_run_does() -> None:
    plan = connect().plan(SWEEP)
    assert plan.points == 4
    assert connect().plan("quick").points == 5
    with pytest.raises(LimitError, match=r"limits\.motor_speed"):
        connect().plan(campaign("fast", steady(speeds_deg_s=(600.0,))))


def test_recordings_are_datasets_in_si_units(folder: Path) -> None:
    sets = list(recordings(folder))
    files = RecordingFolder.open(folder).recordings
    assert [data.attrs["recording_id"] for data in sets] == [file.recording_id for file in files]
    data, file = sets[0], files[0]
    assert (data.set_load_torque, data.set_velocity) == (file.setpoint.load_torque, file.setpoint.velocity)
    assert np.array_equal(data["load_torque"].values, file.si("load_torque"))
    assert data["load_torque"].attrs["units"] == "N·m"
    (part,) = file.steady()
    steady_rows = data.isel(time=np.flatnonzero(data.segment == "steady"))
    assert steady_rows.sizes["time"] == part.stop - part.start
    expected = file.si("load_angle", part.start, part.stop) - file.si("motor_angle", part.start, part.stop) / 185.0
    assert np.allclose(steady_rows.transmission_error.values, expected, atol=1e-15)


def test_recordings_are_identified_and_the_model_is_what_they_are_compared_with(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = recordings(folder).identify(1, 4, 46)
    found = model.transmission_error()
    assert found is not None
    compared: list[tuple[Path, Path, str | None]] = []

    def run(where: Path, out: Path, simulation: Path | None = None) -> None:
        compared.append((where, out, None if simulation is None else Simulation.load(simulation).to_json()))

    monkeypatch.setattr("bench.api.run_mismatch", run)
    recordings(folder).find_mismatch(tmp_path / "report", model)
    recordings(folder).find_mismatch(tmp_path / "report")
    assert compared == [(folder, tmp_path / "report", model.to_json()), (folder, tmp_path / "report", None)]


def test_a_bus_that_a_service_has_is_not_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BENCH_RUNTIME", str(tmp_path))
    wire = connect("rh380n", bus="eth9")
    with serving(wire.file, {"url": "http://127.0.0.1:1"}), pytest.raises(DeviceError, match="joins its queue"):
        wire.run(SWEEP, tmp_path / "never")
    with bus_in_use(wire.file), pytest.raises(DeviceError, match="is in use by process"):
        wire.run(SWEEP, tmp_path / "never")


@pytest.mark.parametrize(
    ("program", "without"),
    [("bench.cli", ("bench.api", "numpy")), ("bench.service.web.app", ("numba", "scipy", "bench.cycle.rig"))],
)
def test_a_program_starts_without_what_it_does_not_need(program: str, without: tuple[str, ...]) -> None:
    script = f"import sys, bench, {program}; print(*({set(without)!r} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_a_name_that_is_not_there_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        _ = bench.nothing
