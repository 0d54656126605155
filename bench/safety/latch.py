"""After a stop torque comes back by three separate acts of a person: acknowledge, reset, resume.

Acknowledge: the cause has been read. Reset: the cause is gone and the drives have lost their faults; still no torque.
Resume: a run may enable torque again. A latch is a value; :class:`LatchFile` keeps one on disk, so that neither a new
process nor a power cut forgets a stop.
"""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from enum import Enum
from pathlib import Path
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
        """Read what :meth:`as_dict` gave."""
        acts = tuple(Done(**done) for done in data["acts"])
        return cls(Standing(data["standing"]), data["cause"], data["text"], data["at"], acts)


class LatchFile:
    """A latch on disk, or in memory where there is no path."""

    def __init__(self, path: Path | None = None) -> None:
        self.path = path
        self._kept = Latch()

    def read(self) -> Latch:
        """Return the latch; one that cannot be read counts as a stop, because nothing is known of it."""
        if self.path is None:
            return self._kept
        try:
            return Latch.from_dict(json.loads(self.path.read_text("utf-8")))
        except FileNotFoundError:
            return Latch()
        except (OSError, ValueError, KeyError, TypeError) as error:
            return Latch(Standing.STOPPED, "UNKNOWN", f"{self.path} cannot be read: {error}", "")

    def write(self, latch: Latch) -> None:
        """Keep a latch: on the disk when this returns."""
        self._kept = latch
        if self.path is not None:
            write_durably(self.path, latch.as_dict())

    def stopped(self, cause: str, text: str, at: datetime) -> None:
        """Latch a stop."""
        self.write(self.read().stopped(cause, text, at.isoformat(timespec="milliseconds")))

    def act(self, act: Act, by: str) -> Latch:
        """Do an act (see :meth:`Latch.after`) and keep what is then."""
        latch = self.read().after(act, by)
        self.write(latch)
        return latch


def write_durably(path: Path, content: dict[str, Any]) -> None:
    """Write JSON so that after a power cut either the old file or the new one is there, whole."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(path.name + ".new")
    with beside.open("w", encoding="utf-8") as file:
        json.dump(content, file, indent=1, ensure_ascii=False)
        file.flush()
        os.fsync(file.fileno())
    beside.replace(path)
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
