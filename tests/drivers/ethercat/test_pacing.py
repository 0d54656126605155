import time

from hypothesis import given
from hypothesis import strategies as st

from drivers.ethercat import AbsoluteDeadlines, FreeRunning
from drivers.ethercat.pacing import _libc_sleeper, _relative_sleep_until

PERIOD_NS = 500_000


class Clock:
    def __init__(self) -> None:
        self.now = 12_345_678

    def read(self) -> int:
        return self.now

    def sleep_until(self, deadline: int) -> None:
        self.now = max(self.now, deadline)


@given(st.lists(st.integers(0, 4 * PERIOD_NS), min_size=1, max_size=60))
def test_slots_stay_on_the_grid_and_are_never_made_up_for(work: list[int]) -> None:
    clock = Clock()
    pacing = AbsoluteDeadlines(PERIOD_NS * 1e-9, clock.read, clock.sleep_until)
    start = clock.now
    last = -1
    for busy in work:
        slot, now = pacing.next_slot()
        assert slot > last
        # A slot begins no earlier than its place on the grid and never a whole period late.
        assert 0 <= now - (start + slot * PERIOD_NS) < PERIOD_NS
        last = slot
        clock.now += busy
    assert last <= sum(work) // PERIOD_NS + len(work)


def test_a_cycle_in_time_misses_nothing() -> None:
    clock = Clock()
    pacing = AbsoluteDeadlines(PERIOD_NS * 1e-9, clock.read, clock.sleep_until)
    slots = []
    for _ in range(5):
        slots.append(pacing.next_slot()[0])
        clock.now += PERIOD_NS // 3
    assert slots == [0, 1, 2, 3, 4]


def test_an_overrun_of_two_and_a_half_periods_skips_two_slots() -> None:
    clock = Clock()
    pacing = AbsoluteDeadlines(PERIOD_NS * 1e-9, clock.read, clock.sleep_until)
    pacing.next_slot()
    clock.now += 2 * PERIOD_NS + PERIOD_NS // 2
    assert pacing.next_slot()[0] == 2
    assert pacing.next_slot()[0] == 3


@given(st.lists(st.integers(0, 4 * PERIOD_NS), min_size=1, max_size=60))
def test_late_slots_are_made_up_for_as_long_as_it_was_allowed(work: list[int]) -> None:
    clock = Clock()
    pacing = AbsoluteDeadlines(PERIOD_NS * 1e-9, clock.read, clock.sleep_until, make_up_s=3 * PERIOD_NS * 1e-9)
    start, last = clock.now, -1
    for busy in work:
        slot, now = pacing.next_slot()
        late = now - (start + slot * PERIOD_NS)
        assert 0 <= late < 4 * PERIOD_NS
        # a slot is left out only where it would have begun later than allowed
        assert slot == last + 1 or late >= 3 * PERIOD_NS
        last = slot
        clock.now += busy


def test_a_stall_is_made_up_for_one_right_after_the_other() -> None:
    clock = Clock()
    pacing = AbsoluteDeadlines(PERIOD_NS * 1e-9, clock.read, clock.sleep_until, make_up_s=0.01)
    start = clock.now
    pacing.next_slot()
    clock.now += 5 * PERIOD_NS
    begun = [pacing.next_slot() for _ in range(7)]
    assert [slot for slot, _ in begun] == [1, 2, 3, 4, 5, 6, 7]
    assert [(now - start) / PERIOD_NS for _, now in begun] == [5, 5, 5, 5, 5, 6, 7]


def test_free_running_counts_cycles() -> None:
    pacing = FreeRunning(0.0005)
    assert [pacing.next_slot() for _ in range(3)] == [(0, 0), (1, PERIOD_NS), (2, 2 * PERIOD_NS)]


def test_both_sleepers_reach_an_absolute_deadline() -> None:
    sleepers = [_relative_sleep_until]
    if (of_libc := _libc_sleeper()) is not None:
        sleepers.append(of_libc)
    for sleep_until in sleepers:
        deadline = time.monotonic_ns() + 3_000_000
        sleep_until(deadline)
        assert time.monotonic_ns() >= deadline
        sleep_until(deadline)  # one that has passed returns at once
