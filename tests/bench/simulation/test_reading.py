"""Functions of a thermometer's reading, beside rates of the heat balance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bench.mismatch.regression.regressors import Free
from bench.simulation.quantities import READ, factor
from bench.simulation.reading import is_read, left_side, of_temperature
from bench.simulation.tables import Grid
from bench.simulation.terms import TEMPERATURE
from tests.bench.mismatch.regression.synthetic import campaign

KNOTS = ((-0.2, 0.0, 0.2),)


def test_a_function_that_is_read_is_there_at_once_and_a_rate_adds_up() -> None:
    frame = campaign(4)
    rate, read = (Free(TEMPERATURE, (Grid(("velocity",), times, KNOTS),)) for times in ("1", READ))
    hats = read.grids[0].columns(frame)
    assert np.array_equal(read.columns(frame), hats)
    for number in range(4):
        rows = frame.recording == number
        # at one speed a rate is a straight line
        assert np.allclose(rate.columns(frame)[rows], hats[rows] * frame.elapsed[rows][:, None])
    assert (rate.equation, read.equation) == (
        "dT/dt += f(velocity), f a table",
        "temperature += f(velocity), f a table",
    )
    both = Free(TEMPERATURE, (*read.grids, *rate.grids))
    assert both.equation == "dT/dt += d(f_1(velocity))/dt + f_2(velocity), f a table"
    assert read.words == "a function of velocity, read by the thermometer"
    assert {row["unit"] for row in read.parameters(np.ones(3), np.ones(3))} == {"K"}
    assert {row["unit"] for row in rate.parameters(np.ones(3), np.ones(3))} == {"K/s"}


def test_the_factor_itself_is_one_and_stands_in_products() -> None:
    frame = campaign(2)
    assert np.array_equal(factor(f"{READ}*tau", frame), factor("tau", frame))
    assert is_read(f"tau*{READ}")
    assert not is_read("tau")
    assert (left_side([READ, "1"]), left_side([READ]), left_side([])) == ("dT/dt", "temperature", "dT/dt")
    both = of_temperature(np.ones((frame.size, 2)), [READ, "1"], replace(frame))
    assert np.allclose(both[:, 0], 1.0)
    assert both[:, 1].max() > 1.0
