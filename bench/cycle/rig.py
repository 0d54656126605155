"""The rig: the one who owns the bus. Runs phases block by block under the safety step and brings the bench to rest."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from datetime import datetime
from types import TracebackType

import numpy as np

from bench.configuration import BenchFile
from bench.cycle.ahead import make_link
from bench.cycle.assembly import Assembly, assemble, device_errors
from bench.cycle.decode import warm_up
from bench.cycle.end import End, EndKind
from bench.cycle.feed import emit, make_feed, run_guarded
from bench.cycle.link import BusLostError
from bench.cycle.sink import NoSink, SafeSink, Sink
from bench.cycle.stop.climb import Stop
from bench.cycle.stoppable import Stoppable
from bench.cycle.trajectory import Trajectory
from bench.cycle.view import FoundZero
from bench.errors import one_sentence
from bench.protocols import Phase
from bench.safety import Cause, Inputs, LatchFile, SafetyState, Verdict, settings, step

_TARE_S = 1.0
_LOOK_S = 0.2
_NEXT_ACTS = "Next: acknowledge, reset, go on."


class Rig(Stoppable):
    """A bench in operation.

    Parameters
    ----------
    file : the bench configuration.
    seed : of the noise of an emulated plant.
    real_time : pace an emulated bench by the clock.
    assembly : devices to use instead of those the file names (for tests).
    latch : where stops are remembered; in memory if None.
    zero : of the encoders as commissioning found it; that of the bench file if None.
    not_before : time of day at which an emulated bench in fast time begins at the earliest: its time runs ahead of the
        clock, and a campaign that follows another begins after it.
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
        not_before: datetime | None = None,
    ) -> None:
        bench = file.configuration
        link = make_link(
            bench,
            assembly or assemble(bench, seed=seed, real_time=real_time),
            paced=real_time,
            zero=zero.motor_angle if zero else 0.0,
        )
        super().__init__(bench, link, real_time, zero.zero_id if zero else bench.zero_id, latch or LatchFile())
        if not_before is not None and bench.bus.in_process and not real_time:
            self._started = max(self._started, not_before)
        self._assembly, self._cycle_time = link.assembly, bench.bus.cycle_time
        self._limits = settings(
            self.bench.limits, self.bench.gearbox.ratio, self._cycle_time, self.bench.motion.standstill
        )
        self._safety = SafetyState.fresh()
        self._tripped: End | None = None
        self._where = ""

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
            self._link.release()
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

    def run(self, phases: Sequence[Phase], sink: Sink, stop_requested: Callable[[], bool], where: str = "") -> End:
        """Run phases from rest to rest; on a trip or on request bring the bench to rest by the stop ladder.

        ``where`` is the point as an alarm names it, empty for motions that are none.
        ``stop_requested`` is asked between blocks. After anything but FINISHED and EXPIRED the drives are off, and only
        :meth:`enable` gives them torque again.
        """
        if self._tripped is not None:
            sink.event("error", f"stopped before: {self._tripped.text}")
            return self._tripped
        if not self._link.drives.asked_for("ENABLED"):
            return End(EndKind.TRIPPED, "the drives have no voltage; enable() comes first", Cause.INPUT_DRIVE_FAULT)
        sink, self._where = SafeSink(sink), where
        trajectory = Trajectory(phases, self._cycle_time, self._link.velocity, self._link.torque)
        try:
            with device_errors():
                end = self._follow(trajectory, sink, stop_requested)
        except BusLostError as error:
            sink.event("error", str(error))
            end = self._tripped = self._lost(error)
        except Exception as error:  # noqa: BLE001 - nobody leads the motion any more: the ladder has to
            end = self.trip(End(EndKind.TRIPPED, one_sentence(error), Cause.PROGRAM), sink)
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

    def trip(self, end: End, sink: Sink | None = None) -> End:
        """Bring the bench to rest for a reason outside of it (the program of the run), as any other stop; return it.

        Drives that have no voltage any more are left as they are: they were stopped for another reason.
        """
        if self._tripped is not None or not self._link.drives.asked_for("ENABLED"):
            return self._tripped or end
        safe = SafeSink(sink or NoSink())
        safe.event("error", f"stopped: {end.text}")
        try:
            with device_errors():
                self._tripped = self._stop(end, safe)
        except BusLostError:
            self._tripped = end
            self._stops.lost(end)
        return self._tripped or end

    def idle(self, duration_s: float = 0.05) -> None:
        """Keep the bus alive at the last set values while somebody else (a writer that closes) needs the time.

        Limits hold here as well: after a trip the bench is at rest and the next :meth:`run` says why. Drives that are
        off, after a stop, are kept as they are: that they are off is no further reason to stop.
        """
        remaining = self._link.cycles(duration_s)
        try:
            with device_errors():
                while remaining > 0 and self._tripped is None and self._link.drives.asked_for("ENABLED"):
                    n = min(remaining, self._assembly.block)
                    self._link.keep_ahead(self.set_values == (0.0, 0.0))
                    velocity, torque = self.set_values
                    decoded, verdict = run_guarded(self._link, np.full(n, velocity), np.full(n, torque), self._judge)
                    end = self._end_of(verdict)
                    if end is not None:
                        self._tripped = end
                        self._tripped = self._stop(end, NoSink())
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

    # -- private -------------------------------------------------------------------------------------------------------

    def _follow(self, trajectory: Trajectory, sink: SafeSink, stop_requested: Callable[[], bool]) -> End | None:
        """Run a trajectory to its end and return None, or stop the bench and return why."""
        feed = make_feed(self._link, trajectory)
        while not feed.finished:
            if stop_requested():
                sink.event("warning", "stop requested by the operator")
                end = End(EndKind.INTERRUPTED, "stopped on the operator's request", Cause.OPERATOR)
                return self._stop(end, sink)
            fed = feed.next(self._judge)
            if fed is not None:
                emit(fed, sink)
                stop = self._end_of(fed.verdict) or sink.failure
                if stop is not None:
                    sink.event("error", f"stopped: {stop.text}")
                    return self._stop(stop, sink)
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
        if not verdict.tripped:
            return None
        at = f" at {self._where}" if self._where else ""
        return End(EndKind.TRIPPED, f"{verdict.text}{at}. {_NEXT_ACTS}", verdict.cause)

    def _stop(self, end: End, sink: Sink) -> End:
        """Bring the bench to rest; return the end, which says as well if the stop could not be stored."""
        self._stops.stop(end, sink, self._ladder())
        if end.cause is not Cause.OPERATOR:
            self._link.hold_stopped()
        self._link.arm(False)
        end = self._add_storage_failure(end, sink)
        if self._link.is_silent:
            self._tripped = end
        return end

    def _add_storage_failure(self, end: End, sink: Sink) -> End:
        trouble = self._stops.unstored()
        if trouble is None or trouble in end.text:
            return end
        sink.event("error", trouble)
        return replace(end, text=f"{end.text}; {trouble}")

    def _ladder(self) -> Stop:
        self._link.drop_ahead()
        return Stop(self, self.bench, self._cycle_time, self._assembly.block)

    def _lost(self, error: BusLostError) -> End:
        """Return the end of a run whose bus is gone."""
        end = self._tripped or End(EndKind.TRIPPED, str(error), Cause.BUS_ENDED)
        self._stops.lost(end)
        return self._add_storage_failure(end, NoSink())
