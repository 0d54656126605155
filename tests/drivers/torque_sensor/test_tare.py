from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.errors import SensorError
from drivers.torque_sensor import Tare, TorqueScale, drift, take_tare

SCALE = TorqueScale(10.0 / 32768, 1000.0)
NM = SCALE.newton_metre_per_count
AT = datetime(2026, 11, 21, 8, tzinfo=UTC)


def noise(mean: float, deviation: float, n: int = 2000) -> np.ndarray:
    return np.rint(mean + deviation * np.random.default_rng(1).standard_normal(n)).astype(np.int16)


def tare(counts: np.ndarray, usable: np.ndarray | None = None) -> Tare:
    mask = np.ones(len(counts), bool) if usable is None else usable
    return take_tare(counts, mask, SCALE, AT, largest_zero_nm=50.0, largest_spread_nm=5.0)


@given(st.floats(-150, 150), st.floats(0.6, 10))
def test_tare_finds_zero_and_scatter(mean: float, deviation: float) -> None:
    found = tare(noise(mean, deviation))
    assert found.zero_count == pytest.approx(mean, abs=0.3 + deviation / 20)
    assert found.deviation_count == pytest.approx(np.hypot(deviation, 12**-0.5), rel=0.2)
    assert found.samples == 2000


def test_what_is_no_tare() -> None:
    with pytest.raises(SensorError, match=r"the zero is 91\.\d+ N·m where 50 N·m are allowed; take the load off"):
        tare(noise(300, 2))
    with pytest.raises(SensorError, match=r"scatter by .* taring needs the bench at rest"):
        tare(noise(0, 60))
    usable = np.ones(2000, bool)
    usable[:7] = False
    with pytest.raises(SensorError, match="7 of 2000 readings for taring are out of range"):
        tare(noise(0, 2), usable)
    with pytest.raises(SensorError, match="exactly 0 counts; check the wire"):
        tare(np.zeros(100, np.int16))


def test_drift_is_later_minus_earlier_in_the_benchs_sign() -> None:
    before = Tare(10.0, 1.0, 100, AT)
    after = Tare(30.0, 1.0, 100, AT + timedelta(hours=7))
    found = drift(before, after, SCALE, rated_torque_nm=10_000.0)
    assert found.torque_nm == pytest.approx(20 * NM)
    assert found.fraction == pytest.approx(20 * NM / 10_000)
    assert found.duration_s == 7 * 3600
    reversed_ = TorqueScale(SCALE.volt_per_count, SCALE.newton_metre_per_volt, polarity=-1)
    assert drift(before, after, reversed_, 10_000.0).torque_nm == pytest.approx(-20 * NM)
