"""A hysteresis counts as one only where the recordings drive its loops."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.candidates import exercised
from bench.mismatch.regression.regressors import named
from bench.simulation.frame import Frame, concatenate
from bench.simulation.terms import TRANSMISSION_ERROR
from tests.bench.simulation.terms.frames import frame

LOADS = (-900.0, -600.0, -300.0, 300.0, 600.0, 900.0)
SPEEDS = (0.05, 0.08, 0.12, 0.17)
EACH = 40


def _campaign(path: np.ndarray) -> Frame:
    """Recordings of forty rows at six loads and four speeds in both directions; ``path`` scales the load in each."""
    one = frame().take(np.arange(EACH))
    parts = []
    for number, (load, speed, turn) in enumerate(itertools.product(LOADS, SPEEDS, (1.0, -1.0))):
        parts.append(
            replace(
                one,
                recording=np.full(EACH, number),
                time=one.elapsed + 100.0 * number,
                torque=load * path,
                torque_level=load * path,
                velocity=np.full(EACH, turn * speed),
                direction=np.full(EACH, turn),
                last_direction=np.full(EACH, turn),
                temperature=np.full(EACH, 25.0 + 4.0 * (number % 5)),
                steady=np.ones(EACH),
            )
        )
    return concatenate(parts)


@pytest.mark.parametrize(("path", "driven"), [("steady", False), ("up and down", True)])
def test_loops_are_driven_where_the_load_goes_up_and_down(path: str, driven: bool) -> None:
    rise = np.linspace(0.0, 1.0, EACH // 2)
    rows = _campaign(np.ones(EACH) if path == "steady" else np.concatenate([rise, rise[::-1]]))
    loop = named("te.hysteresis", TRANSMISSION_ERROR, "play", (200.0,))
    assert exercised(loop, loop.columns(rows), rows) is driven
    plain = named("te.lost_motion", TRANSMISSION_ERROR, "tanh", (100.0,))
    assert exercised(plain, plain.columns(rows), rows)
