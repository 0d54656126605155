"""A name small beside what has no explanation is no part of that where it depends on other quantities."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from bench.mismatch.regression.beside import shaped
from bench.mismatch.regression.independent import beyond_noise, independent
from bench.mismatch.regression.pruning import _above_the_rest
from bench.mismatch.regression.regressors import named
from bench.mismatch.regression.search import begun
from bench.simulation.terms import MOTOR_TORQUE
from tests.bench.mismatch.regression.synthetic import banked, campaign, problem


@pytest.mark.parametrize(
    ("hidden", "told"),
    [
        # a drag that follows the temperature in a curve that no name has, and a mass that turns with the output
        ("mass", True),
        # a drag that comes and goes with the angle as well: the mass is a part of it
        ("angle", False),
    ],
)
def test_a_name_is_independent_of_what_depends_on_other_quantities(hidden: str, told: bool) -> None:
    frame = campaign()
    rng = np.random.default_rng(7)
    mass = 0.04 * np.cos(frame.q)
    rest = 0.1 * np.sin(frame.temperature) * frame.direction
    if hidden == "angle":
        mass, rest = 0.01 * np.cos(frame.q), 0.2 * np.sign(np.cos(7.0 * frame.q)) * frame.direction
    y = 0.5 * frame.direction + 0.006 * frame.omega + mass + rest + rng.normal(0.0, 0.01, frame.size)
    search = begun(problem(frame, y))
    found = shaped(search, [], named("load.unbalance", MOTOR_TORQUE, "gravity"))
    assert found is not None
    search.model.price = search.scan([], search.model.fit).price
    assert independent(search, [found], found) is told
    assert (_above_the_rest(search, [found]) == [found]) is told


@pytest.mark.parametrize("integral", [True, False])
def test_the_level_at_which_a_recording_begins_is_nothing_left_of_an_integral(integral: bool) -> None:
    frame = campaign(8)
    noise = np.random.default_rng(4).normal(scale=0.05, size=frame.size)
    bank, base = banked(problem(frame, noise + 30.0 + 2.0 * frame.recording), 0.05, 0.0)
    model = SimpleNamespace(
        bank=bank, problem=SimpleNamespace(spec=SimpleNamespace(integral=integral)), blocks=lambda _chosen: base
    )
    fitted = SimpleNamespace(coefficients=np.zeros(len([i for b in base for i in b.indices])))
    left = beyond_noise(model, [], fitted)  # type: ignore[arg-type]
    assert (left < 0.3) if integral else (left > 1000.0)
