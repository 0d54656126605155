"""The rig: the one who owns the bus. Runs phases block by block under the safety step and brings the bench to rest."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from enum import Enum
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.configuration import BenchFile
from bench.cycle.assembly import Assembly, assemble, device_errors
from bench.cycle.channels import DriveScales, Scaling, Zeros, make_scaling
from bench.cycle.decode import Decoded, Decoder, warm_up
from bench.cycle.sink import NoSink, Sink
from bench.cycle.stopping import Stop
from bench.cycle.trajectory import Trajectory
from bench.errors import DeviceError
from bench.protocols import Phase
from bench.safety import Cause, SafetyState, Verdict, settings, step

_TARE_S = 1.0
_LEAD_S = 3.0
_TURN = 2.0 * math.pi


def _nothing() -> None:
    """Stand in for what a device does not have."""


class EndKind(Enum):
    """How a run of phases ended."""

    FINISHED = "finished"
    EXPIRED = "a condition was not met in time"
    TRIPPED = "a limit stopped the bench"
    INTERRUPTED = "the operator stopped the bench"


@dataclass(frozen=True, slots=True)
class End:
    """How a run of phases ended, with the sentence for the operator."""

    kind: EndKind
    text: str = ""
    cause: Cause = Cause.NONE


@dataclass(frozen=True, slots=True)
class _Memory:
    """Everything a replay goes back to."""

    master: Any
    decoder: Any
    sequences: tuple[Any, Any]
    cycle: int


class Rig:
    """A bench in operation.

    Parameters
    ----------
    file : the bench configuration.
    seed : of the noise of an emulated plant.
    real_time : pace an emulated bench by the clock.
    assembly : devices to use instead of those the file names (for tests).
    """

    def __init__(
        self, file: BenchFile, *, seed: int = 0, real_time: bool = False, assembly: Assembly | None = None
    ) -> None:
        self.bench = file.configuration
        self._real_time = real_time
        self._assembly = assembly or assemble(self.bench, seed=seed, real_time=real_time)
        self._cycle_time = self.bench.bus.cycle_time
        self._limits = settings(
            self.bench.limits, self.bench.gearbox.ratio, self._cycle_time, self.bench.motion.standstill
        )
        self._safety = SafetyState.fresh()
        self._cycle = 0
        self._cycle_shift = 0
        self._started = datetime.now(UTC)
        self._due = time.monotonic()
        self._velocity = self._torque = 0.0
        self._last: Decoded | None = None
        self._decoder: Decoder | None = None
        self.zeros = Zeros()

    @property
    def source(self) -> str:
        """``emulator`` or ``hardware``, for the recordings."""
        return "emulator" if self.bench.bus.plant is not None else "hardware"

    @property
    def scaling(self) -> Scaling:
        """Scale and offset of every channel; known once the bench is open."""
        return self._open_decoder().scaling

    @property
    def temperature(self) -> float:
        """Last lubricant temperature, °C."""
        if self._last is None:
            raise DeviceError("the bench has not been read yet; open it first")
        return float(self._last.inputs.temperature[-1])

    @property
    def elapsed_s(self) -> float:
        """Bench time since it was opened."""
        return self._cycle * self._cycle_time

    @property
    def now(self) -> datetime:
        """Time of day on the bench, UTC: bench time, which in fast emulation runs ahead of the clock."""
        return self._started + timedelta(seconds=self.elapsed_s)

    @property
    def is_real_time(self) -> bool:
        """Whether bench time is the clock's."""
        return self._real_time or not self._assembly.can_replay

    def open(self) -> None:
        """Bring the bus to operation, find the encoders' common zero, tare the torque sensor; nothing moves.

        Raises
        ------
        DeviceError
            If a slave is missing, of the wrong identity, or does not reach operation.
        """
        warm_up(self._limits)
        with device_errors():
            self._assembly.bus.open()
            try:
                self._start_bus()
            except BaseException:
                self._assembly.bus.close()
                raise

    def reset_faults(self) -> None:
        """Acknowledge faults the drives show from before; an operator's act, never done by itself.

        Raises
        ------
        DeviceError
            If a fault does not go away within 3 s.
        """
        with device_errors():
            self._lead("FAULT_RESET", "lose their faults")

    def enable(self) -> None:
        """Bring both drives to operation enabled, at standstill and without load.

        Raises
        ------
        DeviceError
            If a drive is in fault or does not follow its state machine.
        """
        self._velocity = self._torque = 0.0
        with device_errors():
            self._lead("ENABLED", "reach operation enabled")
        self._safety = SafetyState.fresh()

    def run(self, phases: Sequence[Phase], sink: Sink, stop_requested: Callable[[], bool]) -> End:
        """Run phases from rest to rest; on a trip or on request bring the bench to rest by the stop ladder.

        ``stop_requested`` is asked between blocks. After anything but FINISHED and EXPIRED the drives are off, and only
        :meth:`enable` gives them torque again.
        """
        trajectory = Trajectory(phases, self._cycle_time, self._velocity, self._torque)
        with device_errors():
            while not trajectory.finished:
                if stop_requested():
                    sink.event("warning", "stop requested by the operator")
                    self._stop(Cause.OPERATOR, sink)
                    return End(EndKind.INTERRUPTED, "stopped on the operator's request", Cause.OPERATOR)
                block = trajectory.block(self._assembly.block)
                if block.size == 0:
                    trajectory.observe(self.temperature)
                    continue
                decoded, verdict = self._guarded(block.velocity, block.load_torque)
                self._emit(decoded, [(change.offset, change.segment) for change in block.changes], sink)
                if verdict.tripped:
                    sink.event("error", f"stopped: {verdict.text}")
                    self._stop(verdict.cause, sink)
                    return End(EndKind.TRIPPED, verdict.text, verdict.cause)
                trajectory.observe(self.temperature)
        if trajectory.expired is not None:
            phase = trajectory.expired
            text = (
                f"the lubricant is at {self.temperature:.1f} °C after {phase.duration_s / 60.0:.0f} min, "
                f"{phase.temperature:.1f} °C were wanted"
            )
            return End(EndKind.EXPIRED, text)
        return End(EndKind.FINISHED)

    def idle(self, duration_s: float = 0.05) -> None:
        """Keep the bus alive at the last set values while somebody else (a writer that closes) needs the time."""
        n = max(1, round(duration_s / self._cycle_time))
        with device_errors():
            while n > 0:
                take = min(n, self._assembly.block)
                self._cycles(take)
                n -= take

    def tare(self, zero: float) -> None:
        """Subtract ``zero`` in N·m from the torque sensor from now on, beyond what is subtracted already."""
        self.zeros = replace(self.zeros, load_torque=self.zeros.load_torque + zero)
        self._open_decoder().scaling = self._scaling()

    def _torque_at_rest(self) -> float:
        """Return the torque sensor's mean reading in N·m over a second, beyond what is tared already."""
        total, count = 0.0, 0
        with device_errors():
            while count * self._cycle_time < _TARE_S:
                decoded = self._cycles(min(self._assembly.block, max(1, round(_TARE_S / self._cycle_time))))
                total += float(decoded.inputs.load_torque.sum())
                count += decoded.size
        return total / count

    def shutdown(self) -> None:
        """Ramp down what still moves, take the voltage off both drives."""
        with device_errors():
            self._stop(Cause.OPERATOR, NoSink())

    def close(self) -> None:
        """Bring all slaves to INIT and close the interface."""
        with device_errors():
            try:
                self._assembly.bus.close()
            finally:
                # a thermometer beside the bus has a thread and a line of its own
                getattr(self._assembly.thermometer, "close", _nothing)()

    def __enter__(self) -> Rig:
        """Open the bench."""
        self.open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Take the voltage off and close, whatever happened."""
        try:
            if self._decoder is not None:
                self.shutdown()
        finally:
            self.close()

    # -- for the stop ladder -------------------------------------------------------------------------------------------

    def stop_cycles(self, n: int, velocity: float, torque: float, goal: str | None, sink: Sink) -> Decoded:
        """Run ``n`` cycles of a stop: set values at their end, and a goal for both drives if it changes."""
        if goal is not None:
            self._request(goal)
        share = np.arange(1, n + 1) / n
        velocities = self._velocity + share * (velocity - self._velocity)
        torques = self._torque + share * (torque - self._torque)
        decoded = self._exchange(velocities, torques)
        self._velocity, self._torque = velocity, torque
        self._emit(decoded, [], sink)
        return decoded

    @property
    def set_values(self) -> tuple[float, float]:
        """Load-side velocity in rad/s and load torque in N·m as last commanded."""
        return self._velocity, self._torque

    def drives_off(self) -> bool:
        """Whether both drives say that they have no voltage."""
        return self._reached() and all(drive.sequence.goal.name == "DISABLED" for drive in self._drives())

    # -- private -------------------------------------------------------------------------------------------------------

    def _start_bus(self) -> None:
        assembly = self._assembly
        bus = assembly.bus
        bus.configure()
        assembly.input_drive.attach(bus.outputs["input_drive"], bus.inputs["input_drive"])
        assembly.load_drive.attach(bus.outputs["load_drive"], bus.inputs["load_drive"])
        assembly.torque_terminal.attach(None, bus.inputs["torque_terminal"])
        assembly.thermometer.attach(None, bus.inputs.get("temperature_terminal"))
        bus.to_operational()
        self._decoder = Decoder(assembly, self._scaling())
        # the first conversions of slow sensors, then where everything stands
        for _ in range(max(1, round(0.3 / self._cycle_time / assembly.block))):
            first = self._cycles(min(assembly.block, round(0.3 / self._cycle_time)))
        self.zeros = self._find_zeros(first)
        self._decoder.scaling = self._scaling()
        self.tare(self._torque_at_rest())
        self._cycles(1)

    def _find_zeros(self, seen: Decoded) -> Zeros:
        """Choose the motor's turn count so that both encoders agree: a single-turn encoder cannot know it."""
        bench = self.bench
        zeros = Zeros(bench.input_encoder.zero, bench.load_encoder.zero, bench.torque_sensor.zero)
        motor = float(seen.inputs.motor_angle[-1]) - zeros.motor_angle
        load = float(seen.inputs.load_angle[-1]) - zeros.load_angle
        turns = round((motor - load * bench.gearbox.ratio) / _TURN)
        return replace(zeros, motor_angle=zeros.motor_angle + turns * _TURN)

    def _scaling(self) -> Scaling:
        assembly = self._assembly

        def scales(drive: Any) -> DriveScales:
            return DriveScales(drive.units.position_rad, drive.units.velocity_rad_s, drive.units.torque_nm)

        return make_scaling(
            self.bench,
            scales(assembly.input_drive),
            scales(assembly.load_drive),
            assembly.torque_terminal.volt_per_count,
            assembly.thermometer.scale,
            getattr(assembly.thermometer, "dtype", "int16"),
            assembly.thermometer.channels > 1,
            self.zeros,
        )

    def _drives(self) -> tuple[Any, Any]:
        return self._assembly.input_drive, self._assembly.load_drive

    def _request(self, goal: str) -> None:
        for drive in self._drives():
            # the drives' own enumeration of goals; its class is not ours to import
            drive.request(type(drive.sequence.goal)[goal])

    def _lead(self, goal: str, what: str) -> None:
        self._request(goal)
        deadline = self._cycle + round(_LEAD_S / self._cycle_time)
        while not self._reached():
            self._cycles(1)
            for drive in self._drives():
                drive.check(1)
            if self._cycle > deadline:
                raise DeviceError(f"the drives did not {what} within {_LEAD_S:g} s")

    def _reached(self) -> bool:
        return all(drive.sequence.outcome.name == "REACHED" for drive in self._drives())

    def _open_decoder(self) -> Decoder:
        if self._decoder is None:
            raise DeviceError("the bench is not open")
        return self._decoder

    def _cycles(self, n: int) -> Decoded:
        return self._exchange(np.full(n, self._velocity), np.full(n, self._torque))

    def _guarded(self, velocity: NDArray[np.float64], torque: NDArray[np.float64]) -> tuple[Decoded, Verdict]:
        memory = self._remember() if velocity.size > 1 and self._assembly.can_replay else None
        decoded = self._exchange(velocity, torque)
        self._safety, verdict = step(self._safety, decoded.inputs, True, self._limits)
        keep = verdict.cycle + 1 if verdict.tripped else decoded.size
        if memory is not None and keep < decoded.size:
            self._go_back(memory)
            decoded = self._exchange(velocity[:keep], torque[:keep])
        self._velocity, self._torque = float(velocity[keep - 1]), float(torque[keep - 1])
        return decoded, verdict

    def _remember(self) -> _Memory:
        first, second = self._drives()
        return _Memory(
            self._assembly.master.snapshot(),
            self._open_decoder().state(),
            (first.sequence, second.sequence),
            self._cycle,
        )

    def _go_back(self, memory: _Memory) -> None:
        self._assembly.master.restore(memory.master)
        self._open_decoder().restore(memory.decoder)
        for drive, sequence in zip(self._drives(), memory.sequences, strict=True):
            drive.sequence = sequence
        # the bus goes on counting; the bench's own cycles go back
        self._cycle_shift += self._cycle - memory.cycle
        self._cycle = memory.cycle

    def _exchange(self, velocity: NDArray[np.float64], torque: NDArray[np.float64]) -> Decoded:
        n = velocity.size
        motor_velocity = velocity * self.bench.gearbox.ratio
        first, second = self._drives()
        first.set_velocity(motor_velocity, n)
        second.set_torque(torque, n)
        first.prepare(n)
        second.prepare(n)
        done = self._assembly.bus.exchange(n)
        n = done.n_done
        if n == 0:
            raise DeviceError("the master exchanged no cycle; the bus is down")
        first.digest(n)
        second.digest(n)
        cycle = done.cycle - self._cycle_shift
        decoded = self._open_decoder().decode(n, cycle, done.wkc, motor_velocity[:n])
        self._cycle = int(cycle[-1]) + 1
        self._last = decoded
        self._pace(n)
        return decoded

    def _pace(self, n: int) -> None:
        if not (self._real_time and self._assembly.can_replay):
            return
        self._due = max(self._due + n * self._cycle_time, time.monotonic() - 1.0)
        time.sleep(max(0.0, self._due - time.monotonic()))

    def _emit(self, decoded: Decoded, changes: Sequence[tuple[int, Any]], sink: Sink) -> None:
        begin = 0
        for offset, segment in changes:
            if offset >= decoded.size:
                break
            self._rows(decoded, begin, offset, sink)
            sink.segment(segment)
            begin = offset
        self._rows(decoded, begin, decoded.size, sink)

    def _rows(self, decoded: Decoded, start: int, stop: int, sink: Sink) -> None:
        if stop <= start:
            return
        good = decoded.inputs.good[start:stop]
        rows = {name: values[start:stop] for name, values in decoded.raw.items()}
        sink.rows(rows if good.all() else {name: values[good] for name, values in rows.items()})

    def _stop(self, cause: Cause, sink: Sink) -> None:
        Stop(self, self.bench, self._cycle_time, self._assembly.block).run(cause, sink)
