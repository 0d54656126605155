"""The transmission error of the moving plant against the truth, and the truth against the paper's form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes.plant import Plant, PlantTruth, read_plant, shipped_plants
from fakes.plant.transmission import Scale, place, rotate
from tests.fakes.plant.motion import bring_up, commands, quiet, ramped

PAPER = (1, 3, 4, 6, 9, 12, 13, 14, 18, 19, 24, 27, 46, 90, 92, 135, 138, 180, 184, 276)


@pytest.fixture(scope="module")
def truth() -> PlantTruth:
    return read_plant("rh380n")


@pytest.mark.parametrize(
    ("velocity", "torque", "temperature"), [(2.5, 0.0, 22.0), (-10.0, 500.0, 30.0), (10.0, -1000.0, 50.0)]
)
def test_measured_at_steady_motion_is_the_truth(
    truth: PlantTruth, velocity: float, torque: float, temperature: float
) -> None:
    ratio = truth.gearbox.ratio
    rate = np.deg2rad(velocity)
    still = replace(quiet(truth), heat=replace(truth.heat, initial=temperature, ambient=temperature, capacity=1e9))
    plant = Plant(still, seed=1)
    bring_up(plant, rate * ratio, torque)
    rows = plant.step(commands(2.0, rate * ratio, torque))
    theta = rows["input_position"] / 2.0**34 * 2 * np.pi / ratio
    q = -rows["load_position"] / 2.0**40 * 2 * np.pi
    at_flange = torque + np.sign(velocity) * truth.load_side.bearing_friction
    expected = still.te(theta, np.array(at_flange), np.array(rate), np.array(temperature))
    error = q - theta - expected
    assert np.std(expected) > 3e-5
    assert np.abs(error).max() < 2.5e-6  # the load side's inertia under the highest orders, and the 20 ms lag
    assert np.sqrt(np.mean(error**2)) < 1e-6


def test_orders_and_size_of_the_truth(truth: PlantTruth) -> None:
    plain = truth.without_weak_orders()
    assert tuple(plain.transmission_error.orders.astype(int)) == PAPER
    theta = np.linspace(0, 2 * np.pi, 4000, endpoint=False)
    for torque, velocity, temperature in ((0.0, 0.04, 21.0), (1000.0, 0.17, 50.0), (-1000.0, -0.04, 35.0)):
        state = np.array(torque), np.array(velocity), np.array(temperature)
        whole, part = truth.te(theta, *state), plain.te(theta, *state)
        assert 0.8e-4 < np.abs(part - part.mean()).max() < 3e-4
        assert np.std(whole - part) == pytest.approx(2.5e-5, rel=0.35)


@pytest.mark.parametrize("name", shipped_plants())
def test_amplitudes_stay_positive_in_the_box(name: str) -> None:
    series = read_plant(name).transmission_error
    grids = np.meshgrid(*(np.linspace(low, high, 9) for low, high in series.box.array()), indexing="ij")
    t, v, c = (g.ravel() for g in grids)
    basis = np.stack([t * t, v * v, c * c, t, v, c, t * v, t * c, v * c, np.ones_like(t)], axis=-1)
    for direction, sign in ((0, 1), (1, -1)):
        amplitude = basis[v * sign >= 0] @ series.amplitude[direction].T
        phase = basis[v * sign >= 0] @ series.phase[direction].T
        assert amplitude.min() > 0.0
        assert amplitude.max() < 1.5e-4
        assert np.ptp(phase, axis=0).max() < 2.5


def test_coefficients_give_the_same_in_the_simulation_library(truth: PlantTruth) -> None:
    table = truth.te_coefficients()["negative"]
    theta = np.linspace(-7, 7, 300)
    state = np.array([-640.0, -0.1, 41.0])
    t, v, c = state
    basis = np.array([t * t, v * v, c * c, t, v, c, t * v, t * c, v * c, 1.0])
    value = np.full(theta.size, basis @ np.array(table["a0"]))
    for order, part in table.items():
        if order != "a0":
            assert isinstance(part, dict)
            value += basis @ np.array(part["A"]) * np.sin(float(order) * theta + basis @ np.array(part["phi"]))
    np.testing.assert_allclose(value, truth.te(theta, *(np.array(x) for x in state)), atol=1e-15)
    slope = 2 * table["a0"][0] * t + table["a0"][3] + table["a0"][6] * v + table["a0"][7] * c  # type: ignore[index]
    assert slope == pytest.approx(-1 / truth.torsional_stiffness, rel=0.3)


@given(
    st.lists(st.floats(-5, 5), min_size=10, max_size=10),
    st.floats(-1000, 1000),
    st.floats(-0.17, 0.17),
    st.floats(20, 50),
)
def test_scaled_polynomials_become_raw_ones(
    scaled: list[float], torque: float, velocity: float, temperature: float
) -> None:
    scale = Scale(1000.0, 0.1745, 35.0, 15.0)
    x, y, z = torque / 1000.0, velocity / 0.1745, (temperature - 35.0) / 15.0
    t, v, c = torque, velocity, temperature
    here = np.array([x * x, y * y, z * z, x, y, z, x * y, x * z, y * z, 1.0])
    raw = np.array([t * t, v * v, c * c, t, v, c, t * v, t * c, v * c, 1.0])
    assert float(raw @ scale.to_raw(np.array(scaled))) == pytest.approx(float(here @ scaled), abs=1e-9)


def test_turned_orders_stay_exact() -> None:
    orders = np.array([1.0, 46.0, 276.0, 4440.0])
    sine_cosine = np.zeros((2, 4))
    theta = 1234.5
    place(sine_cosine, orders, theta)
    for change in np.full(20, 5.4e-4):
        rotate(sine_cosine, orders, change)
        theta += change
    np.testing.assert_allclose(sine_cosine, [np.sin(orders * theta), np.cos(orders * theta)], atol=2e-9)


def test_standstill_keeps_the_last_direction(truth: PlantTruth) -> None:
    plant = Plant(quiet(truth), seed=1)
    bring_up(plant, -8.0, 0.0)
    plant.step(ramped(0.5, -8.0, 0.0, 0.0, 0.0))
    plant.step(commands(1.0))
    first = plant.state
    # the drive's overshoot of a few counts may take back a little of the way
    assert first["te_weight"] == pytest.approx(-1.0, abs=0.3)
    plant.step(commands(2.0))
    assert plant.state["te_weight"] == pytest.approx(first["te_weight"], abs=1e-3)
    assert plant.state["te"] == pytest.approx(first["te"], abs=1e-8)
    bring_up(plant, 8.0, 0.0)
    assert plant.state["te_weight"] == 1.0
