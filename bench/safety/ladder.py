"""The stop ladder as a pure function: which rung comes next, given what the bench shows."""

from __future__ import annotations

from dataclasses import dataclass

from bench.safety.causes import Rung


@dataclass(frozen=True, slots=True)
class Deadlines:
    """How long each rung may take, s."""

    controlled_ramp: float
    quick_stop: float
    disable_voltage: float


@dataclass(frozen=True, slots=True)
class LadderState:
    """Rung in force and the time spent on it, s."""

    rung: Rung
    elapsed_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Observation:
    """What is seen of the bench: both shafts at rest, no set torque left, both drives without power, bus alive."""

    at_rest: bool
    load_off: bool
    drives_off: bool
    bus_alive: bool = True


def climb(state: LadderState, seen: Observation, step_s: float, deadlines: Deadlines) -> LadderState:
    """Return the state after ``step_s`` more seconds.

    A rung that did its work is followed by DISABLE_VOLTAGE, one that did not in time by the next harder one. A dead bus
    leaves only silence: the drives' watchdogs act.
    """
    if state.rung in (Rung.NONE, Rung.FINISHED):
        return state
    if not seen.bus_alive and state.rung < Rung.STOP_SENDING:
        return LadderState(Rung.STOP_SENDING)
    elapsed = state.elapsed_s + step_s
    done = {
        Rung.CONTROLLED_RAMP: seen.at_rest and seen.load_off,
        Rung.QUICK_STOP: seen.at_rest,
        Rung.DISABLE_VOLTAGE: seen.at_rest and seen.drives_off,
        Rung.STOP_SENDING: True,
    }[state.rung]
    if done:
        ended = state.rung >= Rung.DISABLE_VOLTAGE
        return LadderState(Rung.FINISHED if ended else Rung.DISABLE_VOLTAGE)
    limit = {
        Rung.CONTROLLED_RAMP: deadlines.controlled_ramp,
        Rung.QUICK_STOP: deadlines.quick_stop,
        Rung.DISABLE_VOLTAGE: deadlines.disable_voltage,
        Rung.STOP_SENDING: 0.0,
    }[state.rung]
    return LadderState(Rung(state.rung + 1)) if elapsed >= limit else LadderState(state.rung, elapsed)
