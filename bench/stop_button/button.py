"""The button of one run: pressed once, by the first who does; it records what became of it."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

TAKES_TORQUE = ("disable voltage", "stop sending")
"""Rungs of the stop ladder that take the torque away."""


class Step(Protocol):
    """What is asked of one rung of a stop."""

    @property
    def rung(self) -> str:
        """Its name."""
        ...

    @property
    def began_s(self) -> float:
        """When it began after the stop did, s."""
        ...


class Stopped(Protocol):
    """What is asked of the record of a stop."""

    @property
    def rungs(self) -> Sequence[Step]:
        """The rungs in their order."""
        ...

    @property
    def to_rest_s(self) -> float | None:
        """From the begin of the stop until both shafts were seen at rest, s; None where nobody saw it."""
        ...

    @property
    def lasted_s(self) -> float | None:
        """How long the stop took, s; None where nobody led it."""
        ...


@dataclass(frozen=True, slots=True)
class Press:
    """A press: by whom, when by the clock of whoever took it first (Unix time, ns), and when it arrived (monotonic)."""

    by: str
    at_ns: int
    arrived_s: float


class StopButton:
    """Stops one run. May be pressed from any thread and from a signal handler; nothing here takes a lock for long.

    Parameters
    ----------
    run : id of the run.
    """

    def __init__(self, run: str) -> None:
        self.run = run
        # setdefault is one step: of two presses the first one stays, whoever interrupts whom
        self._first: dict[str, Press] = {}
        self._pressed = threading.Event()
        self._at_rest_after_s: float | None = None
        self._torque_rung: tuple[str, int] | None = None
        self._over = False

    def press(self, by: str, at_ns: int | None = None) -> Press:
        """Bring the run's bench to rest; return the press that counts, the first."""
        press = Press(by, time.time_ns() if at_ns is None else at_ns, time.monotonic())
        press = self._first.setdefault("press", press)
        self._pressed.set()
        return press

    @property
    def is_pressed(self) -> bool:
        """Whether the run has to end at rest."""
        return self._pressed.is_set()

    @property
    def at_rest_after_s(self) -> float | None:
        """From the press until both shafts were seen at rest, s; None where nobody saw it, or not yet."""
        return self._at_rest_after_s

    def stopped(self, record: Stopped) -> None:
        """Take the record of a stop of the bench that has just ended."""
        press = self._first.get("press")
        if press is None:
            return
        self._over = True
        if record.to_rest_s is not None and record.lasted_s is not None:
            since_rest_s = record.lasted_s - record.to_rest_s
            self._at_rest_after_s = max(0.0, time.monotonic() - press.arrived_s - since_rest_s)
        step = next((step for step in record.rungs if step.rung in TAKES_TORQUE), None)
        if self._torque_rung is None and step is not None and record.lasted_s is not None:
            self._torque_rung = (step.rung, time.time_ns() - round(1e9 * (record.lasted_s - step.began_s)))

    def ended(self) -> None:
        """The run has ended: what was not seen by now will not be."""
        self._over = True

    def state(self) -> dict[str, Any]:
        """What may be asked: ``running``, ``stopping``, ``at_rest`` (both shafts were seen at rest) or ``not_seen``.

        ``rung`` is the one that took the torque away, ``rung_at_ns`` when it began (Unix time): what a disk that takes
        no record does not know.
        """
        press = self._first.get("press")
        if press is None:
            state = "running"
        elif self._at_rest_after_s is not None:
            state = "at_rest"
        else:
            state = "not_seen" if self._over else "stopping"
        return {
            "run": self.run,
            "state": state,
            "pressed_at_ns": None if press is None else press.at_ns,
            "pressed_by": None if press is None else press.by,
            "at_rest_after_s": self._at_rest_after_s,
            "rung": None if self._torque_rung is None else self._torque_rung[0],
            "rung_at_ns": None if self._torque_rung is None else self._torque_rung[1],
        }
