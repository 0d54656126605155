"""Forms that were added for what others' benches do: a housing that has come to rest, a gain that grows with heat."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bench.simulation.frame import ARRAYS, FloatArray, Frame
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE, TEMPERATURE, Form


def form(effect: str, channel: str, name: str) -> Form:
    return next(f for f in LIBRARY[effect].forms[channel] if f.name == name)


def frame(recordings: int = 2, each: int = 400, **more: FloatArray) -> Frame:
    """Recordings of ``each`` seconds, a row a second, one hour apart."""
    n = recordings * each
    number, second = np.repeat(np.arange(recordings), each), np.tile(np.arange(each, dtype=np.float64), recordings)
    values: dict[str, FloatArray] = {name: np.zeros(n) for name in ARRAYS}
    values |= {"elapsed": second, "time": 3600.0 * number + second, "step": np.where(second > 0, 1.0, 0.0)} | more
    return Frame(ratio=185.0, **values | {"recording": number.astype(np.int64)})  # type: ignore[arg-type]


def test_a_housing_that_came_to_rest_begins_each_recording_as_warm_as_the_lubricant() -> None:
    second = np.tile(np.arange(400, dtype=np.float64), 2)
    temperature = 25.0 + np.repeat([0.0, 8.0], 400) + 10.0 * (1.0 - np.exp(-second / 90.0))
    taken = form("thermal.second_mass", TEMPERATURE, "two_node_rested").columns(
        frame(temperature=temperature), (150.0,)
    )[:, 0]
    for begin in (0, 400):

        def rate(t: float, y: FloatArray, at: int = begin) -> list[float]:
            warm = float(np.interp(t, second[at : at + 400], temperature[at : at + 400]))
            return [(warm - y[0]) / 150.0, -(warm - y[0])]

        told = solve_ivp(rate, (0.0, 399.0), [temperature[begin], 0.0], t_eval=[399.0], rtol=1e-8, max_step=1.0)
        assert taken[begin + 399] - taken[begin] == pytest.approx(told.y[1, -1], rel=0.02)


def test_a_gain_may_grow_with_the_temperature() -> None:
    load, warm = np.linspace(-800.0, 800.0, 800), np.tile(np.linspace(25.0, 45.0, 400), 2)
    columns = form("motor.torque_constant", MOTOR_TORQUE, "temperature").columns(
        frame(torque=load, torque_level=load, temperature=warm), ()
    )
    assert columns @ [0.02, 0.001] == pytest.approx((0.02 + 0.001 * (warm - 25.0)) * load / 185.0)
