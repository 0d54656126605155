"""Draw a plant from a seed: a bench of its own values, weak orders as by default, physics that nobody announces."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from fakes.plant.errors import PlantError
from fakes.plant.hidden.kinds import KINDS, Hidden
from fakes.plant.truth import PlantTruth

Range = tuple[float, float]
_ANGLE: Range = (-math.pi, math.pi)
#: Ranges that the parameters of each kind are drawn from, in their order; the first, its size, by its logarithm. Sizes
#: are such that the physics shows above the sensors' noise somewhere in a campaign, not more.
RANGES: dict[str, tuple[Range, ...]] = {
    "harmonic": ((3e-6, 1.2e-5), (29.0, 83.0), _ANGLE, (0.0, 0.4)),
    "sideband": ((3e-6, 1.2e-5), (46.0, 46.0), _ANGLE, (1.0, 1.0), _ANGLE),
    "defect": ((1e-5, 3e-5), (300.0, 1200.0), _ANGLE),
    "resonance": ((0.3, 0.8), (9.0, 22.0), (0.05, 0.2)),
    "creep": ((8e-6, 3e-5), (400.0, 1500.0)),
    "log_creep": ((3e-6, 1e-5), (60.0, 200.0)),
    "film": ((8e-6, 3e-5), (0.02, 0.06)),
    "film_rational": ((8e-6, 3e-5), (0.02, 0.06)),
    "warm_step": ((6e-6, 2e-5), (28.0, 38.0), (1.5, 4.0)),
    "cage": ((4e-6, 1.2e-5), (31.0, 41.0), (0.02, 0.08), (100.0, 300.0)),
    "lost_arctan": ((1e-5, 4e-5), (25.0, 90.0)),
    "lost_root": ((1e-5, 4e-5), (25.0, 90.0)),
    "hardening": ((8e-6, 3e-5), (700.0, 1000.0)),
    "second_spring": ((2e-5, 8e-5), (350.0, 650.0)),
    "play_pair": ((5e-6, 2e-5), (20.0, 60.0), (90.0, 200.0)),
    "bouc_wen": ((5e-6, 2e-5), (50.0, 200.0)),
    "squeeze": ((6e-6, 2e-5), (3e-9, 2e-8)),
    "mullins": ((1.5e-5, 5e-5), (300.0, 800.0)),
    "stribeck": ((0.06, 0.25), (3.0, 9.0), (1.0, 2.0)),
    "stribeck_rational": ((0.06, 0.25), (3.0, 9.0), (1.0, 2.0)),
    "viscosity": ((0.003, 0.01), (6.0, 14.0)),
    "viscosity_vogel": ((0.003, 0.01), (600.0, 1100.0)),
    "churning": ((1e-4, 3e-4), (2.0, 2.3)),
    "tight_wave": ((0.04, 0.15), (1.0, 3.0), _ANGLE),
    "tight_spot": ((0.06, 0.2), (3.0, 9.0), _ANGLE),
    "run_in": ((0.08, 0.3), (20.0, 80.0)),
    "run_in_power": ((0.08, 0.3), (4.0, 15.0)),
    "dahl": ((0.1, 0.3), (1.0, 4.0)),
    "lugre": ((0.1, 0.3), (1.0, 4.0), (0.3, 0.8), (3.0, 9.0)),
    "maxwell": ((0.1, 0.3), (1.0, 4.0)),
    "flash": ((0.004, 0.012), (0.04, 0.1), (8.0, 30.0), (8.0, 30.0)),
    "thixotropy": ((0.08, 0.3), (150.0, 600.0), (5e-4, 3e-3)),
    "dry_lip": ((0.08, 0.3), (2.0, 8.0), (2.0, 8.0)),
    "scraper": ((0.06, 0.2), (8.0, 40.0)),
    "preload": ((0.03, 0.1), (200.0, 700.0)),
    "sump": ((0.003, 0.01), (10.0, 30.0), (40.0, 200.0)),
    "one_sided": ((0.08, 0.3), (200.0, 500.0)),
    "ripple": ((0.03, 0.1), _ANGLE),
    "torque_gain": ((0.02, 0.06),),
    "saturation": ((0.05, 0.2), (3.0, 7.0)),
    "hot_magnets": ((0.03, 0.1), (0.03, 0.1), (60.0, 300.0)),
    "unbalance_behind": ((2.0, 10.0), _ANGLE),
    "unbalance_before": ((10.0, 40.0), _ANGLE),
    "eddy": ((3.0, 10.0), (0.04, 0.1)),
    "hose": ((4.0, 15.0), (0.3, 1.5)),
    "floor": ((1.5, 6.0), (2.0, 9.0)),
    "lag": ((8.0, 40.0),),
    "lag_twice": ((6.0, 30.0), (4.0, 15.0)),
    "housing": ((3e-4, 1.5e-3), (150.0, 700.0)),
    "room": ((2.0, 8.0),),
    "room_wave": ((1.5, 5.0), (600.0, 1500.0)),
    "fan": ((5e-5, 2e-4), (0.5, 1.0)),
    "latent": ((8e3, 3e4), (27.0, 34.0), (1.5, 3.0)),
    "copper": ((60.0, 200.0),),
    "eccentric": ((1e-3, 4e-3), _ANGLE, (0.0, 0.4)),
    "delay": ((2.0, 10.0),),
    "zero_warm": ((0.15, 0.6),),
    "gain": ((0.005, 0.02),),
    "curved": ((2.0, 10.0),),
    "lagging_gauge": ((1.0, 4.0), (50.0, 250.0)),
}
WHOLE = frozenset(("order", "cycles", "beat"))
"""parameters that are whole numbers"""
_EITHER_SIGN = frozenset(
    (
        *("harmonic", "sideband", "creep", "log_creep", "film", "film_rational", "warm_step", "cage", "hardening"),
        *("unbalance_behind", "floor", "torque_gain", "zero_warm", "gain", "curved"),
    )
)
"""kinds whose size may be negative: play, a loop or a drag that is negative would drive the bench"""


def draw(kind: str, rng: np.random.Generator) -> Hidden:
    """Draw the numbers of one kind.

    Raises:
        PlantError: there is no such kind.
    """
    if kind not in KINDS:
        raise PlantError(f"there is no hidden physics {kind!r}; there are {', '.join(KINDS)}")
    definition = KINDS[kind]
    values = []
    for number, (name, (low, high)) in enumerate(zip(definition.parameters, RANGES[kind], strict=True)):
        value = low * (high / low) ** rng.random() if number == 0 else rng.uniform(low, high)
        values.append(float(round(value)) if name in WHOLE else float(value))
    if kind in _EITHER_SIGN and rng.random() < 0.5:
        values[0] = -values[0]
    return Hidden(kind, tuple(values))


def draw_plant(base: PlantTruth, seed: int, count: int | None = None) -> PlantTruth:
    """Draw the bench of a seed: friction, heat and offsets other than the base's, ``count`` kinds of hidden physics.

    Without a count there are none, one (mostly), two or three; never two that an analysis could not tell apart even
    where it knew the forms (one kind of an effect, one unknown a channel).
    """
    rng = np.random.default_rng([seed, 1515])
    if count is None:
        count = int(rng.choice([0, 1, 2, 3], p=[0.12, 0.6, 0.2, 0.08]))
    names = list(KINDS)
    chosen: list[Hidden] = []
    while len(chosen) < count:
        kind = KINDS[names[int(rng.integers(len(names)))]]
        taken = {(one.definition.effect, one.definition.channel) for one in chosen}
        if any(effect == kind.effect for effect, _channel in taken) or (kind.effect, kind.channel) in taken:
            continue
        chosen.append(draw(kind.name, rng))
    return replace(varied_truth(base, rng), name=f"drawn from {base.name}", hidden=tuple(chosen))


def varied_truth(base: PlantTruth, rng: np.random.Generator) -> PlantTruth:
    """Return a bench of the same make with orders, friction, heat and offsets of its own."""

    def times(value: float, low: float = 0.75, high: float = 1.3) -> float:
        return float(value * rng.uniform(low, high))

    friction, heat, motor = base.friction, base.heat, base.input_motor
    series = base.transmission_error
    # each order a size and a phase of its own, the same in both directions: their polynomials keep their shape
    size = rng.uniform(0.7, 1.3, series.orders.size)
    turned = rng.uniform(-math.pi, math.pi, series.orders.size)
    phase = series.phase.copy()
    phase[:, :, 9] += turned
    return replace(
        base,
        transmission_error=replace(series, amplitude=series.amplitude * size[:, None], phase=phase),
        friction=replace(
            friction,
            coulomb=times(friction.coulomb),
            viscous=times(friction.viscous),
            viscous_temperature=times(friction.viscous_temperature),
            load_dependent=times(friction.load_dependent),
        ),
        heat=replace(
            heat,
            capacity=times(heat.capacity, 0.8, 1.2),
            resistance=times(heat.resistance, 0.8, 1.2),
            ambient=float(heat.ambient + rng.uniform(-1.5, 1.5)),
        ),
        input_motor=replace(motor, torque_offset=times(motor.torque_offset, -1.5, 1.5)),
        load_side=replace(base.load_side, bearing_friction=times(base.load_side.bearing_friction)),
        torque_sensor=replace(base.torque_sensor, zero=times(base.torque_sensor.zero, -1.5, 1.5)),
    )
