"""The servo drive through the process image: units, limits, ramps, trips."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fakes.ethercat.slaves.plant_link import COMMAND_DTYPE
from tests.fakes.ethercat.stand_in import INPUT, LOAD, Bus

RPM = 2.0 * math.pi / 60.0


def bus_with_commands(rows=50):
    """A bus whose plant keeps the commands it gets."""
    bus = Bus(rows)
    seen = []
    plant = bus.master.bench.plant
    step = plant.step

    def keep(commands):
        seen.append(commands.copy())
        return step(commands)

    plant.step = keep
    return bus, seen


def write(bus, slave, index, value, size):
    bus.master.slaves[slave].sdo_write(index, 0, int(value).to_bytes(size, "little", signed=value < 0))


def test_commands_reach_the_plant_in_si():
    bus, seen = bus_with_commands()
    bus.enable()
    bus.set(0x0F, _60FF=100_000, _6071=-500)
    seen.clear()
    bus.run()
    commands = np.concatenate(seen)
    assert commands.dtype == COMMAND_DTYPE
    np.testing.assert_allclose(commands["input_velocity"], 100.0 * RPM)
    np.testing.assert_allclose(commands["load_torque"], -0.5 * 1650.0)
    assert set(commands["input_mode"]) == {9}
    assert set(commands["load_mode"]) == {10}
    assert set(commands["input_enable"]) == {1}


def test_actual_values_are_in_the_units_the_drive_declares():
    bus = Bus(50)
    bus.enable()
    bus.set(0x0F, _60FF=60_000, _6071=100)
    bus.run()
    assert set(bus.in_[INPUT]["606C:00"][1:]) == {60_000}
    turned = np.diff(bus.in_[INPUT]["6064:00"].astype(int)).mean() / 8192 * 2 * math.pi / 0.0005
    assert turned == pytest.approx(60.0 * RPM, rel=0.05)
    assert set(bus.in_[LOAD]["6077:00"]) == {100}


def test_polarity_reverses_commands_and_values():
    bus, seen = bus_with_commands()
    write(bus, INPUT, 0x607E, 0xC0, 1)
    bus.enable()
    bus.set(0x0F, _60FF=60_000)
    seen.clear()
    bus.run()
    assert (np.concatenate(seen)["input_velocity"] < 0).all()
    assert set(bus.in_[INPUT]["606C:00"][1:]) == {60_000}
    assert np.diff(bus.in_[INPUT]["6064:00"].astype(int)).min() >= 0


def test_position_overflows_as_an_integer32():
    bus = Bus(4)
    plant = bus.master.bench.plant
    plant.angle = (2**31 + 5) / 8192 * 2 * math.pi
    bus.run()
    assert bus.in_[INPUT]["6064:00"][-1] == -(2**31) + 5


@pytest.mark.parametrize(("asked", "got"), [(600, 300), (-600, -300), (200, 200)])
def test_torque_limit_holds_and_is_shown(asked, got):
    bus = Bus(10)
    write(bus, LOAD, 0x6072, 300, 2)
    bus.enable()
    bus.set(0x0F, _6071=asked)
    bus.run()
    assert bus.in_[LOAD]["6077:00"][-1] == got
    assert bool(bus.in_[LOAD]["6041:00"][-1] & 0x0800) == (abs(asked) > 300)


def test_speed_limit_holds():
    bus, seen = bus_with_commands()
    write(bus, INPUT, 0x6080, 100, 4)
    bus.enable()
    bus.set(0x0F, _60FF=500_000)
    seen.clear()
    bus.run()
    np.testing.assert_allclose(np.concatenate(seen)["input_velocity"], 100.0 * RPM)


def test_overspeed_trips_at_its_very_cycle():
    """The cycle after the one in which the speed was too high shows the fault reaction."""
    bus = Bus(40)
    bus.enable()
    plant = bus.master.bench.plant
    step = plant.step
    limit = 1.2 * 4000 * RPM
    start = plant.cycles

    def runaway(commands):
        rows = step(commands)
        first = plant.cycles - len(rows) - start
        rows["input_velocity"][max(0, 17 - first) :] = 1.01 * limit
        return rows

    plant.step = runaway
    bus.run()
    status = bus.in_[INPUT]["6041:00"]
    assert np.flatnonzero((status & 0x4F) == 0x0F)[0] == 18
    assert bus.in_[INPUT]["603F:00"][18] == 0x8400


def test_quick_stop_ramps_to_standstill_and_switches_off_in_the_midst_of_a_block():
    bus = Bus(400)
    bus.enable()
    bus.set(0x0F, _60FF=500_000)
    bus.run(10)
    bus.set(0x02, _60FF=500_000)
    bus.run()
    status = bus.in_[INPUT]["6041:00"] & 0x6F
    speed = bus.in_[INPUT]["606C:00"]
    ended = int(np.flatnonzero(status & 0x4F == 0x40)[0])
    assert set(status[:ended]) == {0x07}
    assert 1 < ended < 399
    assert (np.diff(speed[:ended]) < 0).all()
    assert abs(speed[ended - 1]) * 1e-3 * RPM < 2.5


def test_modes_other_than_csv_and_cst_are_not_taken():
    bus = Bus(4)
    bus.out[INPUT]["6060:00"] = 8
    bus.run()
    assert set(bus.in_[INPUT]["6061:00"]) == {9}
    bus.out[INPUT]["6060:00"] = 10
    bus.run()
    assert set(bus.in_[INPUT]["6061:00"]) == {10}


def test_emergency_goes_to_the_callback():
    bus = Bus(4)
    got = []
    bus.master.slaves[INPUT].add_emergency_callback(got.append)
    bus.master.faults.apply("drive_fault", "input_drive", 0x4310)
    bus.master.slaves[INPUT].mbx_receive()
    assert [(e.slave_pos, e.error_code, e.error_reg) for e in got] == [(1, 0x4310, 0x09)]


def test_products_differ_and_units_are_declared():
    slaves = Bus().master.slaves
    assert len({(s.man, s.id, s.rev) for s in slaves}) == 4
    for slave, unit, counts in ((slaves[INPUT], 0xFDB44700, 8192), (slaves[LOAD], 0xFAB44700, 1 << 25)):
        assert int.from_bytes(slave.sdo_read(0x60A9, 0), "little") == unit
        assert int.from_bytes(slave.sdo_read(0x608F, 1), "little") == counts
        assert int.from_bytes(slave.sdo_read(0x6502, 0), "little") == 0x300
