from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fakes.concealed import Folder, cases, open_folder
from fakes.concealed.clutter import TOTAL, draw_clutter
from fakes.concealed.plant import LOAD_RIPPLE_ORDERS, ORDERS, draw_plant, transmission_error
from tests.fakes.concealed.test_effects import SMALL


@pytest.mark.parametrize("seed", range(5))
def test_weak_orders_are_many_apart_and_of_the_size_told(seed: int) -> None:
    rng = np.random.default_rng(seed)
    plain = draw_plant(rng)
    plant = draw_clutter(plain, (7.0, 45.0), rng)
    weak = plant.orders[len(ORDERS) :]
    assert 60 <= weak.size <= 100
    known = np.array([*ORDERS, *LOAD_RIPPLE_ORDERS, 7, 45, 185, 370], dtype=float)
    assert np.abs(np.subtract.outer(weak, known)).min() >= 0.75
    assert np.diff(weak).min() >= 0.75
    assert np.any(weak != np.rint(weak))
    theta = np.linspace(0.0, 20.0 * np.pi, 40_000)
    still = np.zeros(theta.size)
    side, heat = np.ones(theta.size, dtype=np.int64), np.full(theta.size, 35.0)
    series = [transmission_error(p, theta, side, still, still, heat) for p in (plain, plant)]
    assert 0.8 * TOTAL[0] < np.std(series[1] - series[0]) < 1.2 * TOTAL[1]


def test_amplitudes_fall_with_the_order_and_some_depend_on_load_and_direction() -> None:
    plant = draw_clutter(draw_plant(np.random.default_rng(3)), (), np.random.default_rng(4))
    weak = plant.amplitude[:, len(ORDERS) :]
    low = plant.orders[len(ORDERS) :] < 60.0
    assert np.median(weak[1, low, 9]) > np.median(weak[1, ~low, 9])
    share = np.mean(weak[1, :, 3] != 0.0), np.mean(weak[0, :, 9] != weak[1, :, 9])
    assert all(0.15 < part < 0.65 for part in share)


def test_a_cluttered_folder_holds_the_same_bench_and_one_more_effect() -> None:
    def folder(clutter: bool) -> Folder:
        spec = next(c for c in cases("clear", 2, clutter=clutter) if c.forms[0].effect == "te.harmonic")
        return open_folder(replace(spec, design=SMALL))

    plain, full = folder(clutter=False), folder(clutter=True)
    assert full.campaign.plant.f_c == plain.campaign.plant.f_c
    assert len(full.campaign.plant.orders) >= len(ORDERS) + 60
    (one,) = full.truth().effects  # the case conceals an order: it is one of the many
    assert plain.truth().effects[0].effect == one.effect == "te.harmonic"
    assert set(plain.truth().effects[0].location.orders) < set(one.location.orders)
    assert len(one.location.orders) == len(one.location.order_sizes)


def test_a_cluttered_null_is_a_mismatch_with_one_finding() -> None:
    truth = open_folder(replace(next(cases("null", 2, clutter=True)), design=SMALL)).truth()
    assert truth.verdict == "mismatch"
    assert [e.effect for e in truth.effects] == ["te.harmonic"]


def test_weak_orders_pass_a_resonance_as_the_others_do() -> None:
    spec = next(c for c in cases("clear", 2, clutter=True) if c.forms[0].effect == "te.resonance")
    folder = open_folder(replace(spec, design=SMALL))
    (effect,) = folder.campaign.effects
    gain, lag = effect.modulation(np.zeros(3), np.full(3, 0.1), folder.campaign.plant.orders) or (None, None)
    assert gain is not None
    assert lag is not None
    assert gain.shape == lag.shape == (folder.campaign.plant.orders.size, 3)
    assert np.abs(gain[len(ORDERS) :]).max() > 0.01
