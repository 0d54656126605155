"""What a column may be, from its name and its unit."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from bench.errors import ConfigurationError
from bench.importing.looking.column import Column
from bench.importing.looking.words import SET_VALUE, SIGNALS, is_effort, quantity_of
from bench.importing.units import PERCENT, si_of, unit_of

_BY_UNIT = {
    "s": "time", "rad": "angle", "m": "angle", "rad/s": "velocity", "m/s": "velocity", "N·m": "torque", "N": "torque",
    "°C": "temperature", "A": "current", "Hz": "velocity",
}  # fmt: skip
_COUNTED = re.compile(r"count|inc|inkr|tick|cts|cnt")
_ENCODER = re.compile(r"enc|drehgeber|winkelgeber|lagegeber")
COUNTS = 1000.0
"""least range of whole numbers that are taken for counts: an encoder has more of them, whole degrees are fewer"""
_MEASURED = re.compile(r"meas|actual|_act\d*$|feedback|_fb\d*$|^ist_|_ist\d*$")
_HUMP = re.compile(r"(?<=[a-z])(?=[A-Z])")
_LOAD = re.compile(
    r"load|last|abtr|_ab$|output|_out|^out|ausgang|link|joint|gelenk|arm_|secondary|sensor|messwelle|flange|flansch"
    r"|brake|bremse"
)
_MOTOR = re.compile(r"mot|antr|_an$|input|eingang|drive|primary|shaft_1")
_AMBIENT = re.compile(r"amb|room|umgeb|air|luft|raum")
_UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ß": "ss"})
_BRAKE = re.compile(r"brake|bremse|load_?mot|last_?mot")
_THIRD = re.compile(r"(^|_)az(?=\d*(_|$))")
"""the azimuth, but beside ``ax`` or ``ay`` the third of three accelerations"""


@dataclass(frozen=True, slots=True)
class Meaning:
    """What a column may be: ``quantity`` ("" unknown), on the ``load`` side, ``setpoint``, of the ``ambient`` air;
    ``sided``: its name says on which side.
    """

    quantity: str
    unit: str
    load: bool
    setpoint: bool
    ambient: bool
    brake: bool
    counted: bool
    sure: bool
    sided: bool
    measured: bool
    """its name says that it was measured"""
    effort: bool
    """its name is that of a joint's torque in ROS"""

    @property
    def of_motor(self) -> bool:
        """Whether its name says that it is on the motor's side."""
        return self.sided and not self.load


def meanings_of(columns: Sequence[Column]) -> dict[str, Meaning]:
    """Guess what each column of a file is, by its name."""
    names = {_last_part(column.variable.heading[0]).lower() for column in columns}
    meanings = {column.name: meaning(column) for column in columns}
    for column in columns:
        name = _last_part(column.variable.heading[0]).lower()
        beside = {_THIRD.sub(rf"\g<1>{axis}", name) for axis in ("ax", "ay")}
        if _THIRD.search(name) and beside & names and meanings[column.name].quantity == "angle":
            meanings[column.name] = replace(meanings[column.name], quantity="")
    return meanings


def meaning(column: Column) -> Meaning:
    """Guess what a column is; ``sure`` where its unit says the quantity and not its name alone."""
    bare, in_name = column.variable.heading
    unit = column.variable.unit or in_name
    name = _last_part(bare).lower()
    # posDes is pos_des
    words = _HUMP.sub("_", _last_part(bare)).lower()
    by_name = quantity_of(name)
    unit = _of_quantity(unit, by_name)
    by_unit = "time" if column.stamps else _by_unit(unit)
    of_encoder = _COUNTED.search(name) or (_ENCODER.search(name) and may_be_counts(column))
    named_so = of_encoder and by_name != "number"
    counted = bool(_COUNTED.search(unit.lower()) or (not unit and named_so))
    quantity = by_unit or ("angle" if counted else by_name)
    if by_unit == "time" and by_name != "time" and not column.stamps:
        quantity = by_name  # a rise time or an age is no clock
    if unit == PERCENT and by_name not in ("torque", "current"):
        quantity = "other"  # a valve's opening, say: only of a torque and a current it is known what 100 % is of
    if by_unit == "velocity" and unit in ("Hz", "1/s") and by_name != "velocity":
        quantity = ""
    if by_unit and by_name and by_unit != by_name and {by_unit, by_name} != {"current", "torque"}:
        quantity = by_unit
    as_signal = f"{by_name} in {unit if unit == PERCENT else si_of(unit)}"
    if quantity == "other" and as_signal in SIGNALS:
        quantity = as_signal
    return Meaning(
        quantity,
        unit,
        bool(_LOAD.search(name)),
        bool(SET_VALUE.search(name) or SET_VALUE.search(words)),
        bool(_AMBIENT.search(name)),
        bool(_BRAKE.search(name)),
        counted,
        bool(by_unit) and by_unit == by_name,
        bool(_LOAD.search(name) or _MOTOR.search(name)),
        bool(_MEASURED.search(words)),
        quantity == "torque" and is_effort(column.variable.name),
    )


def _last_part(bare: str) -> str:
    """What comes after the last ``/`` of a name, with ``_`` between its words: ``mot.i`` is mot_i."""
    return re.sub(r"[. ]+", "_", bare.rsplit("/", 1)[-1].strip()).strip("_")


def _of_quantity(unit: str, by_name: str) -> str:
    """The unit of a quantity, where that of its column is of another one: degrees of a temperature are those of
    Celsius, and what ends with a second is a rate of something if it is a speed.
    """
    if by_name == "temperature" and _by_unit(unit) == "angle":
        return "degC"
    return "" if by_name == "velocity" and _by_unit(unit) == "time" else unit


def may_be_counts(column: Column) -> bool:
    """Whether a column's numbers may be counts: whole ones over a wide range."""
    return column.whole and column.span[1] - column.span[0] > COUNTS


def _by_unit(unit: str) -> str:
    if not unit:
        return ""
    try:
        return _BY_UNIT.get(unit_of(unit, "").si, "other" if unit not in ("1", "-", "counts", PERCENT) else "")
    except ConfigurationError:
        return ""


def channel_of(column_meaning: Meaning) -> str | None:
    """The channel of the bench that a meaning stands for; None where there is none."""
    side = "load" if column_meaning.load else "motor"
    if column_meaning.quantity in ("angle", "velocity"):
        return f"{side}_{column_meaning.quantity}"
    if column_meaning.quantity in ("torque", "current"):
        if column_meaning.brake:
            return "load_motor_torque"
        if column_meaning.effort:
            return "motor_torque"  # of its joint, but no torque sensor's
        return "load_torque" if column_meaning.load and column_meaning.quantity == "torque" else "motor_torque"
    if column_meaning.quantity == "temperature":
        return "ambient_temperature" if column_meaning.ambient else "temperature"
    return None


def axes_of(columns: Sequence[Column], meanings: Mapping[str, Meaning]) -> dict[str, int]:
    """Axis of each column: its number in a matrix with a line for each axis, or that at the end of its name where
    angles or speeds and torques or currents are numbered alike, as an arm's are.
    """
    axes = {column.name: column.number for column in columns if column.number is not None}
    if axes:
        return axes
    stems: dict[tuple[str, str], dict[int, str]] = {}
    for column in columns:
        parts = re.fullmatch(r"(.*?)_?(\d+)", column.variable.heading[0].strip())
        if parts and not column.stamps:
            stems.setdefault((meanings[column.name].quantity, parts[1]), {})[int(parts[2])] = column.name
    moving = {
        tuple(sorted(numbered))
        for (quantity, _), numbered in stems.items()
        if quantity in ("angle", "velocity") and len(numbered) > 1
    }
    driving = {
        tuple(sorted(numbered)) for (quantity, _), numbered in stems.items() if quantity in ("torque", "current")
    }
    of_an_arm = moving & driving
    return {
        name: k for numbered in stems.values() if tuple(sorted(numbered)) in of_an_arm for k, name in numbered.items()
    }


def busiest_axis(columns: Sequence[Column], meanings: Mapping[str, Meaning], axes: Mapping[str, int]) -> int | None:
    """Of several axes the one that moves farthest; None where there are none."""
    for quantity in ("angle", "velocity"):
        candidates = [c for c in columns if c.name in axes and meanings[c.name].quantity == quantity]
        candidates = [c for c in candidates if not meanings[c.name].setpoint and not c.empty]
        if candidates:
            return axes[max(candidates, key=lambda c: c.span[1] - c.span[0]).name]
    return None


def plain(name: str) -> str:
    """A name without its unit as a mapping may use it for a quantity: letters, digits and underscores."""
    bare = name.rsplit("/", 1)[-1].translate(_UMLAUTS)
    return re.sub(r"[^A-Za-z0-9]+", "_", bare).strip("_") or "quantity"
