"""What the search finds in a torque made by hand, and what it leaves alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression import search as search_of_a_channel
from bench.mismatch.regression.folds import squares
from bench.mismatch.regression.problem import ChannelProblem
from bench.mismatch.regression.regressors import Named
from bench.mismatch.regression.search import searched
from bench.mismatch.regression.spells import levels_of, spell_of
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray, Frame
from tests.bench.mismatch.regression.synthetic import campaign, problem

SIGMA, RECORDINGS = 0.05, 40
FRAME = campaign(RECORDINGS)


def made(effect: FloatArray, frame: Frame = FRAME, seed: int = 1, offset: float = 0.02) -> ChannelProblem:
    rng = np.random.default_rng(seed)
    offsets = rng.normal(scale=offset, size=RECORDINGS)[frame.recording]
    return problem(frame, 0.6 * frame.direction + effect + offsets + rng.normal(scale=SIGMA, size=frame.size))


def test_a_zero_that_jumps_is_a_spell_with_its_ends_between_two_recordings() -> None:
    first, last = 11, 24
    inside = (FRAME.recording >= first) & (FRAME.recording <= last)
    found = searched(made(0.15 * inside)).model
    (own,) = found.chosen
    spell = spell_of(own.main.regressor)
    assert spell is not None
    begin, _, end, _ = spell.knots[0]
    times = FRAME.time[np.flatnonzero(np.diff(FRAME.recording, prepend=-1))]
    assert times[first - 1] < begin < times[first]
    assert times[last] < end < times[last + 1]
    assert found.fit.of(own.main.indices)[0][0] == pytest.approx(0.15, abs=0.03)
    assert own.main.regressor.words.startswith("a constant from ")


def test_a_drag_that_switches_inside_recordings_is_levels_that_change_there() -> None:
    switched = (5, 11, 19, 28)
    moments = [600.0 * r + 12.5 for r in switched]
    high = np.searchsorted(moments, FRAME.time) % 2 == 1
    found = searched(made(0.3 * high * FRAME.direction)).model
    (own,) = found.chosen
    levels = levels_of(own.main.regressor)
    assert levels is not None
    assert (own.effect, levels.times, levels.changes) == ("unknown", "d", 4)
    assert np.asarray(levels.knots[0][1:-1]) == pytest.approx(moments, abs=3.0)
    rise = np.diff(found.fit.of(own.main.indices)[0])
    assert rise == pytest.approx([0.3, -0.3, 0.3, -0.3], abs=0.05)
    assert own.main.regressor.words == "a level times d that changes 4 times"


def test_what_drifts_evenly_is_no_levels() -> None:
    drift = 0.4 * FRAME.time / FRAME.time.max()
    found = searched(made(drift)).model
    assert found.chosen
    assert not any(levels_of(c.main.regressor) for c in found.chosen)


def test_what_changes_more_often_than_levels_may_is_no_levels() -> None:
    # more levels follow it ever better, and none of them says anything of another recording
    some = np.random.default_rng(5).choice(RECORDINGS, 10, replace=False)
    humps = 0.5 * np.isin(FRAME.recording, some) * (FRAME.elapsed > 10.0) * (FRAME.elapsed < 22.0)
    found = searched(made(humps)).model
    assert not any(levels_of(c.main.regressor) for c in found.chosen)


def test_a_hump_at_one_speed_is_a_function_of_the_speed_and_no_stribeck_curve() -> None:
    speed = np.abs(FRAME.velocity)
    hump = 0.25 * FRAME.direction * np.exp(-((np.log(speed / 0.03) / 0.3) ** 2))
    found = searched(made(hump)).model
    assert {c.main.regressor.variables for c in found.chosen} == {("speed",)}
    assert {c.effect for c in found.chosen} == {"unknown"}


def test_a_film_that_grows_with_the_speed_is_friction_that_follows_the_viscosity() -> None:
    """A bearing's drag goes with the two thirds of viscosity and speed (Palmgren): no straight line over the speed."""
    frame = campaign(40)
    drag = 0.02 * frame.direction * np.abs(frame.omega) ** (2.0 / 3.0) * np.exp(-0.04 * (frame.temperature - 25.0))
    y = 0.4 * frame.direction + 0.01 * frame.omega + drag + np.random.default_rng(4).normal(0.0, 0.002, frame.size)
    search = searched(problem(frame, y))
    (effect,) = search.model.chosen
    assert effect.effect == "friction.viscous_temperature"
    assert isinstance(effect.main.regressor, Named)
    assert effect.main.regressor.form.name == "thinning"
    assert effect.main.regressor.point[1] == pytest.approx(2.0 / 3.0, abs=0.1)


def test_recordings_held_out_choose_nothing() -> None:
    folds = np.arange(RECORDINGS, dtype=np.int64)
    folds[[6, 13, 20, 27, 34]] = -1
    held = folds[FRAME.recording] < 0
    hot = 0.25 * FRAME.direction * ((FRAME.temperature - 30.0) / 10.0) ** 2
    as_it_is = searched(replace(made(hot), folds=folds)).model
    otherwise = searched(replace(made(np.where(held, -5.0 * hot, hot)), folds=folds)).model
    assert as_it_is.chosen
    assert [c.main.regressor for c in otherwise.chosen] == [c.main.regressor for c in as_it_is.chosen]
    assert np.array_equal(otherwise.fit.coefficients, as_it_is.fit.coefficients)


def test_in_noise_nothing_is_found() -> None:
    assert not any(searched(made(np.zeros(FRAME.size), seed=s)).model.chosen for s in range(6))


def test_squares_of_points_left_out_are_those_of_a_fit_without_them() -> None:
    own = made(0.1 * np.sin(FRAME.temperature))
    model = searched(own).model
    blocks = model.blocks([])
    index = [i for b in blocks for i in b.indices]
    columns, fold = model.bank.columns.some(index), model.folds[FRAME.recording]
    told = squares(model.bank, blocks, model.folds, 0.0)
    for out in (0, 7, RECORDINGS - 1):
        beta = np.linalg.lstsq(columns[fold != out], model.bank.y[fold != out], rcond=None)[0]
        left = model.bank.y[fold == out] - columns[fold == out] @ beta
        assert told[out] == pytest.approx(float(left @ left), rel=1e-4)


@pytest.mark.parametrize("explained", [True, False])
def test_rows_in_full_are_asked_where_wide_ones_find_nothing(monkeypatch: pytest.MonkeyPatch, explained: bool) -> None:
    """The means contradict the calibrated simulation, and what is found with full rows or not even that."""
    monkeypatch.setattr(search_of_a_channel, "_contradicted", lambda s: 1.0 if explained and s.model.chosen else 60.0)
    hump = 0.4 * np.exp(-((np.abs(FRAME.velocity) / 0.02) ** 2)) * FRAME.direction
    model = searched(made(hump)).model
    assert bool(model.chosen) is explained
    # what is found with rows in full has their price
    alone = search_of_a_channel.begun(made(hump))
    assert not explained or model.price == alone.scan([], alone.model.fit).price
    assert any("60 times as large" in note for note in model.notes) is not explained


@pytest.mark.parametrize(
    ("answers", "widths"),
    [
        # of the simulation, of what was found, of that with narrower noise, of what was found then
        ([6.0, 2.0, 1.0, 1.2], [6.0, 2.0, 1.2]),
        ([6.0, 5.8], [6.0]),
        ([6.0, 2.0, 2.0], [6.0, 2.0]),
    ],
    ids=["narrower", "hardly narrower", "narrower noise is contradicted"],
)
def test_rows_are_taken_less_wide_when_what_was_found_contradicts_their_means_less(
    monkeypatch: pytest.MonkeyPatch, answers: list[float], widths: list[float]
) -> None:
    """As long as each round leaves less, and its fit does not contradict the means."""
    rest = iter(answers)
    taken: list[float] = []

    def begun(own: ChannelProblem, seed: int = 0, residual: FloatArray | None = None, wider: float = 1.0) -> Search:
        taken.append(wider)
        return whole(own, seed, residual, wider)

    whole = search_of_a_channel.begun
    monkeypatch.setattr(search_of_a_channel, "_contradicted", lambda _: next(rest, answers[-1]))
    monkeypatch.setattr(search_of_a_channel, "begun", begun)
    hump = 0.4 * np.exp(-((np.abs(FRAME.velocity) / 0.02) ** 2)) * FRAME.direction
    model = searched(made(hump)).model
    assert taken == [1.0, *widths]
    told = widths[1] if len(widths) == 3 else widths[0]  # what the means contradict is not told
    assert any(f"{told:.2g} times as large" in note for note in model.notes)
