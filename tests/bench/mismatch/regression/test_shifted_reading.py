"""A thermometer whose reading is shifted as soon as the gearbox turns: no heat, and not its lag."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch import criteria
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.discoveries import excess_of
from bench.mismatch.regression.problem import ChannelProblem, nominal_base
from bench.mismatch.regression.regressors import Free, of_reading
from bench.mismatch.regression.search import searched
from bench.simulation.frame import ARRAYS, FloatArray, Frame, concatenate
from bench.simulation.terms import TEMPERATURE

RATIO, STEP, EACH, RECORDINGS = 185.0, 2.0, 120, 24
CAPACITY, RESISTANCE, AMBIENT, NOISE = 7000.0, 0.3, 21.0, 0.02
REST_ROWS = 20


def shifted(by: float) -> Rows:
    """Heating runs both ways at speeds up to 0.9 rad/s, with rest before and after: it reads ``by`` K per (rad/s)^1.4
    more when it turns forwards, and two fifths of it less backwards.
    """
    rng = np.random.default_rng(3)
    parts, y, level = [], [], 25.0
    for number in range(RECORDINGS):
        side, speed = (1.0 if number % 2 == 0 else -1.0), float(rng.uniform(0.3, 0.9))
        elapsed = STEP * np.arange(EACH)
        turns = (np.arange(EACH) >= REST_ROWS) & (np.arange(EACH) < EACH - REST_ROWS)
        loss = np.where(turns, float(rng.uniform(60.0, 180.0)), 0.0)
        temperature = np.empty(EACH)
        slow = 0.5 * STEP / (RESISTANCE * CAPACITY)
        for k in range(EACH):
            temperature[k] = level
            power = 0.5 * (loss[k] + loss[min(k + 1, EACH - 1)])
            # trapezoids, as the analysis adds up
            level = (level * (1.0 - slow) + STEP * (power + AMBIENT / RESISTANCE) / CAPACITY) / (1.0 + slow)
        level -= 0.5 * (level - 25.0)  # it cools before the next
        read = temperature + turns * by * speed**1.4 * (1.0 if side > 0 else -0.4) + rng.normal(0.0, NOISE, EACH)
        values: dict[str, FloatArray] = {name: np.zeros(EACH) for name in ARRAYS}
        values |= {
            "count": np.full(EACH, 100.0),
            "time": 900.0 * number + elapsed,
            "elapsed": elapsed,
            "velocity": side * speed * turns,
            "direction": side * turns,
            "last_direction": np.full(EACH, side),
            "motor_torque": side * loss / (speed * RATIO),
            "power": loss,
            "temperature": temperature,
            "step": np.where(elapsed > 0.0, STEP, 0.0),
        }
        values["recording"] = np.full(EACH, number, dtype=np.int64)
        parts.append(Frame(ratio=RATIO, **values))  # type: ignore[arg-type]
        y.append(read)
    frame = concatenate(parts)
    return Rows(frame, np.concatenate(y), np.full(frame.size, 100.0), np.full(frame.size, NOISE**2))


def problem(by: float) -> ChannelProblem:
    rows = shifted(by)
    usable = np.ones(rows.size, dtype=bool)
    return ChannelProblem(TEMPERATURE, rows, usable, np.arange(RECORDINGS) % 5, tuple(nominal_base(TEMPERATURE, ())))


def test_a_shift_is_told_as_one() -> None:
    own = problem(0.2)
    model = searched(own).model
    (found,) = model.chosen
    assert isinstance(found.main.regressor, Free)
    assert of_reading(found.main.regressor)
    assert found.main.regressor.variables == ("velocity",)
    frame = own.rows.frame
    moving = frame.direction != 0
    course = model.contribution(found, frame)
    course = course - course[~moving].mean()
    true = 0.2 * np.abs(frame.velocity) ** 1.4 * np.where(frame.velocity > 0, 1.0, -0.4)
    assert np.std((course - true)[moving]) < 0.2 * np.std(true[moving])
    # it lies where the reading shifts, and not at rest
    lies = excess_of(model, found, frame, own.rows.number)
    assert np.sum(lies[~moving] ** 2) < 0.01 * np.sum(lies**2)


def test_a_cable_that_is_bent_at_some_angles_shifts_the_reading() -> None:
    """No heat: the gearbox is as warm as before on the other side of it."""
    own = problem(0.0)
    rng = np.random.default_rng(5)
    angle = rng.uniform(0.0, 2.0 * np.pi, own.rows.size)
    bent = (angle > 2.2) & (angle < 3.3)
    rows = replace(own.rows, frame=replace(own.rows.frame, q=angle), y=own.rows.y + 0.2 * bent)
    (found,) = searched(replace(own, rows=rows)).model.chosen
    assert of_reading(found.main.regressor)
    assert found.main.regressor.variables == ("angle",)


def test_nothing_is_told_where_nothing_shifts() -> None:
    assert not searched(problem(0.0)).model.chosen


@pytest.mark.parametrize(("least", "told"), [(0.0, True), (criteria.SELF_HEATING_K, False)])
def test_a_shift_that_its_own_current_may_make_is_not_told(
    least: float, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(criteria, "SELF_HEATING_K", least)
    model = searched(problem(0.035)).model
    assert any(of_reading(c.main.regressor) for c in model.chosen) is told
