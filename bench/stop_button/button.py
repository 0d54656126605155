"""The button of one run: what was pressed first counts; it records what became of it."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from bench.stop_button.rest import after_press_s, is_own_time

TAKES_TORQUE = ("disable voltage", "stop sending")
"""Rungs of the stop ladder that take the torque away."""


class Step(Protocol):
    """What is asked of one rung of a stop."""

    @property
    def rung(self) -> str:
        """Its name."""
        ...

    @property
    def at_ns(self) -> int | None:
        """When it began, Unix time in ns; None where the bench's time is not the clock's."""
        ...


class Stopped(Protocol):
    """What is asked of the record of a stop."""

    @property
    def rungs(self) -> Sequence[Step]:
        """The rungs in their order."""
        ...

    @property
    def to_rest_s(self) -> float | None:
        """From the begin of the stop until both shafts were at rest, s of the bench; None where nobody saw it."""
        ...

    @property
    def rest_seen_at_ns(self) -> int | None:
        """When both shafts were seen at rest, Unix time in ns; None where the bench's time is not the clock's."""
        ...


@dataclass(frozen=True, slots=True)
class Press:
    """A press: by whom, when by the clock of whoever took it first, and when it arrived here (Unix time, ns).

    A run that was halted hears of a press long after it; a stamp that cannot be right stands for its arrival.
    """

    by: str
    at_ns: int
    arrived_at_ns: int

    @property
    def has_own_time(self) -> bool:
        """Whether ``at_ns`` may be of this computer's clock."""
        return is_own_time(self.at_ns, self.arrived_at_ns)

    @property
    def order_ns(self) -> int:
        """By which presses are put in order, Unix time in ns."""
        return self.at_ns if self.has_own_time else self.arrived_at_ns


class StopButton:
    """Stops one run. May be pressed from any thread and from a signal handler; nothing here takes a lock for long.

    Parameters
    ----------
    run : id of the run.
    """

    def __init__(self, run: str) -> None:
        self.run = run
        # to append is one step: no press is lost, whoever interrupts whom
        self._presses: list[Press] = []
        self._pressed = threading.Event()
        self._stopped: Stopped | None = None
        self._torque_rung: Step | None = None
        self._over = False

    def press(self, by: str, at_ns: int | None = None) -> Press:
        """Bring the run's bench to rest; return the press that counts, the first by its stamp.

        ``at_ns`` is when it was pressed, Unix time; None for now.
        """
        now = time.time_ns()
        self._presses.append(Press(by, now if at_ns is None else at_ns, now))
        self._pressed.set()
        return min(self._presses, key=lambda press: press.order_ns)

    @property
    def is_pressed(self) -> bool:
        """Whether the run has to end at rest."""
        return self._pressed.is_set()

    @property
    def at_rest_after_s(self) -> float | None:
        """From the press until both shafts were seen at rest, s; None where nobody saw it, not yet, or not known."""
        press = self._first()
        if press is None or self._stopped is None or not press.has_own_time:
            return None
        return after_press_s(press.at_ns, self._stopped.rest_seen_at_ns)

    def stopped(self, record: Stopped) -> None:
        """Take the record of a stop of the bench that has just ended."""
        if not self._presses:
            return
        self._over = True
        if self._stopped is None and record.to_rest_s is not None:
            self._stopped = record
        if self._torque_rung is None:
            self._torque_rung = next((step for step in record.rungs if step.rung in TAKES_TORQUE), None)

    def ended(self) -> None:
        """The run has ended: what was not seen by now will not be."""
        self._over = True

    def state(self) -> dict[str, Any]:
        """What may be asked: ``running``, ``stopping``, ``at_rest`` (both shafts were seen at rest) or ``not_seen``.

        ``at_rest_after_s`` counts from the press, by the clock; ``bench_to_rest_s`` from the begin of the stop, by the
        time of a bench that is not the clock's. ``rung`` is the one that took the torque away, ``rung_at_ns`` when it
        began (Unix time): what a disk that takes no record does not know. What is not known is None.
        """
        press, stopped, rung = self._first(), self._stopped, self._torque_rung
        seen_at_ns = None if stopped is None else stopped.rest_seen_at_ns
        if press is None:
            state = "running"
        elif stopped is not None:
            state = "at_rest"
        else:
            state = "not_seen" if self._over else "stopping"
        return {
            "run": self.run,
            "state": state,
            "pressed_at_ns": None if press is None else press.at_ns,
            "pressed_by": None if press is None else press.by,
            "at_rest_after_s": self.at_rest_after_s,
            "rest_seen_at_ns": seen_at_ns,
            "bench_to_rest_s": stopped.to_rest_s if stopped is not None and seen_at_ns is None else None,
            "rung": None if rung is None else rung.rung,
            "rung_at_ns": None if rung is None else rung.at_ns,
        }

    def _first(self) -> Press | None:
        return min(self._presses, key=lambda press: press.order_ns, default=None)
