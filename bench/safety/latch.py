"""After a stop torque comes back by three separate acts of a person: acknowledge, reset, resume.

Acknowledge: the cause has been read. Reset: the cause is gone and the drives have lost their faults; still no torque.
Resume: a run may enable torque again. A latch is a value; :class:`~bench.safety.latch_file.LatchFile` keeps one on
disk, so that neither a new process nor a power cut forgets a stop.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from enum import Enum
from typing import Any

from bench.errors import LimitError


class Standing(Enum):
    """Where a bench stands after a stop."""

    CLEAR = "clear"
    STOPPED = "stopped"
    ACKNOWLEDGED = "acknowledged"
    RESET = "reset"


class Act(Enum):
    """What an operator does after a stop."""

    ACKNOWLEDGE = "acknowledge"
    RESET = "reset"
    RESUME = "resume"


NEXT: dict[Standing, Act | None] = {
    Standing.CLEAR: None,
    Standing.STOPPED: Act.ACKNOWLEDGE,
    Standing.ACKNOWLEDGED: Act.RESET,
    Standing.RESET: Act.RESUME,
}
"""The one act that is due."""

_DUE: dict[Standing, int] = {Standing.CLEAR: 0, Standing.RESET: 1, Standing.ACKNOWLEDGED: 2, Standing.STOPPED: 3}
_AFTER: dict[Act, Standing] = {
    Act.ACKNOWLEDGE: Standing.ACKNOWLEDGED,
    Act.RESET: Standing.RESET,
    Act.RESUME: Standing.CLEAR,
}
HOW: dict[Act, str] = {
    Act.ACKNOWLEDGE: "bench acknowledge",
    Act.RESET: "bench reset",
    Act.RESUME: "bench run --resume",
}
"""The command of each act."""


@dataclass(frozen=True, slots=True)
class Done:
    """An act that was done: which, by whom, when (UTC, ISO 8601)."""

    act: str
    by: str
    at: str


@dataclass(frozen=True, slots=True)
class Latch:
    """What is remembered of a stop.

    ``cause`` is the name of the :class:`~bench.safety.causes.Cause`, ``text`` the sentence, ``at`` when (ISO 8601).
    """

    standing: Standing = Standing.CLEAR
    cause: str = ""
    text: str = ""
    at: str = ""
    acts: tuple[Done, ...] = ()

    def stopped(self, cause: str, text: str, at: str) -> Latch:
        """Return the latch after a stop; one that comes before the last was resumed asks for all acts again."""
        return Latch(Standing.STOPPED, cause, text, at)

    def after(self, act: Act, by: str, at: datetime | None = None) -> Latch:
        """Return the latch after an act.

        Raises
        ------
        LimitError
            If another act is due, or none.
        """
        due = NEXT[self.standing]
        if due is not act:
            wanted = "nothing is latched" if due is None else f"{due.value} comes first ({HOW[due]})"
            raise LimitError(f"the bench cannot {act.value} now: {wanted}")
        done = Done(act.value, by, (at or datetime.now(UTC)).isoformat(timespec="seconds"))
        return replace(self, standing=_AFTER[act], acts=(*self.acts, done))

    def require_clear(self, where: str = "") -> None:
        """Refuse torque while a stop is not resumed; ``where`` is what the command of the act is given.

        Raises
        ------
        LimitError
            With what stopped the bench and which act is due.
        """
        due = NEXT[self.standing]
        if due is not None:
            raise LimitError(f"the bench was stopped ({self.text}) and gives no torque: next is {HOW[due]}{where}")

    def as_dict(self) -> dict[str, Any]:
        """Return the latch for JSON."""
        return {**asdict(self), "standing": self.standing.value}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Latch:
        """Read what :meth:`as_dict` gave.

        Raises
        ------
        ValueError, KeyError, TypeError
            If it is anything else.
        """
        acts = tuple(Done(**done) for done in data["acts"])
        texts = (data["cause"], data["text"], data["at"])
        if not all(isinstance(text, str) for text in texts):
            raise TypeError("cause, text and at should be text")
        return cls(Standing(data["standing"]), *texts, acts)

    @property
    def strictness(self) -> int:
        """How many acts are still due, 0 … 3: of several copies that differ the one that asks for most holds."""
        return _DUE[self.standing]
