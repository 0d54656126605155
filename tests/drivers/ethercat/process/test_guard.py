"""The judgement of the bus process on a cycle, and the steps of its stop."""

from __future__ import annotations

import struct

from hypothesis import given
from hypothesis import strategies as st

from drivers.entries import Entry
from drivers.ethercat.process.guard import Guard, Reason
from drivers.ethercat.process.settings import Condition, Protection, StopStep, Watch
from drivers.ethercat.slave import Pdo, SlaveSpec

SLAVES = (
    SlaveSpec("terminal", 1, 1, 1, tx_pdos=(Pdo(0x1A00, (Entry("6000:01", "u1"),)),)),
    SlaveSpec("drive", 2, 1, 2, tx_pdos=(Pdo(0x1A00, (Entry("6041:00", "u2"), Entry("606C:00", "i4"))),)),
)
OFF = (Condition("drive", "6041:00", 0x0004, 0),)
STEPS = (StopStep(b"\x02", 5, OFF), StopStep(b"\x00", 3, OFF))
WKC = 3


def image(status: int = 0x27, velocity: int = 0) -> memoryview:
    return memoryview(struct.pack("<BHi", 0xFF, status, velocity))


def guard(patience: int = 3, bad_cycles: int = 4) -> Guard:
    return Guard(
        Protection(STEPS, (Watch("drive", "606C:00", -100, 100, patience),), bad_cycles), SLAVES, expected_wkc=WKC
    )


@given(st.lists(st.integers(-(1 << 31), (1 << 31) - 1), max_size=30), st.integers(1, 5))
def test_only_readings_beyond_the_limit_in_a_row_count(velocities: list[int], patience: int) -> None:
    judged = guard(patience)
    run = 0
    for velocity in velocities:
        run = run + 1 if abs(velocity) > 100 else 0
        reason = judged.judge(image(velocity=velocity), WKC)
        assert (reason is Reason.LIMIT) == (run >= patience)


@given(st.lists(st.sampled_from([WKC, -1, 1]), max_size=30))
def test_only_wrong_working_counters_in_a_row_count(counters: list[int]) -> None:
    judged = guard(bad_cycles=4)
    run = 0
    for wkc in counters:
        run = run + 1 if wkc != WKC else 0
        assert (judged.judge(image(), wkc) is Reason.WORKING_COUNTER) == (run >= 4)


def test_stale_inputs_are_not_judged() -> None:
    judged = guard(patience=1)
    assert judged.judge(image(velocity=1000), -1) is Reason.NONE


def test_a_stop_goes_on_when_the_drives_have_no_power_any_more() -> None:
    stopping = guard()
    stopping.start(Reason.STARVED)
    assert stopping.outputs == b"\x02"
    assert not stopping.advance(image(0x07), WKC)
    assert not stopping.advance(image(0x40), WKC)
    assert stopping.outputs == b"\x00"
    assert stopping.advance(image(0x40), WKC)
    assert stopping.outputs == b"\x00"


def test_a_step_has_an_end_whatever_the_drives_say() -> None:
    stopping = guard()
    stopping.start(Reason.STARVED)
    ended = [stopping.advance(image(0x27), -1) for _ in range(8)]
    assert ended == [False] * 7 + [True]


def test_a_drive_beyond_its_limit_is_not_asked_for_a_ramp() -> None:
    stopping = guard()
    stopping.start(Reason.LIMIT)
    assert stopping.outputs == b"\x00"
    assert not stopping.advance(image(0x27), WKC)
    assert stopping.advance(image(0x40), WKC)


def test_an_acknowledged_guard_begins_anew() -> None:
    judged = guard(patience=2)
    judged.judge(image(velocity=1000), WKC)
    judged.clear()
    assert judged.judge(image(velocity=1000), WKC) is Reason.NONE
    assert judged.judge(image(velocity=1000), WKC) is Reason.LIMIT
    assert judged.broken == 0


def test_every_reason_has_words() -> None:
    assert all(reason.text for reason in Reason)
