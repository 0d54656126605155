"""Faults of sensors and motors, switched by the same call as those of the bus, as they show in the process image."""

from __future__ import annotations

import numpy as np
import pytest

from fakes.ethercat.benches import bench_of
from tests.fakes.ethercat.stand_in import INPUT, LOAD, TEMPERATURE, TORQUE, Bus

ROWS = 400
VELOCITY = 200_000


@pytest.fixture
def turning():
    """A bus on the real plant whose input motor turns."""
    bus = Bus(ROWS, bench_of("rh380n", 0, 0.0005))
    bus.enable()
    bus.set(0x0F, _60FF=VELOCITY)
    bus.run()
    bus.run()
    assert (np.diff(bus.in_[INPUT]["6064:00"].astype(np.int64)) > 0).mean() > 0.9
    return bus


def strike(bus, name, value=None, at=100):
    bus.master.faults.apply(name, value=value, at_cycle=bus.master.bench.cycle + at)
    bus.run()


@pytest.mark.parametrize(("side", "slave"), [("input", INPUT), ("load", LOAD)])
def test_encoder_frozen(turning, side, slave):
    strike(turning, f"{side}_encoder_frozen")
    counts = turning.in_[slave]["6064:00"].astype(np.int64)
    assert np.ptp(counts[:100]) > 0
    assert np.ptp(counts[101:]) == 0


@pytest.mark.parametrize(("side", "slave", "jump"), [("input", INPUT, 4096), ("load", LOAD, 100_000)])
def test_encoder_jumps(turning, side, slave, jump):
    strike(turning, f"{side}_encoder_jump", float(jump))
    steps = np.diff(turning.in_[slave]["6064:00"].astype(np.int64))
    assert abs(steps[99]) == pytest.approx(jump, rel=0.2)
    assert np.abs(np.delete(steps, 99)).max() < jump / 2


@pytest.mark.parametrize(("side", "slave", "bits"), [("input", INPUT, 8), ("load", LOAD, 12)])
def test_encoder_wraps(turning, side, slave, bits):
    strike(turning, f"{side}_encoder_wrap", float(bits))
    counts = turning.in_[slave]["6064:00"].astype(np.int64)[100:]
    assert np.ptp(counts) < 1 << bits


def test_torque_sensor_saturated(turning):
    strike(turning, "torque_sensor_saturated")
    assert set(turning.in_[TORQUE]["6000:11"][101:]) == {32767}
    assert (turning.in_[TORQUE]["6000:01"][101:] & 0x42 == 0x42).all()


def test_torque_sensor_open_is_no_flag_but_another_value(turning):
    turning.set(0x0F, _60FF=VELOCITY, _6071=300)
    for _ in range(5):
        turning.run()
    strike(turning, "torque_sensor_open", 0.0)
    counts = turning.in_[TORQUE]["6000:11"].astype(int)
    assert abs(counts[:100].mean()) > 1000
    assert abs(counts[110:].mean()) < 100
    assert (turning.in_[TORQUE]["6000:01"] & 0x43 == 0).all()


def test_torque_sensor_frozen(turning):
    strike(turning, "torque_sensor_frozen")
    assert np.ptp(turning.in_[TORQUE]["6000:11"][101:].astype(int)) == 0
    assert np.ptp(turning.in_[TORQUE]["6000:11"][:100].astype(int)) > 0


@pytest.mark.parametrize(("name", "bits"), [("pt100_open", 0x42), ("pt100_short", 0x41)])
def test_pt100_open_and_short(turning, name, bits):
    strike(turning, name)
    assert turning.in_[TEMPERATURE]["6000:01"][-1] & 0x7FFF == bits
    assert turning.in_[TEMPERATURE]["6010:01"][-1] & 0x7FFF == 0
    turning.master.faults.clear(name)
    turning.run()
    assert turning.in_[TEMPERATURE]["6000:01"][-1] & 0x7FFF == 0


def test_overspeed_by_a_runaway_trips_the_drive(turning):
    turning.master.faults.apply("input_runaway", value=50.0)
    for _ in range(20):
        turning.run()
        if turning.in_[INPUT]["6041:00"][-1] & 0x08:
            break
    assert turning.in_[INPUT]["603F:00"][-1] == 0x8400
    assert turning.in_[INPUT]["6041:00"][-1] & 0x08
