"""From the process images of a block to raw channels and to what the safety step sees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.cycle.assembly import Assembly
from bench.cycle.channels import Scaling
from bench.cycle.unwrap import Unwrapper
from bench.devices import Temperatures
from bench.safety import Inputs, SafetySettings, SafetyState, step
from bench.signals import SOURCES

_SETPOINTS = ("motor_velocity_setpoint", "load_motor_torque_setpoint")
_OLDEST_MS = 4e9
"""Ages beyond this (a reading that never came) do not fit the channel."""
_UNWRAPPED = ("motor_angle", "load_angle")


@dataclass(frozen=True, slots=True)
class Decoded:
    """A block as it goes to the recording (raw integers by channel) and to the safety step."""

    raw: dict[str, NDArray[Any]]
    inputs: Inputs
    set_index: NDArray[np.int64] | None = None
    """Which of the set values handed over ahead each cycle has sent, −1 for others; None: those of its own row."""
    late_s: NDArray[np.float64] | None = None
    """How long after it was due each cycle began that was made up for, 0 for others; None where nobody knows."""

    @property
    def size(self) -> int:
        """Number of cycles."""
        return self.inputs.size


def warm_up(limits: SafetySettings) -> None:
    """Load the compiled loops with the types they will see, before the bus runs: it takes longer than a watchdog."""
    Unwrapper()(np.zeros(1, np.int32))
    number, count, word, flag = np.zeros(1), np.zeros(1, np.int64), np.zeros(1, np.uint16), np.zeros(1, np.bool_)
    inputs = Inputs(
        motor_counts=count,
        load_counts=count,
        torque_counts=np.zeros(1, np.int16),
        motor_angle=number,
        load_angle=number,
        motor_velocity=number,
        load_velocity=number,
        motor_torque=number,
        load_torque=number,
        load_motor_torque=number,
        temperature=number,
        temperature_age_s=number,
        velocity_setpoint=number,
        torque_setpoint=number,
        input_status=word,
        load_status=word,
        torque_bad=flag,
        emergency_stop=flag,
        safe_torque_off=flag,
        good=flag,
    )
    step(SafetyState.fresh(), inputs, False, limits)


class Decoder:
    """Reads the views of the bus after an exchange; remembers encoder overflows between blocks."""

    def __init__(self, assembly: Assembly, scaling: Scaling) -> None:
        self._assembly = assembly
        self.scaling = scaling
        """May be replaced while zeros are being found."""
        self._unwrap = {name: Unwrapper() for name in _UNWRAPPED}
        self._has_ambient = "ambient_temperature" in scaling.specs

    def state(self) -> tuple[tuple[int | None, int], ...]:
        """Return what :meth:`restore` needs for a replay."""
        return tuple(self._unwrap[name].state() for name in _UNWRAPPED)

    def restore(self, state: tuple[tuple[int | None, int], ...]) -> None:
        """Go back to an earlier :meth:`state`."""
        for name, part in zip(_UNWRAPPED, state, strict=True):
            self._unwrap[name].restore(part)

    def decode(
        self,
        n: int,
        cycle: NDArray[np.int64],
        wkc: NDArray[np.int32],
        velocity: NDArray[np.float64],
        set_index: NDArray[np.int64] | None = None,
    ) -> Decoded:
        """Return the last ``n`` cycles. ``velocity`` is the set value at the motor shaft, rad/s, shape (n,)."""
        bus, thermometer = self._assembly.bus, self._assembly.thermometer
        raw: dict[str, NDArray[Any]] = {}
        for name, source in SOURCES.items():
            image = bus.sent if name in _SETPOINTS else bus.inputs
            # always a copy: the image is overwritten by the next block
            values = np.array(image[source.role][source.entry][:n])
            raw[name] = self._unwrap[name](values) if name in _UNWRAPPED else values
        lubricant = thermometer.read(n, 1)
        raw["temperature"] = np.array(lubricant.raw)
        if self._has_ambient:
            raw["ambient_temperature"] = np.array(thermometer.read(n, 2).raw)
        raw["temperature_age"] = np.rint(np.minimum(lubricant.age_s * 1e3, _OLDEST_MS)).astype(np.uint32)
        if self._assembly.safety is not None:
            raw["safety_inputs"] = np.array(bus.inputs["safety_terminal"][self._assembly.safety.entry][:n])
        raw["cycle"], raw["time"] = cycle, cycle
        raw["working_counter"] = wkc.astype(np.uint16)
        return Decoded(raw, self._inputs(raw, lubricant, wkc, velocity, n), set_index)

    def si(self, raw: dict[str, NDArray[Any]], name: str) -> NDArray[np.float64]:
        """Return a channel in SI units."""
        return raw[name] * self.scaling.scale(name) + self.scaling.offset(name)

    def _inputs(
        self,
        raw: dict[str, NDArray[Any]],
        lubricant: Temperatures,
        wkc: NDArray[np.int32],
        velocity: NDArray[np.float64],
        n: int,
    ) -> Inputs:
        return Inputs(
            motor_counts=raw["motor_angle"],
            load_counts=raw["load_angle"],
            torque_counts=raw["load_torque"],
            motor_angle=self.si(raw, "motor_angle"),
            load_angle=self.si(raw, "load_angle"),
            motor_velocity=self.si(raw, "motor_velocity"),
            load_velocity=self.si(raw, "load_velocity"),
            motor_torque=self.si(raw, "motor_torque"),
            load_torque=self.si(raw, "load_torque"),
            load_motor_torque=self.si(raw, "load_motor_torque"),
            temperature=lubricant.temperature_c,
            temperature_age_s=lubricant.age_s,
            velocity_setpoint=velocity,
            torque_setpoint=self.si(raw, "load_motor_torque_setpoint"),
            input_status=raw["motor_status"],
            load_status=raw["load_status"],
            torque_bad=~self._assembly.torque_terminal.usable(n),
            emergency_stop=self._stop_demanded("emergency_stop", n),
            safe_torque_off=self._stop_demanded("safe_torque_off", n),
            good=wkc == self._assembly.bus.expected_wkc,
        )

    def _stop_demanded(self, name: str, n: int) -> NDArray[np.bool_]:
        """Return where a safety input demands a stop (n,); nowhere if the bench has none of that name."""
        safety = self._assembly.safety
        if safety is None or name not in safety.names:
            return np.zeros(n, np.bool_)
        return safety.read(name, n)
