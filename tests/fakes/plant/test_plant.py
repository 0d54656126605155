"""The plant as a black box: replay, blocks, seeds, sensors, faults, files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fakes.plant import COMMAND_DTYPE, FAULTS, Plant, PlantError, PlantTruth, read_plant
from tests.fakes.plant.motion import bring_up, commands, ramped


@pytest.fixture(scope="module")
def truth() -> PlantTruth:
    return read_plant("rh380n")


def test_result_does_not_depend_on_the_block(truth: PlantTruth) -> None:
    rows = ramped(0.5, 0.0, 60.0, 0.0, 500.0)
    one, whole = Plant(truth, seed=9), Plant(truth, seed=9)
    single = np.concatenate([one.step(rows[i : i + 1]) for i in range(rows.size)])
    assert single.tobytes() == whole.step(rows).tobytes()
    assert one.state == whole.state


def test_snapshot_replays_bit_by_bit(truth: PlantTruth) -> None:
    plant = Plant(truth, seed=4)
    plant.step(ramped(0.3, 0.0, 60.0, 0.0, 500.0))
    plant.faults.set("torque_sensor_drift", 5.0, at_s=0.4)
    token = plant.snapshot()
    rows = ramped(0.3, 60.0, -10.0, 500.0, 0.0)
    first, state = plant.step(rows), plant.state
    plant.faults.clear_all()
    plant.step(commands(0.1))
    plant.restore(token)
    assert plant.time_s == pytest.approx(0.3)
    assert plant.step(rows).tobytes() == first.tobytes()
    assert plant.state == state


def test_seed_changes_the_noise_only(truth: PlantTruth) -> None:
    rows = commands(0.1)
    first, second = (Plant(truth, seed=seed).step(rows) for seed in (1, 2))
    assert (first["torque_adc"] != second["torque_adc"]).any()
    assert abs(first["torque_adc"].mean() - second["torque_adc"].mean()) < 0.6


def test_resolution_and_noise_of_the_sensors(truth: PlantTruth) -> None:
    plant = Plant(truth, seed=8)
    rows = plant.step(commands(20.0))
    quantum = 10.0e3 / 32768
    torque = rows["torque_adc"] * quantum
    ripple = sum(r.amplitude * np.sin(r.order * plant.state["load_angle"] + r.phase) for r in truth.ripple)
    # at standstill the ripple is a constant offset, held in part by the bearing
    assert abs(torque.mean() - truth.torque_sensor.zero - ripple) < truth.load_side.bearing_friction + 0.5
    assert torque.std() == pytest.approx(np.hypot(truth.torque_sensor.noise, quantum / np.sqrt(12)), rel=0.03)
    assert rows["load_position"].std() == pytest.approx(np.hypot(0.8, 1 / np.sqrt(12)), rel=0.1)
    assert np.unique(rows["input_position"]).size <= 2
    temperature = rows["lubricant_temperature"]
    assert temperature.std() == pytest.approx(0.02, rel=0.1)
    assert (np.flatnonzero(np.diff(temperature)) % 20 == 19).all()
    assert rows["input_torque"].std() == pytest.approx(0.02, rel=0.3)
    steps = rows["load_torque"] / truth.load_drive.torque_resolution
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)


def test_encoder_counts_a_turn(truth: PlantTruth) -> None:
    plant = Plant(truth, seed=1)
    bring_up(plant, 50.0, 0.0)
    row = plant.step(commands(0.5, 50.0, 0.0))[-1]
    assert row["input_position"] == np.floor(plant.state["motor_angle"] * 8192 / (2 * np.pi))
    assert row["load_position"] == pytest.approx(-plant.state["load_angle"] * 2**25 / (2 * np.pi), abs=6)
    assert row["input_velocity"] == pytest.approx(50.0, abs=1.5)
    assert row["load_velocity"] == pytest.approx(-50.0 / 185.0, abs=0.01)


def test_ripple_stands_at_its_orders(truth: PlantTruth) -> None:
    plant = Plant(truth, seed=1)
    rate = np.deg2rad(10.0)
    bring_up(plant, rate * 185.0, 0.0)
    rows = plant.step(commands(36.0, rate * 185.0, 0.0))
    angle = -rows["load_position"] / 2**25 * 2 * np.pi
    torque = (rows["torque_adc"] - rows["torque_adc"].mean()) * 10.0e3 / 32768
    for part in truth.ripple:
        amplitude = 2 * abs(np.mean(torque * np.exp(-1j * part.order * angle)))
        assert amplitude == pytest.approx(part.amplitude, abs=0.4)


def test_second_bench_runs_and_faces_the_other_way() -> None:
    plant = Plant.from_file("rv80n", seed=1)
    bring_up(plant, 14.0, -200.0)  # −200 N·m in this drive's frame opposes +q
    rows = plant.step(commands(0.5, 14.0, -200.0))
    state = plant.state
    assert rows["load_position"][-1] == pytest.approx(state["load_angle"] * 2**23 / (2 * np.pi), abs=4)
    assert state["torque"] == pytest.approx(200.0 + 3.0, abs=8.0)
    assert state["motor_angle"] / 81.0 == pytest.approx(state["load_angle"], abs=1e-3)


@pytest.mark.parametrize("fault", [f.name for f in FAULTS])
def test_every_fault_shows_and_goes_off(truth: PlantTruth, fault: str) -> None:
    plant, healthy = Plant(truth, seed=2), Plant(truth, seed=2)
    for each in (plant, healthy):
        bring_up(each, 60.0, 300.0, settle=0.2)
    rows = commands(0.2, 60.0, 300.0)
    start = plant.time_s + 0.05
    plant.faults.set(fault, at_s=start, until_s=start + 0.1)
    faulty, good = plant.step(rows), healthy.step(rows)
    assert faulty[:100].tobytes() == good[:100].tobytes()
    assert (
        faulty[101:300].tobytes() != good[101:300].tobytes()
        or plant.state["temperature"] != healthy.state["temperature"]
    )
    plant.faults.clear(fault)
    assert not list(plant.faults.scheduled())


def test_faults_read_as_they_should(truth: PlantTruth) -> None:
    plant = Plant(truth, seed=2)
    bring_up(plant, 30.0, 300.0, settle=0.2)
    token = plant.snapshot()
    rows = commands(0.2, 30.0, 300.0)
    checks = {
        "torque_sensor_saturated": ("torque_adc", 32767, 32767),
        "torque_sensor_open": ("torque_adc", -8, 8),
        "pt100_open": ("lubricant_temperature", 10000, 10000),
        "pt100_short": ("lubricant_temperature", -10000, -10000),
        "ambient_pt100_open": ("ambient_temperature", 10000, 10000),
        "input_encoder_wrap": ("input_position", 0, 8191),
        "load_current_off": ("load_torque", -4, 4),
    }
    for fault, (channel, low, high) in checks.items():
        plant.restore(token)
        plant.faults.set(fault)
        values = plant.step(rows)[channel][40:]
        assert values.min() >= low, fault
        assert values.max() <= high, fault
    for fault, channel in (("input_encoder_frozen", "input_position"), ("torque_sensor_frozen", "torque_adc")):
        plant.restore(token)
        plant.faults.set(fault)
        assert np.ptp(plant.step(rows)[channel]) == 0, fault


def test_frozen_input_encoder_lets_the_motor_run_away(truth: PlantTruth) -> None:
    plant = Plant(truth, seed=2)
    bring_up(plant, 30.0, 0.0, settle=0.2)
    plant.faults.set("input_encoder_frozen")
    plant.step(commands(0.3, 30.0, 0.0))
    assert plant.state["motor_velocity"] > 300.0


def test_uncoupled_load_motor_runs_away(truth: PlantTruth) -> None:
    plant = Plant(truth, seed=2)
    plant.step(commands(0.1))
    plant.faults.set("load_uncoupled")
    plant.step(commands(0.1, 0.0, 1000.0))
    state = plant.state
    # 1000 N·m on 3 kg·m² for 0.1 s, less bearing friction and the torque's lag of 2 ms
    assert state["load_velocity"] == pytest.approx(-(1000.0 - 8.0) / 3.0 * 0.098, rel=0.02)
    assert state["torque"] == 0.0
    assert abs(state["motor_velocity"]) < 0.1


def test_stalled_output_takes_the_motor_to_its_limit(truth: PlantTruth) -> None:
    plant = Plant(truth, seed=2)
    bring_up(plant, 30.0, 0.0, settle=0.2)
    plant.faults.set("output_stalled")
    rows = plant.step(commands(1.0, 30.0, 0.0))
    assert rows["input_torque"][-1] == pytest.approx(52.5, abs=0.2)
    # 52.5 N·m at 185, less friction while it turns, with friction's help where it came to rest behind its overshoot
    assert 8500.0 < plant.state["torque"] < 185.0 * (52.5 + 0.5) / (1.0 - 0.04)


def test_wrong_commands_and_names_are_refused(truth: PlantTruth) -> None:
    plant = Plant(truth)
    with pytest.raises(PlantError, match="COMMAND_DTYPE"):
        plant.step(np.zeros(3))
    with pytest.raises(PlantError, match="as long as"):
        plant.step(np.zeros(3, COMMAND_DTYPE), plant.step(np.zeros(2, COMMAND_DTYPE)))
    with pytest.raises(PlantError, match="no fault 'melted'"):
        plant.faults.set("melted")
    with pytest.raises(PlantError, match="rh380n"):
        Plant.from_file("no_such_bench")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("ratio = 185.0", 'ratio = "185"', "gearbox: ratio"),
        ("ratio = 185.0", "", "'ratio' is missing"),
        ("ratio = 185.0", "ratio = 185.0\nteeth = 3", "unknown key 'teeth'"),
        ('format = "emulated-plant"', 'format = "bench"', "format"),
        ("torque = [-1100.0, 1100.0]", "torque = [1100.0, -1100.0]", "lower, upper"),
        ("[gearbox]", "[gearbox", "not TOML"),
    ],
)
def test_a_wrong_plant_file_is_named(tmp_path: Path, old: str, new: str, message: str) -> None:
    source = Path(__file__).parents[3] / "fakes" / "plants" / "rh380n.toml"
    path = tmp_path / "plant.toml"
    path.write_text(source.read_text(encoding="utf-8").replace(old, new, 1), encoding="utf-8")
    with pytest.raises(PlantError, match=message):
        Plant.from_file(path)


def test_cycle_time_is_a_parameter(truth: PlantTruth) -> None:
    plant = Plant(replace(truth), seed=1, cycle_time_s=0.001)
    plant.step(commands(0.5))
    assert plant.time_s == pytest.approx(1.0)


def test_nominal_parameters_are_those_of_the_bench(truth: PlantTruth) -> None:
    table = {symbol: value for row in truth.nominal_parameters().values() for symbol, value in row.items()}
    # the values of the bench's description; tau_0 and z_0 are the plant's own
    assert table == {
        "f_c": 0.5, "f_v": 0.006, "f_vT": -1e-4, "f_l": 0.04, "J": 0.0029, "tau_0": 0.04,
        "C": 25e3, "R": 0.25, "T_amb": 21.0, "f_b": 8.0, "J_L": 3.0, "z_0": 3.4,
    }  # fmt: skip
    assert (truth.gearbox.stiffness, truth.load_side.coupling_stiffness) == (4e6, 15e6)
    assert (truth.input_encoder.bits, truth.load_encoder.bits) == (13, 25)
    assert (truth.input_motor.maximum_torque, truth.load_motor.maximum_torque) == (52.5, 3400.0)
