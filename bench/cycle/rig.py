"""The rig: the one who owns the bus. Runs phases block by block under the safety step and brings the bench to rest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from enum import Enum
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.configuration import BenchFile
from bench.cycle.assembly import Assembly, assemble, device_errors
from bench.cycle.channels import Scaling, Zeros
from bench.cycle.decode import Decoded, warm_up
from bench.cycle.link import Link
from bench.cycle.sink import NoSink, Sink
from bench.cycle.stopping import Stop
from bench.cycle.trajectory import Trajectory
from bench.errors import DeviceError
from bench.protocols import Phase
from bench.safety import Cause, SafetyState, Verdict, settings, step

_TARE_S = 1.0


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
        self._link = Link(self.bench, self._assembly, paced=real_time)
        self._cycle_time = self.bench.bus.cycle_time
        self._limits = settings(
            self.bench.limits, self.bench.gearbox.ratio, self._cycle_time, self.bench.motion.standstill
        )
        self._safety = SafetyState.fresh()
        self._tripped: End | None = None
        self._started = datetime.now(UTC)

    @property
    def source(self) -> str:
        """``emulator`` or ``hardware``, for the recordings."""
        return "emulator" if self.bench.bus.plant is not None else "hardware"

    @property
    def scaling(self) -> Scaling:
        """Scale and offset of every channel; known once the bench is open."""
        return self._link.scaling

    @property
    def zeros(self) -> Zeros:
        """What is subtracted from encoders and torque sensor."""
        return self._link.zeros

    @property
    def temperature(self) -> float:
        """Last lubricant temperature, °C."""
        if self._link.last is None:
            raise DeviceError("the bench has not been read yet; open it first")
        return float(self._link.last.inputs.temperature[-1])

    @property
    def elapsed_s(self) -> float:
        """Bench time since it was opened."""
        return self._link.cycle * self._cycle_time

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
            self._link.open()
            self.tare(float(np.mean(self._link.hold(_TARE_S).inputs.load_torque)))
            self._link.hold(self._cycle_time)

    def tare(self, zero: float) -> None:
        """Subtract ``zero`` in N·m from the torque sensor from now on, beyond what is subtracted already."""
        self._link.tare(zero)

    def reset_faults(self) -> None:
        """Acknowledge faults the drives show from before; an operator's act, never done by itself.

        Raises
        ------
        DeviceError
            If a fault does not go away within 3 s.
        """
        with device_errors():
            self._link.lead("FAULT_RESET", "lose their faults")

    def enable(self) -> None:
        """Bring both drives to operation enabled, at standstill and without load.

        Raises
        ------
        DeviceError
            If a drive is in fault or does not follow its state machine.
        """
        self._link.velocity = self._link.torque = 0.0
        with device_errors():
            self._link.lead("ENABLED", "reach operation enabled")
        self._safety, self._tripped = SafetyState.fresh(), None

    def run(self, phases: Sequence[Phase], sink: Sink, stop_requested: Callable[[], bool]) -> End:
        """Run phases from rest to rest; on a trip or on request bring the bench to rest by the stop ladder.

        ``stop_requested`` is asked between blocks. After anything but FINISHED and EXPIRED the drives are off, and only
        :meth:`enable` gives them torque again.
        """
        if self._tripped is not None:
            sink.event("error", f"stopped before: {self._tripped.text}")
            return self._tripped
        trajectory = Trajectory(phases, self._cycle_time, self._link.velocity, self._link.torque)
        with device_errors():
            while not trajectory.finished:
                if stop_requested():
                    sink.event("warning", "stop requested by the operator")
                    self._stop(Cause.OPERATOR, sink)
                    return End(EndKind.INTERRUPTED, "stopped on the operator's request", Cause.OPERATOR)
                block = trajectory.block(self._assembly.block)
                if block.size:
                    decoded, verdict = self._guarded(block.velocity, block.load_torque)
                    self._emit(decoded, [(change.offset, change.segment) for change in block.changes], sink)
                    if verdict.tripped:
                        sink.event("error", f"stopped: {verdict.text}")
                        self._stop(verdict.cause, sink)
                        return End(EndKind.TRIPPED, verdict.text, verdict.cause)
                trajectory.observe(self.temperature)
        if trajectory.expired is None:
            return End(EndKind.FINISHED)
        phase = trajectory.expired
        text = (
            f"the lubricant is at {self.temperature:.1f} °C after {phase.duration_s / 60.0:.0f} min,"
            f" {phase.temperature:.1f} °C were wanted"
        )
        return End(EndKind.EXPIRED, text)

    def idle(self, duration_s: float = 0.05) -> None:
        """Keep the bus alive at the last set values while somebody else (a writer that closes) needs the time.

        Limits hold here as well: after a trip the bench is at rest and the next :meth:`run` says why.
        """
        remaining = max(1, round(duration_s / self._cycle_time))
        with device_errors():
            while remaining > 0 and self._tripped is None:
                n = min(remaining, self._assembly.block)
                velocity, torque = self.set_values
                _, verdict = self._guarded(np.full(n, velocity), np.full(n, torque))
                if verdict.tripped:
                    self._tripped = End(EndKind.TRIPPED, verdict.text, verdict.cause)
                    self._stop(verdict.cause, NoSink())
                remaining -= n

    def shutdown(self) -> None:
        """Ramp down what still moves, take the voltage off both drives."""
        with device_errors():
            self._stop(Cause.OPERATOR, NoSink())

    def close(self) -> None:
        """Bring all slaves to INIT and close the interface."""
        with device_errors():
            self._link.close()

    def __enter__(self) -> Rig:
        """Open the bench."""
        self.open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Take the voltage off and close, whatever happened."""
        try:
            if self._link.is_open:
                self.shutdown()
        finally:
            self.close()

    # -- for the stop ladder -------------------------------------------------------------------------------------------

    def stop_cycles(self, n: int, velocity: float, torque: float, goal: str | None, sink: Sink) -> Decoded:
        """Run ``n`` cycles of a stop: set values at their end, and a goal for both drives if it changes."""
        if goal is not None:
            self._link.request(goal)
        share = np.arange(1, n + 1) / n
        start_velocity, start_torque = self.set_values
        decoded = self._link.exchange(
            start_velocity + share * (velocity - start_velocity), start_torque + share * (torque - start_torque)
        )
        self._emit(decoded, [], sink)
        return decoded

    @property
    def set_values(self) -> tuple[float, float]:
        """Load-side velocity in rad/s and load torque in N·m as last commanded."""
        return self._link.velocity, self._link.torque

    def drives_off(self) -> bool:
        """Whether both drives say that they have no voltage."""
        return self._link.reached("DISABLED")

    # -- private -------------------------------------------------------------------------------------------------------

    def _guarded(self, velocity: NDArray[np.float64], torque: NDArray[np.float64]) -> tuple[Decoded, Verdict]:
        link = self._link
        memory = link.remember() if velocity.size > 1 and self._assembly.can_replay else None
        decoded = link.exchange(velocity, torque)
        self._safety, verdict = step(self._safety, decoded.inputs, True, self._limits)
        keep = verdict.cycle + 1
        if verdict.tripped and memory is not None and keep < velocity.size:
            link.go_back(memory)
            decoded = link.exchange(velocity[:keep], torque[:keep])
        return decoded, verdict

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
        # a lost cycle leaves no row
        good = decoded.inputs.good[start:stop]
        rows = {name: values[start:stop] for name, values in decoded.raw.items()}
        sink.rows(rows if good.all() else {name: values[good] for name, values in rows.items()})

    def _stop(self, cause: Cause, sink: Sink) -> None:
        Stop(self, self.bench, self._cycle_time, self._assembly.block).run(cause, sink)
