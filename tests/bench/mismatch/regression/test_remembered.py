"""A quantity that goes on from recording to recording is worked out through all of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bench.mismatch.regression.course import ROWS_AT_ONCE, added, columns_at, groups
from bench.mismatch.regression.regressors import Free, remembers
from bench.simulation.tables import Grid
from bench.simulation.terms import MOTOR_TORQUE
from tests.bench.mismatch.regression.synthetic import EACH, campaign

RECORDINGS = ROWS_AT_ONCE // EACH + 40


def table(name: str) -> Free:
    return Free(MOTOR_TORQUE, (Grid((name,), "1", ((-2.0, 0.0, 2.0),)),))


def test_how_warm_it_was_before_is_not_forgotten_between_groups_of_recordings() -> None:
    frame = campaign(RECORDINGS)
    frame = replace(frame, temperature=30.0 + 2.0 * np.sin(frame.time / 5000.0))
    assert len(groups(frame)) > 1
    warm, coefficients = table("warming"), np.array([-1.0, 0.0, 1.0])
    assert remembers(warm)
    assert not remembers(table("temperature"))
    whole = warm.columns(frame) @ coefficients
    assert np.array_equal(added(warm, frame, coefficients), whole)
    chosen = np.arange(0, frame.size, 97)
    assert np.array_equal(columns_at(warm, frame, chosen) @ coefficients, whole[chosen])
