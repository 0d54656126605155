"""Alarms: what happened, when, at which point, what to do next; none stands that is over."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from bench.service.alarms.alarm_kinds import kind_of
from bench.service.files.book import Book, local_time
from bench.service.files.disk import Disk
from bench.service.files.kept import Broken


@dataclass(frozen=True, slots=True)
class Alarm:
    """One alarm.

    Attributes
    ----------
    number : counts up.
    at : when it was raised, local time with its offset.
    cause, text : name of the cause, and what happened in a sentence.
    point : which point ran, empty if none did; of the twin's alarm the recording since which it is.
    folder : name of the folder of recordings it is about, empty if it is about none.
    what_to_do : the next acts.
    clears_itself : whether it goes when it is over; else it is acknowledged, and no torque is given before.
    """

    number: int
    at: str
    cause: str
    text: str
    what_to_do: str
    clears_itself: bool = False
    point: str = ""
    folder: str = ""


class Alarms:
    """All alarms that stand; each is written to the book, and those who are to know are notified.

    Parameters
    ----------
    changed : is called when an alarm goes by itself.
    path : file the alarms are kept in, so that a service that was killed comes back with them. Those that clear
        themselves are not taken over: what they said is looked at anew.
    """

    def __init__(
        self,
        book: Book,
        notify: Callable[[Alarm], None],
        changed: Callable[[], None],
        path: Path,
        disk: Disk,
        broken: Broken,
    ) -> None:
        self._book, self._notify, self._changed, self._path, self._disk = book, notify, changed, path, disk
        kept = broken.load(path, lambda entries: [_alarm(entry) for entry in entries]) or []
        self._number = max((alarm.number for alarm in kept), default=0)
        self._alarms = {alarm.number: alarm for alarm in kept if not alarm.clears_itself}

    def raise_(self, cause: str, text: str, point: str = "", folder: str = "") -> Alarm:
        """Raise an alarm, unless the same one already stands; of one that clears itself there is one a cause."""
        kind = kind_of(cause)
        for alarm in self._alarms.values():
            if alarm.cause == cause and (alarm.text == text or kind.clears_itself):
                return alarm
        self._number += 1
        alarm = Alarm(self._number, local_time(), cause, text, kind.next_act, kind.clears_itself, point, folder)
        self._alarms[alarm.number] = alarm
        self._save()
        self._book.write("alarm", "service", text, cause=cause, **({"point": point} if point else {}))
        self._notify(alarm)
        return alarm

    def set(self, cause: str, text: str | None) -> None:
        """Let an alarm that clears itself stand as long as there is a text, and no longer."""
        if text is not None:
            self.raise_(cause, text)
            return
        over = [alarm for alarm in self._alarms.values() if alarm.cause == cause and alarm.clears_itself]
        for alarm in over:
            del self._alarms[alarm.number]
            self._book.write("over", "service", f"over: {alarm.text}", cause=cause)
        if over:
            self._save()
            self._changed()

    def acknowledge(self, number: int, by: str) -> Alarm | None:
        """Acknowledge and remove an alarm; None if there is none of this number that has to be acknowledged."""
        alarm = self._alarms.get(number)
        if alarm is None or alarm.clears_itself:
            return None
        del self._alarms[number]
        self._save()
        self._book.write("acknowledge", by, alarm.text, cause=alarm.cause)
        return alarm

    def to_acknowledge(self) -> bool:
        """Whether an alarm stands that somebody has to read before the bench gets torque."""
        return any(not alarm.clears_itself for alarm in self._alarms.values())

    def current(self) -> list[dict[str, Any]]:
        """For the page, newest first."""
        return [asdict(alarm) for alarm in reversed(self._alarms.values())]

    def _save(self) -> None:
        self._disk.replace(self._path, json.dumps([asdict(alarm) for alarm in self._alarms.values()], indent=1))


def _alarm(entry: dict[str, Any]) -> Alarm:
    """Read an alarm; keys of other versions are ignored."""
    return Alarm(**{key: value for key, value in entry.items() if key in Alarm.__dataclass_fields__})
