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
from bench.cycle.channels import DriveScales, Scaling, Zeros, make_scaling
from bench.cycle.decode import Decoded, Decoder
from bench.errors import DeviceError

FloatArray = NDArray[np.float64]
_FIRST_LOOK_S = 0.3
_LEAD_S = 3.0
_TURN = 2.0 * math.pi


@dataclass(frozen=True, slots=True)
class Memory:
    """Everything a replay goes back to."""

    master: Any
    decoder: Any
    sequences: tuple[Any, ...]
    cycle: int


class Link:
    """Bus, drives and terminals of one bench.

    Parameters
    ----------
    bench : the configuration.
    assembly : the devices.
    paced : hold an emulated bench to the clock.

    Attributes
    ----------
    cycle : bus cycles since the link was opened; goes back with a replay.
    velocity, torque : set values after the last cycle, load side, rad/s and N·m.
    last : the last block.
    zeros : what is subtracted from encoders and torque sensor.
    """

    def __init__(self, bench: BenchConfiguration, assembly: Assembly, paced: bool) -> None:
        self.assembly = assembly
        self.cycle = 0
        self.velocity = self.torque = 0.0
        self.last: Decoded | None = None
        self.zeros = Zeros(bench.input_encoder.zero, bench.load_encoder.zero, bench.torque_sensor.zero)
        self._bench = bench
        self._paced = paced and assembly.can_replay
        self._drives: tuple[Any, Any] = (assembly.input_drive, assembly.load_drive)
        self._decoder: Decoder | None = None
        self._shift = 0
        self._due = time.monotonic()

    @property
    def is_open(self) -> bool:
        """Whether process data has been exchanged."""
        return self._decoder is not None

    @property
    def scaling(self) -> Scaling:
        """Scale and offset of every channel; known once the link is open."""
        return self._opened().scaling

    def open(self) -> None:
        """Bring the bus to operation, take the devices' units, find the encoders' common zero."""
        assembly = self.assembly
        bus = assembly.bus
        bus.open()
        try:
            bus.configure()
            for role, drive in zip(("input_drive", "load_drive"), self._drives, strict=True):
                drive.attach(bus.outputs[role], bus.inputs[role])
            assembly.torque_terminal.attach(None, bus.inputs["torque_terminal"])
            assembly.thermometer.attach(None, bus.inputs.get("temperature_terminal"))
            bus.to_operational()
            self._decoder = Decoder(assembly, self._scaling())
            # slow sensors convert for the first time
            first = self.hold(_FIRST_LOOK_S)
            self._resolve_turns(first)
        except BaseException:
            bus.close()
            raise

    def close(self) -> None:
        """Bring all slaves to INIT and close the interface; let go of a thermometer beside the bus."""
        try:
            self.assembly.bus.close()
        finally:
            close = getattr(self.assembly.thermometer, "close", None)
            if close is not None:
                close()

    def tare(self, zero: float) -> None:
        """Subtract ``zero`` in N·m from the torque sensor, beyond what is subtracted already."""
        self.zeros = replace(self.zeros, load_torque=self.zeros.load_torque + zero)
        self._opened().scaling = self._scaling()

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
        first, second = self._drives
        motor_velocity = velocity * self._bench.gearbox.ratio
        first.set_velocity(motor_velocity, n)
        second.set_torque(torque, n)
        first.prepare(n)
        second.prepare(n)
        done = self.assembly.bus.exchange(n)
        n = done.n_done
        if n == 0:
            raise DeviceError("the master exchanged no cycle; the bus is down")
        first.digest(n)
        second.digest(n)
        cycle = done.cycle - self._shift
        decoded = self._opened().decode(n, cycle, done.wkc, motor_velocity[:n])
        self.cycle = int(cycle[-1]) + 1
        self.velocity, self.torque = float(velocity[n - 1]), float(torque[n - 1])
        self.last = decoded
        self._pace(n)
        return decoded

    def remember(self) -> Memory:
        """Return what :meth:`go_back` needs; only where the master can go back."""
        sequences = tuple(drive.sequence for drive in self._drives)
        return Memory(self.assembly.master.snapshot(), self._opened().state(), sequences, self.cycle)

    def go_back(self, memory: Memory) -> None:
        """Return bench and drivers to an earlier moment."""
        self.assembly.master.restore(memory.master)
        self._opened().restore(memory.decoder)
        for drive, sequence in zip(self._drives, memory.sequences, strict=True):
            drive.sequence = sequence
        # the bus goes on counting; the bench's own cycles go back
        self._shift += self.cycle - memory.cycle
        self.cycle = memory.cycle

    def request(self, goal: str) -> None:
        """Ask both drives for a goal of their state machine, by its name."""
        for drive in self._drives:
            # the drives' own enumeration of goals; its class is not ours to import
            drive.request(type(drive.sequence.goal)[goal])

    def reached(self, goal: str | None = None) -> bool:
        """Whether both drives are where they were asked to go (and that is ``goal``)."""
        return all(
            drive.sequence.outcome.name == "REACHED" and goal in (None, drive.sequence.goal.name)
            for drive in self._drives
        )

    def lead(self, goal: str, what: str) -> None:
        """Ask for a goal and run cycles until it is reached.

        Raises
        ------
        DeviceError
            If it is not within three seconds, or a drive is in fault.
        """
        self.request(goal)
        deadline = self.cycle + round(_LEAD_S / self._bench.bus.cycle_time)
        while not self.reached():
            self.exchange(np.full(1, self.velocity), np.full(1, self.torque))
            for drive in self._drives:
                drive.check(1)
            if self.cycle > deadline:
                raise DeviceError(f"the drives did not {what} within {_LEAD_S:g} s")

    def _resolve_turns(self, seen: Decoded) -> None:
        """Choose the motor's turn count so that both encoders agree: a single-turn encoder cannot know it."""
        load = float(seen.inputs.load_angle[-1]) * self._bench.gearbox.ratio
        turns = round((float(seen.inputs.motor_angle[-1]) - load) / _TURN)
        self.zeros = replace(self.zeros, motor_angle=self.zeros.motor_angle + turns * _TURN)
        self._opened().scaling = self._scaling()

    def _scaling(self) -> Scaling:
        thermometer = self.assembly.thermometer
        scales = [
            DriveScales(drive.units.position_rad, drive.units.velocity_rad_s, drive.units.torque_nm)
            for drive in self._drives
        ]
        return make_scaling(
            self._bench,
            scales[0],
            scales[1],
            self.assembly.torque_terminal.volt_per_count,
            thermometer.scale,
            getattr(thermometer, "dtype", "int16"),
            thermometer.channels > 1,
            self.zeros,
        )

    def _opened(self) -> Decoder:
        if self._decoder is None:
            raise DeviceError("the bench is not open")
        return self._decoder

    def _pace(self, n: int) -> None:
        if self._paced:
            self._due = max(self._due + n * self._bench.bus.cycle_time, time.monotonic() - 1.0)
            time.sleep(max(0.0, self._due - time.monotonic()))
