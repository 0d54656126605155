"""Rows of recordings by channel: in a heating run no transmission error is compared, but its states go on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.mismatch.given import Known
from bench.mismatch.prediction import evaluated
from bench.mismatch.recordings.collected import Collected
from bench.mismatch.recordings.motion import Manner
from bench.mismatch.recordings.prepared import Folder, prepare
from bench.mismatch.regression.regressors import Free
from bench.recording import ChannelSpec, Recording, Segment, write_recording
from bench.simulation.frame import gone_through
from bench.simulation.quantities import quantity
from bench.simulation.tables import Grid
from bench.simulation.terms import TRANSMISSION_ERROR
from tests.bench.recording import builders

RATE, SIZE, LOAD = 200.0, 8000, 20.0
TIME = np.arange(SIZE) / RATE
NAMES = frozenset({TRANSMISSION_ERROR})
MANNER = Manner(0.5, 0.06, 1000.0)


def read(folder: Path, kinds: tuple[str, ...]) -> Collected:
    """Recordings of such kinds under one load, one after another."""
    out = Collected()
    for number, kind in enumerate(kinds):
        rng = np.random.default_rng(number)
        values = {"time": TIME, "motor_angle": 18.5 * TIME, "load_angle": 0.1 * TIME + rng.normal(0.0, 1e-6, SIZE)}
        values["load_torque"] = np.full(SIZE, LOAD)
        channels = {name: (v, ChannelSpec.of(name, dtype="float64")) for name, v in values.items()}
        header = builders.header(f"r{number}", sample_rate=RATE, kind=kind)
        write_recording(folder / f"r{number}.h5", header, channels, [Segment("steady", 0, SIZE)], [])
        recording = Recording.open(folder / f"r{number}.h5")
        begun = recording.started_at.timestamp() - number * SIZE / RATE
        out.add(prepare(recording, number, Folder(begun, MANNER), group=1), NAMES, MANNER)
    return out


def test_states_of_the_transmission_error_go_on_through_a_heating_run(tmp_path: Path) -> None:
    rows = read(tmp_path, ("constant_velocity", "heating", "constant_velocity")).joined(TRANSMISSION_ERROR)
    assert set(rows.frame.recording) == {0, 2}
    assert rows.frame.aside is not None
    assert set(rows.frame.aside.recording) == {1}
    came = quantity("impulse_25000Nms", rows.frame)
    begins = came[np.searchsorted(rows.frame.recording, 2)]
    assert begins == pytest.approx(2.0 * LOAD * SIZE / RATE, rel=0.02)


def test_a_heating_run_alone_has_no_transmission_error_to_compare(tmp_path: Path) -> None:
    assert TRANSMISSION_ERROR not in read(tmp_path, ("heating",)).rows


def test_a_function_of_a_state_is_predicted_in_a_heating_run_and_beyond_it(tmp_path: Path) -> None:
    rows = read(tmp_path, ("constant_velocity", "heating", "constant_velocity")).joined(TRANSMISSION_ERROR)
    campaign = rows.frame
    whole = gone_through(campaign)
    grid = Grid(("impulse_25000Nms",), "1", ((-25000.0, 25000.0),))
    known = Known(Free(TRANSMISSION_ERROR, (grid,)), np.array([-25e-6, 25e-6]))
    for number in (0, 1, 2):
        at = whole.recording == number
        own = replace(whole.take(at), aside=None)
        expected = 1e-9 * quantity("impulse_25000Nms", whole)[at]
        assert evaluated(known, own, campaign) == pytest.approx(expected, abs=1e-8)
    assert expected.min() > 1.9e-9 * LOAD * SIZE / RATE  # what came before is in it
