"""The nominal equations of the bench with true parameters drawn at random.

Written from the equations of the bench description alone, for the examiner's own use: the analyser's simulation is
not consulted, so that one mistake cannot hide in both.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]

RATIO = 185.0
ORDERS: tuple[int, ...] = (1, 3, 6, 9, 13, 14, 18, 19, 27, 4, 12, 46, 92, 138, 184, 276, 24, 90, 135, 180)
#: Notched by every analysis: torque ripple of the load motor (6 and 12 times 25 pole pairs).
LOAD_RIPPLE_ORDERS: tuple[int, ...] = (150, 300)
#: The polynomials hold within the campaign; beyond, nature saturates (torque N·m, rate rad/s, temperature °C).
_BOUNDS = ((-1150.0, 1150.0), (-0.2, 0.2), (0.0, 100.0))
"""beyond which the polynomials are not followed: a warm-up runs five times as fast as any point that is compared. No
bench gets as cold or as hot: a kink at a temperature that is reached would be physics that no truth tells
"""
_CENTRE = np.array([0.0, 0.0, 35.0])
_SPAN = np.array([1000.0, 0.17, 15.0])


@dataclass(frozen=True, slots=True)
class Plant:
    """True parameters of one bench.

    Attributes:
        orders: (K,) orders of the series; the nominal ones first, weak ones that no simulation knows after them.
        amplitude, phase: (2, K, 10) coefficients (rad) of the quadratic polynomials in scaled torque, rate and
            temperature, for direction negative (0) and positive (1).
        offset: (2, 10) the same for a₀ (rad), compliance included.
        f_c … load_zero: input friction, heat and load side in SI units, named as in the equations.
        ripple: (2,) amplitudes in N·m and (2,) phases of the load motor's ripple.
    """

    orders: Floats
    amplitude: Floats
    phase: Floats
    offset: Floats
    f_c: float
    f_v: float
    f_vt: float
    f_l: float
    inertia: float
    torque_offset: float
    heat_capacity: float
    heat_resistance: float
    ambient: float
    f_b: float
    load_inertia: float
    load_zero: float
    ripple: Floats
    ripple_phase: Floats


def draw_plant(rng: np.random.Generator) -> Plant:
    """A bench as no other: every nominal parameter off its assumed value, within what is physically plausible."""

    def around(value: float, spread: float) -> float:
        return float(value * np.exp(rng.normal(0.0, spread)))

    shape = (2, len(ORDERS), 10)
    order = np.array(ORDERS, dtype=np.float64)
    size = 28e-6 / (1.0 + (order / 40.0) ** 0.6) * np.exp(rng.normal(0.0, 0.5, len(ORDERS)))
    amplitude = np.zeros(shape)
    phase = np.zeros(shape)
    common = rng.uniform(-np.pi, np.pi, len(ORDERS))
    for d in range(2):
        amplitude[d, :, 9] = size * rng.uniform(0.8, 1.2, len(ORDERS))
        amplitude[d, :, :9] = size[:, None] * rng.normal(0.0, 1.0, (len(ORDERS), 9)) * _influence(0.10)
        phase[d, :, 9] = common + rng.normal(0.0, 0.25, len(ORDERS))
        phase[d, :, :9] = rng.normal(0.0, 1.0, (len(ORDERS), 9)) * _influence(0.12)
    offset = np.zeros((2, 10))
    stiffness = around(4e6, 0.25)
    for d, sign in enumerate((-1.0, 1.0)):
        offset[d] = rng.normal(0.0, 6e-6, 10)
        offset[d, 3] = -_SPAN[0] / stiffness
        offset[d, 9] += 2e-5 - sign * around(3e-5, 0.3)
    return Plant(
        orders=order,
        amplitude=amplitude,
        phase=phase,
        offset=offset,
        f_c=around(0.5, 0.3),
        f_v=around(0.006, 0.25),
        f_vt=-around(1e-4, 0.25),
        f_l=around(0.04, 0.3),
        inertia=around(0.0029, 0.15),
        torque_offset=float(rng.normal(0.0, 0.03)),
        heat_capacity=around(8.5e3, 0.25),
        heat_resistance=around(0.30, 0.2),
        ambient=float(rng.uniform(18.5, 24.0)),
        f_b=around(8.0, 0.3),
        load_inertia=around(3.0, 0.15),
        load_zero=float(rng.normal(0.0, 4.0)),
        ripple=np.array([around(5.0, 0.4), around(2.5, 0.4)]),
        ripple_phase=rng.uniform(-np.pi, np.pi, 2),
    )


def elsewhere(plant: Plant, rng: np.random.Generator) -> Plant:
    """Another laboratory's bench: a worn or a better gearbox, lighter oil, another motor, more or less ripple."""

    def by(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    wear = by(0.5, 2.5)
    return replace(
        plant,
        amplitude=plant.amplitude * wear,
        f_c=plant.f_c * by(0.5, 2.0),
        f_v=plant.f_v * by(0.6, 1.6),
        f_l=plant.f_l * by(0.4, 1.8),
        inertia=plant.inertia * by(0.7, 1.6),
        heat_capacity=plant.heat_capacity * by(0.8, 1.8),
        f_b=plant.f_b * by(0.4, 2.5),
        load_inertia=plant.load_inertia * by(0.5, 3.0),
        ripple=plant.ripple * by(0.3, 2.0),
    )


def _influence(level: float) -> Floats:
    """Relative influence of x², y², z², x, y, z, xy, xz, yz on an amplitude or a phase."""
    return level * np.array([0.35, 0.3, 0.2, 1.0, 0.8, 0.7, 0.3, 0.25, 0.25])


@njit(cache=True)
def _basis(x: float, y: float, z: float, out: Floats) -> None:
    out[0], out[1], out[2] = x * x, y * y, z * z
    out[3], out[4], out[5] = x, y, z
    out[6], out[7], out[8] = x * y, x * z, y * z
    out[9] = 1.0


@njit(cache=True)
def _transmission(
    theta: Floats,
    side: NDArray[np.int64],
    x: Floats,
    orders: Floats,
    amplitude: Floats,
    phase: Floats,
    offset: Floats,
    gain: Floats,
    shift: Floats,
    out: Floats,
) -> None:
    basis = np.empty(10)
    for n in range(theta.size):
        _basis(x[0, n], x[1, n], x[2, n], basis)
        d = side[n]
        total = 0.0
        for i in range(10):
            total += offset[d, i] * basis[i]
        for k in range(orders.size):
            a = 0.0
            p = 0.0
            for i in range(10):
                a += amplitude[d, k, i] * basis[i]
                p += phase[d, k, i] * basis[i]
            if gain.shape[1] > 0:
                a *= 1.0 + gain[k, n]
                p += shift[k, n]
            total += a * np.cos(orders[k] * theta[n] - p)
        out[n] = total


def transmission_error(
    plant: Plant,
    theta: Floats,
    side: NDArray[np.int64],
    torque: Floats,
    rate: Floats,
    temperature: Floats,
    modulation: tuple[Floats, Floats] | None = None,
) -> Floats:
    """The nominal transmission error (N,) in rad.

    ``side`` (N,) is 0 for negative and 1 for positive direction (the last one at standstill). ``modulation`` is a
    relative gain and a phase lag, each (K, N), by which an effect may change the orders.
    """
    scaled = np.empty((3, theta.size))
    for row, values in enumerate((torque, np.abs(rate), temperature)):
        low, high = _BOUNDS[row]
        scaled[row] = (np.clip(values, low, high) - _CENTRE[row]) / _SPAN[row]
    if modulation is None:
        modulation = (np.empty((plant.orders.size, 0)), np.empty((plant.orders.size, 0)))
    out = np.empty(theta.size)
    _transmission(
        theta, side, scaled, plant.orders, plant.amplitude, plant.phase, plant.offset, modulation[0], modulation[1], out
    )
    return out


def nominal_motor_torque(
    plant: Plant, torque: Floats, motor_rate: Floats, motor_acceleration: Floats, temperature: Floats, sign: Floats
) -> Floats:
    """Equation 2 of the nominal simulation: the input motor's torque (N,) in N·m."""
    friction = plant.f_c + plant.f_l * np.abs(torque) / RATIO
    viscous = plant.f_v + plant.f_vt * (temperature - 25.0)
    return (
        torque / RATIO
        + sign * friction
        + viscous * motor_rate
        + plant.inertia * motor_acceleration
        + plant.torque_offset
    )


@njit(cache=True)
def heat_up(
    start: Floats,
    step: float,
    power: Floats,
    conductance: Floats,
    ambient: Floats,
    capacity: float,
    house_capacity: float,
    house_link: float,
    extra_capacity: Floats,
) -> Floats:
    """Temperatures (N + 1, 2) of lubricant and housing by explicit Euler steps of ``step`` seconds.

    With ``house_capacity`` 0 the lubricant itself faces the surroundings (equation 3); else the housing does.
    ``extra_capacity`` is (height J/K, centre °C, width K) of a bump in the lubricant's heat capacity.
    """
    out = np.empty((power.size + 1, 2))
    out[0] = start
    for n in range(power.size):
        lubricant, house = out[n, 0], out[n, 1]
        c = capacity + extra_capacity[0] * np.exp(-(((lubricant - extra_capacity[1]) / extra_capacity[2]) ** 2))
        if house_capacity > 0.0:
            flow = house_link * (lubricant - house)
            out[n + 1, 0] = lubricant + step * (power[n] - flow) / c
            out[n + 1, 1] = house + step * (flow - conductance[n] * (house - ambient[n])) / house_capacity
        else:
            out[n + 1, 0] = lubricant + step * (power[n] - conductance[n] * (lubricant - ambient[n])) / c
            out[n + 1, 1] = out[n + 1, 0]
    return out
