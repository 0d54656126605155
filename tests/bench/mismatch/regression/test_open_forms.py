"""How sure the numbers of a name are where another of its forms predicts about as well."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.beside import shaped
from bench.mismatch.regression.open_forms import _in, with_open_forms
from bench.mismatch.regression.regressors import Named, named
from bench.mismatch.regression.search import begun
from bench.mismatch.regression.slots import Slot
from bench.simulation.terms import MOTOR_TORQUE
from tests.bench.mismatch.regression.synthetic import campaign, problem

SIZE, SPEED = 0.4, 4.0


def numbers(noise: float, form: str) -> tuple[Named, Named]:
    """A Stribeck curve in the ``form`` that is told, of one that is Gaussian: before and after its forms are asked."""
    frame = campaign()
    rng = np.random.default_rng(2)
    true = named("friction.stribeck", MOTOR_TORQUE, "gaussian", (SPEED,)).columns(frame)[:, 0]
    y = 0.6 * frame.direction + 0.01 * frame.omega + SIZE * true + rng.normal(0.0, noise, frame.size)
    search = begun(problem(frame, np.asarray(y)))
    own = shaped(search, [], named("friction.stribeck", MOTOR_TORQUE, form, (SPEED,)))
    assert own is not None
    own = replace(own, shape=None)
    search.model = replace(search.model, chosen=[own], fit=search.model.refitted([own]))
    (slot,) = with_open_forms(search, [Slot(own, 50.0, 0.001, 0.9, ())])
    assert search.model.chosen == [slot.chosen]
    before, after = own.main.regressor, slot.chosen.main.regressor
    assert isinstance(before, Named)
    assert isinstance(after, Named)
    assert after.point == before.point
    return before, after


@pytest.mark.parametrize(
    ("noise", "form", "wider"), [(0.002, "gaussian", 1.0), (0.3, "gaussian", 8.3), (0.002, "exponential", 7.1)]
)
def test_numbers_are_as_unsure_as_the_form(noise: float, form: str, wider: float) -> None:
    """Where points left out tell the form, the others say nothing; where they do not, all count; and a form that nature
    has not is off by what the right one says.
    """
    before, after = numbers(noise, form)
    assert before.deviation[0] is not None
    assert after.deviation[0] is not None
    assert after.carried[0] / before.carried[0] == pytest.approx(wider, rel=0.1)
    assert after.deviation[0] >= before.deviation[0]


def test_intervals_of_a_term_that_was_told_cover_the_truth() -> None:
    """Refined beside the simulation, without and then with the offsets that it makes."""
    frame = campaign()
    true = named("friction.stribeck", MOTOR_TORQUE, "gaussian", (SPEED,)).columns(frame)[:, 0]
    scores = []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        offsets = rng.normal(0.0, 0.02, int(frame.recording.max()) + 1)[frame.recording]
        noise = offsets + rng.normal(0.0, 0.05, frame.size)
        y = 0.6 * frame.direction + 0.01 * frame.omega + SIZE * true + noise
        found = shaped(begun(problem(frame, y)), [], named("friction.stribeck", MOTOR_TORQUE, "gaussian", (2.0,)))
        assert found is not None
        term = found.main.regressor
        assert isinstance(term, Named)
        assert term.deviation[0] is not None
        scores.append((term.point[0] - SPEED) / term.deviation[0])
    # 95 % of 30 is 28.5; fewer than 25 have a chance of 1 in 300
    assert np.sum(np.abs(scores) < 1.96) >= 25
    assert np.sqrt(np.mean(np.square(scores))) > 0.5


def test_a_form_of_which_the_recordings_have_no_point_is_not_asked() -> None:
    frame = campaign()
    y = 0.6 * frame.direction + np.random.default_rng(2).normal(0.0, 0.01, frame.size)
    search = begun(problem(frame, np.asarray(y)))
    gaussian, exponential = (
        named("friction.stribeck", MOTOR_TORQUE, form, (SPEED,)) for form in ("gaussian", "exponential")
    )
    nowhere = replace(
        exponential.form,
        grid=lambda _: (),
        nonlinear=tuple(replace(s, upper=np.inf) for s in exponential.form.nonlinear),
    )
    assert _in(search, [], gaussian, nowhere) is None
