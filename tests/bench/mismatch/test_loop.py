"""The loop closes: what a comparison finds and writes into model.json is gone in a second one given that file."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.mismatch.assess import Assessment, assess
from bench.mismatch.dataset import Dataset
from bench.mismatch.given import Given
from bench.mismatch.improved import improved
from bench.mismatch.motor_ripple import HIGHEST, ShaftSpectrum
from bench.mismatch.page import page
from bench.mismatch.run import Report
from bench.simulation.laws import response
from bench.simulation.model import Simulation, Term
from tests.bench.mismatch.synthetic import effect, temperatures, torques, transmission

TORQUES = ("load_torque", "motor_torque")
SERIES = Simulation.nominal().with_term(Term("te.fourier", True, {}, (1.0, 46.0, 92.0)))


def twice(data: Dataset, channels: tuple[str, ...], start: Simulation, path: Path) -> tuple[Assessment, Assessment]:
    """Compare with ``start``, then with the simulation improved by what was found, through a file."""
    first = assess(data, Given.of(start), channels)
    improved(first.findings, first.analysis, start).save(path)
    return first, assess(data, Given.of(Simulation.load(path)), channels)


def _motor(name: str, form: str, linear: tuple[float, ...], point: tuple[float, ...] = ()) -> Callable[[Any], Any]:
    return lambda f: effect(name, "motor_torque", form, f, linear, point)


MOTOR = {
    "friction.stribeck": _motor("friction.stribeck", "gaussian", (0.3,), (8.0,)),
    "friction.position_dependent": _motor("friction.position_dependent", "constant", (0.1, 0.05), (3.0,)),
    "friction.run_in": _motor("friction.run_in", "coulomb", (0.2,), (20.0,)),
}


@pytest.mark.parametrize("name", MOTOR)
def test_terms_of_the_motor_torque(name: str, tmp_path: Path) -> None:
    if name == "friction.run_in":
        from bench.simulation.terms import LIBRARY

        form = LIBRARY[name].forms["motor_torque"][0]
        data = torques(lambda f: form.columns(f, form.grid(f)[2]) @ np.full(len(form.linear), 0.25))
    else:
        data = torques(MOTOR[name])
    first, second = twice(data, ("motor_torque",), Simulation.nominal(), tmp_path / "model.json")
    assert [f.effect for f in first.findings] == [name]
    assert first.scores["motor_torque"].before > 1.1 * first.scores["motor_torque"].floor
    assert second.findings == []
    assert second.scores["motor_torque"].before < 1.03 * second.scores["motor_torque"].floor


def test_several_effects_at_once_and_an_error_of_the_torque_sensor_in_all_channels(tmp_path: Path) -> None:
    data = torques(MOTOR["friction.stribeck"], lambda f: 0.25 * (f.temperature - 25.0))
    first, second = twice(data, TORQUES, Simulation.nominal(), tmp_path / "model.json")
    assert {f.effect for f in first.findings} == {"friction.stribeck", "sensor.torque_zero_temperature"}
    assert next(f for f in first.findings if f.effect.startswith("sensor")).also_in == ["motor_torque"]
    assert second.findings == []


def test_lag_of_the_thermometer(tmp_path: Path) -> None:
    first, second = twice(temperatures(40.0), ("temperature",), Simulation.nominal(), tmp_path / "model.json")
    assert [f.effect for f in first.findings] == ["thermal.sensor_lag"]
    assert second.findings == []


def test_torque_ripple_of_the_motor(tmp_path: Path) -> None:
    data = torques()
    rng = np.random.default_rng(4)
    for member in data.members:
        noise = 1e-3 * (rng.normal(size=HIGHEST + 1) + 1j * rng.normal(size=HIGHEST + 1))
        noise[24] += 0.05 - 0.02j
        data.shaft.append(ShaftSpectrum(member.index, noise, 1e-3, 0.05))
    rows = data.slow["motor_torque"]
    data.slow["motor_torque"] = replace(rows, within=rows.within + 0.5 * abs(0.05 - 0.02j) ** 2)
    first, second = twice(data, ("motor_torque",), Simulation.nominal(), tmp_path / "model.json")
    assert [f.effect for f in first.findings] == ["motor.torque_ripple"]
    assert second.findings == []
    before, after = first.scores["motor_torque"], second.scores["motor_torque"]
    assert after.before == pytest.approx(before.after, rel=0.01)
    assert after.before < 0.8 * before.before


def test_order_sidebands_and_pulse(tmp_path: Path) -> None:
    def extra(f: Any) -> Any:
        carrier = 3e-5 * (1.0 + 0.1 * f.torque / 1000.0)
        sidebands = 0.12 * carrier * (np.sin(43.0 * f.theta + 0.3) + np.sin(49.0 * f.theta + 1.0))
        pulse = effect("te.local_defect", "transmission_error", "gaussian", f, (2.5e-5,), (2.0, 0.025))
        return sidebands + 3e-6 * np.cos(31.0 * f.theta) + pulse

    data = transmission(extra=extra)
    first, second = twice(data, ("transmission_error",), SERIES, tmp_path / "model.json")
    assert {"te.sideband", "te.harmonic", "te.local_defect"} >= {f.effect for f in first.findings}
    assert {"te.harmonic", "te.local_defect"} <= {f.effect for f in first.findings}
    assert second.findings == []
    assert second.scores["transmission_error"].before < 1.1 * second.scores["transmission_error"].floor
    text = page(Report("mismatch", "", data, first.scores, first.findings, first.analysis))
    assert "order per output revolution" in text  # the plots: a spectrum, and a course over the angle
    assert "output angle / deg" in text


def test_resonance_is_in_force_as_a_law(tmp_path: Path) -> None:
    data = transmission(vectors=lambda f, v: response(f * v, 9.0, 0.12), turns=18)
    first, second = twice(data, ("transmission_error",), SERIES, tmp_path / "model.json")
    assert "te.resonance" in {f.effect for f in first.findings}
    row = next(t for t in json.loads((tmp_path / "model.json").read_text())["terms"] if t["effect"] == "te.resonance")
    assert row["law"]["point"][0] == pytest.approx(9.0, rel=0.1)
    assert second.findings == []
    assert "frequency of the order" in page(Report("", "", data, first.scores, first.findings, first.analysis))
    score = second.scores["transmission_error"]
    assert score.before == pytest.approx(first.scores["transmission_error"].after, rel=0.05)
