"""Mechanics and heat of the plant against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from fakes.plant import COMMAND_DTYPE, MODE_TORQUE, MODE_VELOCITY, Plant, PlantTruth, read_plant
from tests.fakes.plant.motion import CYCLE, bring_up, commands, quiet, ramped, smooth


@pytest.fixture(scope="module")
def truth() -> PlantTruth:
    return read_plant("rh380n")


def energy(plant: Plant) -> float:
    """Stored energy in J: both inertias and the spring."""
    state, truth = plant.state, plant.truth
    kinetic = 0.5 * truth.input_motor.inertia * state["motor_velocity"] ** 2
    kinetic += 0.5 * truth.load_motor.inertia * state["load_velocity"] ** 2
    twist = state["motor_angle"] / truth.gearbox.ratio + state["te"] - state["load_angle"]
    return float(kinetic + 0.5 * truth.torsional_stiffness * twist**2)


def test_energy_is_neither_made_nor_lost(truth: PlantTruth) -> None:
    plant = Plant(truth, seed=3)
    plant.step(commands(0.01))
    names = ("work_motor", "work_load", "loss_gearbox", "loss_bearing")
    before, stored = plant.state, energy(plant)
    plant.step(ramped(0.6, 0.0, 150.0, 0.0, 800.0))
    plant.step(ramped(0.6, 150.0, -100.0, 800.0, -500.0))
    after = plant.state
    change = {name: after[name] - before[name] for name in names}
    given = change["work_motor"] + change["work_load"]
    used = change["loss_gearbox"] + change["loss_bearing"] + energy(plant) - stored
    turned_over = abs(change["work_motor"]) + abs(change["work_load"])
    assert change["loss_gearbox"] > 0.0
    assert change["loss_bearing"] > 0.0
    assert given == pytest.approx(used, abs=2e-3 * turned_over)


@pytest.mark.parametrize(
    ("omega", "torque"), [(8.07, 0.0), (-32.3, 700.0), (32.3, -1000.0), (-16.1, -333.0), (200.0, 0.0)]
)
def test_steady_torque_is_the_nominal_equation(truth: PlantTruth, omega: float, torque: float) -> None:
    plant = Plant(quiet(truth.without_weak_orders()), seed=1)
    bring_up(plant, omega, torque)
    revolutions = max(abs(omega) / 185.0 * 4.0 / (2 * np.pi), 0.2)
    measured = plant.step(commands(4.0, omega, torque))
    at_flange = torque + np.sign(omega) * truth.load_side.bearing_friction
    expected = float(
        plant.truth.motor_torque(np.array(at_flange), np.array(omega), np.array(plant.state["temperature"]))
    )
    # (1 + TE') modulates the reaction along the angle; over part of a turn it does not average out completely
    tolerance = 3e-3 + 2e-4 * abs(torque) / 185.0 / revolutions
    assert float(measured["input_torque"].mean()) == pytest.approx(expected, abs=tolerance)


def test_shafts_stick_without_creep(truth: PlantTruth) -> None:
    plant = Plant(truth, seed=5)
    plant.step(commands(0.2))
    off = np.zeros(4000, COMMAND_DTYPE)
    off["load_mode"], off["load_enable"], off["load_torque"] = MODE_TORQUE, 1, 60.0
    plant.step(off[:2000])
    before = plant.state
    plant.step(off)
    after = plant.state
    # 60 N·m at the output are 0.32 N·m at the input shaft, below f_c
    assert after["motor_angle"] == before["motor_angle"]
    assert after["motor_velocity"] == 0.0
    assert abs(after["load_velocity"]) < 1e-5
    assert abs(after["load_angle"] - before["load_angle"]) < 1e-8
    assert after["loss_gearbox"] - before["loss_gearbox"] < 1e-6


def test_more_than_friction_holds_turns_the_unpowered_shaft(truth: PlantTruth) -> None:
    plant = Plant(truth, seed=5)
    off = np.zeros(2000, COMMAND_DTYPE)
    off["load_mode"], off["load_enable"], off["load_torque"] = MODE_TORQUE, 1, 400.0
    plant.step(off)
    assert plant.state["motor_velocity"] < -1.0


def test_power_off_coasts_to_rest_by_friction(truth: PlantTruth) -> None:
    plant = Plant(quiet(smooth(truth)), seed=1)
    bring_up(plant, 100.0, 0.0)
    start = plant.state
    off = np.zeros(round(4.0 / CYCLE), COMMAND_DTYPE)
    off["input_mode"], off["load_mode"] = MODE_VELOCITY, MODE_TORQUE
    times, speed = coast(plant, off)
    ratio, inertia = truth.gearbox.ratio, truth.input_motor.inertia
    total = inertia + truth.load_motor.inertia / ratio**2
    viscous = truth.friction.viscous + truth.friction.viscous_temperature * (start["temperature"] - 25.0)
    # the bearing's 8 N·m decelerate too, behind the gearbox: at the flange there is |τ| = f_b − J_L·deceleration
    constant = truth.friction.coulomb + truth.load_side.bearing_friction / ratio * (1 + truth.friction.load_dependent)
    stop = total / viscous * np.log1p(viscous * 100.0 / constant)
    assert times[np.flatnonzero(speed < 0.5)[0]] == pytest.approx(stop, rel=0.03)
    assert plant.state["motor_velocity"] == 0.0


def coast(plant: Plant, off: NDArray[np.void]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Run and return times and speeds every 5 ms."""
    speed: list[float] = []
    for start in range(0, off.size, 10):
        plant.step(off[start : start + 10])
        speed.append(plant.state["motor_velocity"])
    return np.arange(1.0, len(speed) + 1.0) * 10 * CYCLE, np.array(speed, dtype=np.float64)


def test_resonance_of_the_load_side(truth: PlantTruth) -> None:
    plant = Plant(replace(quiet(smooth(truth)), load_side=replace(truth.load_side, bearing_friction=0.0)), seed=1)
    plant.step(commands(0.5, 0.0, 300.0))
    release = commands(0.25, 0.0, 0.0)
    torque = np.empty(release.size)
    for i in range(release.size):
        plant.step(release[i : i + 1])
        torque[i] = plant.state["torque"]
    spectrum = np.abs(np.fft.rfft(torque[20:] * np.hanning(torque.size - 20), 1 << 16))
    peak = np.fft.rfftfreq(1 << 16, CYCLE)[200 + np.argmax(spectrum[200:])]
    behind = 1.0 / truth.load_motor.inertia
    before = 1.0 / (truth.input_motor.inertia * truth.gearbox.ratio**2)
    both_free = np.sqrt(truth.torsional_stiffness * (behind + before)) / (2 * np.pi)
    assert both_free == pytest.approx(165.7, abs=0.1)
    assert peak == pytest.approx(both_free, rel=0.005)


def test_steps_converge(truth: PlantTruth) -> None:
    def swing(substeps: int) -> NDArray[np.float64]:
        exact = replace(quiet(truth), numerics=replace(truth.numerics, substeps=substeps))
        plant = Plant(exact, seed=2)
        plant.step(ramped(0.1, 0.0, 100.0, 0.0, 800.0))
        torque = []
        for row in commands(0.03, 100.0, 0.0).reshape(-1, 2):
            plant.step(row)
            state = plant.state
            twist = state["motor_angle"] / truth.gearbox.ratio + state["te"] - state["load_angle"]
            torque.append(truth.torsional_stiffness * twist)
        return np.array(torque)

    exact = swing(64)
    errors = np.array([np.abs(swing(n) - exact).max() for n in (1, 2, 4, 8)])
    # 800 N·m let go at once, five periods of the resonance: below 2 % in the step that is used, and falling
    assert np.ptp(exact) > 800.0
    assert errors[0] < 16.0
    assert (errors[1:] < 0.6 * errors[:-1]).all()


def test_heat_balance_closed_form(truth: PlantTruth) -> None:
    # constant friction torque: no temperature in the viscous part
    fixed = replace(quiet(smooth(truth)), friction=replace(truth.friction, viscous_temperature=0.0))
    fixed = replace(fixed, heat=replace(truth.heat, capacity=50.0, resistance=0.25))
    plant = Plant(fixed, seed=1)
    bring_up(plant, 100.0, 0.0)
    first = plant.state["temperature"]
    plant.step(commands(15.0, 100.0, 0.0))
    power = (0.5 + 0.006 * 100.0 + 0.04 * 8.0 / 185.0) * 100.0
    final = 21.0 + 0.25 * power
    expected = final + (first - final) * np.exp(-15.0 / (50.0 * 0.25))
    assert plant.state["temperature"] == pytest.approx(expected, abs=0.02)


def test_further_ways_of_heat(truth: PlantTruth) -> None:
    bare = replace(quiet(smooth(truth)), friction=replace(truth.friction, viscous_temperature=0.0))
    plain = replace(truth.heat, capacity=50.0, resistance=1e9, initial=60.0, ambient=20.0)
    rest = commands(10.0)

    cooled = Plant(replace(bare, heat=replace(plain, resistance=0.2, housing_rate=0.0)), seed=1)
    cooled.step(rest)
    assert cooled.state["temperature"] == pytest.approx(20.0 + 40.0 * np.exp(-10.0 / 10.0), abs=0.02)

    drifting = Plant(replace(bare, heat=replace(plain, ambient_rate=0.1, ambient_cosine=2.0, ambient_period=20.0)))
    drifting.step(rest)
    assert drifting.state["surroundings"] == pytest.approx(20.0 + 0.1 * 10.0 - 2.0, abs=0.01)

    switched = replace(plain, ambient_change=5.0, ambient_begin=4.0, ambient_settling=3.0)
    settling = Plant(replace(bare, heat=switched))
    settling.step(commands(3.0))
    assert settling.state["surroundings"] == pytest.approx(20.0)
    settling.step(commands(7.0))
    assert settling.state["surroundings"] == pytest.approx(20.0 + 5.0 * (1.0 - np.exp(-2.0)), abs=0.01)

    # the second mass starts as warm as the first; both share what came in when the first is heated
    shared = Plant(replace(bare, heat=replace(plain, housing_rate=0.5, housing_time=1.0)), seed=1)
    shared.faults.set("heating_external", 500.0, until_s=2.0)
    shared.step(rest)
    gain = 500.0 * 2.0 / 50.0
    # k_h·τ_h = 0.5: the housing holds half of what the lubricant holds
    assert shared.state["temperature"] == pytest.approx(60.0 + gain / 1.5, abs=0.05)
    assert shared.state["housing"] == pytest.approx(shared.state["temperature"], abs=0.05)

    windy = Plant(replace(bare, heat=replace(plain, speed_cooling=0.05, speed_exponent=0.5)), seed=1)
    bring_up(windy, 25.0, 0.0)
    before = windy.state
    windy.step(commands(1.0, 25.0, 0.0))
    after = windy.state
    heat = (after["loss_gearbox"] - before["loss_gearbox"]) / 50.0
    middle = 0.5 * (before["temperature"] + after["temperature"])
    fall = 0.05 * 0.5 * (middle - 20.0)
    assert after["temperature"] - before["temperature"] == pytest.approx(heat - fall, abs=0.01)


def test_quick_stop_ramps_down_and_holds(truth: PlantTruth) -> None:
    plant = Plant(truth, seed=1)
    bring_up(plant, 100.0, 0.0)
    stop = commands(0.2, 100.0, 0.0)
    stop["input_quick_stop"] = 1
    plant.step(stop)
    assert plant.state["motor_velocity"] == pytest.approx(100.0 - 0.2 * 400.0, abs=4.0)
    plant.step(np.tile(stop, 5))
    assert abs(plant.state["motor_velocity"]) < 0.5


def test_brake_holds_after_its_delay() -> None:
    plant = Plant.from_file("rv80n", seed=1)
    rows = commands(0.5, 0.0, -300.0)  # its load drive faces the other way
    plant.step(rows)
    rows["input_enable"] = 0
    plant.step(rows)
    assert plant.state["motor_velocity"] == 0.0


@pytest.mark.parametrize("omega", [30.0, -30.0])
def test_torque_at_each_cycles_end_has_the_mean_that_accelerates_the_load(truth: PlantTruth, omega: float) -> None:
    """The transmission error changes with speed: in steps of a cycle it would shift what is read by 10 mN·m."""
    sensor = replace(truth.torque_sensor, noise=0.0, zero=0.0, rated_torque=100.0)
    plant = Plant(replace(quiet(truth), torque_sensor=sensor), seed=1)
    plant.step(ramped(0.1, 0.0, 0.1 * omega, 0.0, 0.0))
    measured = plant.step(ramped(0.7, 0.1 * omega, omega, 0.0, 0.0))
    angle = -measured["load_position"] * 2.0 * np.pi / 2.0**40
    half, at = 500, np.array([650, 750, 850])
    # the mean of an acceleration under a triangle is the second difference of the angle
    rate = (angle[at + half] - 2.0 * angle[at] + angle[at - half]) / (half * CYCLE) ** 2
    triangle = np.bartlett(2 * half + 1) / half
    torque = measured["torque_adc"] * 100.0 / 32768
    mean = np.array([triangle @ torque[i - half : i + half + 1] for i in at])
    load = truth.load_motor.inertia * rate + np.sign(omega) * truth.load_side.bearing_friction
    assert mean == pytest.approx(load, abs=2e-3)
