"""A gearbox full of weak orders: what a series of twenty neglects, on every real bench and the emulated one.

Sixty to a hundred orders are drawn: most of them integers, the lower the likelier, some tied to the ratio and the
tooth numbers. Amplitudes are lognormal about a law that falls with the order; together they are :data:`TOTAL` rad RMS.
A part of them depends on load, direction, speed or temperature. They belong to the gearbox: what passes a resonance
takes them along.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from fakes.concealed.plant import LOAD_RIPPLE_ORDERS, ORDERS, RATIO, Floats, Plant
from fakes.concealed.truth import ConcealedEffect, Location

#: RMS in rad of all weak orders together is drawn evenly from here; the emulated bench has 25 µrad.
TOTAL = (10e-6, 25e-6)
_COUNT = (60, 100)
_HIGHEST = 400
_RATIO_PARTS = (1 / 3, 2 / 5, 1 / 2, 3 / 5, 2 / 3, 3 / 4, 4 / 3, 3 / 2, 5 / 3)
_TOOTH_PARTS = (24, 45, 46, 48, 90, 92, 96, 138, 184, 230, 322, 368)
_APART = 0.75  # orders closer than this are one order to any recording of about one revolution
#: Chance that a weak order depends on: load, direction, speed, temperature.
_DEPENDS = (0.4, 0.3, 0.15, 0.15)


def draw_clutter(plant: Plant, taken: Iterable[float], rng: np.random.Generator) -> Plant:
    """The same gearbox with weak orders; none lies on a nominal order, the ripple's, the motor's or one ``taken``."""
    orders = _draw_orders(taken, rng)
    count = orders.size
    size = np.exp(rng.normal(0.0, 0.8, count)) / (1.0 + (orders / 40.0) ** 0.6)
    size *= np.sqrt(2.0) * rng.uniform(*TOTAL) / np.sqrt(np.sum(size**2))
    on_load, on_side, on_speed, on_heat = (rng.random(count) < share for share in _DEPENDS)
    amplitude, phase = np.zeros((2, count, 10)), np.zeros((2, count, 10))
    common = rng.uniform(-np.pi, np.pi, count)
    slope, curvature = rng.normal(0.0, 0.35, count), rng.normal(0.0, 0.15, count)
    speed, warm = rng.normal(0.0, 0.2, count), rng.normal(0.0, 0.25, count)
    for d in range(2):
        mine = np.where(on_side, rng.uniform(0.6, 1.4, count), 1.0) * size
        amplitude[d, :, 9] = mine
        amplitude[d, :, 3] = mine * slope * on_load
        amplitude[d, :, 4] = mine * speed * on_speed
        phase[d, :, 9] = common + on_side * rng.normal(0.0, 0.8, count)
        phase[d, :, 3] = curvature * on_load
        phase[d, :, 5] = warm * on_heat
    return replace(
        plant,
        orders=np.append(plant.orders, orders),
        amplitude=np.append(plant.amplitude, amplitude, axis=1),
        phase=np.append(plant.phase, phase, axis=1),
    )


def clutter_truth(plant: Plant, noise_rms: float) -> ConcealedEffect | None:
    """What the truth says of a plant's weak orders: one ``te.harmonic`` with all of them; None where it has none."""
    weak = plant.orders[len(ORDERS) :]
    if not weak.size:
        return None
    sizes = np.abs(plant.amplitude[:, len(ORDERS) :, 9]).mean(axis=0) / np.sqrt(2.0)
    by_size = np.argsort(-sizes)
    return ConcealedEffect(
        effect="te.harmonic",
        status="named",
        form="weak orders of the gearbox",
        channels=("transmission_error",),
        strength=round(float(np.sqrt(np.sum(sizes**2)) / noise_rms), 3),
        location=Location(
            orders=tuple(round(float(weak[i]), 6) for i in by_size),
            order_sizes=tuple(float(sizes[i]) for i in by_size),
        ),
    )


def merged(effects: list[ConcealedEffect], weak: ConcealedEffect | None) -> list[ConcealedEffect]:
    """The effects with the weak orders as one more; an order concealed on purpose joins them, for it is one of them."""
    if weak is None:
        return effects
    same = [e for e in effects if e.effect == weak.effect]
    sizes = [max(weak.location.order_sizes)] * sum(len(e.location.orders) for e in same)
    orders = [order for e in same for order in e.location.orders]
    whole = replace(
        weak,
        form="; ".join([*(e.form for e in same), weak.form]),
        location=Location(orders=(*orders, *weak.location.orders), order_sizes=(*sizes, *weak.location.order_sizes)),
    )
    return [*(e for e in effects if e.effect != weak.effect), whole]


def _draw_orders(taken: Iterable[float], rng: np.random.Generator) -> Floats:
    forbidden = [float(k) for k in (*ORDERS, *LOAD_RIPPLE_ORDERS, *taken)]
    forbidden += [RATIO * k for k in range(1, 5)]  # whole revolutions of the motor are its encoder's
    pool = np.arange(2.0, _HIGHEST + 1.0)
    chance = 1.0 / (15.0 + pool)
    wanted = [float(k) for k in rng.choice(pool, pool.size, replace=False, p=chance / chance.sum())]
    near = [float(k + m) for k in _TOOTH_PARTS for m in (-1, 0, 1)]
    parts = [RATIO * part for part in _RATIO_PARTS]
    tied = [parts[i] for i in rng.permutation(len(parts))[: int(rng.integers(2, 5))]]
    tied += [near[i] for i in rng.permutation(len(near))[: int(rng.integers(6, 15))]]
    count = int(rng.integers(_COUNT[0], _COUNT[1] + 1))
    picked: list[float] = []
    for order in [*tied, *wanted]:
        if len(picked) == count:
            break
        if min(abs(order - k) for k in (*forbidden, *picked)) >= _APART:
            picked.append(order)
    return np.sort(np.array(picked))
