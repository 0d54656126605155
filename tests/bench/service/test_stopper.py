"""Which press of STOP counts."""

from __future__ import annotations

import time

from bench.service.runs.stopper import Stopper


def test_a_press_that_is_heard_of_late_is_the_one_that_counted() -> None:
    """A page presses at the service and at the run; a service that hung hears of it when the run has ended."""
    stopper, at = Stopper(10.0, lambda: None), time.time_ns()
    assert stopper.pressed("Ann", at, "run-1")[1]
    stopper.seen("run-1", 0.8)
    late, first = stopper.pressed("Ann", at + 1_000_000, None)
    assert not first
    assert (late.run, late.at_rest_after_s, late.over) == ("run-1", 0.8, True)
    # somebody else, or somebody who presses again later, pressed while nothing ran
    assert stopper.pressed("Bob", at, None)[0].run is None
    stopper.pressed("Ann", at, "run-2")
    assert stopper.pressed("Ann", at + 5 * 10**9, None)[0].run is None
