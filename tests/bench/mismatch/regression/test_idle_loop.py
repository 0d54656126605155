"""A loop that the recordings never turned has to beat a function of the torque by its handicap to be told alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch import criteria
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.beside import idle, shaped
from bench.mismatch.regression.folds import weights
from bench.mismatch.regression.problem import ChannelProblem, nominal_base
from bench.mismatch.regression.regressors import named
from bench.mismatch.regression.search import begun
from bench.mismatch.regression.slots import slots
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray
from bench.simulation.terms import TRANSMISSION_ERROR
from tests.bench.simulation.terms.frames import at_loads_and_speeds

LOADS, SPEEDS, EACH = (-900.0, -600.0, -300.0, 300.0, 600.0, 900.0), (0.05, 0.17), 20
NOISE = 2e-6


def _with_a_loop(path: FloatArray) -> Search:
    """A search of an error with lost motion, whose model says hysteresis."""
    rows = at_loads_and_speeds(path, LOADS, SPEEDS)
    y = 2e-5 * np.tanh(rows.torque / 60.0) + NOISE * np.random.default_rng(3).normal(size=rows.size)
    recordings = np.arange(int(rows.recording.max()) + 1)
    own = Rows(rows, y, rows.count)
    base = tuple(nominal_base(TRANSMISSION_ERROR, ()))
    search = begun(ChannelProblem(TRANSMISSION_ERROR, own, np.ones(rows.size, dtype=bool), recordings, base))
    loop = shaped(search, [], named("te.hysteresis", TRANSMISSION_ERROR, "play", (200.0,)))
    assert loop is not None
    model = search.model
    return replace(search, model=replace(model, chosen=[loop], fit=model.refitted([loop])))


@pytest.mark.parametrize("turned", [False, True])
def test_only_a_loop_that_was_turned_weighs_what_it_predicts(turned: bool) -> None:
    rise = np.linspace(0.0, 1.0, EACH // 2)
    search = _with_a_loop(np.concatenate([rise, rise[::-1]]) if turned else np.ones(EACH))
    (loop,) = search.model.chosen
    assert idle(search, loop) is not turned
    (slot,) = slots(search)
    names = [r for r in slot.alternatives if r.chosen.effect != "unknown"]
    assert names
    # what a loop gains that was never turned is its form's: a name that is nearer to it than nothing is as good
    near = [r for r in names if r.loss < slot.gain - r.loss]
    assert near
    if not turned:
        assert all(r.as_good for r in near)
    own, without = search.density([loop]), search.density([])
    table = np.array([own, *(r.density for r in slot.alternatives), without])
    plain = weights(table, search.seed)
    best = max(range(len(slot.alternatives)), key=lambda k: plain[k + 1] * (slot.alternatives[k] in names))
    expected = plain[0] / plain[best + 1] * np.exp(-criteria.RICHER * (not turned))
    # the bootstrap's draws are the same, the order of the alternatives is not
    assert slot.weight / slot.alternatives[best].weight == pytest.approx(expected, rel=1e-6)
