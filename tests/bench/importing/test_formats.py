"""Every kind of file gives the same numbers, names, units and rates."""

from __future__ import annotations

import gc
import json
import struct
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io

from bench.errors import RecordingError
from bench.importing.formats import Source, open_source
from bench.importing.formats.json_file import is_json
from bench.importing.looking import take_inventory

_T = np.arange(300) / 100.0
_Q = np.cumsum(np.sin(_T))


def _mat4(path: Path) -> dict[str, str]:
    scipy.io.savemat(path, {"t": _T, "q": _Q}, format="4")
    return {"t": "t", "q": "q"}


def _mat4_without_nul(path: Path) -> dict[str, str]:
    values = np.vstack([_T, _Q])
    path.write_bytes(struct.pack("<5i", 0, *values.shape, 0, 4) + b"data" + values.tobytes("F"))
    return {"t": "data row 1", "q": "data row 2"}


def _mat5(path: Path) -> dict[str, str]:
    scipy.io.savemat(path, {"log": {"t": _T, "sig": np.array([{"v": _Q}, {"v": -_Q}], dtype=object)}})
    return {"t": "log.t", "q": "log.sig(1).v"}


def _mat73(path: Path) -> dict[str, str]:
    with h5py.File(path, "w", userblock_size=512) as file:
        file["log/t"] = _T.reshape(1, -1)
        file["q"] = np.vstack([_Q, -_Q])  # MATLAB's 300 x 2
        file["#refs#/a"] = np.zeros(3)
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64")
    return {"t": "log.t", "q": "q column 1"}


def _hdf5(path: Path) -> dict[str, str]:
    table = np.zeros(300, dtype=[("t", "f8"), ("n", "i4")])
    table["t"] = _T
    with h5py.File(path, "w") as file:
        file["run/table"] = table
        file["run/q"] = np.vstack([np.zeros(300), _Q])
    return {"t": "run/table.t", "q": "run/q row 2"}


def _json(path: Path) -> dict[str, str]:
    records = [{"t": t, "joint": {"q": q}} for t, q in zip(_T.tolist(), _Q.tolist(), strict=True)]
    path.write_text(json.dumps({"machine": "rig", "log": records}), encoding="utf-8")
    return {"t": "log.t", "q": "log.joint.q"}


def _json_matrix(path: Path) -> dict[str, str]:
    path.write_text(json.dumps([[t, q] for t, q in zip(_T.tolist(), _Q.tolist(), strict=True)]), encoding="utf-8")
    return {"t": "array column 1", "q": "array column 2"}


def _json_lines(path: Path) -> dict[str, str]:
    lines = [json.dumps({"t": t, "q": q}) for t, q in zip(_T.tolist(), _Q.tolist(), strict=True)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return {"t": "t", "q": "q"}


def _tdms(path: Path) -> dict[str, str]:
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(path) as writer:
        writer.write_segment([ChannelObject("run", "t", _T), ChannelObject("run", "q", _Q)])
    return {"t": "run/t", "q": "run/q"}


def _parquet(path: Path) -> dict[str, str]:
    import pyarrow
    from pyarrow import parquet

    parquet.write_table(pyarrow.table({"t": _T, "q": _Q}), path)
    return {"t": "t", "q": "q"}


def _mdf(path: Path) -> dict[str, str]:
    from asammdf import MDF, Signal

    with MDF(version="4.10") as file:
        file.append([Signal(_Q, _T, name="q", unit="rad"), Signal(-_Q, _T, name="p")])
        file.append([Signal(_Q[::10], _T[::10], name="slow")])
        file.save(path)
    return {"t": "0/time", "q": "q"}


def _npz(path: Path) -> dict[str, str]:
    with path.open("wb") as file:
        np.savez_compressed(file, t=_T, q=np.column_stack([-_Q, _Q]), notes=np.array({"by": "x"}, dtype=object))
    return {"t": "t", "q": "q column 2"}


def _npy(path: Path) -> dict[str, str]:
    table = np.zeros(300, dtype=[("t", "f8"), ("q", "f8")])
    table["t"], table["q"] = _T, _Q
    with path.open("wb") as file:
        np.save(file, table)
    return {"t": "array.t", "q": "array.q"}


def _csv(path: Path) -> dict[str, str]:
    path.write_text("t;q\n" + "".join(f"{t!r};{q!r}\n" for t, q in zip(_T.tolist(), _Q.tolist(), strict=True)))
    return {"t": "t", "q": "q"}


def _rows(path: Path) -> dict[str, str]:
    path.write_text("".join(f"{n}\t{u}\t" + "\t".join(map(repr, v.tolist())) + "\n" for n, u, v in _NAMED))
    return {"t": "t", "q": "q"}


_NAMED = (("t", "[s]", _T), ("q", "[rad]", _Q))


def _read(source: Source, name: str) -> Any:
    variable, _, place = name.partition(" ")
    return source.read(variable, **{k: int(v) for k, v in [place.split()] if place} if place else {})


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::FutureWarning", "ignore::UserWarning")
@pytest.mark.parametrize(
    "write",
    [
        _mat4,
        _mat4_without_nul,
        _mat5,
        _mat73,
        _hdf5,
        _tdms,
        _parquet,
        _mdf,
        _npz,
        _npy,
        _json,
        _json_matrix,
        _json_lines,
        _csv,
        _rows,
    ],
)
def test_the_same_numbers_from_every_kind_of_file(tmp_path: Path, write: Callable[[Path], dict[str, str]]) -> None:
    path = tmp_path / "measured"  # no suffix: what a file is, its content says
    names = write(path)
    if not path.exists():
        next(tmp_path.iterdir()).rename(path)
    source = open_source(path)
    np.testing.assert_array_equal(_read(source, names["t"]), _T)
    np.testing.assert_array_equal(_read(source, names["q"]), _Q)
    assert {name.split(" ")[0].replace("log.", "log/") for name in names.values()} <= {
        variable.name.replace("log.", "log/") for variable in source.variables()
    }
    with pytest.raises(RecordingError, match="there is no variable 'nothing'; the file has"):
        source.read("nothing")


def test_units_rates_and_clocks_are_taken_from_where_the_file_says_them(tmp_path: Path) -> None:
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(tmp_path / "a.tdms") as writer:
        start = np.datetime64("2026-03-01T12:00:00")
        properties = {"unit_string": "N·m", "wf_increment": 0.001, "wf_start_time": start}
        writer.write_segment([ChannelObject("run", "M", _Q, properties=properties)])
    source = open_source(tmp_path / "a.tdms")
    (found,) = source.variables()
    assert found.unit == "N·m"
    assert found.rate == pytest.approx(1000.0)
    assert source.started_at is not None
    assert source.started_at.isoformat() == "2026-03-01T12:00:00+00:00"
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["t"], file["q"] = _T, _Q
        file["t"].make_scale("t")
        file["q"].dims[0].attach_scale(file["t"])
        file["q"].attrs["units"] = "deg"
    assert [(v.name, v.unit, v.clock) for v in open_source(tmp_path / "a.h5").variables()] == [
        ("q", "deg", "t"),
        ("t", "", None),
    ]


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::FutureWarning", "ignore::UserWarning")
def test_groups_of_an_mdf_file_have_a_clock_each(tmp_path: Path) -> None:
    _mdf(tmp_path / "a.mf4")
    source = open_source(tmp_path / "a.mf4")
    found = {variable.name: variable for variable in source.variables()}
    assert (found["q"].unit, found["q"].shape, found["q"].clock) == ("rad", (300,), "0/time")
    assert (found["slow"].shape, found["slow"].clock) == ((30,), "1/time")
    np.testing.assert_array_equal(source.read("1/time"), _T[::10])


@pytest.mark.parametrize(
    ("module", "extra", "head"),
    [
        ("nptdms", "tdms", b"TDSm"),
        ("pyarrow", "parquet", b"PAR1"),
        ("asammdf", "mdf", b"MDF     4.10    "),
    ],
)
def test_what_has_to_be_installed_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: str, extra: str, head: bytes
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    (tmp_path / "a").write_bytes(head + bytes(100))
    with pytest.raises(RecordingError, match=f"install the project with the extra '{extra}'"):
        open_source(tmp_path / "a")


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "is empty, it should hold measurements"),
        (b"\x01\x02\x00\x05" * 40, "is none of MAT, HDF5, TDMS, Parquet, MDF, NumPy, JSON or text"),
        (struct.pack("<5i", 0, 10, 1, 0, 1) + b"t" + bytes(8), "is none of MAT, HDF5, TDMS"),
        (b"PAR1" + bytes(50), "is not a readable Parquet file"),
        (b"MDF     4.10    " + bytes(50), "is not a readable MDF file"),
        (b"TDSm" + bytes(50), "is not a readable TDMS file"),
        (struct.pack("<5i", 0, 10, 1, 0, 2) + b"t\0" + bytes(8), "is not a readable MAT file"),
        (b"\x93NUMPY" + bytes(50), "is not a readable NumPy file"),
        (b'{"t": [0, 1,', "is not readable as JSON (Expecting value in line 1, column 13)"),
        (b'{"t": 1}\n{"t": 2', "is not readable as JSON (Extra data in line 2, column 1)"),
        (b'{"t": "\xff"}', "is not readable as JSON in UTF-8"),
        (b"[[" * 100_000, "is JSON that is nested too deep to be measurements"),
        (b"hello world\nno table here\n", "holds no table of numbers"),
        (b"# only remarks\n\n", "holds no line of data"),
    ],
)
def test_a_file_that_is_no_use_is_one_sentence(tmp_path: Path, content: bytes, sentence: str) -> None:
    (tmp_path / "a.bin").write_bytes(content)
    with pytest.raises(RecordingError) as caught:
        open_source(tmp_path / "a.bin")
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)
    del caught
    gc.collect()  # a destructor that complains is an error here


def test_of_json_records_fields_become_columns_and_texts_say_what_they_are(tmp_path: Path) -> None:
    at = "2026-03-01T12:00:0{}Z".format
    entries = [
        {"n": 1, "on": True, "at": at(0)},
        {"n": 2.5, "on": False, "at": at(1)},
        {"on": True, "at": at(2), "extra": 7},
    ]
    content = {"mass": 0.5, "unit": "kip", "entries": entries, "empty": [], "rows": [[1, 2], [3]]}
    (tmp_path / "a.json").write_text(json.dumps(content), encoding="utf-8")
    source = open_source(tmp_path / "a.json")
    kinds = {variable.name: (variable.dtype, variable.shape, variable.zoned) for variable in source.variables()}
    assert kinds["mass"] == ("float64", (1,), False)
    assert kinds["unit"][0] == "text"
    assert kinds["entries.at"] == ("time stamps", (3,), True)
    np.testing.assert_array_equal(source.read("entries.n"), [1.0, 2.5, np.nan])
    np.testing.assert_array_equal(source.read("entries.extra"), [np.nan, np.nan, 7.0])
    np.testing.assert_array_equal(source.read("entries.on"), [1, 0, 1])
    assert source.read("entries.at")[2] == np.datetime64("2026-03-01T12:00:02")
    for name, sentence in (("unit", r"unit is text \('kip'\), it should be numeric"), ("rows", "should be numeric")):
        with pytest.raises(RecordingError, match=sentence):
            source.read(name)


@pytest.mark.parametrize("content", ["[Header]\nt;q\n0;1\n1;2\n2;3\n", "[1 2 3]\n[4 5 6]\n", "{0} 1 2\n"])
def test_a_text_that_begins_with_a_bracket_is_no_json(content: str) -> None:
    assert not is_json(content.encode())


def test_what_is_pickled_is_never_run(tmp_path: Path) -> None:
    _npz(tmp_path / "a.npz")
    with pytest.raises(RecordingError, match="notes is pickled, it should be an array of numbers"):
        open_source(tmp_path / "a.npz").read("notes")


@pytest.mark.parametrize(("kind", "way"), [("timetable", "v = log.Variables"), ("quaternion", "saved as arrays.")])
def test_a_matlab_object_says_how_its_numbers_are_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, way: str
) -> None:
    """SciPy gives such an object unread; only MATLAB can write one."""
    fields = [(name, object) for name in ("s0", "s1", "s2", "arr")]
    inside = np.array([(b"log", b"MCOS", kind.encode(), 0)], dtype=fields)
    (tmp_path / "a.mat").write_bytes(b"MATLAB 5.0 MAT-file" + bytes(200))
    monkeypatch.setattr(scipy.io, "loadmat", lambda *_, **__: {"None": scipy.io.matlab.MatlabOpaque(inside)})
    with pytest.raises(RecordingError) as caught:
        take_inventory(tmp_path / "a.mat")
    assert f"log is a MATLAB {kind}, which only MATLAB reads" in str(caught.value)
    assert way in str(caught.value)


def test_a_matrix_needs_a_column_or_a_row(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "a.mat", {"X": np.arange(12).reshape(3, 4), "c": "text"})
    source = open_source(tmp_path / "a.mat")
    assert source.read("X", column=2).tolist() == [1, 5, 9]
    assert source.read("X", row=2).tolist() == [4, 5, 6, 7]
    for sentence, place in (
        ("3 x 4 matrix, 'column' (or 'row'", {}),
        ("has 4 columns, column 5", {"column": 5}),
        ("has 3 rows, row 4", {"row": 4}),
    ):
        with pytest.raises(RecordingError) as caught:
            source.read("X", **place)
        assert sentence in str(caught.value)


def test_a_spreadsheet_is_to_be_saved_as_csv(tmp_path: Path) -> None:
    (tmp_path / "rig.xlsx").write_bytes(b"PK\x03\x04" + bytes(50))
    with pytest.raises(RecordingError, match="should be saved as CSV"):
        open_source(tmp_path / "rig.xlsx")


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::FutureWarning", "ignore::UserWarning")
def test_an_mdf_file_is_closed_with_its_source(tmp_path: Path) -> None:
    names = _mdf(tmp_path / "measured.mf4")
    path = next(tmp_path.iterdir())
    source: Any = open_source(path)
    np.testing.assert_array_equal(_read(source, names["q"]), _Q)
    opened = source._file._mdf._file
    assert not opened.closed
    del source
    assert opened.closed
