"""Blocks of the offset: a load that changes ends a block, for what has a knee has no mean at the mean load."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bench.mismatch.orders.offset_rows import at_level, offset_rows
from bench.mismatch.recordings.rows import Rows, join
from bench.simulation.frame import ARRAYS, FloatArray, Frame

ROWS = 4000
STEP_S = 0.01


def ramped(rate: float) -> Rows:
    """Forty seconds at one speed, the load going up at ``rate`` N·m/s."""
    clock = STEP_S * np.arange(ROWS)
    values: dict[str, FloatArray] = {name: np.zeros(ROWS) for name in ARRAYS}
    values |= {"elapsed": clock, "time": clock, "step": np.append(0.0, np.diff(clock)), "count": np.ones(ROWS)}
    values |= {"velocity": np.full(ROWS, 0.1), "theta": 0.1 * clock, "direction": np.ones(ROWS)}
    values |= {"last_direction": np.ones(ROWS), "reversal_time": 100.0 + clock, "reversal_travel": np.ones(ROWS)}
    values |= {"torque": rate * clock, "torque_level": rate * clock, "steady": np.ones(ROWS)}
    frame = Frame(ratio=185.0, **values | {"recording": np.zeros(ROWS, dtype=np.int64)})  # type: ignore[arg-type]
    return Rows(frame, np.zeros(ROWS), np.ones(ROWS))


def test_blocks_end_where_the_load_changes() -> None:
    """At 25 N·m/s to 1000 N·m no block spans more than a fortieth of it; at one load they last a second."""
    inside = np.ones(ROWS, dtype=bool)
    ramp = ramped(25.0)
    edges = offset_rows(ramp, ramp.y, inside)[2]
    spans = np.diff(ramp.frame.torque[np.append(edges, ROWS - 1)])
    assert spans.max() <= 1000.0 / 40.0 + 1.0
    calm = offset_rows(ramped(0.0), ramp.y, inside)[0]
    assert 38 <= calm.size <= 42
    quick = ramped(200.0)
    spans = np.diff(quick.frame.torque[np.append(offset_rows(quick, quick.y, inside)[2], ROWS - 1)])
    assert spans.max() <= 8000.0 / 40.0 + 5.0


def test_a_load_that_hums_ends_no_block_at_each_swing() -> None:
    """A swing within 20 ms is no change of the load: its mean stands for it."""
    rows = ramped(0.0)
    hum = 500.0 + 60.0 * np.sin(2.0 * np.pi * 41.0 * rows.frame.elapsed)
    humming = Rows(replace(rows.frame, torque=hum, torque_level=hum), rows.y, rows.number)
    found = offset_rows(humming, rows.y, np.ones(ROWS, dtype=bool))[0]
    assert found.size <= ROWS // 2


def test_what_a_load_wavers_about_its_line_is_taken_off_by_the_compliance() -> None:
    """Of the swing of an unbalance a series may have taken a part: what is left says nothing of the compliance."""
    compliance, left_over = 2.5e-7, 0.8
    parts = []
    for number, level in enumerate((-600.0, 100.0, 600.0)):
        rows = ramped(0.5)
        swing = 3.0 * np.sin(rows.frame.theta)
        line = level + rows.frame.torque
        frame = replace(
            rows.frame, torque=line + swing, torque_level=line + swing, recording=rows.frame.recording + number
        )
        parts.append(Rows(frame, compliance * (line + left_over * swing), rows.number))
    rows = join(parts)
    found = at_level(rows, np.ones(rows.size, dtype=bool))
    for number in range(3):
        own = found.frame.recording == number
        clock = found.frame.elapsed[own]
        assert np.ptp(found.frame.torque[own] - np.polyval(np.polyfit(clock, found.frame.torque[own], 1), clock)) < 1e-9
    # what the series took of it is in what was measured, and no load follows it any more
    swing = np.tile(3.0 * np.sin(ramped(0.0).frame.theta), 3)
    assert np.allclose(found.y, compliance * (found.frame.torque - (1.0 - left_over) * swing), atol=0.01 * compliance)
    assert np.std(rows.frame.torque - found.frame.torque) > 1.0
    assert np.array_equal(found.frame.torque, found.frame.torque_level)


def test_a_load_that_goes_up_and_down_stays_as_it_is() -> None:
    rows = ramped(0.0)
    load = 500.0 * np.sin(2.0 * np.pi * rows.frame.elapsed / 40.0)
    driven = Rows(replace(rows.frame, torque=load, torque_level=load), 1e-7 * load, rows.number)
    assert at_level(driven, np.ones(ROWS, dtype=bool)) is driven


def test_loads_that_are_alike_tell_no_compliance() -> None:
    rows = ramped(0.01)
    load = 500.0 + 3.0 * np.sin(rows.frame.theta)
    alike = Rows(replace(rows.frame, torque=load, torque_level=load), 1e-7 * load, rows.number)
    assert at_level(alike, np.ones(ROWS, dtype=bool)) is alike
