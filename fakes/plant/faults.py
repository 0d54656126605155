"""What can break: a table of named faults, each switched on and off by name, at once or at a moment of plant time.

The compiled step sees one row a fault: the cycles from which and until which it holds, and a value.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fakes.plant.errors import PlantError

FAULT_DTYPE = np.dtype([("start", "i8"), ("stop", "i8"), ("value", "f8")])
_NEVER = np.iinfo(np.int64).max


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault of the plant."""

    name: str
    text: str
    default: float = 0.0
    unit: str = ""


FAULTS: tuple[Fault, ...] = (
    Fault("input_encoder_frozen", "the input encoder repeats its last count, to the drive's loop as well"),
    Fault("input_encoder_jump", "the input encoder's counts are shifted", 4096.0, "counts"),
    Fault("input_encoder_wrap", "the input encoder counts within this many bits only", 13.0, "bit"),
    Fault("load_encoder_frozen", "the load encoder repeats its last count"),
    Fault("load_encoder_jump", "the load encoder's counts are shifted", 100000.0, "counts"),
    Fault("load_encoder_wrap", "the load encoder counts within this many bits only", 25.0, "bit"),
    Fault("torque_sensor_saturated", "the amplifier sits at full scale, sign of the value", 1.0, "1"),
    Fault("torque_sensor_open", "broken wire: the ±10 V input floats near this value", 0.0, "N·m"),
    Fault("torque_sensor_frozen", "the torque sensor repeats its last value"),
    Fault("torque_sensor_drift", "the sensor's zero runs away from the start of the fault on", 1.0, "N·m/s"),
    Fault("torque_sensor_gain", "the sensor's gain is wrong by this factor", 0.5, "1"),
    Fault("pt100_open", "broken wire at the lubricant's PT100: reads +10000 °C"),
    Fault("pt100_short", "short circuit at the lubricant's PT100: reads −10000 °C"),
    Fault("pt100_frozen", "the lubricant's PT100 repeats its last value"),
    Fault("pt100_offset", "the lubricant's PT100 reads wrong by this much", 10.0, "K"),
    Fault("ambient_pt100_open", "broken wire at the PT100 of the surroundings: reads +10000 °C"),
    Fault("ambient_pt100_short", "short circuit at the PT100 of the surroundings: reads −10000 °C"),
    Fault("input_current_off", "the input drive gives no current though it reports itself enabled"),
    Fault("load_current_off", "the load drive gives no current though it reports itself enabled"),
    Fault(
        "input_runaway",
        "the input drive gives this torque whatever its set value is, as long as it has voltage",
        20.0,
        "N·m",
    ),
    Fault("load_runaway", "the load drive gives this torque (own frame) likewise", 1000.0, "N·m"),
    Fault("load_uncoupled", "the coupling is open: no torque between gearbox and load motor"),
    Fault("output_stalled", "the load side is blocked by this friction", 20000.0, "N·m"),
    Fault("input_stalled", "the input shaft is blocked by this friction", 200.0, "N·m"),
    Fault("friction_raised", "the gearbox's friction is multiplied (lubricant lost)", 3.0, "1"),
    Fault("heating_external", "heat from elsewhere into the lubricant", 2000.0, "W"),
)
INDEX = {fault.name: i for i, fault in enumerate(FAULTS)}


class FaultTable:
    """Switches for every fault in ``FAULTS``; times are plant time in s."""

    def __init__(self, cycle_time_s: float) -> None:
        self._cycle_time_s = cycle_time_s
        self.rows = np.zeros(len(FAULTS), FAULT_DTYPE)
        self.clear_all()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all faults there are."""
        return tuple(INDEX)

    def set(
        self, name: str, value: float | None = None, *, at_s: float | None = None, until_s: float | None = None
    ) -> None:
        """Switch a fault on, from ``at_s`` (now) until ``until_s`` (for ever), with its parameter or the default."""
        index = self._index(name)
        row = self.rows[index]
        row["value"] = FAULTS[index].default if value is None else value
        row["start"] = 0 if at_s is None else math.ceil(at_s / self._cycle_time_s - 1e-6)
        row["stop"] = _NEVER if until_s is None else math.ceil(until_s / self._cycle_time_s - 1e-6)

    def clear(self, name: str) -> None:
        """Switch a fault off."""
        row = self.rows[self._index(name)]
        row["start"], row["stop"], row["value"] = _NEVER, _NEVER, 0.0

    def clear_all(self) -> None:
        """Switch every fault off."""
        for name in INDEX:
            self.clear(name)

    def scheduled(self) -> Iterator[tuple[str, float]]:
        """Yield name and value of every fault that is on or will come on."""
        for fault, row in zip(FAULTS, self.rows, strict=True):
            if row["start"] != _NEVER:
                yield fault.name, float(row["value"])

    def _index(self, name: str) -> int:
        """Return the row of a fault."""
        if name not in INDEX:
            raise PlantError(f"there is no fault {name!r} in the plant; there are {', '.join(INDEX)}")
        return INDEX[name]
