import math
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.configuration import UNITS, load_bench, parse_bench, parse_quantity, shipped_benches
from bench.errors import ConfigurationError


@pytest.fixture(scope="module")
def text() -> str:
    return load_bench("rh380n").text


def refusal(text: str) -> str:
    with pytest.raises(ConfigurationError) as caught:
        parse_bench(text, "mine.toml")
    message = str(caught.value)
    assert message.startswith("mine.toml")
    assert "\n" not in message
    return message


def test_the_bench_on_a_wire_differs_in_its_bus_only() -> None:
    a, b = (load_bench(name).configuration for name in ("rh380n", "rh380n-wire"))
    same = {"name": True, "bus": True, "limits": {"lost_cycles"}}
    assert a.model_dump(exclude=same) == b.model_dump(exclude=same)
    assert (b.bus.master, b.bus.plant) == ("soem", a.bus.plant)
    roles = [slave.role for slave in a.bus.slaves if slave.role != "temperature_terminal"]
    assert [slave.role for slave in b.bus.slaves] == roles
    assert [sensor.driver for sensor in b.bus.slow_sensors] == ["pt100_modbus_rtu"]


def test_shipped_benches_differ_where_it_matters() -> None:
    assert shipped_benches() == ("rh380n", "rh380n-wire", "rv80n")
    a, b = (load_bench(name).configuration for name in ("rh380n", "rv80n"))
    assert a.gearbox.ratio != b.gearbox.ratio
    assert a.input_encoder.bits != b.input_encoder.bits
    assert a.bus.slave("load_drive") != b.bus.slave("load_drive")
    assert a.torque_sensor.rated_torque != b.torque_sensor.rated_torque


def test_values_are_si_inside() -> None:
    bench = load_bench("rh380n").configuration
    assert bench.torque_sensor.rated_torque == 10_000.0
    assert bench.bus.cycle_time == pytest.approx(5e-4)
    assert bench.gearbox.stiffness == 4e6
    assert bench.heating.time_limit == 7200.0


def test_bench_file_never_holds_the_plants_truth(text: str) -> None:
    # the only thing an emulated bench file says of its plant is its name
    assert re.findall(r"^.*plant.*$", text, re.MULTILINE) == ['plant = "rh380n"']


@pytest.mark.parametrize(
    ("old", "new", "parts"),
    [
        ('rated_torque = "10 kN*m"', "rated_torque = 10", ["torque_sensor.rated_torque = 10", '"10 kN*m"']),
        ('rated_torque = "10 kN*m"', 'rated_torque = "10 kg"', ['"kg" is not a unit of torque', "N*m"]),
        ("bits = 25", "bitz = 25", ["load_encoder.bitz", '"bits" is missing']),
        ("bits = 25", "bits = 2", ["load_encoder.bits = 2", "greater than or equal to 8"]),
        ("ratio = 185.0", "ratio = 184.0", ["gearbox", "185"]),
        ('motor_speed = "220 rad/s"', 'motor_speed = "900 rad/s"', ["limits.motor_speed", "input_motor.maximum_speed"]),
        ('load_torque = "1300 N*m"', 'load_torque = "5 kN*m"', ["limits.load_torque", "gearbox.rated_torque"]),
        ('hysteresis = "1 K"', 'hysteresis = "2 K"', ["heating", "band"]),
        ('role = "torque_terminal"', 'role = "load_drive"', ["exactly one load_drive", "2"]),
        ("position = 4", "position = 7", ["positions 1 to 5"]),
        ('plant = "rh380n"\n', "", ["plant"]),
        ("valid_until = 2028-03-17", "valid_until = 2020-03-17", ["torque_sensor.calibration", "valid_until"]),
        ('zero_id = "2026-11-02-a"', 'zero_id = "a"\ncolour = "blue"', ["colour", "no such key"]),
        ('temperature = "70 degC"', 'temperature = "70 K"', ["limits.temperature", "degC"]),
    ],
)
def test_wrong_file_gets_a_sentence(text: str, old: str, new: str, parts: list[str]) -> None:
    assert old in text
    message = refusal(text.replace(old, new, 1))
    for part in parts:
        assert part in message


def test_broken_toml_and_missing_files_are_sentences(tmp_path: Path) -> None:
    assert "not valid TOML" in refusal("name = ")
    with pytest.raises(ConfigurationError, match="rh380n"):
        load_bench("nowhere")
    with pytest.raises(ConfigurationError, match="cannot be read"):
        load_bench(tmp_path / "absent.toml")


def test_file_on_disk_is_found_and_kept_as_text(text: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text, "utf-8")
    loaded = load_bench(path)
    assert loaded.text == text
    assert loaded.digest == load_bench("rh380n").digest


@given(st.sampled_from(sorted(UNITS)), st.floats(-1e6, 1e6, allow_nan=False), st.data())
def test_every_unit_reads_back(kind: str, number: float, data: st.DataObject) -> None:
    unit = data.draw(st.sampled_from(sorted(UNITS[kind])))
    assert math.isclose(parse_quantity(f"{number!r} {unit}", kind), number * UNITS[kind][unit], rel_tol=1e-12)


@given(st.text(max_size=12), st.sampled_from(sorted(UNITS)))
def test_any_text_is_a_value_or_a_sentence(text: str, kind: str) -> None:
    sentence = ""
    value = 0.0
    try:
        value = parse_quantity(text, kind)
    except ValueError as error:
        sentence = str(error)
    assert math.isfinite(value)
    assert sentence == "" or (kind in sentence and len(sentence) > 20)


@pytest.mark.parametrize("value", [True, None, [], {}, 3, 3.5, "", "5", "N*m", "1e999 N*m"])
def test_values_that_are_no_torque(value: object) -> None:
    with pytest.raises(ValueError, match="torque"):
        parse_quantity(value, "torque")
