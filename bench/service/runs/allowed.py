"""What may be done now: a table of states and acts, the same for the page and for the API that refuses."""

from __future__ import annotations

from dataclasses import dataclass

RUNNING = frozenset({"measuring_zero", "measuring", "heating"})
PHASES = frozenset({"free", "opening", "paused", "stopping", "resetting", "by_hand", "taring", "ended"}) | RUNNING
"""Every phase of the bench; ``ended`` is a run whose process is about to go."""

DONE = {
    "pause": "it pauses after this point",
    "go_on": "it goes on",
    "skip": "the point is left out",
    "repeat": "the point is measured once more",
    "note": "written down: {}",
}
"""What a wish passed on to the run does, for the page and the book."""


@dataclass(frozen=True, slots=True)
class Situation:
    """What decides: the phase, whether the queue is held, whether there are runs waiting and ended."""

    phase: str
    held: bool = False
    waiting: bool = False
    proposed: bool = False
    ended: bool = False
    alarms: bool = False
    """Whether an alarm stands that has to be acknowledged: until then nothing gives torque."""
    pausing: bool = False
    """Whether a pause was asked for that has not come yet."""
    due: str = ""
    """Act that is due after a stop: ``acknowledge``, ``reset``, ``resume``, or nothing."""


BEGINS = frozenset({"start", "jog", "tare", "queue", "approve", "again", "reset", "go_on"})
"""Acts after which something may move or be powered; none while an alarm waits to be acknowledged."""

_IN_PHASES: dict[str, frozenset[str]] = {
    "pause": RUNNING,
    "go_on": frozenset({"paused"}),
    "skip": RUNNING | {"paused"},
    "repeat": RUNNING | {"paused"},
    "note": RUNNING | {"paused"},
    "abort": RUNNING | {"paused", "opening", "by_hand", "taring"},
}


def allowed_acts(now: Situation) -> frozenset[str]:
    """Return the acts that are possible now for whoever holds the controls; ``stop`` is always, for anybody."""
    acts = {act for act, phases in _IN_PHASES.items() if now.phase in phases}
    acts |= {"stop"}
    acts = acts - {"pause"} | {"go_on"} if now.pausing and now.phase in RUNNING else acts
    free = now.phase == "free"
    acts |= {"start"} if now.due in ("", "resume") else set()
    # what waits would begin as soon as the button is let go
    acts |= {"jog", "tare"} if free and not now.due and not now.waiting else set()
    acts |= {"queue"} if now.held and now.waiting else set()
    acts |= {"approve"} if now.proposed else set()
    acts |= {"withdraw"} if now.proposed or now.waiting else set()
    acts |= {"again"} if free and now.ended and now.due in ("", "resume") else set()
    acts |= {"reset"} if free and (now.due == "reset" or (now.ended and not now.due)) else set()
    if now.alarms:
        acts = acts - BEGINS | {"acknowledge"}
    return frozenset(acts)


def why_not(act: str, now: Situation) -> str:
    """Return the sentence for an act that is not possible now."""
    if now.alarms and act in BEGINS:
        return f"{act.replace('_', ' ')} is not possible now: there is an alarm, next is to acknowledge it"
    if now.phase == "free" and now.due and now.due != act:
        return f"{act.replace('_', ' ')} is not possible now: the bench was stopped, next is to {now.due}"
    phase = {"free": "nothing runs", "opening": "the bench is being opened", "ended": "the run has ended"}.get(
        now.phase, f"the bench is {now.phase.replace('_', ' ')}"
    )
    return f"{act.replace('_', ' ')} is not possible now: {phase}"
