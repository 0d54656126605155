from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from bench.identification import Identification, to_json, to_simulation
from bench.identification.plausible import KEY, implausible
from bench.identification.tables import parameter_table
from bench.simulation import Simulation


def test_what_can_be_is_not_marked() -> None:
    values = {"J": 0.003, "C": 25e3, "R": 0.2, "T_amb": 21.0, "f_c": 0.5, "f_vT": -1e-4, "tau_0": -0.02, "z_0": -3.0}
    assert implausible(values, {}) == {}


def test_what_cannot_be_has_its_likely_cause() -> None:
    said = implausible({"J": -0.003, "f_c": -0.5}, {"J": 1e-5, "f_c": None})
    assert "likely cause" in said["J"]
    assert "same instant" in said["J"]
    assert "sign" in said["f_c"]


def test_what_is_not_told_apart_from_its_bound_is_told_so() -> None:
    said = implausible({"J_L": -0.2}, {"J_L": 0.3})
    assert "cannot be distinguished from 0" in said["J_L"]
    assert "cause" not in said["J_L"]


def test_no_impossible_value_is_written_unmarked(found: Identification, tmp_path: Path) -> None:
    wrong = replace(found, friction=replace(found.friction, values={**found.friction.values, "J": -0.0029}))
    path = tmp_path / "model.json"
    to_simulation(wrong).save(path)
    row = next(t for t in json.loads(path.read_text())["terms"] if t["effect"] == "motor.inertia")
    assert "J is -0.0029 and should be above 0" in row[KEY]["J"]
    # the mark survives whoever reads the file and writes it again
    assert "J" in Simulation.load(path).terms["motor.inertia"].extra[KEY]
    assert "J" in to_json(wrong)["implausible"]
    assert "J (!)" in [str(cell) for cell in parameter_table(wrong).columns[0].cells]
    fine = next(t for t in to_simulation(found).to_json()["terms"] if t["effect"] == "motor.inertia")
    assert KEY not in fine
