from __future__ import annotations

import math
import threading

import pytest

from drivers.errors import SensorError
from drivers.pt100 import BackgroundReader, Measurement


class Script:
    """Answers with what stands next in a list; the last answer for ever."""

    name = "lubricant"

    def __init__(self, *answers: Measurement | SensorError) -> None:
        self.answers = list(answers)
        self.asked = threading.Event()
        self.closed = False

    def measure(self) -> Measurement:
        answer = self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]
        self.asked.set()
        if isinstance(answer, SensorError):
            raise answer
        return answer

    def close(self) -> None:
        self.closed = True


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def test_readings_age_until_the_next() -> None:
    clock = Clock()
    reader = BackgroundReader(Script(Measurement(40.0), Measurement(41.0)), clock=clock)
    first = reader.latest()
    assert math.isnan(first.temperature_c)
    assert first.age_s == math.inf
    reader.ask()
    clock.now += 1.5
    assert (reader.latest().temperature_c, reader.latest().age_s) == (40.0, 1.5)
    reader.ask()
    assert (reader.latest().temperature_c, reader.latest().age_s) == (41.0, 0.0)


def test_a_failure_holds_the_last_reading_and_says_so() -> None:
    clock = Clock()
    reader = BackgroundReader(
        Script(Measurement(40.0), SensorError("lubricant: open circuit"), Measurement(42.0)), clock=clock
    )
    reader.ask()
    clock.now += 2.0
    reader.ask()
    reading = reader.latest()
    assert (reading.temperature_c, reading.age_s, reading.error) == (40.0, 2.0, "lubricant: open circuit")
    with pytest.raises(SensorError, match="open circuit"):
        reading.require("lubricant", highest_age_s=10.0)
    reader.ask()
    assert reader.latest().require("lubricant", highest_age_s=1.0) == 42.0


def test_a_device_that_answers_without_converting_ages() -> None:
    clock = Clock()
    reader = BackgroundReader(Script(Measurement(40.0, conversion=7)), clock=clock)
    for _ in range(5):
        reader.ask()
        clock.now += 1.0
    assert reader.latest().age_s == 5.0
    with pytest.raises(SensorError, match="the last reading is 5 s old, 3 s are allowed"):
        reader.latest().require("lubricant", highest_age_s=3.0)


def test_the_thread_asks_by_itself_and_ends() -> None:
    script = Script(Measurement(40.0))
    reader = BackgroundReader(script, period_s=0.001)
    reader.start()
    assert script.asked.wait(2.0)
    reader.close()
    assert script.closed
    assert reader.latest().temperature_c == 40.0
    assert not any(thread.name == "thermometer lubricant" for thread in threading.enumerate())
