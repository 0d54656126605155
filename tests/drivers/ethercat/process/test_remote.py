"""A bus in a process of its own: set values ahead, images back, and nothing that goes unsaid."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from drivers.cia402.protection import protection
from drivers.errors import BusError, IdentityError, SdoAccessError
from drivers.ethercat.exchange import Exchange
from drivers.ethercat.process import RemoteBus, Watch
from drivers.ethercat.process import layout as at
from drivers.ethercat.process.layout import Shared
from tests.drivers.ethercat.process.apart import MASTER, ORDINARY, Apart, apart
from tests.drivers.rig import make_devices

ENABLED, MASK = 0x27, 0x6F


@pytest.fixture(scope="module")
def running() -> Iterator[Apart]:
    """One process for all tests that do not end it."""
    with apart() as made:
        yield made


def test_every_cycle_says_what_was_sent_and_when(running: Apart) -> None:
    bus = running.bus
    running.take()
    first = bus.flush()
    before = bus.queued
    for k in range(20):
        running.drives[0].set_velocity(float(k), 10)
        running.drives[1].set_torque(0.0, 10)
        bus.outputs["input_drive"]["60FF:00"][:10] = 1000 * k + np.arange(10)
        bus.submit(10)
    assert before == 0
    seen = {}
    rows = 0
    last = first
    while last < first + 199:
        exchange = running.take(10)
        index = exchange.set_index
        assert (np.diff(exchange.cycle) >= 1).all()
        assert (np.diff(index) >= 0).all()
        sent = bus.sent["input_drive"]["60FF:00"][: exchange.n_done].tolist()
        for i, value in zip(index.tolist(), sent, strict=True):
            assert seen.setdefault(i, value) == value
        meta = bus.meta
        assert (meta[:, at.DUE] <= meta[:, at.WOKE]).all()
        assert (meta[:, at.WOKE] <= meta[:, at.BACK]).all()
        assert (meta[:, at.BACK] <= meta[:, at.DONE]).all()
        assert (exchange.wkc == bus.expected_wkc).all()
        last, rows = int(index[-1]), rows + exchange.n_done
    assert [seen[first + i] for i in range(200)] == [1000 * (i // 10) + i % 10 for i in range(200)]
    assert rows >= 200


def test_flushed_set_values_are_never_sent(running: Apart) -> None:
    bus = running.bus
    running.give(0.0, 500)
    running.give(0.0, 500)
    dropped = bus.queued
    later = bus.flush()
    flushed_ns = time.monotonic_ns()
    assert bus.queued == 0
    # several cycles without a set value: what is held keeps its own index, that of a row that was sent
    held = running.until(lambda _: bus.meta[-1, at.WOKE] > flushed_ns).set_index[-1]
    assert held < later - max(dropped // 2, 1), f"{dropped} rows were dropped"
    running.give(0.0, 10)
    seen: set[int] = set()

    def look(exchange: Exchange) -> bool:
        assert exchange.set_index is not None
        seen.update(exchange.set_index[bus.meta[:, at.WOKE] > flushed_ns].tolist())
        return later + 9 in seen

    running.until(look)
    # a machine that is busy may have sent some before the flush; none after it
    assert {index for index in seen if index < later} <= {held}


def test_more_set_values_than_fit_are_refused(running: Apart) -> None:
    def give_for_ever() -> None:
        while True:
            running.give(0.0, 1000)

    with pytest.raises(BusError, match="may be ahead"):
        give_for_ever()
    running.bus.flush()


def test_objects_are_read_while_the_bus_cycles(running: Apart) -> None:
    sdo = running.bus.sdo("input_drive")
    assert sdo.read(0x6502, 0, "u4") & 0x300
    assert not sdo.exists(0x5FFF, 0)
    with pytest.raises(SdoAccessError, match="object does not exist") as caught:
        running.bus.sdo_read("input_drive", 0x5FFF, 0, "u2")
    assert (caught.value.slave, caught.value.index, caught.value.abort_code) == ("input_drive", 0x5FFF, 0x06020000)
    with pytest.raises(BusError, match="no configured slave"):
        running.bus.sdo("brake")
    assert running.bus.emergencies() == ()
    assert {step.name for step in running.bus.recover()} >= {"input_drive", "load_drive"}


def test_others_may_look_at_the_rings_and_not_write(running: Apart) -> None:
    path, layout = running.bus.tap
    descriptor = os.open(path, os.O_RDONLY)
    shared = Shared(descriptor, layout, read_only=True)
    os.close(descriptor)
    running.take()
    assert shared.words[at.IMAGE_HEAD] > 0
    assert shared.words[at.PID] == running.bus.pid
    with pytest.raises(ValueError, match="read-only"):
        shared.inputs[0, 0] = 1


def test_a_rig_that_gives_no_set_values_has_its_drives_stopped(running: Apart) -> None:
    made = running.fresh()
    made.bus.arm(10_000)
    made.enable()
    made.bus.flush()
    made.give(30.0, 1000)
    made.until(lambda _: abs(int(made.bus.inputs["input_drive"]["606C:00"][0])) > 0)
    made.bus.arm(100)
    made.until(lambda _: made.bus.stopped is not None)
    assert made.bus.stopped == "the rig gave no set values in time"
    made.until(lambda _: made.status() & MASK != ENABLED and not made.status() & 0x04)
    # what the rig hands over now is not followed until an operator has said so, however much it is
    for _ in range(10):
        made.give(10.0, 1000)
        made.take()
    stale = made.until(lambda exchange: exchange.n_done)
    assert stale.set_index[-1] == -1
    made.bus.arm(0)
    made.bus.resume()
    made.until(lambda _: made.bus.stopped is None)
    made.enable()


def test_the_rig_can_order_the_stop(running: Apart) -> None:
    made = running.fresh()
    made.bus.arm(1 << 20)
    made.enable()
    made.bus.order_stop()
    made.until(lambda _: made.bus.stopped == "the rig ordered it" and not made.status() & 0x04)


def test_a_speed_beyond_its_limit_stops_the_drives(running: Apart) -> None:
    made = running.fresh()
    given = protection(made.bus, made.drives, 2.0, 1.0, 0.01, 200)
    assert {watch.slave for watch in given.watches} == {"input_drive", "load_drive"}
    made.bus.protect(replace(given, watches=(Watch("input_drive", "606C:00", -1000, 1000, 20),)))
    made.bus.arm(1 << 20)
    made.enable()
    made.bus.flush()
    for _ in range(5):
        made.give(50.0, 1000)
    made.until(lambda _: made.bus.stopped is not None)
    assert made.bus.stopped == "input_drive 606C:00 left -1000 … 1000 for 20 cycles in a row"
    made.until(lambda _: not made.status() & 0x04)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_the_end_of_the_process_is_said(number: signal.Signals) -> None:
    with apart() as made:
        os.kill(made.bus.pid, number)
        while made.bus.collect().n_done:
            pass
        assert made.bus.ended is not None
        text = "was killed by SIGKILL" if number is signal.SIGKILL else "ended with exit code 0"
        assert text in made.bus.ended
        with pytest.raises(BusError, match="bus process"):
            made.bus.sdo_read("input_drive", 0x6041, 0, "u2")


def test_what_is_wrong_with_the_slaves_is_said_as_without_a_process() -> None:
    with pytest.raises(IdentityError, match="4 slaves but 3 are configured"), apart(slaves=3):
        pass


def test_a_bus_that_is_not_open_says_so() -> None:
    bus = RemoteBus(MASTER, "emulated", [device.spec for device in make_devices(0.1)], real_time=ORDINARY)
    for use in (bus.configure, bus.flush, bus.collect, lambda: bus.ended):
        with pytest.raises(BusError, match=r"open\(\) comes first"):
            use()
    bus.close()
