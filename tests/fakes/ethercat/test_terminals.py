"""Analogue and PT100 terminals: counts, ranges, status bits, conversions that are held."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes.pt100 import OHM_64, TEMPERATURE, Wiring, convert, measured_resistance, resistance, wiring_of
from tests.fakes.ethercat.stand_in import TEMPERATURE as RTD
from tests.fakes.ethercat.stand_in import TORQUE, Bus

TOGGLE, REST = 0x8000, 0x7FFF


@pytest.mark.parametrize(
    ("adc", "value", "bits"),
    [(0, 0, 0), (-1234, -1234, 0), (32767, 32767, 0x42), (40000, 32767, 0x42), (-32768, -32768, 0x41)],
)
def test_analogue_value_and_range(adc, value, bits):
    bus = Bus(3)
    bus.master.bench.plant.torque_adc = adc
    bus.run()
    assert set(bus.in_[TORQUE]["6000:11"]) == {value}
    assert set(bus.in_[TORQUE]["6000:01"] & REST) == {bits}


def test_analogue_toggles_every_cycle():
    bus = Bus(6)
    bus.run()
    assert (np.diff(bus.in_[TORQUE]["6000:01"] & TOGGLE) != 0).all()


@pytest.mark.parametrize("blocks", [(300,), (1,) * 60, (7, 93, 100, 1, 99)])
def test_pt100_is_held_between_conversions(blocks):
    """The plant warms by 0.01 K a cycle; a conversion comes every 100 cycles, whatever the blocks."""
    bus = Bus(max(blocks))
    values, toggles = [], []
    for rows in blocks:
        bus.run(rows)
        values += bus.in_[RTD]["6000:11"][:rows].tolist()
        toggles += (bus.in_[RTD]["6000:01"][:rows] & TOGGLE).tolist()
    steps = [i for i in range(1, len(values)) if values[i] != values[i - 1]]
    assert steps == [i for i in range(100, len(values), 100)]
    assert [i for i in range(1, len(toggles)) if toggles[i] != toggles[i - 1]] == steps
    assert values[0] == 400


def test_pt100_presentations():
    bus = Bus(200)
    bus.master.bench.plant.lubricant = 25.0
    expected = {(0, 0): 250.0, (0, 2): 2500.0, (8, 0): 16 * resistance(25.0), (9, 0): 64 * resistance(25.0)}
    for (element, presentation), counts in expected.items():
        slave = bus.master.slaves[RTD]
        slave.sdo_write(0x8000, 0x19, element.to_bytes(2, "little"))
        slave.sdo_write(0x8000, 0x02, bytes([presentation]))
        bus.master.bench.plant.cycles = 0
        bus.run()
        assert bus.in_[RTD]["6000:11"][0] == pytest.approx(counts, abs=25)
        assert bus.in_[RTD]["6010:11"][-1] == 210


@pytest.mark.parametrize(("reading", "bits"), [(10_000.0, 0x42), (-10_000.0, 0x41)])
def test_open_and_short_are_errors(reading, bits):
    bus = Bus(150)
    bus.master.bench.plant.lubricant = reading
    bus.run()
    assert bus.in_[RTD]["6000:01"][-1] & REST == bits
    assert bus.in_[RTD]["6010:01"][-1] & REST == 0


@given(st.floats(-200.0, 850.0))
def test_resistance_follows_iec_60751(celsius):
    a, b, c = 3.9083e-3, -5.775e-7, -4.183e-12
    cold = c * (celsius - 100.0) * celsius**3 if celsius < 0 else 0.0
    assert resistance(celsius) == pytest.approx(100.0 * (1 + a * celsius + b * celsius**2 + cold), rel=1e-12)
    assert wiring_of(celsius) is Wiring.GOOD


@pytest.mark.parametrize(("celsius", "ohm"), [(0.0, 100.0), (100.0, 138.5055), (-100.0, 60.2558), (850.0, 390.4811)])
def test_resistance_at_the_points_of_the_standards_table(celsius, ohm):
    assert resistance(celsius) == pytest.approx(ohm, abs=6e-5)


def test_open_and_short_resistances():
    assert measured_resistance(20.0, Wiring.OPEN) == float("inf")
    assert measured_resistance(20.0, Wiring.SHORT) == 0.0


@given(st.floats(-20_000.0, 20_000.0), st.sampled_from([TEMPERATURE, OHM_64]), st.sampled_from([0, 2]))
def test_conversion_never_leaves_the_integer(celsius, element, presentation):
    ((status, value),) = convert(np.array([celsius]), element, presentation).tolist()
    assert -32768 <= value <= 32767
    assert bool(status & 0x40) == (status & 0x03 != 0)
