"""A hysteresis counts as one only where the recordings drive its loops."""

import numpy as np
import pytest

from bench.mismatch.regression.candidates import exercised
from bench.mismatch.regression.regressors import named
from bench.simulation.terms import TRANSMISSION_ERROR
from tests.bench.simulation.terms.frames import at_loads_and_speeds

LOADS = (-900.0, -600.0, -300.0, 300.0, 600.0, 900.0)
SPEEDS = (0.05, 0.08, 0.12, 0.17)
EACH = 40


@pytest.mark.parametrize(("path", "driven"), [("steady", False), ("up and down", True)])
def test_loops_are_driven_where_the_load_goes_up_and_down(path: str, driven: bool) -> None:
    rise = np.linspace(0.0, 1.0, EACH // 2)
    rows = at_loads_and_speeds(np.ones(EACH) if path == "steady" else np.concatenate([rise, rise[::-1]]), LOADS, SPEEDS)
    loop = named("te.hysteresis", TRANSMISSION_ERROR, "play", (200.0,))
    assert exercised(loop, loop.columns(rows), rows) is driven
    plain = named("te.lost_motion", TRANSMISSION_ERROR, "tanh", (100.0,))
    assert exercised(plain, plain.columns(rows), rows)
