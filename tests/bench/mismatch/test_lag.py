"""A sensor of the temperature that lags: the motor torque is that of the gearbox, which is warmer than it reads."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from bench.mismatch import analysis
from bench.mismatch.analysis import LAG, behind_of
from bench.mismatch.power_zeros import UNNAMED, Zeros
from bench.mismatch.regression.model import Block, Chosen
from bench.mismatch.regression.regressors import UNKNOWN, Named
from bench.simulation.frame import ARRAYS, FloatArray, Frame
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE, TEMPERATURE

CONSTANT, PER_CAPACITY, LOSS = 40.0, 5e-5, 200.0
"""s, K/J, W"""


def frame() -> Frame:
    """A warm-up of ten minutes that begins cold."""
    n = 601
    values: dict[str, FloatArray] = {name: np.zeros(n) for name in ARRAYS}
    values |= {"time": np.arange(n) * 1.0, "step": np.append(0.0, np.ones(n - 1)), "power": np.full(n, LOSS)}
    values["power"][0] = 0.0
    return Frame(ratio=185.0, **values | {"recording": np.zeros(n, dtype=np.int64)})  # type: ignore[arg-type]


def heat(effect: str = LAG, name: str = "first_order", point: tuple[float, ...] = (CONSTANT,)) -> Any:
    """A model of the temperature that has an effect."""
    term = LIBRARY[effect]
    form = next(f for f in term.forms[TEMPERATURE] if f.name in (name, "two_node"))
    block = Block(Named(term, TEMPERATURE, form, point), (0,), np.zeros(1))
    fit = SimpleNamespace(of=lambda _place: (np.array([PER_CAPACITY]), np.zeros((1, 1))))
    problem = SimpleNamespace(rows=SimpleNamespace(frame=frame()))
    return SimpleNamespace(chosen=[Chosen(block)], fit=fit, problem=problem)


def test_the_sensor_stays_behind_by_its_constant_times_the_rise() -> None:
    """A body that warms by P/C a second is that times the time constant ahead of a first-order lag that follows."""
    behind = behind_of(heat())
    assert behind is not None
    assert behind[0] == 0.0
    assert behind[-1] == pytest.approx(CONSTANT * PER_CAPACITY * LOSS, rel=1e-3)
    assert behind[40] == pytest.approx((1.0 - np.exp(-1.0)) * behind[-1], rel=0.03)


def test_behind_two_lags_it_is_as_far_as_their_mean_constant() -> None:
    behind = behind_of(heat(name="two_lags_kept", point=(20.0, 80.0, 0.4)))
    assert behind is not None
    assert behind[-1] == pytest.approx((0.6 * 20.0 + 0.4 * 80.0) * PER_CAPACITY * LOSS, rel=1e-2)


def test_a_sensor_that_reads_right_at_the_start_is_behind_by_what_it_lacks() -> None:
    model = heat(name="first_order_settled")
    block = model.chosen[0].main
    model.fit = SimpleNamespace(of=lambda _place: (np.array([PER_CAPACITY, 0.0, 0.0]), np.zeros((3, 3))))
    behind = behind_of(model)
    assert behind is not None
    np.testing.assert_allclose(behind, -block.regressor.columns(frame()) @ [PER_CAPACITY, 0.0, 0.0])
    assert behind[0] == 0.0
    assert behind[-1] == pytest.approx(CONSTANT * PER_CAPACITY * LOSS, rel=1e-2)


def test_a_sensor_without_a_lag_is_not_behind() -> None:
    assert behind_of(heat("thermal.second_mass")) is None


@pytest.mark.parametrize(
    ("explained", "taken_off", "lag_again", "accepted"),
    [
        (True, False, None, True),
        (False, False, None, False),
        # the temperature was fitted with a loss less the function without a name: it is searched again without
        (True, True, LAG, True),
        (True, True, "thermal.second_mass", False),
    ],
)
def test_what_the_lag_explains_of_the_motor_torque_goes(
    monkeypatch: pytest.MonkeyPatch, explained: bool, taken_off: bool, lag_again: str | None, accepted: bool
) -> None:
    """The motor torque is searched again at the gearbox's temperature, and what had no name goes if none is left and
    the temperature still has the lag with that.
    """
    closed: list[str] = []
    seen: list[Frame] = []

    def search(name: str, nameless: tuple[str, ...], channel: str = MOTOR_TORQUE) -> Any:
        rows = SimpleNamespace(frame=frame())
        model = SimpleNamespace(nameless=nameless, problem=SimpleNamespace(rows=rows), channel=channel)
        return SimpleNamespace(model=model, close=lambda: closed.append(name))

    def of_heat(name: str, effect: str) -> Any:
        return SimpleNamespace(model=heat(effect), close=lambda: closed.append(name))

    first, again = search("first", ("a function",)), search("again", () if explained else ("a function",))
    warm = of_heat("heat", LAG)
    outcome: Any = SimpleNamespace(discoveries=[SimpleNamespace(effect=UNKNOWN)], notes=[])
    out = analysis.Analysis(
        cast(Any, None),
        searches={MOTOR_TORQUE: first, TEMPERATURE: warm},
        outcomes={MOTOR_TORQUE: outcome},
        zeros=Zeros((UNNAMED,) if taken_off else ()),
    )

    def searched(problem: Any, _seed: int) -> Any:
        seen.append(problem.rows.frame)
        return again

    def changed(one: Any, **parts: Any) -> Any:
        return SimpleNamespace(**{**vars(one), **parts}) if isinstance(one, SimpleNamespace) else replace(one, **parts)

    monkeypatch.setattr(analysis, "searched", searched)
    monkeypatch.setattr(analysis, "_outcome", lambda *_: SimpleNamespace(discoveries=[], notes=[]))
    monkeypatch.setattr(analysis, "slots_of", lambda *_: [])
    monkeypatch.setattr(analysis, "_heat", lambda *_: of_heat("heat again", str(lag_again)))
    monkeypatch.setattr(analysis, "replace", changed)
    nothing = cast(Any, None)
    analysis._as_warm_as_it_is(out, nothing, nothing, nothing, True, 0, ())
    assert seen[0].temperature[-1] == pytest.approx(CONSTANT * PER_CAPACITY * LOSS, rel=1e-3)
    assert (out.searches[MOTOR_TORQUE] is again) == accepted
    assert (out.searches[TEMPERATURE] is warm) == (not (accepted and taken_off))
    assert [d.effect for d in out.outcomes[MOTOR_TORQUE].discoveries] == ([] if accepted else [UNKNOWN])
    assert bool(out.outcomes[MOTOR_TORQUE].notes) == accepted
    of_the_heat = [] if not (explained and taken_off) else ["heat"] if accepted else ["heat again"]
    assert closed == [*of_the_heat, "again"]
