"""The plant truth: every value the emulated bench obeys, read from a TOML file of its own.

Nothing outside the fakes and their tests reads it: an analysis sees recordings only.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, replace
from importlib import resources
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

import numpy as np

from fakes.plant.errors import PlantError
from fakes.plant.hidden.kinds import Hidden
from fakes.plant.hidden.kinds import read as read_hidden
from fakes.plant.parts import (
    Drive,
    Effect,
    Encoder,
    Friction,
    Gearbox,
    Heat,
    LoadSide,
    Motor,
    Numerics,
    Pt100,
    Ripple,
    TorqueSensor,
)
from fakes.plant.transmission import Box, FloatArray, Scale, TransmissionError

FORMAT = "emulated-plant"
_T = TypeVar("_T")


_NOT_TABLES = ("name", "ripple", "transmission_error", "effects", "laws", "hidden", "ledger")
"""fields that are no table of a plant file"""


@dataclass(frozen=True, slots=True)
class PlantTruth:
    """True values of a bench."""

    name: str
    gearbox: Gearbox
    friction: Friction
    heat: Heat
    input_motor: Motor
    load_motor: Motor
    input_drive: Drive
    load_drive: Drive
    input_encoder: Encoder
    load_encoder: Encoder
    torque_sensor: TorqueSensor
    lubricant_sensor: Pt100
    ambient_sensor: Pt100
    load_side: LoadSide
    ripple: tuple[Ripple, ...]
    transmission_error: TransmissionError
    numerics: Numerics = field(default_factory=Numerics)
    effects: tuple[Effect, ...] = ()
    """terms of the physics library played on top; only a plant that runs a simulation file has any"""
    laws: tuple[Any, ...] = ()
    """laws (bench.simulation.laws) that the amplitudes of the orders follow, where a simulation file brings them"""
    hidden: tuple[Hidden, ...] = ()
    """physics of its own beyond the nominal equations"""
    ledger: str = ""
    """file that takes what of each channel is the hidden physics', for a sealed truth; empty for none"""

    @classmethod
    def from_file(cls, name: str | Path) -> PlantTruth:
        """Read a plant file: a path, or the name of one that ships (``rh380n``).

        Raises:
            PlantError: the file is missing or a key is unknown, missing or of the wrong type.
        """
        path = Path(name)
        if path.suffix != ".toml":
            path = Path(str(resources.files("fakes") / "plants" / f"{name}.toml"))
        if not path.is_file():
            raise PlantError(
                f"there is no plant file {name}; name one that ships ({', '.join(shipped())}) or a .toml file"
            )
        with path.open("rb") as file:
            try:
                table = tomllib.load(file)
            except tomllib.TOMLDecodeError as error:
                raise PlantError(f"plant file {path} is not TOML: {error}") from error
        return cls.from_table(table, str(path))

    @classmethod
    def from_table(cls, table: Mapping[str, Any], where: str = "plant") -> PlantTruth:
        """Build the truth from a parsed plant file."""
        rest = dict(table)
        if rest.pop("format", None) != FORMAT:
            raise PlantError(f'{where}: key "format" must be "{FORMAT}"')
        if "simulation" in rest:
            return _of_simulation(rest, where)
        hints = get_type_hints(cls)
        values: dict[str, Any] = {"name": rest.pop("name", Path(where).stem)}
        for name in (f.name for f in fields(cls)):
            if name in _NOT_TABLES or (name == "numerics" and name not in rest):
                continue
            values[name] = _part(hints[name], rest.pop(name, None), f"{where}: {name}")
        values["ripple"] = tuple(
            _part(Ripple, row, f"{where}: ripple {i + 1}") for i, row in enumerate(rest.pop("ripple", []))
        )
        values["transmission_error"] = _transmission_error(
            rest.pop("transmission_error", None), f"{where}: transmission_error"
        )
        values["hidden"] = tuple(
            read_hidden(row, f"{where}: hidden {i + 1}") for i, row in enumerate(rest.pop("hidden", []))
        )
        if rest:
            raise PlantError(f"{where}: unknown key {next(iter(rest))!r}")
        return cls(**values)

    @property
    def torsional_stiffness(self) -> float:
        """Gearbox and coupling in series, as the load encoder sees them, N·m/rad: the elastic part of a_0 is −τ/K."""
        return 1.0 / (1.0 / self.gearbox.stiffness + 1.0 / self.load_side.coupling_stiffness)

    def without_weak_orders(self) -> PlantTruth:
        """Return the same bench with only the orders that the paper's model has."""
        return replace(self, transmission_error=self.transmission_error.without_weak_orders())

    def te_coefficients(self) -> dict[str, dict[str, Mapping[str, list[float]] | list[float]]]:
        """Return the true series, weak orders included, in the paper's form and units (N·m, rad/s, °C, rad).

        ``{"positive": {"46": {"A": [10], "phi": [10]}, …, "a0": [10]}, "negative": …}`` as in a simulation file; a_0
        holds the elastic part −τ/K of gearbox and coupling.
        """
        return self.transmission_error.coefficients(self.torsional_stiffness)

    def nominal_parameters(self) -> dict[str, dict[str, float]]:
        """Return the true parameters of the nominal simulation's terms, by effect and symbol, in SI units and °C."""
        friction, heat = self.friction, self.heat
        return {
            "friction.coulomb": {"f_c": friction.coulomb},
            "friction.viscous": {"f_v": float(self._viscous(25.0))},
            "friction.viscous_temperature_linear": {"f_vT": friction.viscous_temperature},
            "friction.load_dependent": {"f_l": friction.load_dependent},
            "motor.inertia": {"J": self.input_motor.inertia},
            "motor.torque_offset": {"tau_0": self.input_motor.torque_offset},
            "thermal.loss_heating": {"C": heat.capacity},
            "thermal.convection": {"R": heat.resistance, "T_amb": heat.ambient},
            "load.bearing_friction": {"f_b": self.load_side.bearing_friction},
            "load.inertia": {"J_L": self.load_motor.inertia},
            "load.torque_offset": {"z_0": self.torque_sensor.zero},
        }

    def _viscous(self, temperature: FloatArray | float) -> FloatArray:
        """Return the viscous coefficient at a temperature, N·m·s/rad."""
        friction = self.friction
        linear = friction.viscous + friction.viscous_temperature * (temperature - friction.reference_temperature)
        lowest: FloatArray = np.maximum(linear, friction.minimum_viscous_share * friction.viscous)
        return lowest

    def te(self, theta: FloatArray, torque: FloatArray, velocity: FloatArray, temperature: FloatArray) -> FloatArray:
        """Return the noise-free transmission error q − θ in rad of steady motion (see TransmissionError.evaluate)."""
        return self.transmission_error.evaluate(theta, torque, velocity, temperature, self.torsional_stiffness)

    def motor_torque(self, torque: FloatArray, motor_velocity: FloatArray, temperature: FloatArray) -> FloatArray:
        """Return the input motor's torque of steady motion, N·m (equation 2 with ω̇ = 0)."""
        friction = self.friction
        ratio = self.gearbox.ratio
        direction = np.sign(motor_velocity)
        constant = direction * (friction.coulomb + friction.load_dependent * np.abs(torque) / ratio)
        total: FloatArray = (
            torque / ratio + constant + self._viscous(temperature) * motor_velocity + self.input_motor.torque_offset
        )
        return total


def shipped() -> tuple[str, ...]:
    """Return the names of the plant files that ship."""
    folder = resources.files("fakes") / "plants"
    return tuple(sorted(Path(item.name).stem for item in folder.iterdir() if item.name.endswith(".toml")))


def _of_simulation(table: Mapping[str, Any], where: str) -> PlantTruth:
    """Read a plant file that plays a simulation file (``simulation``) on the hardware of another plant (``base``)."""
    # the reader of simulation files brings the analyser's library with it: only plants that ask for it pay
    from fakes.plant.simulation import simulated

    if set(table) - {"name", "simulation", "base"}:
        raise PlantError(f'{where}: beside "simulation" there may be "base" and "name" only')
    path = Path(where).parent / str(table["simulation"])
    return simulated(path, PlantTruth.from_file(str(table.get("base", "rh380n"))))


def _part(kind: type[_T], table: Any, where: str) -> _T:
    """Build one part's dataclass; every key must be known, numbers must be numbers."""
    if not isinstance(table, Mapping):
        raise PlantError(f"{where}: the table is missing")
    hints = get_type_hints(kind)
    values: dict[str, Any] = {}
    for key, value in table.items():
        if key not in hints:
            raise PlantError(f"{where}: unknown key {key!r}; known are {', '.join(hints)}")
        whole = hints[key] is int
        if isinstance(value, bool) or not isinstance(value, int if whole else (int, float)):
            raise PlantError(f"{where}: {key} = {value!r} must be {'an integer' if whole else 'a number'}")
        values[key] = value if whole else float(value)
    for f in fields(kind):  # type: ignore[arg-type]
        if f.name not in values and f.default is MISSING:
            raise PlantError(f"{where}: key {f.name!r} is missing")
    return kind(**values)


def _polynomial(row: Any, where: str) -> list[float]:
    """Return ten coefficients."""
    if not isinstance(row, Sequence) or len(row) != 10 or not all(isinstance(v, int | float) for v in row):
        raise PlantError(f"{where} must be a list of ten numbers (the paper's terms 1 to 10)")
    return [float(v) for v in row]


def _transmission_error(table: Any, where: str) -> TransmissionError:
    """Read the series: ``scale``, ``box``, ``a0``, ``order`` rows, and ``weak_order`` rows where ``weak_orders``."""
    if not isinstance(table, Mapping):
        raise PlantError(f"{where}: the table is missing")
    known = {"scale", "box", "a0", "order", "weak_order", "weak_orders"}
    if set(table) - known:
        raise PlantError(
            f"{where}: unknown key {sorted(set(table) - known)[0]!r}; known are {', '.join(sorted(known))}"
        )
    scale = _part(Scale, table.get("scale"), f"{where}.scale")
    box = table.get("box", {})
    rows = [(row, False) for row in table.get("order", [])]
    if table.get("weak_orders", False):
        rows += [(row, True) for row in table.get("weak_order", [])]
    rows.sort(key=lambda item: float(item[0]["order"]))
    amplitude, phase = np.zeros((2, 2, len(rows), 10))
    for i, (row, _) in enumerate(rows):
        for d, direction in enumerate(("positive", "negative")):
            for key, target in (("A", amplitude), ("phi", phase)):
                label = f"{where}: order {row['order']}, {direction}.{key}"
                target[d, i] = scale.to_raw(np.array(_polynomial(row.get(direction, {}).get(key), label)))
    a0 = table.get("a0", {})
    offset = np.array([_polynomial(a0.get(d), f"{where}: a0.{d}") for d in ("positive", "negative")])
    return TransmissionError(
        orders=np.array([float(row["order"]) for row, _ in rows]),
        amplitude=1e-6 * amplitude,
        phase=phase,
        offset=1e-6 * scale.to_raw(offset),
        weak=np.array([weak for _, weak in rows], dtype=np.bool_),
        box=Box(*(_bounds(box.get(key), f"{where}.box.{key}") for key in ("torque", "velocity", "temperature"))),
    )


def _bounds(pair: Any, where: str) -> tuple[float, float]:
    """Return lower and upper bound."""
    if not isinstance(pair, Sequence) or len(pair) != 2 or not float(pair[0]) < float(pair[1]):
        raise PlantError(f"{where} must be [lower, upper]")
    return float(pair[0]), float(pair[1])
