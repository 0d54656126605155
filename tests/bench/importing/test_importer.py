from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io

from bench.errors import ConfigurationError
from bench.importing import Imported, import_recordings
from bench.recording import Recording, Rejected, Segment
from bench.recording.validation import validate

_ROWS = 200
_TIME = 3.0 + np.arange(_ROWS) / 100
_ANGLE_DEG = 0.25 * np.arange(_ROWS) ** 1.5
_COUNTS = (np.arange(_ROWS) * 37) % 4096
_TORQUE = np.sin(np.arange(_ROWS))

_MAPPING = """
campaign_id = "elsewhere"
kind = "free"
started_at = 2020-02-03T04:05:06+01:00

[gearbox]
ratio = 50.0

[channels.time]
variable = "{time}"
unit = "s"

[channels.load_angle]
variable = "{angle}"
unit = "deg"

[channels.motor_angle]
variable = "{counts}"
unit = "rev"
scale = {scale}
wraps_at = 4096

[channels.motor_torque]
variable = "{torque}"
unit = "mNm"
{torque_extra}

[[segments]]
name = "steady"
start_s = 0.5
stop_s = 1.5

[[recordings]]
file = "{file}"
recording_id = "one"
[recordings.setpoint]
velocity = 0.2
"""
_PLAIN = {"time": "t", "angle": "q", "counts": "n", "torque": "M", "scale": "0.000244140625", "torque_extra": ""}


def _mat5(folder: Path) -> dict[str, str]:
    scipy.io.savemat(
        folder / "a.mat",
        {
            "t": _TIME.reshape(-1, 1),
            "data": {"q": _ANGLE_DEG.reshape(1, -1), "n": _COUNTS.astype(np.uint16)},
            "M": np.column_stack([np.zeros(_ROWS), _TORQUE]),
            "per_count": 1 / 4096,
        },
    )
    names = {"angle": "data.q", "counts": "data.n", "scale": '"per_count"', "torque_extra": "column = 2"}
    return _PLAIN | names | {"file": "a.mat"}


def _mat73(folder: Path) -> dict[str, str]:
    path = folder / "a.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["t"] = _TIME.reshape(1, -1)
        file["data/q"] = _ANGLE_DEG.reshape(1, -1)
        file["n"] = _COUNTS.astype(np.int32).reshape(1, -1)
        file["M"] = np.vstack([np.zeros(_ROWS), _TORQUE])
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64")
    return _PLAIN | {"angle": "data.q", "torque_extra": "column = 2", "file": "a.mat"}


def _hdf5(folder: Path) -> dict[str, str]:
    with h5py.File(folder / "a.hdf", "w") as file:
        file.update({"run/t": _TIME, "run/q": _ANGLE_DEG, "n": _COUNTS, "M": _TORQUE})
    return _PLAIN | {"time": "run/t", "angle": "run/q", "file": "a.hdf"}


def _csv(folder: Path) -> dict[str, str]:
    rows = [f"{t!r};{q!r};{n};{m!r}" for t, q, n, m in _csv_rows()]
    text = "# a remark\nt;q;n;M\n" + "\n".join(rows).replace(".", ",") + "\n"
    (folder / "a.csv").write_text("﻿" + text, encoding="utf-8")
    return _PLAIN | {"file": "a.csv", "torque_extra": '[csv]\ndecimal = ","'}


def _csv_rows() -> list[tuple[Any, ...]]:
    return list(zip(*(values.tolist() for values in (_TIME, _ANGLE_DEG, _COUNTS, _TORQUE)), strict=True))


def _tdms(folder: Path) -> dict[str, str]:
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(folder / "a.tdms") as writer:
        variables = {"t": _TIME, "q": _ANGLE_DEG, "n": _COUNTS.astype(np.int32), "M": _TORQUE}
        writer.write_segment([ChannelObject("run", name, values) for name, values in variables.items()])
    return {"file": "a.tdms", "scale": _PLAIN["scale"], "torque_extra": ""} | {
        key: f"run/{_PLAIN[key]}" for key in ("time", "angle", "counts", "torque")
    }


def _run(folder: Path, text: str) -> list[Imported | Rejected]:
    (folder / "map.toml").write_text(text, encoding="utf-8")
    return list(import_recordings(folder / "map.toml", folder / "out"))


@pytest.mark.parametrize("write", [_mat5, _mat73, _hdf5, _csv, _tdms])
def test_each_kind_of_file_gives_the_same_recording(tmp_path: Path, write: Any) -> None:
    if write is _tdms:
        pytest.importorskip("nptdms", reason="npTDMS (extra 'tdms') is not installed")
    (done,) = _run(tmp_path, _MAPPING.format(**write(tmp_path)))
    assert isinstance(done, Imported)
    assert validate(done.recording.path).violations == ()
    recording = done.recording
    assert recording.source == "import"
    assert recording.started_at.isoformat() == "2020-02-03T03:05:06+00:00"
    assert recording.sample_rate == pytest.approx(100)
    assert recording.setpoint.velocity == 0.2
    assert recording.segments == (Segment("steady", 50, 150),)
    np.testing.assert_allclose(recording.si("time"), _TIME - _TIME[0], atol=1e-12)
    np.testing.assert_allclose(recording.si("load_angle"), np.radians(_ANGLE_DEG), rtol=1e-12)
    np.testing.assert_allclose(recording.si("motor_angle"), np.arange(_ROWS) * 37 * 2 * np.pi / 4096, rtol=1e-12)
    np.testing.assert_allclose(recording.si("motor_torque"), _TORQUE / 1000, rtol=1e-12, atol=1e-18)
    assert any("no channel 'temperature'" in sentence for sentence in done.consequences)


def test_csv_without_headings_and_time_by_rate(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "r1.txt", np.column_stack([_ANGLE_DEG, _TORQUE]))
    np.savetxt(tmp_path / "r2.txt", np.column_stack([_ANGLE_DEG, _TORQUE])[:50])
    done = _run(
        tmp_path,
        """
campaign_id = "c"
started_at = 2020-01-01T00:00:00Z
gearbox.ratio = 1.0
channels.time.rate = 250.0
channels.motor_angle = {column = 1, unit = "mm"}
channels.motor_torque = {column = 2, unit = "kN", scale = -1.0}
[[recordings]]
file = "r*.txt"
""",
    )
    assert [item.recording.recording_id for item in done if isinstance(item, Imported)] == ["r1", "r2"]
    recording = done[0].recording  # type: ignore[union-attr]
    assert recording.sample_rate == pytest.approx(250)
    assert recording.specs["motor_angle"].unit == "m"
    np.testing.assert_allclose(recording.si("motor_angle"), _ANGLE_DEG / 1000)
    np.testing.assert_allclose(recording.si("motor_torque"), -_TORQUE * 1000)
    assert "motor_velocity" in recording
    assert validate(recording.path).violations == ()


def _csv_case(tmp_path: Path, time: Any, value: Any, extra: str = "") -> list[Imported | Rejected]:
    lines = "\n".join(f"{t},{v}" for t, v in zip(time, value, strict=True))
    (tmp_path / "bad.csv").write_text("t,M\n" + lines)
    (tmp_path / "good.csv").write_text("t,M\n0,1\n0.1,2\n0.2,3\n")
    return _run(
        tmp_path,
        f"""
campaign_id = "c"
started_at = 2020-01-01T00:00:00Z
gearbox.ratio = 100.0
channels.time = {{variable = "t", unit = "s"}}
channels.motor_torque = {{variable = "M", unit = "Nm"}}
{extra}
[[recordings]]
file = "bad.csv"
[[recordings]]
file = "good.csv"
""",
    )


@pytest.mark.parametrize(
    ("time", "value", "sentence"),
    [
        ([0, 1, 1, 2], [1, 2, 3, 4], "time in line 4 is the same as the stamp before"),
        ([0, 1, 2, 3], [1, "nan", 3, 4], "motor_torque is nan in line 3"),
        ([0, 1, 2, 3], [1, 2, "x", 4], "M is not numeric"),
    ],
)
def test_bad_values_are_one_sentence_and_the_rest_is_imported(
    tmp_path: Path, time: Any, value: Any, sentence: str
) -> None:
    bad, good = _csv_case(tmp_path, time, value)
    assert isinstance(bad, Rejected)
    assert sentence in bad.why
    assert isinstance(good, Imported)
    assert good.recording.size == 3


def test_bad_rows_can_be_dropped_and_the_recording_says_so(tmp_path: Path) -> None:
    done, _ = _csv_case(tmp_path, [0, 1, 1, 2, 3, 4], [1, 2, 9, "nan", 5, 6], 'invalid_rows = "drop"')
    assert isinstance(done, Imported)
    assert done.recording.si("motor_torque").tolist() == [1, 2, 5, 6]
    assert done.recording.events[0].text.startswith("2 rows with NaN or without increasing time were left out")


@pytest.mark.parametrize(
    ("time", "value", "sentence"),
    [
        (
            [0, 5, 1, 2, 3, 4],
            [1, 2, 3, 4, 5, 6],
            "would leave out 4 of 6 rows, it should be half of them at most: time does not increase in 4, the first in "
            "line 4; rows in the order of time, start and stop where the clock begins anew",
        ),
        (
            [0, 0, 1, 2, 3, 4],
            [1, 2, "nan", "nan", "nan", 6],
            "would leave out 4 of 6 rows, it should be half of them at most: motor_torque is no number in 3, the first "
            "in line 4; missing = 'hold' or 'interpolate' of motor_torque, or a mapping without it would be right",
        ),
    ],
)
def test_no_more_than_half_of_the_rows_are_dropped(tmp_path: Path, time: Any, value: Any, sentence: str) -> None:
    bad, _ = _csv_case(tmp_path, time, value, 'invalid_rows = "drop"')
    assert isinstance(bad, Rejected)
    assert sentence in bad.why


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (("campaign_id", "campain"), "campaign_id: Field required"),
        (('kind = "free"', 'kind = "slow"'), "kind 'slow' should be one of"),
        (('unit = "deg"', 'unit = "furlong"'), "channels.load_angle: unit 'furlong' should be one that becomes 'rad'"),
        (('unit = "deg"', 'unit = "K"'), "channels.load_angle: unit 'K' should be one that becomes 'rad'"),
        (("ratio = 50.0", "ratio = 0"), "gearbox: ratio should not be 0"),
        (
            ('unit = "deg"', 'unti = "deg"'),
            "channels.load_angle.unti is no key there; keys are variable, column, row, file",
        ),
        (('unit = "deg"', 'unti = "deg"'), "; did you mean 'unit'?"),
        (
            ('unit = "mNm"', 'unit = "A"'),
            "unit 'A' is a current's, torque_constant such as 0.21 (N·m/A) makes a torque.",
        ),
        (
            ("ratio = 50.0", "ratio = 50.0\nteeth = 3"),
            "gearbox.teeth is no key there; keys are ratio, axis, z1, z2, z3, z4.",
        ),
        (('name = "steady"', 'name = "all"'), "segments.0.name: should be one of ramp_up"),
        (("start_s = 0.5", "start_s = 7.5"), "segment 'steady' would run from row 200 to 150"),
        (('variable = "q"', ""), "needs 'variable' or 'column'"),
        (("0.000244140625", '"M"'), "channels.motor_angle.scale: variable 'M' holds 200 values"),
        (("campaign_id =", "campaign_id :"), "is not a readable TOML file"),
    ],
)
def test_wrong_mapping_is_one_sentence(tmp_path: Path, change: tuple[str, str], sentence: str) -> None:
    with h5py.File(tmp_path / "a.hdf", "w") as file:
        file.update({"t": _TIME, "q": _ANGLE_DEG, "n": _COUNTS, "M": _TORQUE})
    text = _MAPPING.format(**_PLAIN, file="a.hdf")
    assert change[0] in text
    with pytest.raises(ConfigurationError) as caught:
        _run(tmp_path, text.replace(*change, 1))
    assert sentence in str(caught.value)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (None, "there is no such file; recordings.file counts from the folder of the mapping"),
        (b"\x00\x01", "is none of MAT, HDF5, TDMS, Parquet, MDF, NumPy, JSON or text"),
        (b"MATLAB 5.0 MAT-file" + bytes(200), "is not a readable MAT file"),
        (b"\x89HDF\r\n\x1a\n" + bytes(600), "cannot be read"),
    ],
)
def test_file_that_cannot_be_read(tmp_path: Path, content: bytes | None, sentence: str) -> None:
    if content is not None:
        (tmp_path / "a.bin").write_bytes(content)
    (done,) = _run(tmp_path, _MAPPING.format(**_PLAIN, file="a.bin"))
    assert isinstance(done, Rejected)
    assert sentence in done.why


def test_unknown_variable_names_those_there_are_and_nothing_is_overwritten(tmp_path: Path) -> None:
    names = _hdf5(tmp_path)
    (done,) = _run(tmp_path, _MAPPING.format(**names | {"angle": "phi"}))
    assert isinstance(done, Rejected)
    assert "there is no variable 'phi'; the file has M, n, run/q, run/t" in done.why
    (first,) = _run(tmp_path, _MAPPING.format(**names))
    (again,) = _run(tmp_path, _MAPPING.format(**names))
    assert isinstance(first, Imported)
    assert isinstance(again, Rejected)
    assert "does not overwrite" in again.why


def test_the_first_real_recordings(tmp_path: Path) -> None:
    root = Path(__file__).parents[3]
    data = root / "../shared/real/emps"
    if not data.is_dir():
        pytest.skip("the EMPS recordings (../shared/real/emps) are not on this machine")
    done = list(import_recordings(root / "docs/examples/emps.toml", tmp_path, data))
    assert [type(item) for item in done] == [Imported, Imported]
    raw = scipy.io.loadmat(data / "DATA_EMPS.mat")
    recording = Recording.open(tmp_path / "estimation.h5")
    assert validate(recording.path).violations == ()
    assert recording.gearbox.ratio == 1.0
    assert recording.specs["motor_torque"].unit == "N"
    np.testing.assert_allclose(recording.si("motor_torque"), (raw["vir"] * raw["gtau"]).ravel(), rtol=1e-12)
    np.testing.assert_array_equal(recording.si("motor_angle"), raw["qm"].ravel())
    assert recording.steady() == (slice(0, 24841),)
