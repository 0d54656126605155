"""Read a slow thermometer in a thread of its own, off the control path: the last reading, with its age."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from drivers.errors import SensorError
from drivers.pt100.measurement import Measurement, Thermometer


@dataclass(frozen=True, slots=True)
class Reading:
    """The last reading as of now.

    Attributes
    ----------
    temperature_c : °C; NaN where there has been none yet. It is held while the device fails: look at age and error.
    age_s : time since the device was asked for it, s (since its conversion changed, where it counts them); ∞ where
        there is none.
    error : sentence on why there is no newer one; None while all is well.
    """

    temperature_c: float
    age_s: float
    error: str | None

    def require(self, name: str, highest_age_s: float) -> float:
        """Return the temperature, °C.

        Raises
        ------
        SensorError
            If the device fails or the reading is older than ``highest_age_s``.
        """
        if self.error is not None:
            raise SensorError(self.error)
        if self.age_s > highest_age_s:
            raise SensorError(f"{name}: the last reading is {self.age_s:.3g} s old, {highest_age_s:g} s are allowed")
        return self.temperature_c


class BackgroundReader:
    """Asks a thermometer again and again.

    Start it before the process takes real-time priority: threads inherit the scheduling of whoever starts them.

    Parameters
    ----------
    thermometer : whom to ask.
    period_s : time between two questions, s.
    clock : monotonic clock, s.
    """

    def __init__(
        self, thermometer: Thermometer, period_s: float = 0.5, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.thermometer = thermometer
        self._period_s = period_s
        self._clock = clock
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._last: Measurement | None = None
        self._asked_at = -math.inf
        self._error: str | None = None
        self._thread = threading.Thread(target=self._run, name=f"thermometer {thermometer.name}", daemon=True)

    def start(self) -> None:
        """Begin to ask."""
        self._thread.start()

    def latest(self) -> Reading:
        """Return the last reading with its age; never waits for the device."""
        now = self._clock()
        with self._lock:
            last, asked_at, error = self._last, self._asked_at, self._error
        if last is None:
            return Reading(math.nan, math.inf, error)
        return Reading(last.temperature_c, now - asked_at, error)

    def ask(self) -> None:
        """Ask once, now: what the thread does every period."""
        asked_at = self._clock()
        try:
            measurement = self.thermometer.measure()
        except SensorError as error:
            with self._lock:
                self._error = str(error)
            return
        with self._lock:
            known = self._last.conversion if self._last is not None else None
            # A device that stopped converting answers for ever: its reading ages all the same.
            if measurement.conversion is None or measurement.conversion != known:
                self._asked_at = asked_at
            self._last = measurement
            self._error = None

    def close(self) -> None:
        """Stop asking and let go of the device."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join()
        self.thermometer.close()

    def _run(self) -> None:
        while not self._stop.is_set():
            self.ask()
            self._stop.wait(self._period_s)
