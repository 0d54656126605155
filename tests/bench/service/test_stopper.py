"""Which press of STOP counts."""

from __future__ import annotations

import time

from bench.service.runs.stopper import Stopper


def test_a_press_that_is_heard_of_late_is_the_one_that_counted() -> None:
    """A page presses at the service and at the run; a service that hung hears of it when the run has ended."""
    stopper, at = Stopper(10.0, lambda: None), time.time_ns() - 10 * 10**9
    assert stopper.pressed("Ann", at, "run-1")[1]
    stopper.seen("run-1", True, at + 800_000_000, None)
    late, first = stopper.pressed("Ann", at + 1_000_000, None)
    assert not first
    assert late.at_rest
    assert (late.run, late.at_rest_after_s, late.over) == ("run-1", 0.8, True)
    # somebody else, or somebody who presses again later, pressed while nothing ran
    assert stopper.pressed("Bob", at, None)[0].run is None
    stopper.pressed("Ann", at, "run-2")
    assert stopper.pressed("Ann", at + 5 * 10**9, None)[0].run is None


def test_what_was_seen_counts_from_the_press_that_is_named() -> None:
    stopper, at = Stopper(10.0, lambda: None), time.time_ns() - 7 * 10**9
    press, _ = stopper.pressed("Ann", at, "run-1")
    assert press.pressed_at_ns == at
    stopper.seen("run-1", True, at + 7_100_000_000, None)
    assert stopper.press is not None
    assert (stopper.press.at_rest, stopper.press.at_rest_after_s) == (True, 7.1)
    # by a bench that is faster than the clock only its own time is known
    stopper.pressed("Ann", None, "run-2")
    stopper.seen("run-2", True, None, 1.3)
    assert (stopper.press.at_rest, stopper.press.at_rest_after_s, stopper.press.bench_to_rest_s) == (True, None, 1.3)


def test_a_stamp_ahead_of_its_own_arrival_is_of_another_clock() -> None:
    stopper, ahead = Stopper(10.0, lambda: None), time.time_ns() + 3 * 10**9
    press, _ = stopper.pressed("Ann", ahead, "run-1")
    assert press.pressed_at_ns < ahead
