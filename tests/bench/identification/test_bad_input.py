"""Bad input: each gets its sentence, and the rest is still used."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from bench.errors import RecordingError
from bench.identification import Options, identify_folder, to_json, to_simulation
from bench.identification.samples.spikes import spikes
from bench.identification.samples.windows import counting_bias, lost_cycles
from tests.bench.identification.synthetic import Bench


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Both directions, two loads, one speed, one temperature."""
    folder = tmp_path_factory.mktemp("small")
    bench = Bench(folder, rate=200.0)
    for torque in (-500.0, 0.0, 500.0):
        for d in (1, -1):
            bench.write(torque, float(d * np.deg2rad(10.0)), 30.0)
    return folder


def _spoiled(small: Path, tmp_path: Path, name: str, spoil: Callable[[h5py.File], None]) -> Path:
    folder = tmp_path / "spoiled"
    shutil.copytree(small, folder)
    with h5py.File(folder / f"{name}.h5", "r+") as file:
        spoil(file)
    return folder


def _sentences(folder: Path) -> list[str]:
    found = identify_folder(folder, Options())
    assert found.refined, "the rest should still be used"
    assert found.friction.values["f_c"] == pytest.approx(0.5, rel=0.1)
    return [s.why for s in found.skipped] + list(found.sentences)


def _replace(file: h5py.File, name: str, values: np.ndarray) -> None:
    old = file["channels"][name]
    attributes = dict(old.attrs)
    del file["channels"][name]
    new = file["channels"].create_dataset(name, data=values)
    for key in ("unit", "scale", "offset", "description", "origin"):
        if key in attributes:
            new.attrs[key] = attributes[key]


def test_one_temperature_and_one_speed_leave_polynomial_terms_undetermined(small: Path) -> None:
    found = identify_folder(small, Options())
    said = " ".join(found.sentences)
    assert "the temperature covers" in said
    assert "the velocity covers" in said
    model = to_simulation(found).transmission_error()
    assert model is not None
    assert model.positive is not None
    # τ-terms of a₀ are there (compliance), those in temperature and speed are 0, not invented.
    assert model.positive.offset[3] == pytest.approx(-1.0 / 3.2e6, rel=0.2)
    assert not model.positive.offset[[1, 2, 4, 5, 6, 7, 8]].any()
    assert to_json(found)["refined_better_on_validation"] is None


@pytest.mark.parametrize("torque", [0.0, 300.0])
def test_a_single_recording_is_identified_as_far_as_it_goes(tmp_path: Path, torque: float) -> None:
    folder = tmp_path / "one"
    folder.mkdir()
    Bench(folder, rate=200.0).write(torque, float(np.deg2rad(10.0)), 30.0)
    found = identify_folder(folder, Options())
    assert "the load torque covers" in " ".join(found.sentences)
    model = to_simulation(found).transmission_error()
    assert model is not None
    assert model.positive is not None
    assert model.negative is None
    assert np.isfinite(model.positive.offset).all()
    # nothing but the constant is determined by one point
    assert not model.positive.offset[:9].any()


def test_less_than_a_revolution_is_skipped_and_its_friction_used(small: Path, tmp_path: Path) -> None:
    folder = tmp_path / "short"
    shutil.copytree(small, folder)
    bench = Bench(folder, rate=200.0, number=50)
    bench.write(100.0, float(np.deg2rad(10.0)), 30.0, revolutions=0.6)
    said = _sentences(folder)
    assert any("r051" in s and "0.60 of a revolution; at least one is needed" in s for s in said)


def test_a_gap_in_cycle_is_said_and_the_samples_are_used(small: Path, tmp_path: Path) -> None:
    def spoil(file: h5py.File) -> None:
        cycle = file["channels"]["cycle"][...]
        cycle[1000:] += 4
        file["channels"]["cycle"][...] = cycle

    said = _sentences(_spoiled(small, tmp_path, "r001", spoil))
    assert any("r001: 'cycle' steps over 4 lost cycles in 1 places (first before sample 1000)" in s for s in said)


def test_not_a_number_is_said_and_the_rows_left_out(small: Path, tmp_path: Path) -> None:
    def spoil(file: h5py.File) -> None:
        channel = file["channels"]["load_angle"]
        values = channel[...] * float(channel.attrs["scale"])
        values[1500:1503] = np.nan
        _replace(file, "load_angle", values)
        file["channels"]["load_angle"].attrs["scale"] = 1.0

    said = _sentences(_spoiled(small, tmp_path, "r002", spoil))
    assert any("r002: channel 'load_angle' is not a number in 3 samples (first at 1500)" in s for s in said)


def test_a_channel_of_nans_is_not_used(small: Path, tmp_path: Path) -> None:
    def spoil(file: h5py.File) -> None:
        _replace(file, "temperature", np.full(file["channels"]["temperature"].shape, np.nan))

    said = _sentences(_spoiled(small, tmp_path, "r003", spoil))
    assert any("r003: channel 'temperature' is not a number in 100.0 %" in s for s in said)


def test_a_clock_that_goes_back_is_said_and_the_recording_left_out(small: Path, tmp_path: Path) -> None:
    def spoil(file: h5py.File) -> None:
        channel = file["channels/time"]
        channel[500:] = channel[500:] - round(1.0 / float(channel.attrs["scale"]))

    said = _sentences(_spoiled(small, tmp_path, "r003", spoil))
    assert any("r003: time at index 500 is 1.5 s after 2.495 s, it should strictly increase" in s for s in said)


def test_an_open_thermometer_is_said_and_not_used(small: Path, tmp_path: Path) -> None:
    def spoil(file: h5py.File) -> None:
        channel = file["channels"]["temperature"]
        values = channel[...] * float(channel.attrs.get("scale", 1.0))
        values[values.size // 2 :] = 850.0
        _replace(file, "temperature", values)
        file["channels"]["temperature"].attrs["scale"] = 1.0

    said = _sentences(_spoiled(small, tmp_path, "r003", spoil))
    (told,) = [s for s in said if "PT100" in s]
    assert told.startswith("r003: channel 'temperature' is at an end of a PT100's range (circuit open or shorted)")
    assert "in 50.0 % of its samples" in told


def test_a_broken_file_is_left_out(small: Path, tmp_path: Path) -> None:
    folder = tmp_path / "broken"
    shutil.copytree(small, folder)
    whole = (folder / "r004.h5").read_bytes()
    (folder / "r004.h5").write_bytes(whole[: len(whole) // 3])
    (folder / "r005.h5").write_bytes(b"not HDF5")
    found = identify_folder(folder, Options())
    assert {s.recording for s in found.skipped} >= {"r004.h5", "r005.h5"}
    assert len(found.reductions) == 4


def test_a_recording_without_the_load_angle_still_gives_friction(small: Path, tmp_path: Path) -> None:
    def spoil(file: h5py.File) -> None:
        del file["channels"]["load_angle"]

    said = _sentences(_spoiled(small, tmp_path, "r001", spoil))
    assert any("no usable channel 'load_angle', so no transmission error" in s for s in said)


def test_recordings_of_another_zero_are_not_mixed(small: Path, tmp_path: Path) -> None:
    folder = tmp_path / "zeros"
    shutil.copytree(small, folder)
    for path in folder.glob("*.h5"):
        with h5py.File(path, "r+") as file:
            file.attrs["zero_id"] = "b" if path.stem == "r006" else "a"
    assert any("r006: its encoder zero is b, most have a" in s for s in _sentences(folder))


def test_what_the_quality_gate_refused_is_not_used(small: Path, tmp_path: Path) -> None:
    def spoil(file: h5py.File) -> None:
        file.attrs["accepted"] = False

    assert any(
        "r002: the quality gate did not accept it" in s for s in _sentences(_spoiled(small, tmp_path, "r002", spoil))
    )


def test_spikes_are_left_out(small: Path, tmp_path: Path) -> None:
    def spoil(file: h5py.File) -> None:
        values = file["channels"]["load_angle"][...]
        values[[900, 2000]] += 2_000_000
        file["channels"]["load_angle"][...] = values

    folder = _spoiled(small, tmp_path, "r001", spoil)
    found = identify_folder(folder, Options())
    assert any("2 single wild samples" in s.why for s in found.skipped)
    assert all(s.rmse["bound"] < 3e-6 for s in found.scores)


@pytest.mark.parametrize("make", [lambda p: p / "absent", lambda p: p])
def test_no_folder_and_an_empty_one_get_a_sentence(make: Callable[[Path], Path], tmp_path: Path) -> None:
    with pytest.raises(RecordingError):
        identify_folder(make(tmp_path), Options())


def test_helpers_of_windows() -> None:
    where, lost = lost_cycles(np.array([0, 1, 2, 5, 6, 10], dtype=np.int64))
    assert where.tolist() == [3, 5]
    assert lost == 5
    signal = np.sin(np.arange(100) / 9.0)
    signal[40] += 30.0
    assert np.flatnonzero(spikes(signal)).tolist() == [40]
    # 5.25 counts a sample meets four phases only; an irrational advance meets them all.
    assert counting_bias(5.25, 100_000) == pytest.approx(1.0 / (4 * np.sqrt(12.0)))
    assert counting_bias(5.0 + np.sqrt(2) / 10, 100_000) < 0.003


def test_a_few_samples_at_the_end_of_the_range_are_wild() -> None:
    """Five samples of a saturated amplifier; a ramp to twice the usual load, or a long stay there, is none."""
    rng = np.random.default_rng(4)
    signal = 300.0 * np.sin(np.arange(4000) / 400.0) + rng.normal(0.0, 1.0, 4000)
    signal[700:705] = 9999.7
    signal[2000:2003] = np.nan
    marked = spikes(signal)
    assert np.flatnonzero(marked).tolist() == [*range(700, 705), *range(2000, 2003)]
    assert not spikes(np.where(np.isfinite(signal) & ~marked, signal, 0.0)[:600]).any()
    ramp = np.concatenate([rng.normal(0.0, 1.0, 3000), np.linspace(0.0, 600.0, 20), rng.normal(600.0, 1.0, 40)])
    assert not spikes(ramp).any()
    # an acceleration of a third of a second at 20 Hz, and one step of a converter
    jump = rng.normal(1.0, 0.02, 1200)
    jump[600:606] += 2.0
    assert not spikes(jump).any()
    assert not spikes(np.append(np.full(1995, 25.0), np.full(5, 25.1))).any()
