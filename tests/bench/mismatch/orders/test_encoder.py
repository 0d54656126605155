"""Which multiples of the ratio are errors of the motor's encoder."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.mismatch.orders.discoveries import _of_motor
from bench.mismatch.orders.misread import Misread, TorqueCheck
from bench.simulation.frame import FloatArray

RATIO, TURNS, NOISE = 185.0, 40, 0.3
SCALE = np.random.default_rng(0).uniform(0.8, 1.4, TURNS)
LOAD = np.random.default_rng(1).uniform(-1.0, 1.0, TURNS)


def sight(sizes: dict[float, FloatArray], constant: tuple[float, ...]) -> Any:
    """Orders of these sizes (turns,) in units of noise; the plainest model is the best of the ``constant`` ones."""
    rng = np.random.default_rng(2)
    shown = {
        f: (size + NOISE * (rng.normal(size=TURNS) + 1j * rng.normal(size=TURNS)) * SCALE) / SCALE
        for f, size in sizes.items()
    }
    return SimpleNamespace(
        found=tuple(sizes),
        stage=SimpleNamespace(scale=SCALE),
        at=lambda _, f: shown[f],
        noise=lambda _: NOISE,
        gains=lambda vectors, f: (100.0, 0 if f in constant else 2),
    )


@pytest.mark.parametrize(
    ("wavers", "constant", "of_motor"),
    [
        # nearly the same at every load: another wave of the same disc
        (0.1, (370.0,), (370.0, 740.0)),
        # it follows the load: an order of the gearbox that happens to be there
        (1.5, (370.0,), (370.0,)),
        # no multiple has one vector
        (0.1, (), ()),
    ],
)
def test_multiples_of_the_ratio(wavers: float, constant: tuple[float, ...], of_motor: tuple[float, ...]) -> None:
    one = np.ones(TURNS)
    sizes = {46.0: 5.0 * one, 370.0: 4.0 * one, 740.0: 2.0 * (one + wavers * LOAD)}
    model: Any = SimpleNamespace(laws=(), torque_check=TorqueCheck())
    assert _of_motor(model, sight(sizes, constant), RATIO) == of_motor


def test_the_motor_torque_decides_where_it_was_asked() -> None:
    """Order 185 as a whole is the encoder's by the reaction; 370 was asked and is the gearbox's, though constant."""
    one = np.ones(TURNS)
    part = Misread(185.0, 4e-6 + 0j, 1e-7, 1e-6, 30.0, beside=False)
    model: Any = SimpleNamespace(laws=(), torque_check=TorqueCheck((185.0, 370.0), (part,)))
    assert _of_motor(model, sight({185.0: 4.0 * one, 370.0: 4.0 * one}, (370.0,)), RATIO) == (185.0,)
    # what the gearbox has beside it stays an order of the gearbox
    model.torque_check = TorqueCheck((185.0,), (Misread(185.0, 4e-6 + 0j, 1e-7, 1e-6, 30.0, beside=True),))
    assert _of_motor(model, sight({185.0: 4.0 * one}, (185.0,)), RATIO) == ()
