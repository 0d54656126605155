"""A torque reported for one instant of the bus cycle: how far J may be off by it, from recordings of ramps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
import pytest

from bench.identification.balances.instant import fall_per_row, systematic, systematic_entry, systematic_std
from bench.identification.comparison.coverage import deviates
from bench.identification.comparison.coverage_table import symbols
from bench.identification.statistics.regression import LinearFit
from bench.recording import ChannelSpec, Recording, Setpoint
from bench.simulation import Gearbox, Parameter, Simulation, Term

RATE = 2000.0
INERTIA, GAIN = 0.0029, 0.6
RATIO = 185.0


@dataclass(frozen=True, slots=True)
class _Recording:
    """As much of a recording as is asked for."""

    channels: dict[str, np.ndarray]
    setpoint: Setpoint
    specs: dict[str, ChannelSpec]
    sample_rate: float
    gearbox: Gearbox

    @property
    def size(self) -> int:
        return int(self.channels["motor_torque"].size)

    def read_si(self, names: list[str], start: int, stop: int) -> dict[str, np.ndarray]:
        return {name: self.channels[name][start:stop] for name in names}


def _recordings(number: int, sign: float = 1.0, noise: float = 0.005, ramp_rows: int = 800) -> list[Recording]:
    """Ramps of a rotor behind a proportional loop: the torque falls by Ts·Kp/J of the ramp's from row to row."""
    out: list[Recording] = []
    for k in range(number):
        rng = np.random.default_rng(k)
        n = 2000
        speed = sign * 0.02 * np.minimum(np.arange(n), ramp_rows)
        load = 30.0 * np.sin(0.02 * np.arange(n) + k)
        torque = np.empty(n)
        omega, decay = 0.0, np.exp(-GAIN / INERTIA / RATE)
        for i in range(n):
            error = speed[i] - omega
            torque[i] = GAIN * error
            omega = speed[i] - error * decay
        torque += load / RATIO + noise * rng.normal(size=n)
        channels = {"motor_velocity_setpoint": speed, "motor_torque": torque, "load_torque": load}
        specs = {name: ChannelSpec(name, "1", "float64") for name in channels}
        setpoint = Setpoint(load_torque=0.0, velocity=sign * 0.1, temperature=float("nan"))
        out.append(cast(Recording, _Recording(channels, setpoint, specs, RATE, Gearbox(RATIO))))
    return out


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_fall_behind_a_ramp_is_that_within_a_cycle(sign: float) -> None:
    # from 0.9 to 0.3 of an exponential, the straight line is steeper by what the mean level is below 1
    share = fall_per_row(_recordings(24, sign))
    assert share == pytest.approx(0.6 / np.log(3.0) * GAIN / INERTIA / RATE, rel=0.1)


def test_without_ramps_nothing_is_told() -> None:
    assert fall_per_row(_recordings(24, ramp_rows=0)) is None
    assert fall_per_row(_recordings(3)) is None
    assert systematic(_recordings(3), LinearFit({"J": INERTIA}, {"J": 1e-6}, (), 0.0, 1)) == {}
    assert systematic(_recordings(24), LinearFit({}, {}, ("J",), 0.0, 1)) == {}


def test_coverage_counts_it_and_says_what_it_is_without() -> None:
    fit = LinearFit({"J": INERTIA}, {"J": 1e-6}, (), 0.0, 1)
    extra = systematic_entry(systematic(_recordings(24), fit))
    term = Term("motor.inertia", parameters={"J": Parameter(INERTIA, "kg*m^2", 1e-6)}, extra=extra)
    found = Simulation.nominal(Gearbox(RATIO)).with_term(term)
    assert systematic_std(found.terms["motor.inertia"], "J") == pytest.approx(INERTIA * 0.056 / 12**0.5, rel=0.1)
    truth = {"nominal": {"motor.inertia": {"J": INERTIA * 1.002}}, "transmission_error": {}}
    row = deviates(found, truth)["parameters"]["J"]
    assert abs(row["z"]) < 1.0
    assert abs(row["repeat_z"]) > 5.0


def test_the_table_has_a_row_without_it_beside_results_that_are_older() -> None:
    older = {"value": 1.0, "std": 0.1, "truth": 1.05, "z": -0.5}
    newer = older | {"std": 0.5, "z": -0.1, "repeat_std": 0.01, "repeat_z": -5.0}
    rows = [
        line
        for line in symbols([{"parameters": {"J": older}}, {"parameters": {"J": newer}}])
        if line.startswith(("| J |", "| J,"))
    ]
    assert len(rows) == 2
    assert "2 of 2" in rows[0]
    assert "without what recordings share" in rows[1]
    assert "1 of 2" in rows[1]
