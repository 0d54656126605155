"""Blocks of the offset: a load that changes ends a block, for what has a knee has no mean at the mean load."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bench.mismatch.orders.offset_rows import offset_rows
from bench.mismatch.recordings.rows import Rows
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
