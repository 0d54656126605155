"""The table of hidden physics: names, parameters and what an honest report would call each.

Every kind has up to eight parameters, a row of :data:`MEMORY` numbers that it may change while the plant runs, and says
cycle by cycle what of a channel is its own (:data:`SHOWN`), which the sealed truth is made of.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fakes.plant.errors import PlantError

PARAMETERS, MEMORY = 8, 16
SHOWN = ("transmission_error", "motor_torque", "load_torque", "temperature")
TE, MOTOR, LOADED, HEAT = range(4)
DIFFERENCE = 14
"""place in the memory of a kind of heat: K that the lubricant is off for its sake"""


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of physics.

    Attributes:
        effect: id of the vocabulary, ``unknown`` where no name fits.
        channel: where it shows most. parameters: names in order, amplitude first.
        in_library: whether the analyser's library is known to have the form.
    """

    name: str
    effect: str
    channel: str
    parameters: tuple[str, ...]
    text: str
    in_library: bool = False


def _rows() -> tuple[Kind, ...]:
    te, motor, load, heat = SHOWN

    def row(name: str, effect: str, channel: str, parameters: str, text: str, in_library: bool = False) -> Kind:
        return Kind(name, effect, channel, tuple(parameters.split()), text, in_library)

    return (
        # transmission error: shape of the kinematic error
        row("harmonic", "te.harmonic", te, "amplitude order phase by_load", "an order beside the series", True),
        row("sideband", "te.sideband", te, "amplitude order phase beat beat_phase", "order modulated", True),
        row("defect", "te.local_defect", te, "height sharpness angle", "pulse of one pin per revolution"),
        row("resonance", "te.resonance", te, "gain frequency damping", "series drives a second-order resonator"),
        row("creep", "te.drift_time", te, "amplitude time", "settles exponentially with time", True),
        row("log_creep", "te.drift_time", te, "amplitude time", "creeps with the logarithm of time"),
        row("film", "te.velocity_nonlinear", te, "amplitude speed", "film, exponential in speed", True),
        row("film_rational", "te.velocity_nonlinear", te, "amplitude speed", "film, rational in speed squared"),
        row("warm_step", "te.temperature_nonlinear", te, "amplitude centre width", "seat that gives way when warm"),
        row("cage", "unknown", te, "amplitude order slip load", "cage that slips where the load is small"),
        # transmission error: twist that the torque makes
        row("lost_arctan", "te.lost_motion", te, "amplitude torque", "lost motion, arctan of torque", True),
        row("lost_root", "te.lost_motion", te, "amplitude torque", "lost motion, τ/√(τ² + τ_c²)", True),
        row("hardening", "te.stiffness_nonlinear", te, "amplitude torque", "softening, cube of torque", True),
        row("second_spring", "te.stiffness_nonlinear", te, "amplitude torque", "spring that gives beyond a torque"),
        row("play_pair", "te.hysteresis", te, "amplitude narrow wide", "Maxwell slip: two plays in torque"),
        row("bouc_wen", "te.hysteresis", te, "amplitude torque", "Bouc–Wen twist"),
        row("squeeze", "unknown", te, "gap mobility", "play that the load torque crosses through an oil film"),
        row("mullins", "unknown", te, "amplitude torque", "softer for ever where the torque has once been"),
        # friction at the input shaft
        row("stribeck", "friction.stribeck", motor, "amplitude speed power", "Stribeck exp(−(ω/ω_s)^n)", True),
        row("stribeck_rational", "friction.stribeck", motor, "amplitude speed power", "Stribeck 1/(1 + (ω/ω_s)^n)"),
        row("viscosity", "friction.viscous_temperature", motor, "amplitude span", "viscosity, exponential", True),
        row("viscosity_vogel", "friction.viscous_temperature", motor, "amplitude span", "viscosity after Vogel"),
        row("churning", "friction.viscous_quadratic", motor, "amplitude power", "churning, power of speed"),
        row("tight_wave", "friction.position_dependent", motor, "amplitude order phase", "drag over the angle", True),
        row("tight_spot", "friction.position_dependent", motor, "amplitude sharpness angle", "one tight spot"),
        row("run_in", "friction.run_in", motor, "amplitude distance", "wears in, exponential in distance", True),
        row("run_in_power", "friction.run_in", motor, "amplitude distance", "wears in, power of distance"),
        row("dahl", "friction.presliding", motor, "amplitude angle", "Dahl", True),
        row("lugre", "friction.presliding", motor, "amplitude angle boost speed", "LuGre with Stribeck's curve", True),
        row("maxwell", "friction.presliding", motor, "amplitude angle", "generalised Maxwell slip, four elements"),
        row("flash", "unknown", motor, "amplitude softening capacity time", "film that heats, thins and slows"),
        row("thixotropy", "unknown", motor, "amplitude healing breaking", "grease broken in motion, healed at rest"),
        row("dry_lip", "unknown", motor, "amplitude dry wet", "lip dried one way, wetted the other"),
        row("scraper", "unknown", motor, "amplitude reach", "scraper that sticks and snaps, never the same"),
        row("preload", "unknown", motor, "amplitude time", "bearing preloaded while the shaft is hotter"),
        row("sump", "unknown", motor, "amplitude speed time", "oil thrown out of the sump flows back slowly"),
        row("one_sided", "unknown", motor, "amplitude load", "drag falls with load in one direction"),
        # motor
        row("ripple", "motor.torque_ripple", motor, "amplitude phase", "sixth electrical harmonic", True),
        row("torque_gain", "motor.torque_constant", motor, "gain", "torque constant off", True),
        row("saturation", "motor.torque_constant", motor, "gain torque", "magnetic saturation"),
        row("hot_magnets", "unknown", motor, "gain heating time", "magnets weaken with the winding's own heat"),
        # load side
        row("unbalance_behind", "load.unbalance", load, "amplitude phase", "mass behind the torque sensor", True),
        row("unbalance_before", "load.unbalance", motor, "amplitude phase", "mass before the torque sensor", True),
        row("eddy", "unknown", load, "amplitude speed", "eddy-current drag of the load motor"),
        row("hose", "unknown", load, "amplitude reach", "hose that is dragged along: spring that slips"),
        row("floor", "unknown", load, "amplitude frequency", "a machine next door shakes the load motor"),
        # heat
        row("lag", "thermal.sensor_lag", heat, "time", "PT100 behind its pocket", True),
        row("lag_twice", "thermal.sensor_lag", heat, "time second", "PT100 in a sleeve: two lags"),
        row("housing", "thermal.second_mass", heat, "rate time", "housing coupled to the lubricant", True),
        row("room", "thermal.ambient_drift", heat, "slope", "room that warms, K/h", True),
        row("room_wave", "thermal.ambient_drift", heat, "amplitude period", "air conditioning that swings"),
        row("fan", "thermal.convection_speed", heat, "rate power", "cooling grows with speed"),
        row("latent", "unknown", heat, "capacity centre width", "latent heat of the grease"),
        row("copper", "unknown", heat, "power", "copper loss of the load motor"),
        # sensors
        row("eccentric", "sensor.motor_encoder", te, "amplitude phase second", "eccentric motor encoder", True),
        row("delay", "sensor.timing_skew", load, "cycles", "torque channel late by whole cycles", True),
        row("zero_warm", "sensor.torque_zero_temperature", load, "slope", "zero drifts with temperature", True),
        row("gain", "sensor.torque_gain", load, "gain", "gain of the torque sensor", True),
        row("curved", "sensor.torque_nonlinearity", load, "amplitude", "curvature of the torque sensor", True),
        row("lagging_gauge", "sensor.torque_hysteresis", load, "amplitude torque", "sensor's own hysteresis"),
    )  # fmt: skip


KINDS: dict[str, Kind] = {kind.name: kind for kind in _rows()}
NUMBER: dict[str, int] = {name: number for number, name in enumerate(KINDS)}
"""code of each kind in the compiled equations"""


@dataclass(frozen=True, slots=True)
class Hidden:
    """One kind with its numbers, SI units (temperatures in °C or K)."""

    kind: str
    parameters: tuple[float, ...]

    @property
    def definition(self) -> Kind:
        """Its row of the table."""
        return KINDS[self.kind]


def read(row: Any, where: str) -> Hidden:
    """Read a row of a plant file: ``kind`` and every parameter by name.

    Raises:
        PlantError: an unknown kind, or a parameter missing, unknown or no number.
    """
    if not isinstance(row, Mapping) or row.get("kind") not in KINDS:
        raise PlantError(f"{where}: kind must be one of {', '.join(KINDS)}")
    kind = KINDS[str(row["kind"])]
    given = {key: value for key, value in row.items() if key != "kind"}
    if set(given) != set(kind.parameters):
        raise PlantError(f"{where}: {kind.name} has the parameters {', '.join(kind.parameters)}")
    for key, value in given.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise PlantError(f"{where}: {key} = {value!r} must be a number")
    return Hidden(kind.name, tuple(float(given[name]) for name in kind.parameters))


HiddenArrays = tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
"""kinds (n,), parameters (n, 8), memory (n, 16), shown (n, 4)"""


def arrays(hidden: tuple[Hidden, ...]) -> HiddenArrays:
    """Return room for the compiled equations; the memory begins with zeros."""
    count = len(hidden)
    parameters = np.zeros((count, PARAMETERS))
    for row, one in zip(parameters, hidden, strict=True):
        row[: len(one.parameters)] = one.parameters
    numbers = np.array([NUMBER[one.kind] for one in hidden], dtype=np.int64)
    return numbers, parameters, np.zeros((count, MEMORY)), np.zeros((count, len(SHOWN)))
