import pytest

from drivers.errors import SensorError
from drivers.pt100 import Range
from drivers.pt100.measurement import from_resistance, from_temperature

LIMITS = Range()


@pytest.mark.parametrize("ohm", [1e6, 301.0, float("inf"), float("nan")])
def test_open_circuit(ohm: float) -> None:
    with pytest.raises(SensorError, match="lubricant: open circuit"):
        from_resistance("lubricant", ohm, LIMITS)


@pytest.mark.parametrize("ohm", [0.0, 2.5, 59.9, -1.0])
def test_short_circuit(ohm: float) -> None:
    with pytest.raises(SensorError, match="lubricant: short circuit"):
        from_resistance("lubricant", ohm, LIMITS)


def test_limits_of_a_pt1000_are_ten_times_as_high() -> None:
    assert from_resistance("lubricant", 1097.3, LIMITS, r0=1000.0).temperature_c == pytest.approx(25.0, abs=0.02)


def test_a_temperature_keeps_its_resistance() -> None:
    found = from_resistance("lubricant", 119.40, LIMITS)
    assert found.temperature_c == pytest.approx(50.0, abs=0.01)
    assert found.resistance_ohm == 119.40


@pytest.mark.parametrize("t", [850.0, -200.0, 3276.7, -50.1, float("nan")])
def test_device_codes_for_broken_sensors_are_no_temperatures(t: float) -> None:
    with pytest.raises(SensorError, match=r"is outside the plausible -50 to 200 °C"):
        from_temperature("lubricant", t, LIMITS)
