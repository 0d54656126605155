"""What comes and goes gradually in a campaign: a table over time with knots where it bends."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.regression.bends import Bends, bending, bends_of
from bench.mismatch.regression.choosing import _levels
from bench.mismatch.regression.model import Chosen
from bench.mismatch.regression.search import begun
from bench.mismatch.regression.spells import changing_of, in_levels, price_of_cuts
from bench.simulation.tables import hats
from tests.bench.mismatch.regression.test_search import FRAME, made

WIDTH = 1000.0


def test_knots_are_put_where_a_course_bends() -> None:
    time = np.linspace(0.0, 1000.0, 201)
    value = np.interp(time, [0.0, 300.0, 340.0, 600.0, 680.0, 1000.0], [1.0, 1.0, 4.0, 4.0, 2.0, 2.0])
    jumps = np.searchsorted(time, [320.0, 640.0])
    (*_, (knots, squares)) = bending(time, value, np.ones(time.size), jumps, 4)
    basis = hats(time, np.asarray(knots))
    left = value - basis @ np.linalg.lstsq(basis, value, rcond=None)[0]
    assert np.abs(left).max() < 1e-6
    assert squares == pytest.approx(0.0, abs=1e-3)
    assert list(knots[1:-1]) == [300.0, 340.0, 600.0, 680.0]


def test_a_level_that_comes_and_goes_gradually_bends_and_jumps_not() -> None:
    """Far above the noise no number of jumps is enough for what takes its time."""
    times = [600.0 * r + 12.0 for r in (9, 25)]
    hump = np.tanh((FRAME.time - times[0]) / WIDTH) - np.tanh((FRAME.time - times[1]) / WIDTH)
    search = begun(made(6.0 * hump))
    (found,) = in_levels(search.model, ["1"])
    course = bends_of(found.regressor)
    assert course is not None
    assert 4 <= course.changes <= 12
    assert found.regressor.words == f"a course over time that bends {course.changes} times"
    assert price_of_cuts(search.model, found.regressor) > 0.0
    near = np.min(np.abs(np.asarray(course.knots[0])[:, None] - np.asarray(times)), axis=1)
    assert np.sum(near < 2.0 * WIDTH) >= 4
    # beside such a course no levels are looked for
    search.model.chosen.append(Chosen(found))
    assert all(changing.times != "1" for b in _levels(search) if (changing := changing_of(b.regressor)) is not None)


@pytest.mark.parametrize(
    ("values", "window"),
    [
        ([0.0, 0.0, 4.0, 4.0, 0.5, 0.5], (320.0, 640.0)),
        ([1.0, 1.0, -3.0, -3.0, 1.0, 1.0], (320.0, 640.0)),
        ([0.0, 0.0, 4.0, 4.0, 4.0, 4.0], None),
        ([0.0, 1.0, 2.0, 3.0, 4.0, 5.0], None),
        ([1.0, 1.0, 1.0, 1.0, 1.0, 1.0], None),
    ],
)
def test_what_comes_and_goes_lies_where_it_is_away(values: list[float], window: tuple[float, float] | None) -> None:
    course = Bends(("time",), "1", ((0.0, 300.0, 340.0, 600.0, 680.0, 1000.0),))
    found = course.away(np.array(values))
    assert found == (None if window is None else pytest.approx(window, abs=12.0))
