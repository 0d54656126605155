"""The link to the devices: blocks of set values out, decoded blocks in; can go back to replay. Knows no limits."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.configuration import BenchConfiguration
from bench.cycle.assembly import Assembly
from bench.cycle.channels import Scaling, Zeros, make_scaling
from bench.cycle.decode import Decoded, Decoder
from bench.cycle.drive_pair import DrivePair
from bench.devices import Exchange, ReplayMaster
from bench.errors import DeviceError

FloatArray = NDArray[np.float64]
_FIRST_LOOK_S = 0.3
_LEAD_S = 3.0
_REVOLUTION = 2.0 * math.pi


class BusLostError(DeviceError):
    """Nobody exchanges process data any more: there is no one left to give a set value to."""


@dataclass(frozen=True, slots=True)
class Memory:
    """Everything a replay goes back to; master and drives gave tokens that only they understand."""

    master: Any
    decoder: tuple[tuple[int | None, int], ...]
    drives: tuple[Any, ...]
    cycle: int


class Link:
    """Bus, drives and terminals of one bench.

    Parameters
    ----------
    bench : the configuration.
    assembly : the devices.
    paced : hold an emulated bench to the clock.
    zero : subtracted from the motor's angle beyond the bench file's zero, rad.

    Attributes
    ----------
    drives : both drives.
    cycle : bus cycles since the link was opened; goes back with a replay.
    velocity, torque : set values after the last cycle, load side, rad/s and N·m.
    last : the last block.
    is_silent : process data was stopped for good; the bench has to be opened anew.
    zeros : what is subtracted from encoders and torque sensor.
    """

    _lead_cycles = 1
    """Cycles between two looks at the drives' state machines while they are led."""

    def __init__(self, bench: BenchConfiguration, assembly: Assembly, paced: bool, zero: float = 0.0) -> None:
        self.assembly = assembly
        self.cycle = 0
        self.velocity = self.torque = 0.0
        self.last: Decoded | None = None
        self.zeros = Zeros(bench.input_encoder.zero + zero, bench.load_encoder.zero, bench.torque_sensor.zero)
        self._bench = bench
        self._paced = paced and assembly.can_replay
        self.drives = DrivePair(assembly.input_drive, assembly.load_drive)
        self._decoder: Decoder | None = None
        self._shift = 0
        self._due = time.monotonic()
        self.is_silent = False

    @property
    def is_open(self) -> bool:
        """Whether process data has been exchanged."""
        return self._decoder is not None

    @property
    def scaling(self) -> Scaling:
        """Scale and offset of every channel; known once the link is open."""
        return self._require_decoder().scaling

    def open(self) -> None:
        """Bring the bus to operation, take the devices' units, find the encoders' common zero."""
        assembly = self.assembly
        bus = assembly.bus
        bus.open()
        try:
            bus.configure()
            self.drives.attach(bus.outputs, bus.inputs)
            assembly.torque_terminal.attach(None, bus.inputs["torque_terminal"])
            assembly.thermometer.attach(None, bus.inputs.get("temperature_terminal"))
            if assembly.safety is not None:
                assembly.safety.attach(None, bus.inputs["safety_terminal"])
            self._protect()
            bus.to_operational()
            self._decoder = Decoder(assembly, self._scaling())
            # slow sensors convert for the first time
            first = self.hold(_FIRST_LOOK_S)
            self._resolve_revolutions(first)
        except BaseException:
            bus.close()
            raise

    def close(self) -> None:
        """Bring all slaves to INIT and close the interface; let go of a thermometer beside the bus."""
        try:
            self.assembly.bus.close()
        finally:
            self.assembly.thermometer.close()

    def tare(self, zero: float) -> None:
        """Subtract ``zero`` in N·m from the torque sensor, beyond what is subtracted already."""
        self.zeros = replace(self.zeros, load_torque=self.zeros.load_torque + zero)
        self._require_decoder().scaling = self._scaling()

    def hold(self, duration_s: float) -> Decoded:
        """Exchange cycles at the last set values; return the last block."""
        remaining = max(1, round(duration_s / self._bench.bus.cycle_time))
        while remaining > 0:
            n = min(remaining, self.assembly.block)
            decoded = self.exchange(np.full(n, self.velocity), np.full(n, self.torque))
            remaining -= n
        return decoded

    def exchange(self, velocity: FloatArray, torque: FloatArray) -> Decoded:
        """Send set values (n,), load side, and return what came back; fewer cycles if the master stopped early.

        Raises
        ------
        DeviceError
            If no cycle was exchanged at all.
        """
        n = velocity.size
        motor_velocity = self._prepare(velocity, torque)
        done = self._exchange(n)
        decoded = self._take(done, motor_velocity[: done.n_done])
        n = done.n_done
        self.velocity, self.torque = float(velocity[n - 1]), float(torque[n - 1])
        self._pace(n)
        return decoded

    def descend(self, velocity: FloatArray, torque: FloatArray, least: int) -> Decoded:
        """As :meth:`exchange`, for a stop; ``least`` cycles are waited for where set values are ahead of the bus."""
        return self.exchange(velocity, torque)

    @property
    def sent_values(self) -> tuple[float, float]:
        """Set values of the cycle sent last."""
        return self.velocity, self.torque

    def clock(self) -> float:
        """Time that passes on the bus, s: a bus without a process stands still between blocks, so it is the bench's."""
        return self.cycle * self._bench.bus.cycle_time

    def missing_ahead(self, n: int) -> int:
        """Return how many cycles are to be handed over next, of ``n`` wanted."""
        return n

    def go_silent(self) -> None:
        """Send no process data any more: whoever tries is refused until the bench is opened anew."""
        self.is_silent = True

    # -- what a bus in a process of its own does (bench.cycle.ahead) --------------------------------------------------

    def arm(self, armed: bool) -> None:
        """Let the bus stop the drives by itself from now on; nothing to do where it has no process of its own."""

    def hold_stopped(self) -> None:
        """Let the bus itself refuse set values until it is armed again; nothing to do where it has no process."""

    def release(self) -> None:
        """Have the bus follow set values again after a stop, without torque; nothing to do without a process."""

    def keep_ahead(self, at_rest: bool) -> None:
        """Give the bus enough to live on for a while; nothing to do where it waits for every block."""

    def drop_ahead(self) -> None:
        """Take back what has not been sent; nothing to do where all of it is sent at once."""

    def stopped(self) -> str | None:
        """Why the bus has stopped the drives by itself, or None."""
        return None

    def cycles(self, duration_s: float) -> int:
        """Return how many cycles a time is, one at least."""
        return max(1, round(duration_s / self._bench.bus.cycle_time))

    # -- private ------------------------------------------------------------------------------------------------------

    def _protect(self) -> None:
        """Get ready for OP: the devices are configured and attached."""

    def _exchange(self, n: int) -> Exchange:
        bus = self.assembly.block_bus
        if bus is None:
            raise DeviceError("the bus has a process of its own; set values should be handed over ahead")
        return bus.exchange(n)

    def _prepare(self, velocity: FloatArray, torque: FloatArray) -> FloatArray:
        """Write set values and control words into the outputs; return the velocity at the motor shaft."""
        self._require_voice()
        motor_velocity: FloatArray = velocity * self._bench.gearbox.ratio
        self.drives.prepare(motor_velocity, torque)
        return motor_velocity

    def _require_voice(self) -> None:
        if self.is_silent:
            raise BusLostError("process data was stopped at the end of the stop ladder; open the bench anew")

    def _take(self, done: Exchange, motor_velocity: FloatArray) -> Decoded:
        n = done.n_done
        if n == 0:
            process = self.assembly.process_bus
            reason = None if process is None else process.ended
            raise BusLostError(reason or "the master exchanged no cycle; the bus is down")
        self.drives.digest(n)
        cycle = done.cycle - self._shift
        decoded = self._require_decoder().decode(n, cycle, done.wkc, motor_velocity, done.set_index)
        if done.late_ns is not None:
            late_s = done.late_ns * 1e-9
            decoded = replace(decoded, late_s=np.where(late_s >= self._bench.bus.cycle_time, late_s, 0.0))
        self.cycle = int(cycle[-1]) + 1
        self.last = decoded
        return decoded

    def remember(self) -> Memory:
        """Return what :meth:`go_back` needs; only where the master can go back."""
        return Memory(
            self._require_replay_master().snapshot(),
            self._require_decoder().state(),
            self.drives.snapshot(),
            self.cycle,
        )

    def go_back(self, memory: Memory) -> None:
        """Return bench and drivers to an earlier moment."""
        self._require_replay_master().restore(memory.master)
        self._require_decoder().restore(memory.decoder)
        self.drives.restore(memory.drives)
        # the bus goes on counting; the bench's own cycles go back
        self._shift += self.cycle - memory.cycle
        self.cycle = memory.cycle

    def _require_replay_master(self) -> ReplayMaster:
        master = self.assembly.master
        if not isinstance(master, ReplayMaster):
            raise DeviceError("this master cannot be put back to where it was; an emulated one can")
        return master

    def lead(self, goal: str, what: str, only: str | None = None) -> None:
        """Ask for a goal, of both drives or the ``only`` one named, and run cycles until it is reached.

        Raises
        ------
        DeviceError
            If it is not within three seconds, or a drive is in fault.
        """
        self.drives.request(goal, only)
        deadline = self.cycle + round(_LEAD_S / self._bench.bus.cycle_time)
        n, asked = self._lead_cycles, (self.velocity, self.torque)
        self.drop_ahead()
        self.velocity, self.torque = asked
        while not self.drives.reached(only=only):
            seen = self.exchange(np.full(n, self.velocity), np.full(n, self.torque)).size
            reason = self.stopped()
            if reason is not None:
                raise DeviceError(f"the drives did not {what}, the bus process has stopped them by itself: {reason}")
            self.drives.check(seen, only)
            if self.cycle > deadline:
                raise DeviceError(f"the drives did not {what} within {_LEAD_S:g} s")

    def _resolve_revolutions(self, seen: Decoded) -> None:
        """Choose the motor's count of revolutions so that both encoders agree: a single-turn encoder cannot know it."""
        load = float(seen.inputs.load_angle[-1]) * self._bench.gearbox.ratio
        revolutions = round((float(seen.inputs.motor_angle[-1]) - load) / _REVOLUTION)
        self.zeros = replace(self.zeros, motor_angle=self.zeros.motor_angle + revolutions * _REVOLUTION)
        self._require_decoder().scaling = self._scaling()

    def _scaling(self) -> Scaling:
        thermometer = self.assembly.thermometer
        return make_scaling(
            self._bench,
            *self.drives.scales,
            self.assembly.torque_terminal.volt_per_count,
            thermometer.scale,
            thermometer.dtype,
            thermometer.channels > 1,
            self.zeros,
        )

    def _require_decoder(self) -> Decoder:
        if self._decoder is None:
            raise DeviceError("the bench is not open")
        return self._decoder

    def _pace(self, n: int) -> None:
        if self._paced:
            self._due = max(self._due + n * self._bench.bus.cycle_time, time.monotonic() - 1.0)
            time.sleep(max(0.0, self._due - time.monotonic()))
