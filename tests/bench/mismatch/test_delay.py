"""Who is asked for a delay of the torque channel: the load torque first, the angles only if it cannot tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.analysis import DELAY, _excluded_delay
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.problem import ChannelProblem, nominal_base
from bench.mismatch.regression.search import Search, searched
from bench.simulation.terms import LOAD_TORQUE
from tests.bench.mismatch.regression.synthetic import campaign

RECORDINGS, NOISE = 24, 0.3


def ramps(rate: float, late: float) -> Search:
    """The load torque of up-and-down ramps of ``rate`` N·m/s, read ``late`` s late."""
    rng = np.random.default_rng(0)
    frame = campaign(RECORDINGS)
    up = np.where(frame.elapsed < frame.elapsed.max() / 2.0, 1.0, -1.0)
    slope = np.where(frame.recording % 2 == 0, rate, -rate)
    load = slope * np.minimum(frame.elapsed, frame.elapsed.max() - frame.elapsed)
    shaken = rng.normal(scale=0.1, size=frame.size)
    frame = replace(frame, torque=load, torque_level=load, torque_rate=slope * up, load_acceleration=shaken)
    y = -late * frame.torque_rate + rng.normal(scale=NOISE, size=frame.size)
    base = tuple(nominal_base(LOAD_TORQUE, ()))
    usable = np.ones(frame.size, dtype=bool)
    return searched(ChannelProblem(LOAD_TORQUE, Rows(frame, y, frame.count), usable, np.arange(RECORDINGS), base))


@pytest.mark.parametrize(
    ("rate", "late", "found", "banned"),
    [
        (100.0, 0.0, [], (DELAY,)),  # fast ramps say that there is none
        (100.0, 0.02, [DELAY], ()),  # a delay found: the angles must explain what it does to them
        (0.5, 0.0, [], ()),  # a torque that hardly changes does not know
    ],
)
def test_angles_are_asked_for_a_delay_unless_the_load_torque_excludes_it(
    rate: float, late: float, found: list[str], banned: tuple[str, ...]
) -> None:
    search = ramps(rate, late)
    assert [chosen.effect for chosen in search.model.chosen] == found
    assert _excluded_delay(search) == banned
    search.close()
