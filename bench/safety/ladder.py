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
    look: float = 1.0
    """How long both shafts are waited for, once no drive has voltage."""


@dataclass(frozen=True, slots=True)
class LadderState:
    """Rung in force and the time spent on it, s."""

    rung: Rung
    elapsed_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Observation:
    """What is seen of the bench.

    ``at_rest``: nothing is commanded and the input shaft is slow; ``load_off``: no set torque is left; ``drives_off``:
    no drive has voltage; ``seen_at_rest``: both shafts have been slow for a while.
    """

    at_rest: bool
    load_off: bool
    drives_off: bool
    bus_alive: bool = True
    seen_at_rest: bool = True


def climb(state: LadderState, seen: Observation, step_s: float, deadlines: Deadlines) -> LadderState:
    """Return the state after ``step_s`` more seconds.

    A rung that did its work is followed by DISABLE_VOLTAGE, one that did not in time by the next harder one. A dead bus
    leaves only silence: the drives' watchdogs act. Without voltage the input shaft has to come to rest; that the load
    shaft does as well is waited for, but a sensor that does not show it keeps no stop from ending.
    """
    if state.rung in (Rung.NONE, Rung.FINISHED):
        return state
    if not seen.bus_alive and state.rung < Rung.STOP_SENDING:
        return LadderState(Rung.STOP_SENDING)
    elapsed = state.elapsed_s + step_s
    done = {
        Rung.CONTROLLED_RAMP: seen.at_rest and seen.load_off,
        Rung.QUICK_STOP: seen.at_rest,
        Rung.DISABLE_VOLTAGE: seen.at_rest and seen.drives_off and (seen.seen_at_rest or elapsed >= deadlines.look),
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
