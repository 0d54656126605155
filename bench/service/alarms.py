"""Alarms in plain words: what happened, and what to do about it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from bench.service.book import Book

_LOOK_THEN_GO_ON = "Find the reason. Then start the campaign again: it goes on where it stopped."

WHAT_TO_DO: dict[str, str] = {
    "MOTOR_SPEED": "Look whether the input drive's tuning or the point's speed is wrong. " + _LOOK_THEN_GO_ON,
    "MOTOR_TORQUE": "Look whether something is stuck or the load is too great. " + _LOOK_THEN_GO_ON,
    "LOAD_TORQUE": "Look at the coupling and at the torque sensor. " + _LOOK_THEN_GO_ON,
    "LOAD_MOTOR_TORQUE": "Look at the coupling and at the load drive. " + _LOOK_THEN_GO_ON,
    "TEMPERATURE_HIGH": "Let the gearbox cool down, look at the oil level. " + _LOOK_THEN_GO_ON,
    "TEMPERATURE_LOW": "Warm up the room, or look at the thermometer. " + _LOOK_THEN_GO_ON,
    "TEMPERATURE_RATE": "No lubricant warms that fast: look at the thermometer's plug and cable.",
    "LOAD_POSITION": "Turn the load side back by hand with the drives off, or choose a shorter motion.",
    "VELOCITY_ERROR": "The input motor does not follow: look for something stuck, and at the drive. "
    + _LOOK_THEN_GO_ON,
    "TORQUE_DISAGREEMENT": "Sensor and load motor do not agree: look at the sensor's cable and the coupling's bolts.",
    "ENCODER_DISAGREEMENT": "The two encoders do not agree: look at couplings and encoder cables before going on.",
    "MOTOR_ENCODER_FROZEN": "The motor encoder gives no new values: look at its cable and at the input drive.",
    "LOAD_ENCODER_FROZEN": "The load encoder gives no new values: look at its cable and at the load drive.",
    "TORQUE_SENSOR_FROZEN": "The torque sensor gives no new values: look at its cable, supply and terminal.",
    "TEMPERATURE_AGE": "The thermometer gives no new values: look at its cable and at the device that reads it.",
    "LOST_CYCLES": "The bus lost cycles: look at network plugs and at what else this computer does.",
    "INPUT_DRIVE_FAULT": "Read the input drive's display. With the reason gone, start again and acknowledge the fault.",
    "LOAD_DRIVE_FAULT": "Read the load drive's display. With the reason gone, start again and acknowledge the fault.",
    "TORQUE_SENSOR_RANGE": "The torque sensor is beyond its range or broken: look at its cable before loading again.",
    "TEMPERATURE_SENSOR": "The thermometer is open or short-circuited: look at its plug and cable.",
    "OPERATOR": "Look whether all is well at the bench. Then start the campaign again: it goes on where it stopped.",
    "EMERGENCY_STOP": "Whoever pressed it knows why. With all clear, release it, acknowledge here and reset the bench.",
    "SAFE_TORQUE_OFF": "The drives were taken their torque: look at guards and safety relay, then reset the bench.",
    "BUS_STOPPED": "The computer did not keep pace, or a program ended: look at what else it does. " + _LOOK_THEN_GO_ON,
    "BUS_ENDED": "The program that sends the frames is gone; the drives stop by their watchdogs. " + _LOOK_THEN_GO_ON,
    "RESET": "Nothing has moved. Take the cause away that is named, then reset the bench again.",
    "DeviceError": "Look at power, network cable and emergency stop of the bench, then start again.",
    "LimitError": "Nothing has moved. Change the campaign, or the limit if it is wrong, and start again.",
    "ConfigurationError": "Nothing has moved. Correct the file that is named, and start again.",
    "DISK": "Move old recordings to the backup, see Storage. Finished points are not repeated.",
    "SILENT": "The bench may still move. Press STOP; if it does not come to rest, use the emergency stop.",
    "KILLED": "The drives have stopped by their own watchdogs. Look at the bench, then start again.",
    "DIED": "The drives have stopped by their own watchdogs. Start again: what was recorded is kept.",
}
"""What to do, by the cause a run ends with."""

OTHERWISE = "Note what happened and show it to whoever looks after the software. What was recorded is kept."


@dataclass(frozen=True, slots=True)
class Alarm:
    """One alarm; times UTC."""

    number: int
    at: str
    cause: str
    text: str
    what_to_do: str
    acknowledged_by: str | None = None


class Alarms:
    """All alarms that are not acknowledged; each is written to the book and told to whoever is to know.

    Parameters
    ----------
    path : file the alarms are kept in, so that a service that was killed comes back with them.
    """

    def __init__(self, book: Book, tell: Callable[[Alarm], None], path: Path) -> None:
        self._book, self._tell, self._path = book, tell, path
        entries = json.loads(path.read_text("utf-8")) if path.exists() else []
        self._alarms: dict[int, Alarm] = {entry["number"]: Alarm(**entry) for entry in entries}
        self._number = max(self._alarms, default=0)

    def raise_(self, cause: str, text: str) -> Alarm:
        """Raise an alarm, unless the same one already stands."""
        standing = next((alarm for alarm in self._alarms.values() if (alarm.cause, alarm.text) == (cause, text)), None)
        if standing is not None:
            return standing
        self._number += 1
        at = datetime.now(UTC).isoformat(timespec="seconds")
        alarm = Alarm(self._number, at, cause, text, WHAT_TO_DO.get(cause, OTHERWISE))
        self._alarms[alarm.number] = alarm
        self._save()
        self._book.write("alarm", "service", text, cause=cause)
        self._tell(alarm)
        return alarm

    def acknowledge(self, number: int, by: str) -> Alarm | None:
        """Take an alarm away; None if there is none of this number (any more)."""
        alarm = self._alarms.pop(number, None)
        if alarm is not None:
            self._save()
            self._book.write("acknowledge", by, alarm.text, cause=alarm.cause)
            alarm = replace(alarm, acknowledged_by=by)
        return alarm

    def standing(self) -> list[dict[str, Any]]:
        """For the page, newest first."""
        return [asdict(alarm) for alarm in reversed(self._alarms.values())]

    def _save(self) -> None:
        part = self._path.with_suffix(".part")
        part.write_text(json.dumps([asdict(alarm) for alarm in self._alarms.values()], indent=1), encoding="utf-8")
        os.replace(part, self._path)
