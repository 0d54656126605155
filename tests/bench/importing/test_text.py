"""Text tables as laboratories write them: separators, decimal marks, headings, units, preambles, stamps."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bench.errors import RecordingError
from bench.importing.formats import open_source
from bench.importing.formats.text import TextSource
from bench.importing.formats.text_layout import TextOptions


def _open(folder: Path, text: str, encoding: str = "utf-8", **options: Any) -> TextSource:
    (folder / "a.txt").write_bytes(text.encode(encoding))
    source = open_source(folder / "a.txt", TextOptions(**options))
    assert isinstance(source, TextSource)
    return source


_ANY = st.floats(-1e6, 1e6).map(lambda value: float(f"{value:.6g}"))


@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.lists(st.tuples(_ANY, _ANY, _ANY), min_size=5, max_size=30),
    st.sampled_from(
        [(";", "."), (";", ","), ("\t", "."), ("\t", ","), (",", "."), ("|", "."), (" ", "."), ("  ", ",")]
    ),
    st.booleans(),
    st.booleans(),
)
def test_any_separator_and_decimal_mark_is_found(
    rows: list[tuple[float, ...]], marks: tuple[str, str], headings: bool, preamble: bool
) -> None:
    separator, decimal = marks
    lines = ["Measured by: somebody", "Rate 1000"] if preamble else []
    lines += [separator.join(("time", "angle", "torque"))] if headings else []
    # a point or comma in every number: 1,2,3 alone could be columns as well
    lines += [separator.join(f"{value:.7f}".replace(".", decimal) for value in row) for row in rows]
    with tempfile.TemporaryDirectory() as folder:
        source = _open(Path(folder), "\n".join(lines) + "\n")
        names = ["time", "angle", "torque"] if headings else ["column 1", "column 2", "column 3"]
        assert [variable.name for variable in source.variables()] == names
        for index, name in enumerate(names):
            np.testing.assert_allclose(source.read(name), [row[index] for row in rows], atol=1e-7)


@pytest.mark.parametrize(
    ("text", "encoding", "found"),
    [
        (
            "Zeit [s];Winkel [°];Moment [Nm]\n0,0;1,5;2\n0,1;1,6;3\n",
            "cp1252",
            {"Zeit [s]": "s", "Winkel [°]": "°", "Moment [Nm]": "Nm"},
        ),
        ("t,q,M\ns,deg,N*m\n0.0,1.5,2\n0.1,1.6,3\n", "utf-8-sig", {"t": "s", "q": "deg", "M": "N*m"}),
        ("t\tq\n[s]\t[rad]\n0.0\t1.5\n0.1\t1.6\n", "utf-16", {"t": "s", "q": "rad"}),
        ("# t speed_rpm\n0.0 1.5\n0.1 1.6\n", "utf-8", {"t": "", "speed_rpm": "rpm"}),
        ("a;a;\n0.0;1.5;\n0.1;1.6;\n", "utf-8", {"a": "", "a_2": ""}),
    ],
)
def test_headings_and_units(tmp_path: Path, text: str, encoding: str, found: dict[str, str]) -> None:
    source = _open(tmp_path, text, encoding)
    assert {
        variable.name: variable.unit
        for variable in source.variables()
        if variable.unit or found.get(variable.name) == ""
    } == found


def test_a_logger_s_preamble_is_passed_over(tmp_path: Path) -> None:
    text = "LabVIEW Measurement\nSeparator\tTab\nDate\t2026/03/01\n***End_of_Header***\nX_Value\tAngle\tComment\n"
    source = _open(tmp_path, text + "".join(f"{i / 10:.2f}\t{i * i:.3f}\n" for i in range(20)))
    assert [variable.name for variable in source.variables()] == ["X_Value", "Angle"]
    assert source.location(3) == "line 9"


@pytest.mark.parametrize(
    ("stamps", "expected", "zoned"),
    [
        (["2026-03-01 12:00:00.000", "2026-03-01 12:00:00.250"], "2026-03-01T12:00:00.250", False),
        (["2026-03-01T12:00:00+01:00", "2026-03-01T12:00:01.5+01:00"], "2026-03-01T11:00:01.500", True),
        (["01.03.2026 12:00:00,000", "01.03.2026 12:00:00,250"], "2026-03-01T12:00:00.250", False),
        (["3/14/2026 12:00:00", "3/14/2026 12:00:01"], "2026-03-14T12:00:01", False),
    ],
)
def test_stamps_of_many_forms(tmp_path: Path, stamps: list[str], expected: str, zoned: bool) -> None:
    source = _open(tmp_path, "time;q\n" + "".join(f"{stamp};{i},5\n" for i, stamp in enumerate(stamps)))
    assert source.read("time")[1] == np.datetime64(expected)
    assert source.variables()[0].zoned is zoned
    assert source.read("q").tolist() == [0.5, 1.5]


def test_times_of_day_go_on_over_midnight(tmp_path: Path) -> None:
    source = _open(tmp_path, "time\tq\n23:59:59.5\t1\n00:00:00.0\t2\n00:00:00.5\t3\n")
    assert np.diff(source.read("time")).tolist() == [0.5, 0.5]


@pytest.mark.parametrize(
    ("stamps", "sentence"),
    [
        (["3/4/2026 12:00:00", "3/4/2026 12:00:01"], "day or month first; year-month-day (2026-03-01) would be clear"),
        (["2026-03-01T12:00:00Z", "2026-03-01T12:00:01"], "either all time stamps should say their time zone or none"),
        (["2026-03-01T12:00:00", "2026-13-01T12:00:01"], "it should be a date and time such as"),
    ],
)
def test_stamps_that_cannot_be_read_are_one_sentence(tmp_path: Path, stamps: list[str], sentence: str) -> None:
    source = _open(tmp_path, "time;q\n" + "".join(f"{stamp};{i},5\n" for i, stamp in enumerate(stamps)))
    with pytest.raises(RecordingError) as caught:
        source.read("time")
    assert sentence in str(caught.value)


def test_a_word_among_numbers_is_named_with_its_line(tmp_path: Path) -> None:
    source = _open(tmp_path, "t;q\n0;1\n1;2\n2;broken\n3;4\n4;5\n")
    with pytest.raises(RecordingError, match="q is not numeric: 'broken' stands in line 4"):
        source.read("q")


def test_what_the_mapping_says_comes_before_what_is_found(tmp_path: Path) -> None:
    text = "junk 1 2 3\n1,2\n3,4\n5,6\n7,8\n"
    assert _open(tmp_path, text, skip_lines=1).read(None, column=2).tolist() == [2, 4, 6, 8]
    assert _open(tmp_path, text, skip_lines=1, delimiter=";", decimal=",").read(None, 1).tolist() == [
        1.2,
        3.4,
        5.6,
        7.8,
    ]
    text = "t 0 1 2\nq 5 6 7\n"
    assert _open(tmp_path, text, data_in="rows").read("q").tolist() == [5, 6, 7]


def test_a_short_recording_of_many_named_variables_stands_in_columns(tmp_path: Path) -> None:
    names = [f"q_{index}" for index in range(150)]
    lines = [",".join(names), *(",".join(f"{row}.{index:03d}" for index in range(150)) for row in range(40))]
    source = _open(tmp_path, "\r".join(lines) + "\r")  # as a Mac's spreadsheet ends its lines
    assert not source.layout.rows
    assert source.read("q_7").tolist() == pytest.approx([row + 0.007 for row in range(40)])


def test_a_line_longer_than_any_field_of_a_spreadsheet_is_read(tmp_path: Path) -> None:
    values = np.arange(40_000) / 8.0
    text = "\n".join(" ".join(map(str, values + line)) for line in range(3))
    assert _open(tmp_path, text).read(None, row=2)[:2].tolist() == [1.0, 1.125]


def test_a_name_over_several_columns_is_part_of_theirs(tmp_path: Path) -> None:
    rows = "".join(f"{k},{2 * k},{k},{3 * k}\n" for k in range(20))
    names = [variable.name for variable in _open(tmp_path, "speed,,torque,\nX,Y,X,Y\n" + rows).variables()]
    assert names == ["speed X", "speed Y", "torque X", "torque Y"]


def test_a_line_that_is_no_row_is_named_with_what_stands_there(tmp_path: Path) -> None:
    rows = [f"Time: {k} Position: {k % 7} Current: {k % 5}" for k in range(60)]
    rows.insert(40, "POSITIONING WITH REVSPEED: 1000, DELTAPOS: 0.49, DELTATIME: 2.70")
    path = tmp_path / "raw.txt"
    path.write_text("\n".join(rows) + "\n")
    with pytest.raises(RecordingError) as error:
        open_source(path)
    said = str(error.value)
    assert "is not a table of 6 columns: line 41 has 8 of them ('POSITIONING WITH REVSPEED: 1000, DELTAPOS" in said
    assert said.endswith("it should have 6; [csv] comment = 'POSITIONING' passes over lines that begin so.")
    assert open_source(path, TextOptions(comment="POSITIONING")).read(None, 6)[3] == 3


_ROWS = [(k / 10, k % 7 + 0.5, k % 5 - 0.25) for k in range(20)]


@pytest.mark.parametrize(
    ("heading", "row", "last"),
    [
        ("t,q,M", "{},{},{},0", [0.0] * 20),
        ("t;q;M", "{};{};{};", [np.nan] * 20),
        ("t,q,M", "{0},{1},{2},{1}", [q for _, q, _ in _ROWS]),
        ("t q M", "{} {} {} 0", [0.0] * 20),
        ("# t,q,M", "{},{},{},0", [0.0] * 20),
    ],
)
def test_headings_of_all_columns_but_the_last_are_those_of_the_first(
    tmp_path: Path, heading: str, row: str, last: list[float]
) -> None:
    source = _open(tmp_path, "\n".join([heading, *(row.format(*values) for values in _ROWS)]) + "\n")
    assert [variable.name for variable in source.variables()] == ["t", "q", "M", "column 4"]
    for name, expected in zip("tqM", zip(*_ROWS, strict=True), strict=True):
        np.testing.assert_array_equal(source.read(name), expected)
    np.testing.assert_array_equal(source.read("column 4"), last)
    assert source.notes == (
        "the headings name 3 of 4 columns: they are taken for the first 3, the last one is 'column 4'",
    )


def test_headings_with_spaces_are_those_of_columns_with_a_tab_after_each(tmp_path: Path) -> None:
    source = _open(tmp_path, "time s\tangle q\n" + "".join(f"{t}\t{q}\t\n" for t, q, _ in _ROWS))
    assert [variable.name for variable in source.variables()] == ["time s", "angle q", "column 3"]


@pytest.mark.parametrize(
    ("heading", "row"),
    [
        ("q M", "{index} {1} {2}"),  # row numbers before the columns, as R and pandas write them
        ("time q", "2026-03-01 12:00:{index:02d} {1}"),
        ("t,q", "{},{},{},0"),
        ("Measurement", "{},0"),
        ("x", "{index},5"),
    ],
)
def test_headings_that_may_be_of_other_columns_are_none(tmp_path: Path, heading: str, row: str) -> None:
    rows = [row.format(*values, index=index) for index, values in enumerate(_ROWS)]
    source = _open(tmp_path, "\n".join([heading, *rows]) + "\n")
    assert not source.layout.one_less
    assert source.notes == ()
    if heading != "x":  # decimal commas in one column
        assert all(variable.name.startswith("column ") for variable in source.variables())
