"""Which multiples of the ratio are errors of the motor's encoder."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.mismatch.orders.misread import Misread, TorqueCheck
from bench.mismatch.orders.of_motor import chance, of_motor
from bench.simulation.frame import FloatArray

RATIO, TURNS, NOISE = 185.0, 40, 0.3
SCALE = np.random.default_rng(0).uniform(0.8, 1.4, TURNS)
LOAD = np.random.default_rng(1).uniform(-1.0, 1.0, TURNS)
VELOCITY = np.random.default_rng(5).uniform(-0.7, 0.7, TURNS)
"""output, rad/s"""


def sight(sizes: dict[float, FloatArray], constant: tuple[float, ...]) -> Any:
    """Orders of these sizes (turns,) in units of noise; the plainest model is the best of the ``constant`` ones."""
    rng = np.random.default_rng(2)
    shown = {
        f: (size + NOISE * (rng.normal(size=TURNS) + 1j * rng.normal(size=TURNS)) * SCALE) / SCALE
        for f, size in sizes.items()
    }
    return SimpleNamespace(
        found=tuple(sizes),
        known=(),
        stage=SimpleNamespace(scale=SCALE, revolutions=[SimpleNamespace(velocity=v) for v in VELOCITY]),
        at=lambda _, f: shown[f],
        noise=lambda _: NOISE,
        gains=lambda vectors, f: (100.0, 0 if f in constant else 2),
    )


@pytest.mark.parametrize(
    ("first", "wavers", "constant", "told"),
    [
        # nearly the same at every load: another wave of the same disc
        (0.0, 0.1, (370.0,), (370.0, 740.0)),
        # it follows the load: an order of the gearbox that happens to be there
        (0.0, 1.5, (370.0,), (370.0,)),
        # no multiple has one vector
        (0.3, 0.1, (), ()),
    ],
)
def test_multiples_of_the_ratio(
    first: float, wavers: float, constant: tuple[float, ...], told: tuple[float, ...]
) -> None:
    one = np.ones(TURNS)
    sizes = {46.0: 5.0 * one, 370.0: 4.0 * (one + first * LOAD), 740.0: 2.0 * (one + wavers * LOAD)}
    model: Any = SimpleNamespace(laws=(), notes=[], torque_check=TorqueCheck())
    assert of_motor(model, sight(sizes, constant), RATIO) == told


@pytest.mark.parametrize(
    ("turns", "wavers", "told"), [(1e-3, 0.0, (370.0,)), (0.02, 0.0, (370.0,)), (0.0, 0.02, ()), (1e-3, 0.02, ())]
)
def test_an_order_that_moments_of_reading_turn_by_the_speed_is_the_encoders(
    turns: float, wavers: float, told: tuple[float, ...]
) -> None:
    """``turns``: s by which one encoder is read later; ``wavers``: share of its amplitude that follows the load."""
    turned = 400.0 * (1.0 + wavers * LOAD) * np.exp(370.0j * turns * VELOCITY)
    seen = sight({370.0: turned}, ())

    def gains(vectors: Any, _: float) -> tuple[float, int]:
        one = vectors * SCALE
        return 100.0, 0 if float(np.abs(one - one.mean()).max()) < 6.0 * NOISE * float(SCALE.max()) else 2

    seen.gains = gains
    model: Any = SimpleNamespace(laws=(), notes=[], torque_check=TorqueCheck())
    assert of_motor(model, seen, RATIO) == told


def test_the_motor_torque_decides_where_it_was_asked() -> None:
    """Order 185 as a whole is the encoder's by the reaction; 370 was asked and is the gearbox's, though constant."""
    one = np.ones(TURNS)
    part = Misread(185.0, 4e-6 + 0j, 1e-7, 1e-6, 30.0, beside=False)
    model: Any = SimpleNamespace(laws=(), notes=[], torque_check=TorqueCheck((185.0, 370.0), (part,)))
    assert of_motor(model, sight({185.0: 4.0 * one, 370.0: 4.0 * one}, (370.0,)), RATIO) == (185.0,)
    # what the gearbox has beside it stays an order of the gearbox
    model.torque_check = TorqueCheck((185.0,), (Misread(185.0, 4e-6 + 0j, 1e-7, 1e-6, 30.0, beside=True),))
    assert of_motor(model, sight({185.0: 4.0 * one}, (185.0,)), RATIO) == ()


@pytest.mark.parametrize(("size", "encoders"), [(4.0, ()), (40.0, (185.0,))])
def test_one_of_many_weak_orders_may_lie_on_the_ratio(size: float, encoders: tuple[float, ...]) -> None:
    """Of ninety constant orders up to 400 one lies on 185 or 370 more often than not; hardly ever ten times as
    large.
    """
    rng = np.random.default_rng(3)
    weak = [float(f) for f in rng.permutation([k for k in range(2, 400) if k % 185])[:90]]
    sizes = {f: rng.uniform(1.0, 5.0) * np.ones(TURNS) for f in weak} | {185.0: size * np.ones(TURNS)}
    model: Any = SimpleNamespace(laws=(), notes=[], torque_check=TorqueCheck())
    seen = sight(sizes, tuple(sizes))
    assert of_motor(model, seen, RATIO) == encoders
    assert bool(model.notes) is not bool(encoders)
    by_chance = chance(model, seen, (185.0,), RATIO)
    # two multiples, each with one of 90 orders on 400 places, of which a third is as large: counted by hand
    larger = (1 + sum(float(v[0]) >= 4.0 for f, v in sizes.items() if f != 185.0)) / 91.0
    expected = 1.0 - (1.0 - 90.0 / int(max(sizes)) * larger) ** 2
    assert by_chance == pytest.approx(expected, rel=0.3) if size < 5.0 else by_chance < 0.01


def test_both_multiples_are_no_chance() -> None:
    rng = np.random.default_rng(4)
    weak = [float(f) for f in rng.permutation([k for k in range(2, 400) if k % 185])[:20]]
    sizes = {f: 2.0 * np.ones(TURNS) for f in (*weak, 185.0, 370.0)}
    model: Any = SimpleNamespace(laws=(), notes=[], torque_check=TorqueCheck())
    assert of_motor(model, sight(sizes, tuple(sizes)), RATIO) == (185.0, 370.0)
