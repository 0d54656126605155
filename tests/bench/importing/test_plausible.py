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
    (warning,) = _warnings(tmp_path, "load_torque", load_share=0.02, M=-1.0)
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
    (warning,) = _warnings(tmp_path, "load_torque", load_share=0.02, M=-1.0)
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


def test_a_spring_is_no_negative_inertia(tmp_path: Path) -> None:
    assert _sprung(tmp_path, 10.0, 1.0) == ()


_SWING = np.arange(6000) / 200.0
_ANGLE = 90.0 * np.sin(0.9 * _SWING) + 20.0 * np.sin(2.3 * _SWING)
"""a motor's angle, which turns the output over 60° and more with the ratio of the tests"""
_PLAIN = 'motor_angle = {variable = "q", unit = "rad"}\nmotor_torque = {variable = "M", unit = "N*m"}'


def _swung(folder: Path, over_position: NDArray[Any], delay: int = 0, sign: float = 1.0) -> tuple[str, ...]:
    """Warnings of a motor with inertia, friction and a torque over the position; ``delay`` in samples."""
    speed = np.gradient(_ANGLE, _SWING)
    torque = 1e-3 * np.gradient(speed, _SWING) + 0.01 * speed + 0.3 * np.sign(speed) + over_position
    late = sign * np.roll(torque, delay)
    noise = np.random.default_rng(3).normal(0.0, 0.02, _SWING.size)
    builders.csv(folder / "a.csv", t=_SWING, q=_ANGLE, M=late + noise)
    return builders.one(folder, _PLAIN, ratio=f"{_RATIO}").warnings


@pytest.mark.parametrize("force", [7.0 * np.sin(_ANGLE / _RATIO + 0.3), 4.0 * np.cos(_ANGLE / _RATIO)])
def test_gravity_hides_no_sign_and_is_no_negative_inertia(tmp_path: Path, force: NDArray[Any]) -> None:
    assert _swung(tmp_path, force) == ()
    shutil.rmtree(tmp_path / "out")
    (warning,) = _swung(tmp_path, force, sign=-1.0)
    assert "likely a wrong sign; scale times -1 of motor_torque" in warning


def test_a_torque_that_lags_is_the_last_that_a_negative_inertia_may_be(tmp_path: Path) -> None:
    (warning,) = _swung(tmp_path, 0.0 * _ANGLE, delay=40)
    assert "though friction takes power: likely a force over the position that is no sine of it" in warning
    assert "friction that yields before it slides, or a torque that lags behind motor_angle; of these only" in warning


@pytest.mark.parametrize(("sign", "told"), [(1.0, False), (-1.0, True)])
def test_the_load_motors_torque_has_the_sign_of_the_load_torque(tmp_path: Path, sign: float, told: bool) -> None:
    rng = np.random.default_rng(4)
    speed = np.gradient(_ANGLE, _SWING)
    braked = 20.0 * np.sin(0.31 * _SWING) + 8.0 * np.sin(1.7 * _SWING)
    load = braked + 6.5 * np.gradient(speed, _SWING) / _RATIO
    torque = 1e-3 * np.gradient(speed, _SWING) + 0.01 * speed + 0.3 * np.sign(speed) + load / _RATIO
    spoilt = sign * braked + rng.normal(0.0, 0.1, _SWING.size)
    builders.csv(tmp_path / "a.csv", t=_SWING, q=_ANGLE, M=torque, L=load, B=spoilt)
    others = "".join(f'\n{n} = {{variable = "{c}", unit = "N*m"}}' for n, c in _LOADS.items())
    warnings = builders.one(tmp_path, _PLAIN + others, ratio=f"{_RATIO}").warnings
    assert any("scale times -1 of load_motor_torque would be right" in one for one in warnings) == told
    assert len(warnings) == told


_LOADS = {"load_torque": "L", "load_motor_torque": "B"}


@pytest.mark.parametrize(("unit", "ratio", "told"), [("deg", 121.0, True), ("deg", 2.0, False), ("rev", 121.0, False)])
def test_a_motor_that_turns_less_than_once_may_be_the_output(
    tmp_path: Path, unit: str, ratio: float, told: bool
) -> None:
    builders.csv(tmp_path / "a.csv", t=_SWING, q=60.0 * np.sin(0.9 * _SWING))
    channels = f'motor_angle = {{variable = "q", unit = "{unit}"}}'
    notes = builders.one(tmp_path, channels, ratio=f"{ratio}").notes
    said = [note for note in notes if "turns less than once, so the output with gearbox.ratio 121 less than 3°" in note]
    assert len(said) == told
    assert all(note.endswith("[channels.load_angle] instead of [channels.motor_angle] would be right") for note in said)


def test_an_angle_that_is_said_to_be_the_outputs_is_not_told_to_be(tmp_path: Path) -> None:
    builders.csv(tmp_path / "a.csv", t=_SWING, q=0.1 * np.sin(0.9 * _SWING), M=np.cos(0.9 * _SWING))
    channels = _PLAIN.replace("motor_angle", "load_angle")
    assert not any("less than once" in one for one in builders.one(tmp_path, channels, ratio="121").notes)


def test_counts_per_revolution_are_named_where_the_speed_contradicts_them(tmp_path: Path) -> None:
    speed = np.gradient(_ANGLE, _SWING) * 30 / np.pi
    counts = np.round(_ANGLE / (2 * np.pi) * 16384).astype(np.int64)
    builders.csv(tmp_path / "a.csv", t=_SWING, q=counts, w=speed)
    channels = (
        'motor_angle = {variable = "q", unit = "counts", counts_per_revolution = 65536}\n'
        'motor_velocity = {variable = "w", unit = "rpm"}'
    )
    (warning,) = builders.one(tmp_path, channels, ratio=f"{_RATIO}").warnings
    assert re.search(r"likely channels.motor_angle.counts_per_revolution is not 65536, 163\d\d", warning)
    shutil.rmtree(tmp_path / "out")
    in_rpm = channels.replace("65536", "16384").replace("rpm", "rad/s")
    (warning,) = builders.one(tmp_path, in_rpm, ratio=f"{_RATIO}").warnings
    assert "likely rpm taken for rad/s" in warning


def test_friction_that_is_positive_is_not_said_to_be_negative(tmp_path: Path) -> None:
    for warning in _sprung(tmp_path, 10.0, 0.005):
        assert "both should be positive" not in warning or "friction that takes -" in warning


def test_a_warning_of_many_files_is_shown_once_with_the_others_names(tmp_path: Path) -> None:
    _swung(tmp_path, 0.0 * _ANGLE, delay=40)
    shutil.rmtree(tmp_path / "out")
    shutil.copy(tmp_path / "a.csv", tmp_path / "b.csv")
    mapping = tmp_path / "map.toml"
    mapping.write_text(mapping.read_text().replace('file = "a.csv"', 'file = "*.csv"'))
    done = CliRunner().invoke(make_app(), ["import", str(mapping), "--out", str(tmp_path / "out")])
    assert done.output.count("WARNING") == 1
    assert f"the same warning, with other numbers, of b: {mapping}: channels.motor_torque" in done.output
    assert "a negative inertia (… kg·m²)" in done.output


def _joint(folder: Path, sign: float, seconds: float, other: bool = True) -> tuple[str, ...]:
    """Warnings of a joint that carries a forearm's weight, which hangs on the angle of the joint before it too."""
    time = np.arange(round(seconds * 100)) / 100.0
    own = 0.7 * np.sin(0.53 * time) + 0.2 * np.sin(1.9 * time)
    before = 1.1 * np.sin(0.31 * time + 1.0) + 0.3 * np.sin(1.3 * time)
    speed, theirs = np.gradient(own, time), np.gradient(before, time)
    torque = 0.02 * np.gradient(speed, time) + 0.15 * np.tanh(speed / 0.02) + 0.05 * np.gradient(theirs, time)
    torque += 4.0 * np.sin(own + before) + np.random.default_rng(5).normal(0.0, 0.02, time.size)
    builders.csv(folder / "a.csv", t=time, q=own, M=sign * torque, p=before)
    aux = 'q2 = {variable = "p", unit = "rad"}' if other else ""
    return builders.one(folder, _PLAIN, aux=aux).warnings


def test_gravity_of_another_joint_hides_no_sign_of_the_friction(tmp_path: Path) -> None:
    assert _joint(tmp_path, 1.0, 80.0) == ()
    shutil.rmtree(tmp_path / "out")
    (warning,) = _joint(tmp_path, -1.0, 80.0)
    assert "friction that takes -0.0" in warning
    assert "beside what aux.q2 does" in warning
    assert "likely a wrong sign; scale times -1 of motor_torque" in warning


def test_without_the_other_joint_or_enough_of_it_nothing_is_told_beside_it(tmp_path: Path) -> None:
    assert _joint(tmp_path, -1.0, 80.0, other=False) == ()
    shutil.rmtree(tmp_path / "out")
    assert not any("beside what" in warning for warning in _joint(tmp_path, -1.0, 5.0))


def test_an_axis_that_moves_along_is_named_as_what_may_drive_the_motor(tmp_path: Path) -> None:
    """A second encoder of the same shaft: its difference to the motor's angle is the torque, so it is not fitted."""
    speed = np.gradient(_ANGLE, _SWING)
    torque = 1e-3 * np.gradient(speed, _SWING) + 0.01 * speed + 0.3 * np.sign(speed)
    twisted = _ANGLE / _RATIO - torque / 500.0
    aux = 'end = {variable = "p", unit = "rad"}'
    for sign, told in ((1.0, 0), (-1.0, 1)):
        shutil.rmtree(tmp_path / "out", ignore_errors=True)
        builders.csv(tmp_path / "a.csv", t=_SWING, q=_ANGLE, M=sign * torque, p=twisted)
        warnings = builders.one(tmp_path, _PLAIN, ratio=f"{_RATIO}", aux=aux).warnings
        assert len(warnings) == told
        assert all("or aux.end does, which moves along with it" in warning for warning in warnings)


def _braked(folder: Path, zero: float, sign: float, inertia: float) -> tuple[str, ...]:
    """Warnings of a motor that turns one way against a brake; its drive reports ``zero`` N·m less than there are."""
    speed = 150.0 + 80.0 * np.sin(0.9 * _SWING)
    angle = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) / 200.0)))
    load = 60.0 + 50.0 * np.sin(0.41 * _SWING) + np.random.default_rng(6).normal(0.0, 0.3, _SWING.size)
    torque = load + 0.2 + inertia * np.gradient(speed, _SWING) - zero
    torque += np.random.default_rng(7).normal(0.0, 0.3, _SWING.size)
    builders.csv(folder / "a.csv", t=_SWING, q=angle, M=sign * torque, L=sign * load)
    channels = f'{_PLAIN}\nload_torque = {{variable = "L", unit = "N*m"}}'
    return builders.one(folder, channels).warnings


@pytest.mark.parametrize(
    ("zero", "sign", "inertia", "parts"),
    [
        (0.0, 1.0, 1e-4, None),
        (0.9, 1.0, 1e-4, ("either motor_torque is reported too small", "or both torques have the wrong sign")),
        (0.0, -1.0, 1e-4, ("either motor_torque is reported too small", "motor_angle, or of motor_torque and load_t")),
        (0.9, 1.0, 0.2, ("the inertia is positive, so the signs are right and motor_torque is reported too small",)),
    ],
)
def test_less_power_than_the_load_takes_is_a_gain_or_a_sign(
    tmp_path: Path, zero: float, sign: float, inertia: float, parts: tuple[str, ...] | None
) -> None:
    warnings = _braked(tmp_path, zero, sign, inertia)
    if parts is None:
        assert warnings == ()
        return
    (warning,) = warnings
    assert all(part in warning for part in parts)
    assert ("wrong sign" in warning) == (len(parts) > 1)


@pytest.mark.parametrize(("gain", "noted"), [(1.0, None), (1.2, None), (1.6, "1.6"), (0.6, "0.6"), (3.0, None)])
def test_a_load_that_is_found_too_large_or_small_is_noted_with_its_factor(
    tmp_path: Path, gain: float, noted: str | None
) -> None:
    _machine(tmp_path, M=gain)
    done = builders.one(tmp_path, _CHANNELS, ratio=f"{_RATIO}")
    said = [note for note in done.notes if "load_torque over gearbox.ratio is found" in note]
    assert [note.split(" times")[0].split("found ")[1].split(" ±")[0] for note in said] == ([noted] if noted else [])
    assert all(("passes on 6" in note) == (gain > 1.0) for note in said)
    # three times as much cannot be, and is a warning
    assert bool(done.warnings) == (gain > 2.5)


@pytest.mark.parametrize("name", ["qr", "q_ref"])
def test_the_set_value_of_a_controller_is_no_other_axis(tmp_path: Path, name: str) -> None:
    """Its torque is the difference of both angles less a damping: beside it the friction seems to be negative."""
    step, count = 0.005, 16_000
    time = np.arange(count) * step
    asked = 0.1 * np.sin(0.9 * time) + 0.12 * np.sin(2.3 * time + 1.0) + 0.06 * np.sin(4.1 * time)
    angle, torque = np.zeros(count), np.zeros(count)
    q = v = 0.0
    for i in range(count):
        torque[i] = 10.0 * (asked[i] - q) - 10.0 * v
        v += step * (torque[i] - 0.3 * np.tanh(v / 0.05) - 0.1 * v - 2.0 * np.sin(q)) / 0.5
        q += step * v
        angle[i] = q
    noise = np.random.default_rng(9).normal(0.0, 0.02, count)
    builders.csv(tmp_path / "a.csv", t=time, q=angle, M=torque + noise, p=asked)
    assert builders.one(tmp_path, _PLAIN, aux=f'{name} = {{variable = "p", unit = "rad"}}').warnings == ()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_load_that_keeps_its_level_tells_no_factor(tmp_path: Path, sign: float) -> None:
    """A weight that is lifted and lowered, and a torque whose zero is off by half of what that needs."""
    rng = np.random.default_rng(4)
    time = np.arange(6000) / 200
    speed = 20 * np.sin(1.1 * time)
    angle = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) / 200)))
    weight = np.full(time.size, 80.0)
    torque = 2e-3 * np.gradient(speed, time) + 0.02 * speed + 0.4 * np.sign(speed) + weight / _RATIO
    noise = rng.normal(0, 0.05, (2, time.size))
    builders.csv(tmp_path / "a.csv", t=time, q=angle, M=torque - 0.8 + noise[0], L=sign * weight + noise[1])
    kept = "\n".join(
        line for line in _CHANNELS.splitlines() if re.match("(motor_angle|motor_torque|load_torque) ", line)
    )
    done = builders.one(tmp_path, kept, ratio=f"{_RATIO}")
    assert not done.warnings
    assert not [note for note in done.notes if "times in motor_torque" in note]
