"""What is asked when a function without a name is refuted, and functions of two quantities."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from bench.mismatch.regression import choosing, succession
from bench.mismatch.regression import search as searching
from bench.mismatch.regression.model import Block, ChannelModel, Chosen, unrefined
from bench.mismatch.regression.problem import ChannelProblem
from bench.mismatch.regression.products import products
from bench.mismatch.regression.regressors import UNKNOWN, Free
from bench.mismatch.regression.search import MOST_ASKED_AGAIN, MOST_REFUTED, begun, next_best, searched
from bench.mismatch.regression.succession import settle
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.tables import Grid
from tests.bench.mismatch.regression.synthetic import campaign, problem

SIGMA = 0.05


def made(frame: Frame, effect: FloatArray) -> ChannelProblem:
    """Dry friction and an effect, with noise and offsets of the recordings."""
    rng = np.random.default_rng(1)
    offsets = rng.normal(scale=0.01, size=int(frame.recording.max()) + 1)[frame.recording]
    return problem(frame, 0.6 * frame.direction + effect + offsets + rng.normal(scale=SIGMA, size=frame.size))


@pytest.fixture
def timeless(monkeypatch: pytest.MonkeyPatch) -> None:
    """Levels over the campaign take long to look for, and nothing here has any."""
    monkeypatch.setattr(choosing, "_levels", lambda _search: [])


def humped() -> ChannelProblem:
    """A hump of the friction at one speed."""
    frame = campaign(32)
    return made(frame, 0.25 * frame.direction * np.exp(-((np.log(np.abs(frame.velocity) / 0.03) / 0.3) ** 2)))


@pytest.mark.usefixtures("timeless")
def test_after_a_function_is_refuted_the_next_best_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[list[Chosen]] = []

    def against_the_first(model: ChannelModel) -> list[Chosen]:
        asked.append(list(model.chosen))
        return [] if len(asked) == 1 else list(model.chosen)

    monkeypatch.setattr(succession, "borne_out", against_the_first)
    search = searched(humped())
    settle(search)
    (first,) = asked[0]
    assert search.model.chosen
    assert len(asked) == 2
    of = [(c.main.regressor.variables, c.main.regressor.equation) for c in search.model.chosen]
    assert (first.main.regressor.variables, first.main.regressor.equation) not in of


@pytest.mark.usefixtures("timeless")
def test_it_ends_where_all_are_refuted(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[list[Chosen]] = []

    def against_all(model: ChannelModel) -> list[Chosen]:
        asked.append(list(model.chosen))
        return []

    monkeypatch.setattr(succession, "borne_out", against_all)
    search = searched(humped())
    assert settle(search) == []
    assert 1 < len(asked) <= MOST_ASKED_AGAIN + 1


@pytest.mark.usefixtures("timeless")
def test_when_many_functions_were_refuted_names_alone_are_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """They may have stood before a name."""
    search = begun(humped())
    asked: list[bool] = []
    monkeypatch.setattr(searching, "_forward", lambda _search, more_functions: asked.append(more_functions))
    monkeypatch.setattr(searching, "concluded", lambda search: search)
    tables = [unrefined(search.bank, b) for b in search.blocks if b.regressor.effect == UNKNOWN][:MOST_ASKED_AGAIN]
    for number in range(1, MOST_ASKED_AGAIN + 1):
        search.refuted = tables[:number]
        next_best(search, number - 1)
    assert asked == [*[True] * (MOST_REFUTED - 1), *[False] * (MOST_ASKED_AGAIN - MOST_REFUTED)]


@pytest.mark.usefixtures("timeless")
def test_a_product_of_functions_of_speed_and_load_is_one_function() -> None:
    """A narrow hump over the speed that a load above 100 N·m brings about: no coarse table has it."""
    frame = campaign(144)
    speeds = np.random.default_rng(3).permutation(np.repeat(np.geomspace(0.01, 0.17, 24), 6))
    velocity = np.sign(frame.velocity) * speeds[frame.recording]
    frame = replace(frame, velocity=velocity)
    hump = np.exp(-((np.log(np.abs(velocity) / 0.05) / 0.2) ** 2))
    loaded = 1.0 / (1.0 + np.exp(-(frame.torque - 100.0) / 80.0))
    search = searched(made(frame, 0.8 * frame.direction * hump * loaded))
    settle(search)
    (own,) = search.model.chosen
    free = own.main.regressor
    assert isinstance(free, Free)
    assert own.effect == "unknown"
    assert set(free.variables) == {"speed", "torque"}
    assert {grid.times for grid in free.grids} == {"d"}
    left = search.model.predict(frame) - 0.6 * frame.direction - 0.8 * frame.direction * hump * loaded
    assert float(np.sqrt(np.mean(left**2))) < 0.3 * float(np.sqrt(np.mean((0.8 * hump * loaded) ** 2)))


@pytest.mark.usefixtures("timeless")
def test_what_is_close_in_the_load_and_coarse_in_the_temperature_is_one_function() -> None:
    frame = campaign(72)
    bump = np.exp(-(((frame.torque - 300.0) / 220.0) ** 2)) * np.tanh((frame.temperature - 31.0) / 3.0)
    effect = 0.6 * bump
    search = searched(made(frame, effect))
    settle(search)
    (own,) = search.model.chosen
    assert own.effect == "unknown"
    assert set(own.main.regressor.variables) == {"torque", "temperature"}
    left = search.model.predict(frame) - 0.6 * frame.direction - effect
    assert float(np.sqrt(np.mean(left**2))) < 0.3 * float(np.sqrt(np.mean(effect**2)))


def test_heat_that_is_summed_up_has_no_products() -> None:
    knots = (0.01, 0.05, 0.1)
    table = Free("temperature", (Grid(("load", "speed"), "1", (knots, knots)),))
    chosen = [Chosen(Block(table, tuple(range(9)), np.zeros(9)))]
    model = SimpleNamespace(channel="temperature", problem=SimpleNamespace(free=False), chosen=chosen)
    assert products(cast("Any", SimpleNamespace(model=model, refuted=[]))) == []
