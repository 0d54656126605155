from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers import analog
from drivers.devices import Place
from drivers.entries import entries_dtype
from drivers.errors import DriverError
from drivers.ethercat import SdoClient
from drivers.pt100 import Pt100Terminal, pt100_terminal
from drivers.pt100.iec60751 import resistance
from tests.drivers.ethercat.scripted import ScriptedSlave

PLACE = Place("temperature_terminal", 4, 0xE0, 0x14, cycle_time_s=0.0005)


def attached(n: int = 6, **options: Any) -> tuple[Pt100Terminal, NDArray[Any]]:
    terminal = pt100_terminal(PLACE, options)
    inputs = np.zeros(n, entries_dtype(terminal.spec.inputs))
    terminal.attach(None, inputs)
    return terminal, inputs


def test_tenths_of_a_degree_with_their_age() -> None:
    terminal, inputs = attached()
    inputs["6000:11"] = [400, 400, 401, 401, 401, 402]
    inputs["6000:01"] = np.array([0, 0, 1, 1, 1, 0]) * analog.TOGGLE
    block = terminal.read(6)
    np.testing.assert_allclose(block.temperature_c, [40.0, 40.0, 40.1, 40.1, 40.1, 40.2])
    np.testing.assert_allclose(block.age_s[2:], np.array([0, 1, 2, 0]) * 0.0005)
    assert block.valid.all()
    assert block.error is None
    # The age goes on over the edge of the block.
    inputs["6000:01"] = 0
    np.testing.assert_allclose(terminal.read(6).age_s, np.arange(1, 7) * 0.0005)


def test_resistance_goes_through_the_standard() -> None:
    terminal, inputs = attached(element="resistance_sixteenths")
    inputs["6000:11"] = np.rint(resistance([20, 30, 40, 50, 60, 70]) * 16)
    np.testing.assert_allclose(terminal.read(6).temperature_c, [20, 30, 40, 50, 60, 70], atol=0.09)


@pytest.mark.parametrize(
    ("status", "words"),
    [
        (analog.OVERRANGE | analog.ERROR, "channel 1: open circuit, or above the range"),
        (analog.UNDERRANGE | analog.ERROR, "channel 1: short circuit, or below the range"),
        (analog.ERROR, "reports an error"),
        (analog.INVALID, "marks its value as invalid"),
    ],
)
def test_faults_are_errors_never_temperatures(status: int, words: str) -> None:
    terminal, inputs = attached()
    inputs["6000:11"] = 400
    inputs["6000:01"][3:] = status
    block = terminal.read(6)
    np.testing.assert_array_equal(block.valid, [True] * 3 + [False] * 3)
    assert np.isnan(block.temperature_c[3:]).all()
    assert block.error is not None
    assert words in block.error


def test_implausible_values_without_a_status_bit() -> None:
    terminal, inputs = attached()
    inputs["6000:11"] = 8500
    block = terminal.read(6)
    assert not block.valid.any()
    assert "850 °C is outside the plausible -50 to 200 °C" in (block.error or "")


def test_two_channels_are_apart() -> None:
    terminal, inputs = attached(channels=2)
    inputs["6000:11"], inputs["6010:11"] = 400, 213
    inputs["6010:01"] = analog.ERROR
    assert terminal.read(6, 1).error is None
    assert "channel 2" in (terminal.read(6, 2).error or "")


def test_element_is_set_read_back_and_compared() -> None:
    terminal = pt100_terminal(PLACE, {"element": "temperature_hundredths", "channels": 2})
    slave = ScriptedSlave(0xE0, 0x14, 1, "terminal")
    terminal.configure(SdoClient(slave, "temperature_terminal"))
    assert [slave.get(index, 0x02, "u1") for index in (0x8000, 0x8010)] == [2, 2]
    assert [slave.get(index, 0x19, "u2") for index in (0x8000, 0x8010)] == [0, 0]
    assert terminal.scale == 0.01


def test_wrong_options() -> None:
    with pytest.raises(DriverError, match="element 'pt500' is not known; one of temperature"):
        pt100_terminal(PLACE, {"element": "pt500"})
    with pytest.raises(DriverError, match="limits: option 'highest' is not known"):
        pt100_terminal(PLACE, {"limits": {"highest": 3}})
