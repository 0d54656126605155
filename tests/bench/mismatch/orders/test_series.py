"""The series: how far orders may change with the state is told by their own kind."""

from __future__ import annotations

import numpy as np

from bench.mismatch.orders.revolutions import Revolution, directions, states
from bench.mismatch.orders.series import calibrate

NOISE = 2e-8
TEETH = (46.0, 92.0, 180.0)
WEAK = tuple(float(f) for f in range(201, 261))
RNG = np.random.default_rng(4)
REVOLUTIONS = [
    Revolution(k, slice(0, 0), load, side * speed, temperature, 60.0 * k, side, 1.0, 60.0)
    for k, (load, speed, temperature, side) in enumerate(
        zip(
            RNG.uniform(-800.0, 800.0, 60),
            RNG.uniform(0.1, 0.7, 60),
            RNG.uniform(20.0, 45.0, 60),
            np.where(np.arange(60) % 2 == 0, 1.0, -1.0),
            strict=True,
        )
    )
]


def test_many_orders_that_hardly_change_do_not_still_those_of_the_teeth() -> None:
    x, side = states(REVOLUTIONS), directions(REVOLUTIONS)
    load, speed, warm = x[:, 0] / 800.0, (np.abs(x[:, 1]) - 0.4) / 0.3, (x[:, 2] - 30.0) / 15.0
    teeth = [
        1e-5 * (1.0 + 0.5 * load + 0.3 * speed) * np.exp(1j * (k + 0.9 * load + 0.6 * warm + 0.5 * load * speed))
        for k in range(len(TEETH))
    ]
    weak = [1e-6 * np.exp(1j * f) * np.ones(len(x)) for f in WEAK]
    clean = np.column_stack([*teeth, *weak])
    drawn = RNG.normal(size=(2, *clean.shape))
    vectors = clean + NOISE * (drawn[0] + 1j * drawn[1])
    sigma = np.full(clean.shape, NOISE)

    def left(given: tuple[float, ...] | None) -> float:
        series = calibrate(REVOLUTIONS, vectors, sigma, (*TEETH, *WEAK), given=given)
        apart = series.vectors(x, side)[:, : len(TEETH)] - clean[:, : len(TEETH)]
        return float(np.sqrt(np.mean(np.abs(apart) ** 2))) / NOISE

    assert left(TEETH) < 1.0
    assert left(None) > 3.0 * left(TEETH)
    prior = calibrate(REVOLUTIONS, vectors, sigma, (*TEETH, *WEAK), given=TEETH).prior
    assert np.array_equal(prior[0], prior[2])
    assert prior[0].max() > 10.0 * prior[-1].max()
