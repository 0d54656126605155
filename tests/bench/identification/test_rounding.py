"""A torque that a drive rounds to its own step, and the bus to its codes: found in the codes, and taken back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
import pytest

from bench.identification.samples.rounding import find_step, rounded_twice, with_single_rounding
from bench.recording import ChannelSpec, Recording, Setpoint

CODE = 0.0175
STEP = 6.4e-3
NOISE = 0.02


@dataclass(frozen=True, slots=True)
class _Recording:
    """As much of a recording as is asked for."""

    setpoint: Setpoint
    specs: dict[str, ChannelSpec]
    codes: np.ndarray

    def raw(self, channel: str) -> np.ndarray:
        assert channel == "motor_torque"
        return self.codes


def _spec(dtype: str = "int16") -> ChannelSpec:
    return ChannelSpec("motor_torque", "N*m", dtype, CODE)


def _codes(torque: np.ndarray, step: float | None, seed: int) -> np.ndarray:
    noisy = torque + NOISE * np.random.default_rng(seed).normal(size=torque.size)
    inner = noisy if step is None else np.rint(noisy / step) * step
    return np.rint(inner / CODE).astype(np.int16)


def _campaign(step: float | None, dtype: str = "int16") -> list[Recording]:
    out: list[Recording] = []
    for k in range(8):
        torque = np.linspace(-2.0, 2.0, 400_000) + 0.1 * k
        setpoint = Setpoint(load_torque=100.0 * k, velocity=0.1, temperature=float("nan"))
        out.append(cast(Recording, _Recording(setpoint, {"motor_torque": _spec(dtype)}, _codes(torque, step, k))))
    return out


def test_the_drives_own_step_shows_in_how_often_codes_occur() -> None:
    assert find_step(_campaign(STEP)) == pytest.approx(STEP, rel=1e-4)


def test_one_rounding_shows_no_step() -> None:
    assert find_step(_campaign(None)) is None


def test_without_whole_numbers_or_motion_nothing_is_looked_for() -> None:
    assert find_step(_campaign(STEP, "float64")) is None
    assert find_step([]) is None


def test_the_mean_of_what_is_reported_is_that_of_the_torque_again() -> None:
    """Twice rounded, the mean is off by up to 1 mN·m by level; undone, by a tenth of it."""
    off, left = [], []
    for k, level in enumerate(np.arange(0.3, 1.0, 0.05)):
        codes = _codes(np.full(200_000, level), STEP, k)
        off.append((codes * CODE).mean() - level)
        left.append(with_single_rounding(codes, _spec(), STEP).mean() - level)
    assert max(np.abs(off)) > 5e-4
    assert max(np.abs(left)) < 0.25 * max(np.abs(off))


def test_only_a_channel_that_is_coarser_than_the_step_has_been_rounded_twice() -> None:
    assert rounded_twice(_spec(), STEP)
    assert not rounded_twice(_spec("float64"), STEP)
    assert not rounded_twice(ChannelSpec("motor_torque", "N*m", "int16", 1e-3), STEP)
    assert not rounded_twice(None, STEP)
    spec = ChannelSpec("motor_torque", "N*m", "int16", -CODE, 0.5)
    # a code is no further from its value than half a code, whatever scale and offset
    assert with_single_rounding(np.array([10, -3], dtype=np.int16), spec, STEP) == pytest.approx(
        [-10 * CODE + 0.5, 3 * CODE + 0.5], abs=0.5 * CODE
    )
    assert with_single_rounding(np.empty(0, dtype=np.int16), spec, STEP).size == 0
    # a wild code costs no table of all between
    wild = with_single_rounding(np.array([10, 2**31 - 1], dtype=np.int32), spec, STEP)
    assert wild[0] == with_single_rounding(np.array([10] * 20, dtype=np.int32), spec, STEP)[0]
    assert wild[1] == pytest.approx(-CODE * (2**31 - 1), rel=1e-6)
