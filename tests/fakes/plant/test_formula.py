"""A plant plays a formula of a simulation file as it plays a table."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fakes.plant import Plant
from tests.fakes.plant.motion import bring_up, commands
from tests.fakes.plant.test_simulation import written

ROW: dict[str, Any] = {
    "effect": "unknown",
    "channels": ["motor_torque"],
    "form": "formula",
    "over": ["speed"],
    "within": [[0.0, 0.2]],
    "parts": [{"times": "d", "text": "exp(-x1/s1)"}],
    "parameters": {"c1": {"value": 0.3, "unit": "N*m"}, "s1": {"value": 0.05, "unit": "rad/s"}},
}


def test_a_formula_is_felt_where_it_says(tmp_path: Path) -> None:
    plants = [Plant.from_simulation(written(tmp_path, terms), seed=1) for terms in ([], [ROW])]
    for plant in plants:
        bring_up(plant, 10.0, 0.0)
    plain, extra = (plant.step(commands(0.5, 10.0, 0.0))["input_torque"].mean() for plant in plants)
    polarity = plants[0].truth.input_drive.polarity
    assert polarity * (extra - plain) == pytest.approx(0.3 * np.exp(-10.0 / 185.0 / 0.05), rel=0.05)
