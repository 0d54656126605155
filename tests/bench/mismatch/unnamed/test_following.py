"""Orders that follow a state which is not recorded: found with the state and its time, and in noise not."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.mismatch.discovery import UNNAMED
from bench.mismatch.given import Given
from bench.mismatch.orders.periodic import Periodic
from bench.mismatch.orders.revolutions import Revolution
from bench.mismatch.orders.series import calibrate
from bench.mismatch.problems import base_of
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.simulation_file import _kept, _term
from bench.mismatch.unnamed import following
from bench.mismatch.unnamed.formula_regressor import from_row
from bench.simulation import Simulation
from bench.simulation.frame import FloatArray, recording_starts
from bench.simulation.laws import Law
from bench.simulation.quantities import quantity, state_of
from bench.simulation.terms import TRANSMISSION_ERROR
from tests.bench.mismatch.regression.synthetic import campaign

ORDERS = (1.0, 3.0, 19.0, 46.0)
NOISE = 5e-8
FRAME = campaign(48, seed=4)
# warm-ups and rests between the recordings, more quickly than a state of some minutes follows
FRAME = replace(FRAME, time=150.0 * FRAME.recording + FRAME.elapsed)
STARTS = recording_starts(FRAME)
REVOLUTIONS = [
    Revolution(
        k,
        slice(int(a), int(b)),
        float(FRAME.torque[a]),
        float(FRAME.velocity[a]),
        float(FRAME.temperature[a]),
        float(np.mean(FRAME.time[a:b])),
        float(FRAME.direction[a]),
        1.0,
        30.0,
    )
    for k, (a, b) in enumerate(pairwise(STARTS))
]


@dataclass
class Model:
    """What the search asks of a model of the transmission error."""

    seen: Any
    periodic: Periodic
    train: Any
    rows: Any
    training_revolutions: Any
    given: Any
    banned: tuple[str, ...] = ()


def model(state: FloatArray, size: float, laws: tuple[Law, ...] = ()) -> Any:
    """Four orders at a constant size, the first of which has a part that follows a ``state`` (n,)."""
    rng = np.random.default_rng(2)
    shape = (len(REVOLUTIONS), len(ORDERS))
    vectors = 3e-6 * np.exp(2j * np.pi * rng.random(len(ORDERS))) + np.zeros(shape)
    vectors[:, 0] += size * np.exp(0.7j) * np.array([state[t.rows].mean() for t in REVOLUTIONS])
    vectors += NOISE * (rng.normal(size=shape) + 1j * rng.normal(size=shape))
    noise = np.full(shape, NOISE)
    series = calibrate(REVOLUTIONS, vectors, noise, ORDERS)
    seen = SimpleNamespace(orders=ORDERS, vectors=vectors, noise=lambda orders: np.full((shape[0], len(orders)), NOISE))
    rows, given = SimpleNamespace(frame=FRAME), SimpleNamespace(notch=(), laws=())
    return Model(seen, Periodic(series, laws=laws), np.ones(shape[0], dtype=bool), rows, REVOLUTIONS, given)


@pytest.mark.parametrize("name", ["risen_350s", "recent_torque_400s"])
def test_an_order_that_follows_a_state_is_found_with_its_time(name: str) -> None:
    values = quantity(name, FRAME)
    size = 4e-7 / float(np.std(values))
    found = following.search(model(values, size), 0)
    assert found is not None
    assert found.orders == (1.0,)
    state, wanted = state_of(found.course.name), state_of(name)
    assert state is not None
    assert wanted is not None
    assert state[0] == wanted[0]
    assert state[1] == pytest.approx(wanted[1], rel=0.3)
    # standard deviations are those of a component; a time constant a little off is part of the error
    assert abs(found.vectors[0] - size * np.exp(0.7j)) < max(4.0 * found.std[0], 0.1 * size)
    angle = np.mod(FRAME.theta, 2.0 * np.pi)
    told = found.vectors[0].real * np.sin(angle) + found.vectors[0].imag * np.cos(angle)
    assert found.evaluate(FRAME) == pytest.approx(told * quantity(found.course.name, FRAME), abs=1e-12)


@pytest.mark.parametrize("size", [4e-7, 1.5e-6])
@pytest.mark.parametrize("over", ["temperature", "torque", "square"])
def test_what_the_polynomials_say_is_no_course(over: str, size: float) -> None:
    warm, load = (FRAME.temperature - 31.0) / 5.0, FRAME.torque / 300.0
    values = {"temperature": warm, "torque": load, "square": warm**2}[over]
    assert following.search(model(values, size), 0) is None


def test_an_order_that_sets_in_at_a_moment_and_settles_is_a_drift() -> None:
    """Not a law of the temperature, which comes and goes."""
    begin, constant = 0.45 * FRAME.time.max(), 0.08 * FRAME.time.max()
    course = 1.0 - np.exp(-np.maximum(FRAME.time - begin, 0.0) / constant)
    found = following.search(model(course, 8e-7), 0)
    assert found is not None
    assert (found.course.effect, found.course.of, found.orders) == ("te.drift_time", "time", (1.0,))
    assert found.course.point == pytest.approx((begin, constant), rel=0.4)


def test_a_file_says_what_was_found() -> None:
    values = quantity("risen_350s", FRAME)
    found = following.search(model(values, 4e-7 / float(np.std(values))), 0)
    assert found is not None
    coefficients, std = found.coefficients, np.repeat(found.std, 2)
    row = found.equation(FRAME).row(coefficients, std)
    numbers = {symbol: p["value"] for symbol, p in row["parameters"].items()}
    equation, read = from_row({**row, "parameters": numbers}, TRANSMISSION_ERROR, UNNAMED, "a file")
    assert equation.columns(FRAME) @ read == pytest.approx(found.evaluate(FRAME))
    given = Given.of(Simulation.nominal().with_term(_term(UNNAMED, [{"effect": UNNAMED, **row}])))
    assert len(given.over_input_angle()) == 1
    rows = Rows(FRAME, np.zeros(FRAME.size), FRAME.count)
    assert all(getattr(base.regressor, "formula", None) is None for base in base_of(given, TRANSMISSION_ERROR, rows))
    assert [kept["over"] for kept in _kept(given.simulation)] == [["input_angle", found.course.name]]


def test_a_finding_names_the_orders_that_hold_nine_tenths_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Others may follow the course by chance, by a few standard deviations."""
    monkeypatch.setattr(following, "strong", lambda *_: True)
    values = quantity("risen_350s", FRAME)
    whole = model(values, 4e-7 / float(np.std(values)))
    found = following.search(whole, 0)
    assert found is not None
    vectors = found.vectors[0] * np.array([0.06 + 0.04j, 1.0, 0.05j])
    several = replace(found, orders=(13.0, 46.0, 90.0), vectors=vectors, std=np.abs(vectors[[0, 0, 0]]) / 3.0)
    said = following.as_discovery(whole, several, np.zeros(FRAME.size))
    assert said is not None
    assert said.orders == (46.0,)
    assert said.numbers >= 6  # its numbers are those of all


def test_orders_that_follow_nothing_are_left_alone() -> None:
    assert following.search(model(np.zeros(FRAME.size), 0.0), 0) is None


def test_orders_that_scatter_follow_nothing() -> None:
    """Noise is drawn as large as it is seen: what scatters follows one state or another by chance."""
    scatter = np.random.default_rng(9).normal(size=len(REVOLUTIONS))[FRAME.recording]
    assert following.search(model(scatter, 4e-7), 0) is None


def test_a_law_that_gains_more_stays() -> None:
    values = quantity("risen_350s", FRAME)
    law = Law("te.temperature_nonlinear", "exponential", (5.0,), 1e4, ORDERS[:1], np.array([0.0j]), series=ORDERS[:1])
    assert following.search(model(values, 4e-7 / float(np.std(values)), (law,)), 0) is None
