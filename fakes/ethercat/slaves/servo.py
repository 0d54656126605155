"""A CiA 402 servo drive as a slave: control words in, plant commands out, measurements back into the process image.

A block of cycles is served in runs. Within a run control word and mode are constant and the power state does not
change, so everything is arrays; :meth:`ServoDrive.begin` says how long the run may be, :meth:`ServoDrive.first_event`
where in the measurements something happened that ends it (standstill after a ramp, overspeed).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from fakes.ethercat.drive import faultcodes
from fakes.ethercat.drive.cia402 import Bit, Mode, State
from fakes.ethercat.drive.objects import PROFILE_SERVO, DriveData, servo_objects
from fakes.ethercat.drive.power import PowerStage
from fakes.ethercat.drive.scaling import Floats, Scaling
from fakes.ethercat.objects.common import common
from fakes.ethercat.objects.dictionary import key
from fakes.ethercat.objects.identity import Identity, servo_product
from fakes.ethercat.objects.types import Value
from fakes.ethercat.slaves.plant_link import Rows
from fakes.ethercat.slaves.slave import Emergency, Image, Slave

STOP_TIMEOUT_S = 10.0
"""A ramp that has not reached standstill by then ends all the same."""

_INTERLOCK = 0x08
"""0x60FD bit 3: safe torque off requested."""

_AXIS = {1: "input", 2: "load"}
_MODES = (int(Mode.CSV), int(Mode.CST))
_NAMES = {index: f"{index:04X}:00" for index in (0x60FF, 0x60B1, 0x6071, 0x60B2)}

Ints: TypeAlias = npt.NDArray[np.integer] | int


class ServoDrive(Slave):
    """Drive of one motor; ``drive`` says which and in what units."""

    SET_VALUES = frozenset(key(i, 0) for i in (0x6040, 0x6060, 0x6071, 0x607A, 0x60B0, 0x60B1, 0x60B2, 0x60FF))
    VOLATILE = ("power", "_mode", "_measured", "_permille")

    def __init__(self, role: str, drive: DriveData, cycle_time_s: float, serial: int = 1) -> None:
        identity = Identity(
            product=servo_product(drive.encoder_bits, drive.axis),
            serial=serial,
            order=f"SD-{drive.rated_torque_n_m:g}-{drive.encoder_bits}",
            name=f"Emulated servo drive {drive.rated_torque_n_m:g} Nm, {drive.encoder_bits} bit",
            profile=PROFILE_SERVO,
        )
        self.drive = drive
        self.power = PowerStage()
        self._stop_cycles = round(STOP_TIMEOUT_S / cycle_time_s)
        resolution = 2.0 * math.pi / drive.counts / cycle_time_s
        self._standstill_rad_s = max(1.5 * resolution, 0.001 * drive.maximum_speed_rpm * 2.0 * math.pi / 60.0)
        self._mode = int(drive.mode)
        self._measured: Rows | None = None
        self._permille: npt.NDArray[np.int16] = np.zeros(1, np.int16)
        self._velocity_field = _AXIS[drive.axis] + "_velocity"
        self._torque_field = _AXIS[drive.axis] + "_torque"
        self._position_field = _AXIS[drive.axis] + "_position"
        self._axis = _AXIS[drive.axis]
        self._mapped: frozenset[str] = frozenset()
        self._writers: tuple[tuple[str, Callable[[Rows], Ints]], ...] = ()
        super().__init__(role, identity, (*common(identity, round(cycle_time_s * 1e9)), *servo_objects(drive)))
        self._version = self.dictionary.version
        self._scaling = Scaling.of(self.dictionary, drive)
        self._producers = self._table()
        for index, produce in self._producers.items():
            self.dictionary.readers[key(index, 0)] = self._reader(index, produce)

    @property
    def state(self) -> State:
        """State of the CiA 402 state machine."""
        return self.power.state

    # -- power state --------------------------------------------------------------------------------------------

    def power_cycle(self) -> None:
        """Lose settings and state; the motor carries no torque."""
        super().power_cycle()
        self.power = PowerStage()
        self._mode = int(self.drive.mode)

    def fail(self, code: int) -> None:
        """Trip with an error code and send an emergency."""
        if self.power.fail(code, self.dictionary.integer):
            self.emergencies.append(Emergency(code, faultcodes.error_register(code)))

    def set_safe_torque_off(self, active: bool) -> None:
        """Request safe torque off, or no longer."""
        self.power.set_safe_torque_off(active)

    def _stop_outputs(self) -> None:
        """Without valid outputs a powered drive trips; the watchdog comes here too."""
        if self.power.powered:
            self.fail(faultcodes.COMMUNICATION)

    def _start_inputs(self) -> None:
        super()._start_inputs()
        self._mapped = frozenset(self.outputs.names)
        self._writers = tuple(
            (name, self._producers[int(name[:4], 16)]) for name in self.inputs.names if name[5:] == "00"
        )

    # -- a run of cycles ----------------------------------------------------------------------------------------

    def begin(self, outputs: Image | None, first: int, stop: int) -> int:
        """Serve control word and mode of cycle ``first``; return where the run must end (exclusive, ≤ ``stop``)."""
        if self.dictionary.version != self._version:
            self._version = self.dictionary.version
            self._scaling = Scaling.of(self.dictionary, self.drive)
        if outputs is None:
            return stop
        mode, stop = self._take(outputs, "6060:00", first, stop)
        control, stop = self._take(outputs, "6040:00", first, stop)
        if mode in _MODES:
            self._mode = mode
        found = self.power.command(control, self.dictionary.integer)
        if found is None:
            return stop
        if found.number == 15:
            self.emergencies.append(Emergency(0, 0))
        return first + 1

    def _take(self, outputs: Image, name: str, first: int, stop: int) -> tuple[int, int]:
        """Return an object's value in the first row and up to where it stays so."""
        if name not in self._mapped:
            return self.dictionary.integer(int(name[:4], 16)), stop
        column = outputs[name]
        value = int(column[first])
        if stop > first + 1:
            differs = column[first:stop] != value
            at = int(differs.argmax())
            stop = first + at if at else stop
        return value, stop

    def command(self, commands: Rows, outputs: Image | None, first: int, stop: int) -> None:
        """Fill this axis' fields of the plant commands of a run."""
        axis, power = self._axis, self.power
        commands[axis + "_enable"] = power.powered
        commands[axis + "_quick_stop"] = power.stopping
        commands[axis + "_mode"] = self._mode
        if not power.powered:
            return
        if self._mode == Mode.CSV:
            target = self._setpoint(outputs, 0x60FF, 0x60B1, first, stop)
            commands[self._velocity_field] = self._scaling.velocity_command(target)
        else:
            target = self._setpoint(outputs, 0x6071, 0x60B2, first, stop)
            commands[self._torque_field] = self._scaling.torque_command(target)

    def _setpoint(self, outputs: Image | None, index: int, offset: int, first: int, stop: int) -> Floats:
        """Return set value plus offset in units of the object, as rows or as one number."""
        total: Floats = 0.0
        for part in (index, offset):
            name = _NAMES[part]
            if outputs is not None and name in self._mapped:
                total = outputs[name][first:stop] + total
            else:
                total = total + self.dictionary.integer(part)
        return total

    @property
    def watching(self) -> bool:
        """Whether measurements can change the power state."""
        return self.power.powered

    def first_event(self, measured: Rows) -> int | None:
        """Return the first row at which the drive itself changes state, or None."""
        if not self.power.powered:
            return None
        speed = np.abs(measured[self._velocity_field])
        happened = self._trips(speed)
        if self.power.target is not None:
            happened |= speed < self._standstill_rad_s
            left = self._stop_cycles - self.power.ramp_cycles - 1
            if left < len(happened):
                happened[max(left, 0) :] = True
        first = int(happened.argmax())
        return first if happened[first] else None

    def report(self, measured: Rows, image: Image | None, first: int, stop: int) -> None:
        """Write the measurements of a run into the process image rows ``first`` to ``stop``."""
        self._measured = measured[-1:].copy()
        self._permille = self._scaling.torque(measured[self._torque_field])
        if image is not None:
            for name, produce in self._writers:
                image[name][first:stop] = produce(measured)

    def settle(self, cycles: int, happened: bool) -> None:
        """Close a run of so many cycles: take the state change of its last one, if one ``happened`` there."""
        if self.power.target is not None:
            self.power.ramp_cycles += cycles
        if not happened or self._measured is None:
            return
        if self._trips(np.abs(self._measured[self._velocity_field])).any():
            self.fail(faultcodes.VELOCITY_CONTROL)
        else:
            self.power.standstill()

    def _trips(self, speed: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        if self.power.state is State.FAULT_REACTION:
            return np.zeros(len(speed), dtype=np.bool_)
        return speed > self._scaling.trip_rad_s

    # -- what the process image shows ---------------------------------------------------------------------------

    def _table(self) -> dict[int, Callable[[Rows], Ints]]:
        """Return what produces each object that shows a state or a measurement."""
        return {
            0x1001: lambda _: faultcodes.error_register(self.power.error_code),
            0x603F: lambda _: self.power.error_code,
            0x6041: self._status_word,
            0x6061: lambda _: self._mode,
            0x6062: self._position,
            0x6063: self._position,
            0x6064: self._position,
            0x606B: lambda _: self.dictionary.integer(0x60FF),
            0x606C: lambda m: self._scaling.velocity(m[self._velocity_field]),
            0x6074: lambda _: self.dictionary.integer(0x6071),
            0x6077: lambda _: self._permille,
            0x6078: lambda _: self._permille,
            0x60F4: lambda _: 0,
            0x60FD: lambda _: _INTERLOCK if self.power.safe_torque_off else 0,
        }

    def _status_word(self, measured: Rows) -> Ints:
        word = self.power.status_word()
        if self.power.state is not State.ENABLED:
            return word
        limited: Ints = word + self._scaling.at_torque_limit(self._permille) * int(Bit.INTERNAL_LIMIT)
        return limited

    def _position(self, measured: Rows) -> Ints:
        return self._scaling.position(measured[self._position_field])

    def _reader(self, index: int, produce: Callable[[Rows], Ints]) -> Callable[[], Value]:
        def read() -> Value:
            if self._measured is not None:
                return int(np.ravel(produce(self._measured))[-1])
            return _BEFORE_MEASURING[index](self) if index in _BEFORE_MEASURING else 0

        return read


_BEFORE_MEASURING: dict[int, Callable[[ServoDrive], int]] = {
    0x6041: lambda drive: drive.power.status_word(),
    0x6061: lambda drive: drive._mode,
    0x603F: lambda drive: drive.power.error_code,
}
"""What objects show before the plant has given its first measurement; the others show 0."""
