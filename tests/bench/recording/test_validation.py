"""Each rule of the format, broken once: the sentence names file, place and what would be right."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from bench.errors import RecordingError
from bench.recording import Recording
from bench.recording.validation import validate
from tests.bench.recording import builders

Change = Callable[[h5py.File], None]


def _attr(where: str, name: str, value: Any) -> Change:
    def change(file: h5py.File) -> None:
        file[where].attrs[name] = value

    return change


def _drop_attr(where: str, name: str) -> Change:
    def change(file: h5py.File) -> None:
        del file[where].attrs[name]

    return change


def _drop(name: str) -> Change:
    def change(file: h5py.File) -> None:
        del file[name]

    return change


def _set(name: str, index: Any, value: Any) -> Change:
    def change(file: h5py.File) -> None:
        file[name][index] = value

    return change


def _replace(name: str, values: Any, **attrs: Any) -> Change:
    def change(file: h5py.File) -> None:
        old = dict(file[name].attrs)
        del file[name]
        file[name] = values
        kept = {key: old[key] for key in ("unit", "scale", "offset", "description", "origin") if key in old}
        file[name].attrs.update(kept | attrs)
        if name.startswith("channels/") and name != "channels/time":
            file[name].dims[0].attach_scale(file["channels/time"])

    return change


def _all(*changes: Change) -> Change:
    def change(file: h5py.File) -> None:
        for one in changes:
            one(file)

    return change


_GAP = _all(
    *(
        _replace(f"channels/{name}", np.r_[values[:50], values[53:]])
        for name, values in builders.columns(0, 3003).items()
        if name != "time"
    ),
    _set("channels/time", slice(50, None), np.arange(53, 3003)),
)

_VIOLATIONS: list[tuple[Change, str]] = [
    (_drop_attr("/", "format"), "root attribute 'format' is missing"),
    (_attr("/", "format", "other"), "'format' is 'other', it should be one of bench-recording"),
    (_attr("/", "format_version", "2.0"), "'format_version' is '2.0', it should be one of 1.0"),
    (_attr("/", "recording_id", "zz"), "'recording_id' is 'zz', it should be the file's stem 'a'"),
    (_drop_attr("/", "campaign_id"), "'campaign_id' is missing, it should be text"),
    (_attr("/", "kind", "constant"), "'kind' is 'constant', it should be one of constant_velocity, validation"),
    (_attr("/", "started_at", "yesterday"), "'started_at' is 'yesterday', it should be a date and time in ISO 8601"),
    (_attr("/", "started_at", "2026-11-21T09:00:00"), "should be in UTC and say so"),
    (_attr("/", "started_at", "2026-11-21T09:00:00+02:00"), "should be in UTC and say so"),
    (_attr("/", "sample_rate", 0.0), "'sample_rate' is 0.0, it should be a finite frequency"),
    (_attr("/", "sample_rate", "fast"), "'sample_rate' is 'fast', it should be a number"),
    (_attr("/", "sample_rate", 500.0), "/channels/time steps by 0.0005 s"),
    (_attr("/", "source", "dream"), "'source' is 'dream', it should be one of hardware"),
    (_attr("/", "complete", "maybe"), "'complete' is 'maybe', it should be a bool"),
    (_attr("/", "take", 0), "'take' is 0, takes count from 1"),
    (_attr("/", "accepted", 3), "'accepted' is"),
    (_drop("setpoint"), "/setpoint is missing"),
    (_drop_attr("setpoint", "velocity"), "/setpoint attribute 'velocity' is missing"),
    (_attr("setpoint", "velocity", np.inf), "/setpoint attribute 'velocity' is inf"),
    (_drop("gearbox"), "/gearbox is missing"),
    (_attr("gearbox", "ratio", 0.0), "/gearbox attribute 'ratio' is 0.0"),
    (_attr("gearbox", "z1", 24.5), "/gearbox attribute 'z1' is"),
    (_drop("channels"), "/channels is missing"),
    (_drop("channels/load_angle"), "/channels/load_angle is missing, the bench records it always"),
    (_replace("channels/motor_torque", np.zeros((3000, 2), np.int16)), "/channels/motor_torque is not a readable one-"),
    (_replace("channels/motor_torque", np.zeros(3000, np.float32)), "/channels/motor_torque is float32"),
    (
        _replace("channels/load_angle", np.arange(3000, dtype=np.int32) * 9000),
        "/channels/load_angle is int32, an",
    ),
    (_replace("channels/motor_torque", np.zeros(2999, np.int16)), "/channels/motor_torque has 2999 rows and"),
    (_drop_attr("channels/motor_torque", "unit"), "/channels/motor_torque attribute 'unit' is missing"),
    (_attr("channels/motor_torque", "unit", "Nmm"), "'unit' is 'Nmm', it should be 'N·m'"),
    (_attr("channels/motor_torque", "scale", 0.0), "attribute 'scale' is 0.0, it should be finite and not 0"),
    (_attr("channels/motor_torque", "scale", "2"), "attribute 'scale' is '2', it should be a number"),
    (_drop_attr("channels/motor_torque", "origin"), "attribute 'origin' is missing"),
    (_set("channels/time", 77, 0), "/channels/time at index 77 is 0 s after 0.038 s, it should strictly increase"),
    (_set("channels/time", slice(None), np.arange(5, 3005)), "/channels/time starts at 0.0025 s"),
    (_set("channels/cycle", 77, 0), "/channels/cycle at index 77 is 0 after 12421, it should increase"),
    (_set("channels/cycle", slice(77, None), np.arange(3000 - 77) + 90000), "/channels/time should step likewise"),
    (_all(_GAP, *(_drop(f"events/{name}") for name in ("time", "level", "text"))), "/events/time is missing"),
    (
        _all(_GAP, lambda file: [file[f"events/{name}"].resize((0,)) for name in ("time", "level", "text")] and None),
        "/channels/cycle has a gap at index 50, /events should say so and is empty",
    ),
    (
        _replace("channels/motor_torque", np.where(np.arange(3000) == 1500, np.nan, 1.0)),
        "/channels/motor_torque at index 1500 is nan, every sample should be a finite number",
    ),
    (_drop("segments"), "/segments is missing"),
    (_drop("segments/stop"), "/segments/stop is missing"),
    (_set("segments/name", 0, "ramping"), "/segments row 0 ('ramping') has a name that is not one of ramp_up"),
    (_set("segments/stop", 1, 3001), "/segments row 1 ('steady') runs from 100 to 3001"),
    (_set("segments/start", 1, 2900), "cover 0.100 revolutions of the load side, at least 1 is due"),
    (_set("segments/name", 1, "dwell"), "/segments holds no 'steady', a constant_velocity recording should"),
    (_replace("segments/start", np.array([0.0, 100.0])), "/segments/start is float64, it should be int64"),
    (_drop("events"), "/events is missing"),
    (_set("events/time", 0, np.nan), "/events/time row 0 is nan"),
    (_all(_drop("config"), lambda file: file.create_dataset("config", data="[bench")), "/config is not TOML"),
]


@pytest.mark.parametrize(("change", "sentence"), _VIOLATIONS, ids=[text[:50] for _, text in _VIOLATIONS])
def test_broken_rule_is_named(tmp_path: Path, change: Change, sentence: str) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path, "r+") as file:
        change(file)
    result = validate(path)
    assert not result.valid
    found = [violation for violation in result.violations if sentence in violation]
    assert found, result.violations
    assert found[0].startswith(f"{path}: ")
    assert found[0].endswith(".")


_ALLOWED: list[tuple[Change, str]] = [
    (_drop_attr("/", "complete"), "'complete' is absent"),
    (_attr("/", "complete", False), "'complete' is false"),
    (_drop("config"), "/config is absent"),
    (_drop("software"), "/software is absent"),
    (_drop("channels/cycle"), "/channels/cycle is missing"),
    (_set("segments/stop", 1, -1), "/segments row 1 ('steady') is still open"),
    (_GAP, "/channels/cycle has 1 gaps with 3 lost cycles, the first at index 50"),
]


@pytest.mark.parametrize(("change", "sentence"), _ALLOWED, ids=[text[:50] for _, text in _ALLOWED])
def test_allowed_but_noted(tmp_path: Path, change: Change, sentence: str) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path, "r+") as file:
        change(file)
    result = validate(path)
    assert result.violations == ()
    assert [note for note in result.notes if sentence in note]


_OTHERS: list[Change] = [
    _all(*(_drop_attr("/", name) for name in ("point_id", "take", "accepted", "zero_id", "quality"))),
    _attr("/", "kind", np.bytes_(b"constant_velocity")),
    _attr("/", "kind", np.array(["constant_velocity"], dtype=h5py.string_dtype())),
    _attr("/", "complete", 1),
    _attr("/", "sample_rate", np.float32(2000)),
    _attr("/", "started_at", "2026-11-21T09:00:00Z"),
    _all(*(_drop_attr("gearbox", name) for name in ("z1", "z2", "z3", "z4"))),
    _drop_attr("channels/load_torque", "offset"),
    _all(*(_drop_attr("channels/motor_torque", name) for name in ("units", "scale_factor", "add_offset", "long_name"))),
    _attr("channels/motor_torque", "unit", "N*m"),
    _attr("channels/temperature", "unit", "degC"),
    _replace("channels/time", np.arange(3000) / 2000, scale=1.0),
    _replace("segments/name", np.array([b"ramp_up", b"steady"])),
]


@pytest.mark.parametrize("change", _OTHERS)
def test_files_as_other_libraries_write_them_are_valid(tmp_path: Path, change: Change) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path, "r+") as file:
        change(file)
        if not file["channels/time"].is_scale:
            file["channels/time"].make_scale("time")
            for name in file["channels"]:
                if name != "time":
                    file["channels"][name].dims[0].attach_scale(file["channels/time"])
    assert validate(path).violations == ()
    assert Recording.open(path).size == 3000


def test_dimension_scale_is_required(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path, "r+") as file:
        file["channels/motor_torque"].dims[0].detach_scale(file["channels/time"])
    assert validate(path).violations == (
        f"{path}: /channels/motor_torque does not have /channels/time as its dimension scale.",
    )


def test_rows_never_stored_are_not_taken_for_zeros(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path, "r+") as file:
        for name in file["channels"]:
            file["channels"][name].resize((9001,))
    sentences = validate(path).violations
    assert f"{path}: /channels/motor_angle rows from index 3000 on were never stored." in sentences


def test_missing_file_raises_and_other_files_are_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="there is no such file"):
        validate(tmp_path / "none.h5")
    (tmp_path / "text.h5").write_text("hello")
    (sentence,) = validate(tmp_path / "text.h5").violations
    assert "not a readable HDF5 file" in sentence
