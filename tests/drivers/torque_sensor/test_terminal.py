import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers import analog
from drivers.devices import Place
from drivers.entries import entries_dtype
from drivers.errors import DriverError
from drivers.torque_sensor import AnalogInput, TorqueScale, analog_input

PLACE = Place("torque_terminal", 3, 0xE0, 0x13)


@given(
    zero=st.floats(-500, 500),
    polarity=st.sampled_from([1, -1]),
    counts=st.lists(st.integers(-32768, 32767), min_size=1, max_size=20),
)
def test_torque_is_linear_in_counts_from_the_tared_zero(zero: float, polarity: int, counts: list[int]) -> None:
    scale = TorqueScale(10.0 / 32768, 1000.0, polarity, zero)
    torque = scale.torque(np.array(counts, np.int16))
    np.testing.assert_allclose(torque, polarity * (np.array(counts) - zero) * 10_000 / 32768, atol=1e-8)
    np.testing.assert_allclose(scale.torque([zero]), 0.0, atol=1e-9)
    # SI value = raw · scale + offset, as a recording keeps it.
    np.testing.assert_allclose(torque, np.array(counts) * scale.newton_metre_per_count + scale.offset_nm)


def test_saturated_and_marked_readings_are_no_measurements() -> None:
    terminal = analog_input(PLACE, {})
    inputs = np.zeros(6, entries_dtype(terminal.spec.inputs))
    terminal.attach(None, inputs)
    inputs["6000:11"] = [0, 32766, 32767, -32767, -32768, 100]
    inputs["6000:01"][5] = analog.ERROR
    np.testing.assert_array_equal(terminal.usable(6), [True, True, False, False, False, False])
    np.testing.assert_array_equal(terminal.counts(2), [0, 32766])
    assert terminal.volt_per_count * 32768 == pytest.approx(10.0)


def test_twelve_bits_saturate_where_twelve_bits_end() -> None:
    terminal = AnalogInput(PLACE, bits=12, full_scale_count=2048)
    inputs = np.zeros(2, entries_dtype(terminal.spec.inputs))
    terminal.attach(None, inputs)
    inputs["6000:11"] = [2046, 2047]
    np.testing.assert_array_equal(terminal.usable(2), [True, False])


def test_reading_before_attachment_is_told() -> None:
    with pytest.raises(DriverError, match="torque_terminal has no process data yet"):
        AnalogInput(PLACE).counts(1)
