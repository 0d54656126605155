"""Where a value starts again the motion goes on evenly: a guess agrees with that, and an import says if it does not."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bench.importing.looking import draft, take_inventory
from bench.importing.wraps import jumps_of
from tests.bench.importing import builders

_T = np.arange(4000) / 200
_TURNS = 0.2 * _T + 0.3 * np.sin(0.9 * _T)
_COUNTED = 'motor_angle = {{variable = "x", unit = "counts", counts_per_revolution = {0}, wraps_at = {1}}}'


def _counter(period: int, turns: NDArray[np.float64] = _TURNS) -> NDArray[np.int64]:
    return np.asarray(np.floor(turns * period).astype(np.int64) % period)


def _looked(folder: Path, **columns: Any) -> dict[str, Any]:
    path = builders.csv(folder / "a.csv", **{"t [s]": _T}, **columns)
    content = tomllib.loads(draft(take_inventory(path), folder / "a.toml").text())["channels"]["motor_angle"]
    assert isinstance(content, dict)
    return content


@pytest.mark.parametrize("period", [6, 3600, 4096, 20000, 65536, 100000])
def test_a_counter_starts_again_where_its_motion_goes_on_evenly(tmp_path: Path, period: int) -> None:
    table = _looked(tmp_path, PosCounts=_counter(period))
    assert table["wraps_at"] == table["counts_per_revolution"] == period
    # a log that is ten times as fast as its drive
    held = _counter(period, np.repeat(_TURNS[::10], 10))
    assert _looked(tmp_path, PosCounts=held)["wraps_at"] == period


def test_a_counter_of_no_round_number_starts_again_after_its_largest_value(tmp_path: Path) -> None:
    counter = _counter(23457, np.arange(4000) / 4000 * 3)
    assert _looked(tmp_path, PosCounts=counter)["wraps_at"] == pytest.approx(23457, abs=20)


def test_jumps_across_which_no_motion_goes_on_are_no_overflow(tmp_path: Path) -> None:
    counts = np.where(_T % 7 < 3.5, 0, 5000) + np.round(3000 * _T / 20).astype(np.int64)
    counts[1500:1502] = 30000
    counts[2500:2503] = 21000
    assert "wraps_at" not in _looked(tmp_path, PosCounts=counts)
    degrees = np.abs(np.degrees(_TURNS) * 20 % 720 - 360)
    degrees[[700, 1900, 2600]] = 0.0, 359.9, 180.0
    assert "wraps_at" not in _looked(tmp_path, **{"angle [deg]": degrees})
    assert _looked(tmp_path, **{"angle [deg]": 360 * _TURNS % 360})["wraps_at"] == 360.0


def test_an_overflow_that_makes_the_angle_jump_is_told_with_the_right_one(tmp_path: Path) -> None:
    builders.csv(tmp_path / "a.csv", t=_T, x=_counter(20000))
    done = builders.one(tmp_path, _COUNTED.format(32768, 32768))
    (said,) = [warning for warning in done.warnings if "wraps_at" in warning]
    assert "map.toml: channels.motor_angle.wraps_at is 32768, and 3 of the 3 steps where the values start" in said
    # 12768 of 32768 counts in one row
    assert "(2.456 rad in line 1219, 0.0075 beside it)" in said
    assert said.endswith("likely it is not 32768, 20000 would be right.")


@pytest.mark.parametrize("wraps_at", [20000, 65536])
def test_only_the_right_overflow_is_told_nothing_of(tmp_path: Path, wraps_at: int) -> None:
    builders.csv(tmp_path / "a.csv", t=_T, x=_counter(20000))
    done = builders.one(tmp_path, _COUNTED.format(20000, wraps_at))
    assert any("wraps_at" in warning for warning in done.warnings) == (wraps_at != 20000)


def test_a_row_that_is_missing_at_one_of_the_overflows_is_no_doubt(tmp_path: Path) -> None:
    counter = _counter(20000)
    rows = np.flatnonzero(np.diff(counter) < -10000)
    keep = np.ones(counter.size, dtype=bool)
    keep[rows[0] : rows[0] + 25] = False
    builders.csv(tmp_path / "a.csv", t=_T[keep], x=counter[keep])
    done = builders.one(tmp_path, _COUNTED.format(20000, 20000), top='gaps = "keep"')
    assert not any("wraps_at" in warning for warning in done.warnings)


def test_of_motion_as_fast_as_its_jumps_nothing_is_told() -> None:
    assert jumps_of((0.4 * np.arange(1000)) % 1.0) is None
    assert jumps_of(np.zeros(10)) is None
    assert jumps_of(np.array([0.0, 1.0])) is None
