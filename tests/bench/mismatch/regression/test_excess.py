"""What of an effect no calibration can say."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.regression.excess import excess, levelled
from tests.bench.mismatch.regression.synthetic import EACH, campaign


def test_what_the_simulation_can_say_is_no_excess() -> None:
    rng = np.random.default_rng(1)
    base = [rng.normal(size=(200, 2)), np.ones((200, 1))]
    said = np.hstack(base) @ np.array([2.0, -1.0, 5.0])
    assert excess(said, base, np.full(200, 3.0)) == pytest.approx(np.zeros(200), abs=1e-6)
    beyond = rng.normal(size=200)
    assert excess(said + beyond, base, np.full(200, 3.0)) == pytest.approx(
        excess(beyond, base, np.full(200, 3.0)), abs=1e-6
    )


def test_every_sample_counts_alike() -> None:
    values = np.array([0.0, 1.0])
    left = excess(values, [np.ones((2, 1))], np.array([30.0, 10.0]))
    assert left == pytest.approx([-0.25, 0.75])
    # what is not compared fits nothing
    assert excess(values, [np.ones((2, 1))], np.array([30.0, 0.0])) == pytest.approx([0.0, 1.0])


def test_a_level_of_each_recording_is_no_excess() -> None:
    frame = campaign(2)
    course = np.tile(np.linspace(-1.0, 1.0, EACH), 2)
    level = np.repeat([3.0, -7.0], EACH)
    assert levelled(course + level, frame, np.ones(frame.size)) == pytest.approx(course)
