"""The rig: the one who owns the bus. Runs phases block by block under the safety step and brings the bench to rest."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from datetime import UTC, datetime, timedelta
from types import TracebackType
from typing import Protocol

import numpy as np

from bench.configuration import BenchFile
from bench.cycle.ahead import make_link
from bench.cycle.assembly import Assembly, assemble, device_errors
from bench.cycle.channels import Scaling, Zeros
from bench.cycle.decode import Decoded, warm_up
from bench.cycle.end import End, EndKind
from bench.cycle.feed import Fed, guarded, make_feed
from bench.cycle.link import BusLostError, Link
from bench.cycle.sink import NoSink, SafeSink, Sink
from bench.cycle.stopping import Stop
from bench.cycle.stops import Stops
from bench.cycle.trajectory import Trajectory
from bench.errors import DeviceError
from bench.protocols import Phase
from bench.safety import Cause, Inputs, LatchFile, SafetyState, StopRecord, Verdict, settings, step

__all__ = ["End", "EndKind", "Rig"]

_TARE_S = 1.0
_LOOK_S = 0.2


class FoundZero(Protocol):
    """The common zero of both encoders: its name, and what it takes off the motor's angle, rad."""

    @property
    def zero_id(self) -> str:
        """Its name."""
        ...

    @property
    def motor_angle(self) -> float:
        """Subtracted from the motor's angle beyond the bench file's zero, rad."""
        ...


class Rig:
    """A bench in operation.

    Parameters
    ----------
    file : the bench configuration.
    seed : of the noise of an emulated plant.
    real_time : pace an emulated bench by the clock.
    assembly : devices to use instead of those the file names (for tests).
    latch : where stops are remembered; in memory if None.
    zero : of the encoders as commissioning found it; that of the bench file if None.
    """

    def __init__(
        self,
        file: BenchFile,
        *,
        seed: int = 0,
        real_time: bool = False,
        assembly: Assembly | None = None,
        latch: LatchFile | None = None,
        zero: FoundZero | None = None,
    ) -> None:
        self.bench = file.configuration
        self._real_time = real_time
        self._assembly = assembly or assemble(self.bench, seed=seed, real_time=real_time)
        self._link = make_link(self.bench, self._assembly, paced=real_time, zero=zero.motor_angle if zero else 0.0)
        self.zero_id = zero.zero_id if zero else self.bench.zero_id
        self._cycle_time = self.bench.bus.cycle_time
        self._limits = settings(
            self.bench.limits, self.bench.gearbox.ratio, self._cycle_time, self.bench.motion.standstill
        )
        self._safety = SafetyState.fresh()
        self._tripped: End | None = None
        self._stops = Stops(self, latch or LatchFile())
        self._started = datetime.now(UTC)

    @property
    def link(self) -> Link:
        """The devices, without limits and ladder: for commissioning."""
        return self._link

    @property
    def latch(self) -> LatchFile:
        """What is remembered of stops: after one there is no torque until its three acts are done."""
        return self._stops.latch

    @property
    def stops(self) -> tuple[StopRecord, ...]:
        """Records of the stops since the bench was opened."""
        return tuple(self._stops.records)

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
    def notes(self) -> tuple[str, ...]:
        """What the bus process was not granted, in sentences; empty where there is nothing to say."""
        notes: tuple[str, ...] = getattr(self._assembly.bus, "notes", ())
        return notes

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

    def look(self) -> Verdict:
        """Judge a moment without torque: whether anything asks for a stop as it is, safety circuits included."""
        with device_errors():
            seen = self._link.hold(_LOOK_S)
        return step(SafetyState.fresh(), seen.inputs, False, self._limits)[1]

    def enable(self) -> None:
        """Bring both drives to operation enabled, at standstill and without load.

        Raises
        ------
        DeviceError
            If a drive is in fault or does not follow its state machine.
        """
        self.latch.read().require_clear()
        self._link.velocity = self._link.torque = 0.0
        with device_errors():
            self._link.arm(True)
            self._link.lead("ENABLED", "reach operation enabled")
            self._link.keep_ahead(at_rest=True)
        self._safety, self._tripped = SafetyState.fresh(), None

    def run(self, phases: Sequence[Phase], sink: Sink, stop_requested: Callable[[], bool]) -> End:
        """Run phases from rest to rest; on a trip or on request bring the bench to rest by the stop ladder.

        ``stop_requested`` is asked between blocks. After anything but FINISHED and EXPIRED the drives are off, and only
        :meth:`enable` gives them torque again.
        """
        if self._tripped is not None:
            sink.event("error", f"stopped before: {self._tripped.text}")
            return self._tripped
        if not self._link.asked_for("ENABLED"):
            return End(EndKind.TRIPPED, "the drives have no voltage; enable() comes first", Cause.INPUT_DRIVE_FAULT)
        sink = SafeSink(sink)
        trajectory = Trajectory(phases, self._cycle_time, self._link.velocity, self._link.torque)
        try:
            with device_errors():
                end = self._follow(trajectory, sink, stop_requested)
        except BusLostError as error:
            sink.event("error", str(error))
            end = self._tripped = self._lost(error)
        if end is not None:
            return end
        self._link.keep_ahead(self.set_values == (0.0, 0.0))
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
        remaining = self._link.cycles(duration_s)
        try:
            with device_errors():
                while remaining > 0 and self._tripped is None:
                    n = min(remaining, self._assembly.block)
                    self._link.keep_ahead(self.set_values == (0.0, 0.0))
                    velocity, torque = self.set_values
                    decoded, verdict = guarded(self._link, np.full(n, velocity), np.full(n, torque), self._judge)
                    end = self._end_of(verdict)
                    if end is not None:
                        self._tripped = end
                        self._stop(end, NoSink())
                    remaining -= decoded.size
                if remaining > 0 and self.is_real_time:
                    self._link.hold(remaining * self._cycle_time)
        except BusLostError as error:
            self._tripped = self._lost(error)
            time.sleep(duration_s)

    def shutdown(self) -> None:
        """Ramp down what still moves, take the voltage off both drives."""
        with device_errors(), suppress(BusLostError):  # then the drives' own watchdogs have acted
            self._stops.switch_off(self._ladder())
            self._link.arm(False)

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
        self._rows(decoded, 0, decoded.size, sink)
        return decoded

    @property
    def set_values(self) -> tuple[float, float]:
        """Load-side velocity in rad/s and load torque in N·m as last commanded."""
        return self._link.velocity, self._link.torque

    def drives_off(self) -> bool:
        """Whether both drives say that they have no voltage."""
        return self._link.reached("DISABLED")

    @property
    def drive_states(self) -> dict[str, str]:
        """State of each drive's state machine (CiA 402) as of the last cycle, by role."""
        return self._link.drive_states()

    # -- private -------------------------------------------------------------------------------------------------------

    def _follow(self, trajectory: Trajectory, sink: SafeSink, stop_requested: Callable[[], bool]) -> End | None:
        """Run a trajectory to its end and return None, or stop the bench and return why."""
        feed = make_feed(self._link, trajectory)
        while not feed.finished:
            if stop_requested():
                sink.event("warning", "stop requested by the operator")
                end = End(EndKind.INTERRUPTED, "stopped on the operator's request", Cause.OPERATOR)
                self._stop(end, sink)
                return end
            fed = feed.next(self._judge)
            if fed is not None:
                self._emit(fed, sink)
                stop = self._end_of(fed.verdict) or sink.failure
                if stop is not None:
                    sink.event("error", f"stopped: {stop.text}")
                    self._stop(stop, sink)
                    return stop
            trajectory.observe(self.temperature)
        return None

    def _judge(self, inputs: Inputs) -> Verdict:
        self._safety, verdict = step(self._safety, inputs, True, self._limits)
        return verdict

    def _end_of(self, verdict: Verdict) -> End | None:
        """Return the end a limit, or the bus process by itself, makes of a run; None if there is no reason for one."""
        reason = self._link.stopped()
        if reason is not None:  # whatever the drives show by now follows from it
            text = f"the bus process has stopped the drives by itself: {reason}"
            return End(EndKind.TRIPPED, text, Cause.BUS_STOPPED)
        return End(EndKind.TRIPPED, verdict.text, verdict.cause) if verdict.tripped else None

    def _emit(self, fed: Fed, sink: Sink) -> None:
        begin = fed.start
        for offset, segment in fed.changes:
            self._rows(fed.decoded, begin, offset, sink)
            sink.segment(segment)
            begin = max(begin, offset)
        self._rows(fed.decoded, begin, fed.stop, sink)

    def _rows(self, decoded: Decoded, start: int, stop: int, sink: Sink) -> None:
        if stop <= start:
            return
        # a lost cycle leaves no row
        good = decoded.inputs.good[start:stop]
        rows = {name: values[start:stop] for name, values in decoded.raw.items()}
        sink.rows(rows if good.all() else {name: values[good] for name, values in rows.items()})

    def _stop(self, end: End, sink: Sink) -> None:
        self._stops.stop(end, sink, self._ladder())
        self._link.arm(False)

    def _ladder(self) -> Stop:
        self._link.drop_ahead()
        return Stop(self, self.bench, self._cycle_time, self._assembly.block)

    def _lost(self, error: BusLostError) -> End:
        """Return the end of a run whose bus is gone."""
        end = self._tripped or End(EndKind.TRIPPED, str(error), Cause.BUS_ENDED)
        self._stops.lost(end)
        return end
