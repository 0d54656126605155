"""Laws are looked for one after another, each in what the ones before it have left."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.signal import freqs

from bench.mismatch.orders import laws, modes
from bench.mismatch.orders.law_scores import Amplitudes
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.periodic import Periodic
from bench.mismatch.orders.series import calibrate
from bench.simulation.laws import RESONANCE
from tests.bench.mismatch.orders.test_modes import NOISE, ORDERS, passed


def model_of(training_revolutions: Any, data: Amplitudes) -> TransmissionModel:
    """What a search asks of a model: the revolutions' vectors, their noise, the series calibrated on them."""
    seen = SimpleNamespace(orders=ORDERS, vectors=data.vectors, noise=lambda orders: np.full(data.vectors.shape, NOISE))
    train = np.ones(len(training_revolutions), dtype=bool)
    given = SimpleNamespace(orders=ORDERS, notch=())
    periodic = Periodic(data.series)
    return cast(
        "Any",
        SimpleNamespace(
            parts=(), seen=seen, training_revolutions=training_revolutions, train=train, given=given, periodic=periodic
        ),
    )


def with_another_mode(data: Amplitudes, training_revolutions: Any, natural: float) -> Amplitudes:
    """The same vectors after one more mode."""
    frequency = data.x[:, 1:2] * np.asarray(ORDERS)
    swing = freqs([natural**2], [1.0, 0.2 * natural, natural**2], frequency.ravel())[1].reshape(frequency.shape)
    vectors = data.vectors * (1.0 + 0.1 * (swing - 1.0))
    return replace(data, vectors=vectors, series=calibrate(training_revolutions, vectors, data.sigma, ORDERS))


@pytest.mark.parametrize("naturals", [(7.3,), (7.3, 16.0)])
def test_as_many_modes_are_found_as_there_are(naturals: tuple[float, ...]) -> None:
    names, data = passed("second_order", naturals[0], 0.07, 0.15, 8)
    for natural in naturals[1:]:
        data = with_another_mode(data, names.training_revolutions, natural)
    model = model_of(names.training_revolutions, data)
    found = []
    for _ in range(3):
        law = laws.search(model, 0)
        if law is None:
            break
        assert law.law.effect == RESONANCE
        found.append(law.law.point[0])
        assert model.periodic is not None
        model.periodic = Periodic(law.series, laws=(*model.periodic.laws, law.law))
    assert sorted(found) == pytest.approx(list(naturals), rel=0.02)


@pytest.mark.parametrize(
    ("speeds", "driven"),
    [
        ([0.13, 0.131, 0.132], False),
        ([0.05, 0.13, -0.131], False),
        ([0.05, 0.09, -0.13], True),
        # a sweep: no two neighbours are apart
        (np.linspace(0.05, 0.13, 20).tolist(), True),
    ],
)
def test_a_law_of_speed_needs_three_speeds(speeds: list[float], driven: bool) -> None:
    _, data = passed("second_order", 7.3, 0.07, 0.15, 8)
    own = replace(data, x=np.array([[100.0 * k, v, 25.0] for k, v in enumerate((speeds * 12)[: max(12, len(speeds))])]))
    assert laws._driven(own, "speed") is driven
    assert laws._driven(own, "torque")
    assert laws._driven(own, "temperature")


def test_at_one_speed_no_resonance_is_looked_for() -> None:
    _, data = passed("second_order", 7.3, 0.07, 0.15, 8)
    found = [
        law.effect for law in (*laws.resonances(data), *laws.factors(data)) if laws._driven(data, law.variables[0])
    ]
    assert {RESONANCE, "te.velocity_nonlinear"} <= set(found)
    x = data.x.copy()
    x[:, 1] = 0.13 * np.sign(x[:, 1])
    alone = replace(data, x=x)
    kept = [p.effect for p in (*laws.resonances(alone), *laws.factors(alone)) if laws._driven(alone, p.variables[0])]
    assert kept
    assert not {RESONANCE, "te.velocity_nonlinear"} & set(kept)


def test_a_mode_that_some_orders_move_as_they_will_is_found_with_these() -> None:
    """What moves the mode is another wave of the same order: it answers in a size and a phase of its own."""
    names, data = passed("second_order", 7.3, 0.07, 1e-9, 8)
    rng = np.random.default_rng(5)
    moved = [ORDERS.index(f) for f in (46.0, 92.0, 138.0)]
    size = np.sqrt(np.mean(np.abs(data.vectors[:, moved]) ** 2, axis=0))
    share = 1.5 * size * np.exp(2j * np.pi * rng.random(3))
    frequency = data.x[:, 1:2] * np.asarray(ORDERS)[moved]
    swing = (frequency / 7.3) ** 2 / (1.0 - (frequency / 7.3) ** 2 + 0.14j * frequency / 7.3)
    vectors = data.vectors.copy()
    vectors[:, moved] += share * swing
    data = replace(data, vectors=vectors, series=calibrate(names.training_revolutions, vectors, data.sigma, ORDERS))
    law = laws.search(model_of(names.training_revolutions, data), 0)
    assert law is not None
    assert law.law.form == "second_order_of_base_each"
    assert law.law.orders == (46.0, 92.0, 138.0)
    assert law.law.point == pytest.approx((7.3, 0.07), rel=0.02)


@pytest.mark.parametrize(("phases", "form"), [(0.0, "second_order_of_base"), (1.0, "second_order_of_base_each")])
def test_orders_that_move_a_mode_each_in_a_phase_of_its_own_have_strengths_of_their_own(
    phases: float, form: str
) -> None:
    """``phases``: spread in rad by which orders differ in how they move the mode."""
    names, data = passed("second_order_of_base", 7.3, 0.08, 0.0, 8)
    rng = np.random.default_rng(3)
    frequency = data.x[:, 1:2] * np.asarray(ORDERS)
    swing = freqs([-1.0, 0.0, 0.0], [1.0, 0.16 * 7.3, 7.3**2], frequency.ravel())[1].reshape(frequency.shape)
    strength = 0.4 * np.exp(2j * np.pi * phases * rng.random(len(ORDERS)))
    vectors = data.vectors * (1.0 + strength * swing)
    data = replace(data, vectors=vectors, series=calibrate(names.training_revolutions, vectors, data.sigma, ORDERS))
    found = laws.search(model_of(names.training_revolutions, data), 0)
    assert found is not None
    assert (found.law.effect, found.law.form) == (RESONANCE, form)
    assert found.law.point[0] == pytest.approx(7.3, rel=0.02)


def test_a_participation_that_leaves_more_than_strengths_of_each_gives_way() -> None:
    """Before the series is calibrated under it one participation of all may seem to say more than it does."""
    names, data = passed("second_order_of_base", 7.3, 0.08, 0.4, 8)
    found = laws.search(model_of(names.training_revolutions, data), 0)
    assert found is not None
    law, series = found.law, found.series
    mode = modes.Mode(law, (), series, 0.0, np.zeros(len(ORDERS)))
    worse = replace(law, point=(law.point[0], 3.0 * law.point[1], law.point[2]))
    each = replace(law, orders=ORDERS)
    nothing = np.zeros(len(ORDERS))
    # what says the same with more numbers costs these
    assert not laws._leaves_less(data, (each, series, nothing), mode)
    assert laws._leaves_less(data, (each, series, nothing), replace(mode, law=worse))
    assert not laws._leaves_less(data, (each, series, nothing), None)
