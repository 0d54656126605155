"""A drag that comes and goes evenly over the campaign's time."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression import cycles
from bench.mismatch.regression.cycles import (
    MOST_LINES,
    SHORTEST_S,
    _frequencies,
    _lines,
    cycle_of,
    in_cycles,
    price_of_period,
)
from bench.mismatch.regression.search import begun, searched
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.tables import from_json
from tests.bench.mismatch.regression.synthetic import EACH, campaign, problem

PERIOD = 437.0
"""s, of no whole number of the recordings' spacing"""


def often() -> Frame:
    """Half a minute recorded of every 100 s."""
    frame = campaign(48)
    return replace(frame, time=frame.time - 500.0 * frame.recording)


def measured(frame: Frame, size: float, seed: int = 0) -> FloatArray:
    """Friction with noise, offsets of the recordings, and a part of ``size`` N·m that breathes."""
    rng = np.random.default_rng(seed)
    offsets = np.repeat(rng.normal(0.0, 0.005, frame.size // EACH), EACH)
    drag = 0.5 + size * np.sin(2.0 * np.pi * frame.time / PERIOD + 0.4)
    return np.asarray(drag * frame.direction + 0.006 * frame.omega + rng.normal(0.0, 0.01, frame.size) + offsets)


def test_the_period_is_found() -> None:
    frame = often()
    (block,) = in_cycles(begun(problem(frame, measured(frame, 0.1))).model, ("d",))
    one = cycle_of(block.regressor)
    assert one is not None
    # two hundredths of a period over the whole campaign
    assert one.period == pytest.approx(PERIOD, rel=0.02 * PERIOD / float(np.ptp(frame.time)))


def test_another_line_of_the_spectrum_may_be_the_cycle(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the simulation has taken of the wave may leave another line higher than its own."""
    frame = often()
    model = begun(problem(frame, measured(frame, 0.1))).model
    plain, other = cycles._powers, 1.0 / (0.8 * PERIOD)

    def raised(time: FloatArray, values: FloatArray, weights: FloatArray, frequencies: FloatArray) -> FloatArray:
        powers = plain(time, values, weights, frequencies)
        if frequencies.size > 1:
            powers[:, np.argmin(np.abs(frequencies - other))] = 2.0 * powers.max()
        return powers

    monkeypatch.setattr(cycles, "_powers", raised)
    (block,) = in_cycles(model, ("d",))
    one = cycle_of(block.regressor)
    assert one is not None
    assert one.period == pytest.approx(PERIOD, rel=0.02 * PERIOD / float(np.ptp(frame.time)))


@pytest.mark.parametrize("size", [0, 1, 30])
def test_the_lines_of_a_spectrum_are_its_tops_the_highest_first(size: int) -> None:
    powers = np.random.default_rng(size).uniform(size=size)
    lines = _lines(powers)
    assert len(lines) <= MOST_LINES
    assert size == 0 or lines[0] == int(np.argmax(powers))
    assert all(a >= b for a, b in itertools.pairwise(powers[lines]))
    assert not any(abs(a - b) == 1 for a in lines for b in lines)


@pytest.mark.parametrize("periods", [2.4, 2.6, 3.3])
def test_the_period_is_found_where_the_simulation_has_taken_a_part_of_the_wave(periods: float) -> None:
    """A gearbox that warms all the time: friction that goes with the temperature follows a part of a slow wave."""
    frame = often()
    span = float(np.ptp(frame.time))
    frame = replace(frame, temperature=20.0 + 20.0 * (frame.time - frame.time.min()) / span)
    rng = np.random.default_rng(1)
    drag = 0.006 + 0.002 * np.sin(2.0 * np.pi * periods * frame.time / span + 0.4)
    y = 0.5 * frame.direction + drag * frame.omega + rng.normal(0.0, 0.01, frame.size)
    (block,) = in_cycles(begun(problem(frame, y)).model, ("w",))
    one = cycle_of(block.regressor)
    assert one is not None
    # four hundredths of a period over the whole campaign
    assert one.period == pytest.approx(span / periods, rel=0.04 / periods)


@pytest.mark.parametrize("seed", range(3))
def test_noise_has_none(seed: int) -> None:
    frame = often()
    assert searched(problem(frame, measured(frame, 0.0, seed))).model.chosen == []


def test_a_search_tells_it_without_a_name() -> None:
    frame = often()
    model = searched(problem(frame, measured(frame, 0.1))).model
    (own,) = model.chosen
    regressor = own.main.regressor
    assert own.effect == "unknown"
    assert "cycle" in regressor.words
    coefficients, covariance = model.fit.of(own.main.indices)
    assert np.hypot(*coefficients) == pytest.approx(0.1, rel=0.1)
    symbols = [p["symbol"] for p in regressor.parameters(coefficients, np.sqrt(np.diag(covariance)))]
    assert symbols == ["f_c*d", "f_s*d"]
    assert "table" not in regressor.equation


def test_its_row_of_a_simulation_file_predicts_the_same() -> None:
    frame = often()
    (block,) = in_cycles(begun(problem(frame, measured(frame, 0.1))).model, ("d",))
    one = cycle_of(block.regressor)
    assert one is not None
    values = np.array([0.03, -0.08])
    grid, table = from_json(one.to_json(values), "test")
    assert grid.columns(frame) @ table == pytest.approx(one.columns(frame) @ values, abs=1e-9)


def test_two_periods_at_least_are_seen_of_a_cycle() -> None:
    frame = often().take(often().time < 1.9 * SHORTEST_S)
    assert np.unique(frame.recording).size == 2
    assert _frequencies(float(np.ptp(frame.time))).size == 0


@pytest.mark.parametrize("periods", [1.7, 1.9, 2.0])
def test_a_wave_of_fewer_periods_is_taken_for_one_of_two_at_least(periods: float) -> None:
    frame = often()
    span = float(np.ptp(frame.time))
    y = 0.5 * frame.direction + 0.3 * np.sin(2.0 * np.pi * periods * frame.time / span) * frame.direction
    y = y + np.random.default_rng(2).normal(0.0, 0.01, frame.size)
    (block,) = in_cycles(begun(problem(frame, y)).model, ("d",))
    one = cycle_of(block.regressor)
    assert one is not None
    assert one.period <= 0.5 * span * (1.0 + 1e-9)


def test_a_campaign_that_shows_one_period_only_is_asked_for_it() -> None:
    frame = often()
    span = 2.1 * SHORTEST_S
    frame = replace(frame, time=frame.time * span / float(np.ptp(frame.time)))
    assert _frequencies(span).size == 1
    y = 0.5 * frame.direction + 0.3 * np.sin(2.0 * np.pi * frame.time / SHORTEST_S) * frame.direction
    y = y + np.random.default_rng(2).normal(0.0, 0.01, frame.size)
    (block,) = in_cycles(begun(problem(frame, y)).model, ("d",))
    one = cycle_of(block.regressor)
    assert one is not None
    assert one.period == pytest.approx(SHORTEST_S, rel=0.02)


def test_the_best_of_many_periods_pays_for_all_of_them() -> None:
    frame = often()
    (block,) = in_cycles(begun(problem(frame, measured(frame, 0.1))).model, ("d",))
    span = float(np.ptp(frame.time))
    assert price_of_period(block.regressor) == pytest.approx(np.log(3.0 * span / SHORTEST_S), abs=0.1)
    assert price_of_period(begun(problem(frame, measured(frame, 0.1))).blocks[0].regressor) == 0.0
