"""A lag of the thermometer has the heat capacity of the heating, and cooling is towards surroundings that there are."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.regression import beside
from bench.mismatch.regression.bank import Fit
from bench.mismatch.regression.model import Block
from bench.mismatch.regression.regressors import named
from bench.simulation.terms import LIBRARY, TEMPERATURE

HEATING, LAG = "thermal.loss_heating", "thermal.sensor_lag"
PER_C = 5e-5
"""K/J"""


def fitted(own: float, std: float) -> tuple[Block, Block, Fit]:
    """A lag and the heating, one over their heat capacities, and the standard error of the lag's."""
    lag = Block(named(LAG, TEMPERATURE, "first_order", (20.0,)), (0,), np.zeros(1))
    heating = Block(named(HEATING, TEMPERATURE, LIBRARY[HEATING].forms[TEMPERATURE][0].name), (1,), np.zeros(1))
    covariance = np.diag([std**2, (0.001 * PER_C) ** 2])
    return lag, heating, Fit((0, 1), np.array([own, PER_C]), covariance, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("share", "std", "alike"),
    [
        (1.0, 0.01, True),
        (0.6, 0.01, True),
        (1.9, 0.01, True),
        (0.05, 0.01, False),
        (4.0, 0.01, False),
        (4.0, 1.5, True),
    ],
)
def test_a_lag_has_the_heat_capacity_of_the_heating(share: float, std: float, alike: bool) -> None:
    """Within a factor of two and the standard errors: a part of the heat that comes late is another effect."""
    lag, heating, fit = fitted(share * PER_C, std * PER_C)
    assert beside._shares(lag, [heating], fit) is alike


def test_a_term_that_shares_nothing_is_free() -> None:
    _, heating, fit = fitted(PER_C, 0.0)
    other = Block(named("thermal.convection_speed", TEMPERATURE, "power", (0.5,)), (0,), np.zeros(1))
    assert beside._shares(other, [heating], fit)


@pytest.mark.parametrize(
    ("surroundings", "h_1", "std", "physical"),
    [
        (21.0, 4e-5, 0.01, True),
        (135.0, 4e-5, 0.01, False),
        (135.0, 4e-5, 1.0, True),
        (-90.0, 4e-5, 0.01, False),
        # cooling that falls with the speed
        (337.0, -4e-6, 0.3, False),
    ],
)
def test_cooling_is_towards_surroundings_that_there_are(
    surroundings: float, h_1: float, std: float, physical: bool
) -> None:
    """``std``: relative standard error of both coefficients."""
    term = named("thermal.convection_speed", TEMPERATURE, "power", (0.5,))
    found = np.array([h_1, h_1 * surroundings])
    assert beside.admissible(term, found, np.diag((std * found) ** 2)) is physical
