"""Whole numbers whose sign stands in a bit: the first look sees it in them, and in nothing ordinary."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from bench.importing import Imported, import_recordings
from bench.importing.formats import Variable
from bench.importing.looking import draft, take_inventory
from bench.importing.looking.column import Column
from bench.importing.looking.guesses import sign_bit
from tests.bench.importing import builders

_T = np.arange(2000) / 100
_WAVE = np.sin(2 * _T)
_NOISE = np.random.default_rng(3).normal(0.0, 1.0, _T.size)


def _bit(values: NDArray[np.float64]) -> int | None:
    whole = np.round(values).astype(np.int64)
    return sign_bit(Column(Variable("x", whole.shape, "int64"), whole))


def _written(values: NDArray[np.float64], bit: int) -> NDArray[np.float64]:
    """Numbers as a register has them whose sign is a bit."""
    whole = np.round(values)
    return np.where(whole < 0, 2.0**bit - whole, whole)


@pytest.mark.parametrize("bit", [10, 11, 15])
@pytest.mark.parametrize("values", [900 * _WAVE, 50 * np.round(18 * _WAVE), 60 * _WAVE + 30 * _NOISE, 20 * _NOISE])
def test_a_sign_in_a_bit_is_seen(values: NDArray[np.float64], bit: int) -> None:
    assert _bit(_written(values, bit)) == bit


@pytest.mark.parametrize(
    "values",
    [
        4095 * (0.5 + 0.5 * _WAVE),  # an unsigned counter that passes the bit
        (9000 * _T) % 65536,  # counters that overflow
        (900 * _WAVE) % 4096,
        (900 * _WAVE) % 65536,
        (3000 * _WAVE + 1000) % 36000,  # hundredths of a degree: the next power of two is near
        (3000 * _WAVE + 1500 + 30 * _NOISE) % 20000,
        (200 * _WAVE) % 360,
        np.abs(2000 * _NOISE),
        900 * _WAVE,
        np.where(_WAVE > 0, 1100, 10) + 3 * np.abs(_NOISE),  # levels
        np.where(_WAVE > 0, 1024.0, 0.0),
        np.where(_WAVE > 0, 0x8637, 0x0637) + np.arange(2000) % 5,  # a state with a bit that goes on and off
        np.repeat(np.round(2000 * np.abs(_NOISE[:40])), 50),  # set values
        10000 * _T,
    ],
)
def test_ordinary_numbers_have_no_sign_in_a_bit(values: NDArray[np.float64]) -> None:
    assert _bit(values) is None


def test_the_look_proposes_the_bit_and_a_note_says_so(tmp_path: Path) -> None:
    speed = 1500 * _WAVE
    path = builders.csv(
        tmp_path / "a.csv",
        t_s=_T,
        pos=np.round(2000 - 700 * np.cos(2 * _T)).astype(np.int64),
        speed=_written(speed, 15).astype(np.int64),
    )
    made = draft(take_inventory(path), tmp_path / "a.toml")
    channels = tomllib.loads(made.text())["channels"]
    assert channels["motor_velocity"] == {"variable": "speed", "sign_bit": 15, "unit": "?"}
    assert made.entries()["channels.motor_velocity.unit"].why == "the values are -1500 to 1500"
    (note,) = [remark for remark in made.remarks if "sign" in remark]
    assert note.startswith("speed seems to have its sign in bit 15")
    assert "sign_bit = 15 in its table gives the sign back" in note
    made.write(tmp_path / "a.toml")
    assert f"# {note}" in (tmp_path / "a.toml").read_text("utf-8")
    units = {"channels.motor_velocity.unit": "deg/s", "channels.motor_angle.unit": "deg", "gearbox.ratio": 1.0}
    (done,) = import_recordings(tmp_path / "a.toml", tmp_path / "out", changes=units)
    assert isinstance(done, Imported)
    np.testing.assert_allclose(done.recording.si("motor_velocity"), np.radians(np.round(speed)), atol=1e-9)
