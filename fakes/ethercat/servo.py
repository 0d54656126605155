"""A CiA 402 servo drive as a slave: control words in, plant commands out, measurements back into the process image.

A block of cycles is served in runs. Within a run control word and mode are constant and the power state does not
change, so everything is arrays; :meth:`ServoDrive.begin` says how long the run may be, :meth:`ServoDrive.first_event`
where in the measurements something happened that ends it (standstill after a ramp, overspeed).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from fakes.ethercat import faultcodes
from fakes.ethercat.cia402 import POWERED, Bit, Mode, State, transition
from fakes.ethercat.dictionary import Object, key
from fakes.ethercat.identity import Identity, servo_product
from fakes.ethercat.objects_cia402 import PROFILE_SERVO, DriveData, servo_objects, velocity_unit_rad_s
from fakes.ethercat.objects_common import common
from fakes.ethercat.plant_link import Rows
from fakes.ethercat.slave import Emergency, Image, Slave
from fakes.ethercat.types import Value

OVERSPEED = 1.2
"""Part of 0x6080 above which the drive trips."""

STOP_TIMEOUT_S = 10.0
"""A ramp that has not reached standstill by then ends without torque."""

_INTERLOCK = 0x08
"""0x60FD bit 3: safe torque off requested."""

_AXIS = {1: "input", 2: "load"}
_INT32 = (-(2**31), 2**31 - 1)
_INT16 = (-(2**15), 2**15 - 1)
_NAMES = {index: f"{index:04X}:00" for index in (0x60FF, 0x60B1, 0x6071, 0x60B2)}

Ints: TypeAlias = npt.NDArray[np.integer] | int
_Floats: TypeAlias = npt.NDArray[np.float64] | float


@dataclass(frozen=True, slots=True)
class _Settings:
    """What the object dictionary sets, in the units of the cycle."""

    top_rad_s: float
    trip_rad_s: float
    position_sign: int
    velocity_unit: float
    torque_unit: float
    torque_low: int
    torque_high: int
    home_offset: int
    mode: int


class ServoDrive(Slave):
    """Drive of one motor; ``drive`` says which and in what units."""

    SET_VALUES = frozenset(key(i, 0) for i in (0x6040, 0x6060, 0x6071, 0x607A, 0x60B0, 0x60B1, 0x60B2, 0x60FF))
    VOLATILE = ("state", "error_code", "safe_torque_off", "_previous", "_mode", "_target", "_ramp_cycles", "_measured")

    def __init__(self, role: str, drive: DriveData, cycle_time_s: float, serial: int = 1) -> None:
        identity = Identity(
            product=servo_product(drive.encoder_bits, drive.axis),
            serial=serial,
            order=f"SD-{drive.rated_torque_n_m:g}-{drive.encoder_bits}",
            name=f"Emulated servo drive {drive.rated_torque_n_m:g} Nm, {drive.encoder_bits} bit",
            profile=PROFILE_SERVO,
        )
        objects: tuple[Object, ...] = (*common(identity, round(cycle_time_s * 1e9)), *servo_objects(drive))
        self.drive = drive
        self.cycle_time_s = cycle_time_s
        self.velocity_unit = velocity_unit_rad_s(drive.velocity_unit)
        self.torque_unit = drive.rated_torque_n_m / 1000.0
        resolution = 2.0 * math.pi / drive.counts / cycle_time_s
        self.standstill_rad_s = max(1.5 * resolution, 0.001 * drive.maximum_speed_rpm * 2.0 * math.pi / 60.0)
        self.state = State.SWITCH_ON_DISABLED
        self.error_code = 0
        self.safe_torque_off = False
        self._previous = 0
        self._mode = int(drive.mode)
        self._target: State | None = None
        self._ramp_cycles = 0
        self._measured: Rows | None = None
        self._axis = _AXIS[drive.axis]
        self._mapped: frozenset[str] = frozenset()
        self._writers: tuple[tuple[str, Callable[[Rows], Ints]], ...] = ()
        super().__init__(role, identity, objects)
        self._version = -1
        self._settings = self._derive()
        self._producers: dict[int, Callable[[Rows], Ints]] = {
            0x1001: lambda _: faultcodes.error_register(self.error_code),
            0x603F: lambda _: self.error_code,
            0x6041: self._status_word,
            0x6061: lambda _: self._mode,
            0x6062: self._position,
            0x6063: self._position,
            0x6064: self._position,
            0x606B: lambda _: self.dictionary.integer(0x60FF),
            0x606C: self._velocity,
            0x6074: lambda _: self.dictionary.integer(0x6071),
            0x6077: self._torque,
            0x6078: self._torque,
            0x60F4: lambda _: 0,
            0x60FD: lambda _: _INTERLOCK if self.safe_torque_off else 0,
        }
        for index, produce in self._producers.items():
            self.dictionary.readers[key(index, 0)] = self._reader(produce)

    # -- power state --------------------------------------------------------------------------------------------

    def power_cycle(self) -> None:
        """Lose settings and state; the motor carries no torque."""
        super().power_cycle()
        self.state, self.error_code, self._target, self._previous = State.SWITCH_ON_DISABLED, 0, None, 0
        self._mode = int(self.drive.mode)

    def fail(self, code: int) -> None:
        """Enter the fault reaction for an error code (transition 13) and send an emergency."""
        if self.state in (State.FAULT, State.FAULT_REACTION):
            return
        self.error_code = code
        self.emergencies.append(Emergency(code, faultcodes.error_register(code)))
        reacts = self.state in POWERED and self.dictionary.integer(0x605E) > 0
        self.state = State.FAULT_REACTION if reacts else State.FAULT
        self._ramp_to(State.FAULT if reacts else None)

    def set_safe_torque_off(self, active: bool) -> None:
        """Cut the torque by the safety input; the drive stays in SWITCH ON DISABLED while it is requested."""
        self.safe_torque_off = active
        if active and self.state not in (State.FAULT, State.FAULT_REACTION):
            self.state = State.SWITCH_ON_DISABLED
        elif active:
            self.state = State.FAULT
        self._ramp_to(None)

    def _stop_outputs(self) -> None:
        """Without valid outputs a powered drive faults; the watchdog comes here too."""
        if self.state in POWERED:
            self.fail(faultcodes.COMMUNICATION)

    def _start_inputs(self) -> None:
        super()._start_inputs()
        self._mapped = frozenset(self.outputs.names)
        self._writers = tuple(
            (name, self._producers[int(name[:4], 16)]) for name in self.inputs.names if name[5:] == "00"
        )

    def _ramp_to(self, target: State | None) -> None:
        self._target, self._ramp_cycles = target, 0

    def _command(self, control_word: int) -> bool:
        """Serve the control word of one cycle; return whether the power state changed."""
        found = transition(self.state, control_word, self._previous)
        self._previous = control_word
        if found is None:
            return False
        ramping = self._target is not None and self.state is State.ENABLED
        if ramping and found.number in (5, 8):
            return False
        if self.safe_torque_off and found.number == 2:
            return False
        d = self.dictionary
        ramp = {5: d.integer(0x605C), 8: d.integer(0x605B), 11: d.integer(0x605A)}.get(found.number, 0)
        if found.number == 11:
            self.state = State.QUICK_STOP if ramp else State.SWITCH_ON_DISABLED
            self._ramp_to(State.SWITCH_ON_DISABLED if 1 <= ramp <= 4 else None)
        elif ramp:
            self._ramp_to(found.target)
        else:
            self.state = found.target
            self._ramp_to(None)
        if found.number == 15:
            self.error_code = 0
            self.emergencies.append(Emergency(0, 0))
        return True

    def _derive(self) -> _Settings:
        """Read the settings anew if the dictionary has changed since."""
        d = self.dictionary
        if d.version == self._version:
            return self._settings
        self._version = d.version
        polarity, limit = d.integer(0x607E), d.integer(0x6072)
        rated = 2.0 * math.pi / 60.0 * self.drive.maximum_speed_rpm
        return _Settings(
            top_rad_s=min(d.integer(0x6080) * 2.0 * math.pi / 60.0, d.integer(0x607F) * self.velocity_unit),
            trip_rad_s=OVERSPEED * rated,
            position_sign=-1 if polarity & 0x80 else 1,
            velocity_unit=-self.velocity_unit if polarity & 0x40 else self.velocity_unit,
            torque_unit=-self.torque_unit if polarity & 0x20 else self.torque_unit,
            torque_low=-min(limit, d.integer(0x60E1)),
            torque_high=min(limit, d.integer(0x60E0)),
            home_offset=d.integer(0x607C),
            mode=d.integer(0x6060),
        )

    # -- a run of cycles ----------------------------------------------------------------------------------------

    def begin(self, outputs: Image | None, first: int, stop: int) -> int:
        """Serve control word and mode of cycle ``first``; return where the run must end (exclusive, ≤ ``stop``)."""
        self._settings = self._derive()
        if outputs is None:
            return stop
        mode, control = self._settings.mode, -1
        if "6060:00" in self._mapped:
            column = outputs["6060:00"]
            mode = int(column[first])
            stop = _constant_until(column, first, stop)
        if "6040:00" in self._mapped:
            column = outputs["6040:00"]
            control = int(column[first])
            stop = _constant_until(column, first, stop)
        self._set_mode(mode)
        changed = self._command(self.dictionary.integer(0x6040) if control < 0 else control)
        return first + 1 if changed else stop

    def _set_mode(self, mode: int) -> None:
        if mode in (Mode.CSV, Mode.CST):
            self._mode = mode

    def command(self, commands: Rows, outputs: Image | None, first: int, stop: int) -> None:
        """Fill this axis' fields of the plant commands of a run."""
        axis, powered = self._axis, self.state in POWERED
        commands[axis + "_enable"] = powered
        commands[axis + "_quick_stop"] = powered and (self.state is not State.ENABLED or self._target is not None)
        commands[axis + "_mode"] = self._mode
        if not powered:
            return
        settings = self._settings
        if self._mode == Mode.CSV:
            target = self._setpoint(outputs, 0x60FF, 0x60B1, first, stop) * settings.velocity_unit
            commands[axis + "_velocity"] = _clip(target, -settings.top_rad_s, settings.top_rad_s)
        else:
            target = _clip(
                self._setpoint(outputs, 0x6071, 0x60B2, first, stop), settings.torque_low, settings.torque_high
            )
            commands[axis + "_torque"] = target * settings.torque_unit

    def _setpoint(self, outputs: Image | None, index: int, offset: int, first: int, stop: int) -> _Floats:
        """Return set value plus offset in units of the object, as rows or as one number."""
        total: _Floats = 0.0
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
        return self.state in POWERED

    def first_event(self, measured: Rows) -> int | None:
        """Return the first row at which the drive itself changes state, or None."""
        if self.state not in POWERED:
            return None
        speed = np.abs(measured[self._axis + "_velocity"])
        happened = self._trips(speed)
        if self._target is not None:
            happened |= speed < self.standstill_rad_s
            left = round(STOP_TIMEOUT_S / self.cycle_time_s) - self._ramp_cycles - 1
            if left < len(happened):
                happened[max(left, 0) :] = True
        first = int(happened.argmax())
        return first if happened[first] else None

    def report(self, measured: Rows, image: Image | None, first: int, stop: int) -> None:
        """Write the measurements of a run into the process image rows ``first`` to ``stop``."""
        self._measured = measured[-1:].copy()
        if image is not None:
            for name, produce in self._writers:
                image[name][first:stop] = produce(measured)

    def settle(self, cycles: int, happened: bool) -> None:
        """Close a run of so many cycles: take the state change of its last one, if one ``happened`` there."""
        if self._target is not None:
            self._ramp_cycles += cycles
        if not happened or self._measured is None:
            return
        if self._trips(np.abs(self._measured[self._axis + "_velocity"])).any():
            self.fail(faultcodes.VELOCITY_CONTROL)
        elif self._target is not None:
            self.state = self._target
            self._ramp_to(None)

    def _trips(self, speed: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        if self.state is State.FAULT_REACTION:
            return np.zeros(len(speed), dtype=np.bool_)
        return speed > self._settings.trip_rad_s

    # -- what the process image shows ---------------------------------------------------------------------------

    def _reader(self, produce: Callable[[Rows], Ints]) -> Callable[[], Value]:
        def read() -> Value:
            if self._measured is None:
                return (
                    0
                    if produce in (self._position, self._velocity, self._torque)
                    else int(np.ravel(produce(_NO_ROWS))[0])
                )
            return int(np.ravel(produce(self._measured))[0])

        return read

    def _status_word(self, measured: Rows) -> Ints:
        word = self.state.value | Bit.REMOTE
        if not self.safe_torque_off:
            word |= Bit.VOLTAGE_ENABLED
        if self.state is not State.ENABLED or not len(measured):
            return word
        if self._target is None:
            word |= Bit.FOLLOWS_COMMAND
        torque = self._torque(measured)
        limited = (torque <= self._settings.torque_low) | (torque >= self._settings.torque_high)
        with_limit: Ints = word + limited * int(Bit.INTERNAL_LIMIT)
        return with_limit

    def _position(self, measured: Rows) -> Ints:
        counts = (measured[self._axis + "_position"] + self._settings.home_offset) * self._settings.position_sign
        wrapped: npt.NDArray[np.int32] = counts.astype(np.int32)
        return wrapped

    def _velocity(self, measured: Rows) -> Ints:
        units = _clip(np.rint(measured[self._axis + "_velocity"] / self._settings.velocity_unit), *_INT32)
        limited: npt.NDArray[np.int32] = units.astype(np.int32)
        return limited

    def _torque(self, measured: Rows) -> npt.NDArray[np.int16]:
        permille = _clip(np.rint(measured[self._axis + "_torque"] / self._settings.torque_unit), *_INT16)
        limited: npt.NDArray[np.int16] = permille.astype(np.int16)
        return limited


_NO_ROWS: Rows = np.zeros(0, dtype=[("none", "u1")])


def _clip(values: Any, low: float, high: float) -> Any:
    """Limit numbers or rows; two ufuncs are faster than ``np.clip``."""
    return np.minimum(np.maximum(values, low), high)


def _constant_until(column: npt.NDArray[np.integer], first: int, stop: int) -> int:
    """Return the first index in (first, stop) at which the column differs from ``column[first]``, else ``stop``."""
    if stop == first + 1:
        return stop
    differs = column[first:stop] != column[first]
    at = int(differs.argmax())
    return first + at if at else stop
