import math
from dataclasses import dataclass

import numpy as np
import pytest

from bench.cycle.slow import Reader, SlowThermometer


@dataclass
class Reading:
    temperature_c: float
    age_s: float
    error: str | None = None


class Fake:
    def __init__(self, reading: Reading) -> None:
        self.reading, self.running = reading, False

    def start(self) -> None:
        self.running = True

    def latest(self) -> Reading:
        return self.reading

    def close(self) -> None:
        self.running = False


def test_every_cycle_holds_the_last_reading_with_its_age() -> None:
    lubricant, ambient = Fake(Reading(31.2345, 0.4)), Fake(Reading(21.0, 1.0))
    readers: list[Reader] = [lubricant, ambient]
    thermometer = SlowThermometer(readers, 0.0005)
    thermometer.attach(None, None)
    assert lubricant.running
    assert thermometer.channels == 2
    block = thermometer.read(4)
    assert block.raw.tolist() == [31234] * 4 or block.raw.tolist() == [31235] * 4
    assert block.raw.dtype == thermometer.dtype
    assert block.temperature_c.tolist() == [31.2345] * 4
    assert block.age_s == pytest.approx([0.3985, 0.399, 0.3995, 0.4])
    assert thermometer.read(2, 2).raw.tolist() == [21000, 21000]
    thermometer.close()
    assert not lubricant.running
    assert not ambient.running


def test_an_error_is_never_a_temperature() -> None:
    readers: list[Reader] = [Fake(Reading(30.0, 2.0, "open circuit"))]
    assert np.isnan(SlowThermometer(readers, 0.0005).read(3).temperature_c).all()


def test_no_reading_yet_is_infinitely_old() -> None:
    readers: list[Reader] = [Fake(Reading(math.nan, math.inf))]
    block = SlowThermometer(readers, 0.0005).read(3)
    assert np.isinf(block.age_s).all()
    assert np.isnan(block.temperature_c).all()
