"""How the responder keeps the plant to the clock, on a clock of its own."""

from __future__ import annotations

import random

import pytest

from fakes.ethercat.wire import responder as module
from fakes.ethercat.wire.responder import Responder
from fakes.ethercat.wire.segment import LRW
from tests.fakes.ethercat.simple_plant import simple_bench
from tests.fakes.ethercat.wire.test_segment import frame

CYCLE_NS = 500_000


class Clock:
    """Stands for the module ``time``."""

    def __init__(self) -> None:
        self.now = 1_000_000_000
        self.slept = []

    def monotonic_ns(self) -> int:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)


class FakePort:
    """Hands out one frame at a time and keeps what is sent."""

    def __init__(self) -> None:
        self.next = b""
        self.sent = []

    def receive(self, buffer: bytearray) -> int:
        buffer[: len(self.next)] = self.next
        return len(self.next)

    def send(self, view: memoryview) -> None:
        self.sent.append(bytes(view))


@pytest.fixture
def made(monkeypatch):
    """A responder whose drives are in OP with process data mapped, and its clock."""
    return make(monkeypatch)


def make(monkeypatch, make_up_s=0.0):
    clock = Clock()
    monkeypatch.setattr(module, "time", clock)
    port = FakePort()
    responder = Responder(simple_bench(), port, make_up_s=make_up_s)
    for controller in responder.segment.all:
        slave = controller.slave
        slave.watchdog_s = 0.1
        for manager, start, size in zip(
            slave.sync_managers,
            (0x1000, 0x1200, 0x1400, 0x1A00),
            (256, 256, slave.outputs.size, slave.inputs.size),
            strict=True,
        ):
            manager.start, manager.length, manager.enabled = start, size, size > 0
        for state in (2, 4, 8):
            slave.al.request(state)
        assert slave.al.state == 8
        controller.memory[0x600:0x610] = bytes.fromhex("00000100090000070014000201000000")
    responder.segment.forget()
    port.next = bytes(frame((LRW, 0, 1, bytes(9))))
    return responder, clock, port


def serve(responder, clock, step_ns, count, jitter_ns=0):
    chance = random.Random(1)
    for _ in range(count):
        clock.now += step_ns
        late = chance.randint(-jitter_ns, jitter_ns)
        clock.now += late
        responder.serve()
        clock.now -= late


def test_one_cycle_a_frame_whatever_the_jitter(made):
    responder, clock, _ = made
    serve(responder, clock, CYCLE_NS, 1000, jitter_ns=200_000)
    counters = responder.counters
    assert (counters.process_frames, counters.cycles) == (1000, 1000)
    assert (counters.added_cycles, counters.left_out_cycles) == (0, 0)


def test_a_master_slightly_off_is_followed_without_slips(made):
    responder, clock, _ = made
    serve(responder, clock, round(CYCLE_NS * 1.001), 3000)
    assert responder.counters.cycles == 3000
    assert responder.counters.added_cycles == 0


def test_a_master_of_half_the_rate_gets_two_cycles_a_frame(made):
    responder, clock, _ = made
    serve(responder, clock, 2 * CYCLE_NS, 500)
    assert responder.counters.cycles == pytest.approx(1000, abs=4)


def test_a_master_of_twice_the_rate_does_not_hurry_the_plant(made):
    responder, clock, _ = made
    serve(responder, clock, CYCLE_NS // 2, 1000)
    assert responder.counters.cycles == pytest.approx(500, abs=4)
    assert responder.counters.process_frames == 1000


def test_a_pause_is_made_up_for(made):
    responder, clock, _ = made
    serve(responder, clock, CYCLE_NS, 100)
    clock.now += 20_000_000
    serve(responder, clock, CYCLE_NS, 100)
    assert responder.counters.cycles == pytest.approx(240, abs=3)


def test_without_frames_plant_and_watchdog_run_on(made):
    responder, clock, port = made
    serve(responder, clock, CYCLE_NS, 10)
    port.next = b""
    for _ in range(30):
        clock.now += 4_000_000
        responder.serve()
    assert responder.counters.cycles == pytest.approx(250, abs=6)
    assert [slave.al.status for slave in responder.bench.slaves] == [0x14, 0x14, 0x08, 0x08]
    assert responder.segment.all[0].memory[0x130] == 0x14
    assert responder.segment.all[0].memory[0x134] == 0x1B
    assert responder.segment.all[0].memory[0x440:0x443] == b"\x00\x00\x01"
    port.next = bytes(frame((LRW, 0, 1, bytes(9))))
    serve(responder, clock, CYCLE_NS, 2)
    assert responder.segment.all[0].memory[0x440:0x443] == b"\x01\x00\x01"


def test_lost_and_late_frames(made):
    responder, clock, port = made
    responder.faults.apply("frame_lost", value=3)
    serve(responder, clock, CYCLE_NS, 5)
    assert len(port.sent) == 2
    assert responder.counters.dropped == 3
    responder.faults.apply("frame_late", value=0.004)
    serve(responder, clock, CYCLE_NS, 2)
    assert clock.slept == [0.004]


def test_a_bench_without_any_slave_in_reach_is_silent(made):
    responder, clock, port = made
    responder.faults.apply("cable_pulled", "input_drive")
    responder.rearrange()
    serve(responder, clock, CYCLE_NS, 50)
    assert port.sent == []
    assert responder.counters.cycles == pytest.approx(47, abs=3)


def test_malformed_frames_are_counted_and_not_answered(made):
    responder, clock, port = made
    port.next = b"\xff" * 12 + b"\x88\xa4" + b"\xff\x1f" + bytes(50)
    serve(responder, clock, CYCLE_NS, 3)
    assert responder.counters.malformed == 3
    assert port.sent == []


def test_a_plant_that_waits_lets_a_stalled_master_make_up(monkeypatch):
    responder, clock, _port = make(monkeypatch, make_up_s=0.01)
    serve(responder, clock, CYCLE_NS, 100)
    before = responder.counters.cycles
    clock.now += 12 * CYCLE_NS
    serve(responder, clock, CYCLE_NS // 5, 15)
    serve(responder, clock, CYCLE_NS, 100)
    assert responder.counters.added_cycles == responder.counters.left_out_cycles == 0
    assert responder.counters.cycles == before + 115


def test_a_plant_that_waits_adds_what_nobody_makes_up_for(monkeypatch):
    responder, clock, _port = make(monkeypatch, make_up_s=0.01)
    serve(responder, clock, CYCLE_NS, 100)
    before = responder.counters.cycles
    clock.now += 12 * CYCLE_NS
    serve(responder, clock, CYCLE_NS, 20)
    assert responder.counters.cycles == before + 20
    serve(responder, clock, CYCLE_NS, 40)
    assert responder.counters.added_cycles == 12
    assert responder.counters.cycles == before + 72


def test_a_plant_that_waits_runs_on_alone_that_much_later(monkeypatch):
    responder, clock, port = make(monkeypatch, make_up_s=0.01)
    serve(responder, clock, CYCLE_NS, 100)
    before = responder.counters.cycles
    port.next = b""
    serve(responder, clock, CYCLE_NS, 100)
    assert before + 79 <= responder.counters.cycles <= before + 81
