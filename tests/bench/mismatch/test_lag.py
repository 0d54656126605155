"""A sensor of the temperature that lags: the motor torque is that of the gearbox, which is warmer than it reads."""

from __future__ import annotations

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


def heat(effect: str = LAG) -> Any:
    """A model of the temperature that has an effect."""
    term = LIBRARY[effect]
    form = next(f for f in term.forms[TEMPERATURE] if f.name in ("first_order", "two_node"))
    block = Block(Named(term, TEMPERATURE, form, (CONSTANT,)), (0,), np.zeros(1))
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


def test_a_sensor_without_a_lag_is_not_behind() -> None:
    assert behind_of(heat("thermal.second_mass")) is None


@pytest.mark.parametrize(("explained", "taken_off"), [(True, False), (False, False), (True, True)])
def test_what_the_lag_explains_of_the_motor_torque_goes(
    monkeypatch: pytest.MonkeyPatch, explained: bool, taken_off: bool
) -> None:
    """The motor torque is searched again at the gearbox's temperature, and what had no name goes if none is left; not
    where the temperature was fitted with a loss less that.
    """
    closed: list[str] = []
    seen: list[Frame] = []

    def search(name: str, nameless: tuple[str, ...]) -> Any:
        rows = SimpleNamespace(frame=frame())
        model = SimpleNamespace(nameless=nameless, problem=SimpleNamespace(rows=rows), channel=MOTOR_TORQUE)
        return SimpleNamespace(model=model, close=lambda: closed.append(name))

    first, again = search("first", ("a function",)), search("again", () if explained else ("a function",))
    outcome = SimpleNamespace(discoveries=[SimpleNamespace(effect=UNKNOWN)], notes=[])
    zeros = Zeros((UNNAMED,) if taken_off else ())
    out = SimpleNamespace(searches={MOTOR_TORQUE: first}, outcomes={MOTOR_TORQUE: outcome}, zeros=zeros)

    def searched(problem: Any, _seed: int) -> Any:
        seen.append(problem.rows.frame)
        return again

    def changed(one: Any, **parts: Any) -> Any:
        return (
            Frame(**{**{n: getattr(one, n) for n in Frame.__dataclass_fields__}, **parts})
            if isinstance(one, Frame)
            else SimpleNamespace(**{**vars(one), **parts})
        )

    monkeypatch.setattr(analysis, "searched", searched)
    monkeypatch.setattr(analysis, "_said", lambda *_: SimpleNamespace(discoveries=[], notes=[]))
    monkeypatch.setattr(analysis, "replace", changed)
    nothing, of_heat = cast(Any, None), cast(Any, SimpleNamespace(model=heat()))
    analysis._as_warm_as_it_is(cast(Any, out), nothing, nothing, of_heat, True, 0)
    if taken_off:
        assert (seen, out.searches[MOTOR_TORQUE], out.outcomes[MOTOR_TORQUE]) == ([], first, outcome)
        return
    assert seen[0].temperature[-1] == pytest.approx(CONSTANT * PER_CAPACITY * LOSS, rel=1e-3)
    assert closed == ["again"]
    assert (out.searches[MOTOR_TORQUE] is again) == explained
    assert [d.effect for d in out.outcomes[MOTOR_TORQUE].discoveries] == ([] if explained else [UNKNOWN])
    assert bool(out.outcomes[MOTOR_TORQUE].notes) == explained
