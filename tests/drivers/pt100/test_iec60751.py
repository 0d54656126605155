import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.pt100.iec60751 import resistance, temperature

TABLE = {
    -200: 18.52,
    -150: 39.72,
    -100: 60.26,
    -50: 80.31,
    -10: 96.09,
    0: 100.00,
    10: 103.90,
    25: 109.73,
    50: 119.40,
    100: 138.51,
    150: 157.33,
    200: 175.86,
    300: 212.05,
    400: 247.09,
    500: 280.98,
    600: 313.71,
    700: 345.28,
    850: 390.48,
}
"""Resistances of a PT100 as IEC 60751 tabulates them, Ω by °C."""


@pytest.mark.parametrize(("t", "ohm"), TABLE.items())
def test_resistances_of_the_standards_table(t: float, ohm: float) -> None:
    # The table is rounded half up: 138.5055 is printed as 138.51.
    assert float(resistance(t)) == pytest.approx(ohm, abs=0.00501)


@given(st.floats(-200.0, 850.0))
def test_back_and_forth(t: float) -> None:
    assert float(temperature(resistance(t))) == pytest.approx(t, abs=1e-9)


@given(st.floats(-200.0, 850.0))
def test_pt1000_is_ten_times_a_pt100(t: float) -> None:
    assert float(resistance(t, r0=1000.0)) == pytest.approx(10 * float(resistance(t)))
    assert float(temperature(resistance(t, r0=1000.0), r0=1000.0)) == pytest.approx(t, abs=1e-9)


def test_arrays_keep_their_shape_and_order() -> None:
    t = np.linspace(-200, 850, 2000).reshape(4, 500)
    ohm = resistance(t)
    assert ohm.shape == t.shape
    assert np.all(np.diff(ohm.ravel()) > 0)
    np.testing.assert_allclose(temperature(ohm), t, atol=1e-9)


@pytest.mark.parametrize("ohm", [0.0, 10.0, 18.51, 390.49, 1e4, np.inf, -np.inf, np.nan, -5.0])
def test_what_is_no_pt100_is_no_temperature(ohm: float) -> None:
    assert np.isnan(temperature(ohm))


@pytest.mark.parametrize("t", [-200.01, 850.01, np.inf, np.nan])
def test_outside_the_standard_there_is_no_resistance(t: float) -> None:
    assert np.isnan(resistance(t))
