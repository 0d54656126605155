"""Signs and scales that physics rules out are told with the likely right one, and nothing is told of what can be."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.importing.plausible.factors import reason
from tests.bench.importing import builders

_RATIO = 50.0


def _machine(folder: Path, load_share: float = 1.0, **factors: float) -> None:
    """A motor with inertia and friction that drives a load through a gearbox; factors spoil columns."""
    rng = np.random.default_rng(2)
    time = np.arange(6000) / 200
    speed = 60 * np.sin(1.1 * time) + 25 * np.sin(2.9 * time) + 5
    angle = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) / 200)))
    load = load_share * 100 * np.sin(0.37 * time) + load_share * 30 * np.sin(1.7 * time)
    torque = 2e-3 * np.gradient(speed, time) + 0.02 * speed + 0.4 * np.sign(speed) + load / _RATIO
    columns: dict[str, NDArray[Any]] = {
        "q": angle,
        "w": speed,
        "p": angle / _RATIO,
        "M": torque + rng.normal(0, 0.05, time.size),
        "L": load + rng.normal(0, 0.5, time.size),
        "T": 30 + time / 10,
    }
    spoilt = {name: values * factors.get(name, 1.0) for name, values in columns.items()}
    builders.csv(folder / "a.csv", t=time, **spoilt)


_CHANNELS = """
motor_angle = {variable = "q", unit = "rad"}
motor_velocity = {variable = "w", unit = "rad/s"}
load_angle = {variable = "p", unit = "rad"}
motor_torque = {variable = "M", unit = "N*m"}
load_torque = {variable = "L", unit = "N*m"}
temperature = {variable = "T", unit = "degC"}
"""


def _warnings(
    folder: Path, without: str = "", channels: str = _CHANNELS, load_share: float = 1.0, **factors: float
) -> tuple[str, ...]:
    _machine(folder, load_share, **factors)
    kept = "\n".join(line for line in channels.splitlines() if not without or not line.startswith(without))
    done = builders.one(folder, kept, ratio=f"{_RATIO}")
    warned = [event.text for event in done.recording.events if event.level == "warning"]
    assert list(done.warnings) == warned
    return done.warnings


def test_nothing_is_told_of_a_machine_that_can_be(tmp_path: Path) -> None:
    assert _warnings(tmp_path) == ()


@pytest.mark.parametrize("without", ["load", "motor_velocity", "motor_torque", "motor_angle"])
def test_nor_where_a_channel_is_missing(tmp_path: Path, without: str) -> None:
    if without == "load":
        channels = _CHANNELS.replace("load_torque", "load_torque_setpoint")
        assert _warnings(tmp_path, "load_angle", channels) == ()
    else:
        assert not any("wrong" in sentence for sentence in _warnings(tmp_path, without))


@pytest.mark.parametrize(
    ("factors", "sentences"),
    [
        ({"M": -1.0}, ["channels.load_torque over gearbox.ratio is found -0.99", "a wrong sign"]),
        ({"L": -1.0}, ["channels.load_torque over gearbox.ratio is found -", "a wrong sign; scale times -"]),
        ({"L": 1000.0}, ["a thousand too much or too little"]),
        (
            {"w": -1.0},
            ["channels.motor_velocity is -1 times the rate of motor_angle", "likely a wrong sign; scale times -1"],
        ),
        ({"w": 9.5493}, ["rpm taken for rad/s", "scale times 0.1047 would be right"]),
        (
            {"w": 0.02},
            ["motor_velocity is of the other side", "[channels.load_velocity] instead of"],
        ),
        ({"p": 57.29578}, ["load_angle turns 57.3 times as far", "degrees taken for radians"]),
        ({"p": 50.0 / 47.0}, ["gearbox.ratio = 47"]),
        ({"T": 10.0}, ["channels.temperature is 315 °C, which no lubricant is; unit = 'K' would be right"]),
    ],
)
def test_a_wrong_sign_or_scale_is_told_with_the_likely_one(
    tmp_path: Path, factors: dict[str, float], sentences: list[str]
) -> None:
    text = " ".join(_warnings(tmp_path, **factors))
    for sentence in sentences:
        assert sentence in text


def test_negative_inertia_and_friction_are_a_wrong_sign_of_the_torque(tmp_path: Path) -> None:
    (warning,) = _warnings(tmp_path, "load_torque", load_share=0.1, M=-1.0)
    assert "map.toml: channels.motor_torque gives a negative inertia (-0.00" in warning
    assert "scale times -1 of motor_torque (or of motor_angle) would be right" in warning


def test_an_angle_in_degrees_taken_for_radians_turns_too_fast(tmp_path: Path) -> None:
    channels = 'motor_angle = {variable = "q", unit = "rad"}\nmotor_torque = {variable = "M", unit = "N*m"}'
    warnings = _warnings(tmp_path, "", channels, q=57.29578 * 5)
    assert any("faster than motors do" in sentence for sentence in warnings)


@pytest.mark.parametrize(("factor", "expected"), [(1.0, ""), (1.3, "channels.motor_velocity is 1.3")])
def test_a_shaking_motion_is_no_wrong_scale(tmp_path: Path, factor: float, expected: str) -> None:
    """To and fro eight times a second: differences of the angle over a twenty-fifth of one are a sixth too small."""
    time = np.arange(3000) / 100.0
    speed = 4.0 * np.cos(2 * np.pi * 8.0 * time)
    angle = np.sin(2 * np.pi * 8.0 * time) / (4 * np.pi)
    builders.csv(tmp_path / "a.csv", t=time, q=angle, w=factor * speed)
    both = 'motor_angle = {variable = "q", unit = "rad"}\nmotor_velocity = {variable = "w", unit = "rad/s"}'
    warnings = builders.one(tmp_path, both).warnings
    assert any(expected in warning for warning in warnings) if expected else warnings == ()


def test_factors_have_names() -> None:
    assert reason(-1.0) == "likely a wrong sign; scale times -1 would be right"
    assert "other side of the gearbox" in reason(1 / 185.0, 185.0)
    assert "a wrong scale" in reason(3.3)


def test_of_a_current_the_torque_constant_is_the_other_thing_that_may_be_wrong(tmp_path: Path) -> None:
    current = _CHANNELS.replace('"M", unit = "N*m"', '"M", unit = "A", torque_constant = 0.2')
    (warning,) = _warnings(tmp_path, channels=current)
    right = r"scale times 0\.(2|199|20)\d* would be right of load_torque, or torque_constant times [45]"
    assert re.search(right, warning)


def test_of_a_torque_no_torque_constant_is_spoken_of(tmp_path: Path) -> None:
    (warning,) = _warnings(tmp_path, M=0.2)
    assert "of load_torque." in warning


def test_a_wrong_sign_is_not_all_that_it_can_be_where_no_load_was_recorded(tmp_path: Path) -> None:
    (warning,) = _warnings(tmp_path, "load_torque", load_share=0.1, M=-1.0)
    assert (
        "both should be positive, unless a load that no channel holds drives the motor: likely a wrong sign" in warning
    )


def _sprung(folder: Path, stiffness: float, friction: float) -> tuple[str, ...]:
    """Warnings of a spring with friction that is swung to and fro once a second."""
    time = np.arange(4000) / 200.0
    angle = np.sin(2 * np.pi * time) + 0.3 * np.sin(2 * np.pi * 0.31 * time)
    speed = np.gradient(angle, time)
    noise = np.random.default_rng(3).normal(0.0, 0.5, time.size)
    builders.csv(folder / "a.csv", t=time, q=angle, M=stiffness * angle + friction * speed + noise)
    channels = 'motor_angle = {variable = "q", unit = "rad"}\nmotor_torque = {variable = "M", unit = "N*m"}'
    return builders.one(folder, channels).warnings


def test_a_negative_inertia_may_be_a_spring(tmp_path: Path) -> None:
    (warning,) = _sprung(tmp_path, 10.0, 1.0)
    assert "though friction takes power: likely it lags behind motor_angle, unless a spring acts" in warning


def test_friction_that_is_positive_is_not_said_to_be_negative(tmp_path: Path) -> None:
    for warning in _sprung(tmp_path, 10.0, 0.005):
        assert "both should be positive" not in warning or "friction that takes -" in warning


def test_a_warning_of_many_files_is_shown_once_with_the_others_names(tmp_path: Path) -> None:
    _sprung(tmp_path, 10.0, 1.0)
    shutil.rmtree(tmp_path / "out")
    shutil.copy(tmp_path / "a.csv", tmp_path / "b.csv")
    mapping = tmp_path / "map.toml"
    mapping.write_text(mapping.read_text().replace('file = "a.csv"', 'file = "*.csv"'))
    done = CliRunner().invoke(make_app(), ["import", str(mapping), "--out", str(tmp_path / "out")])
    assert done.output.count("WARNING") == 1
    assert f"the same warning, with other numbers, of b: {mapping}: channels.motor_torque" in done.output
    assert "a negative inertia (… kg·m²)" in done.output
