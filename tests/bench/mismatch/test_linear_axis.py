"""A linear axis speaks of newtons and metres: the report, the simulation file and what is exported of it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from bench.exchange.to_c import header
from bench.exchange.to_modelica import to_modelica
from bench.exchange.to_python import to_python
from bench.exchange.written import formulas_of
from bench.mismatch.leave_one_out import leave_one_out
from bench.mismatch.report.report import Report
from bench.mismatch.run import run
from bench.simulation.linear import in_metres
from bench.simulation.model import Simulation
from tests.bench.importing import builders

SECONDS, RATE = 48.0, 50.0
MASS, DRY, VISCOUS, PULL, NOISE = 90.0, 20.0, 200.0, 15.0, 1.5
"""kg; N; N·s/m; N beyond Coulomb friction near standstill; N"""
OF_A_SHAFT = re.compile(r"N[*·]m|\brad\b|\btorque\b|\bdeg/s|°/s|\brevolution")


@pytest.fixture(scope="module")
def analysed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Report, Path]:
    folder = tmp_path_factory.mktemp("axis")
    rng = np.random.default_rng(3)
    time = np.arange(int(SECONDS * RATE)) / RATE
    corners = np.arange(0.0, SECONDS + 1.0, 2.0)
    speed = np.interp(time, corners, rng.uniform(-0.25, 0.25, corners.size))
    place = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) / RATE)))
    force = MASS * np.gradient(speed, time) + (DRY + PULL * np.exp(-np.abs(speed) / 0.05)) * np.sign(speed)
    force += VISCOUS * speed + rng.normal(0.0, NOISE, time.size)
    builders.csv(folder / "a.csv", t=np.round(time, 6), x=place, F=force)
    channels = 'motor_angle = {variable = "x", unit = "m"}\nmotor_torque = {variable = "F", unit = "N"}'
    builders.run(folder, channels, top="pieces = {seconds = 6}")
    return run(folder / "out", folder / "report"), folder


def test_report_page_and_terminal(analysed: tuple[Report, Path]) -> None:
    report, folder = analysed
    assert report.findings
    content = json.loads((folder / "report" / "report.json").read_text(encoding="utf-8"))
    assert content["channels"][0]["unit"] == "N"
    units = {p["unit"] for f in content["findings"] for p in f["parameters"]}
    assert {own for own in units if own.startswith("N")}
    told = [t for f in content["findings"] for t in (f["name"], f["words"], f["location"]["text"])]
    texts = [report.sentence, *content["notes"], *units, *told]
    assert not [t for t in texts if OF_A_SHAFT.search(t)]
    page = (folder / "report" / "report.html").read_text(encoding="utf-8")
    body = re.sub(r'(href|d)="[^"]*"', "", page.split("</head>")[1])
    assert not OF_A_SHAFT.search(body)
    assert "speed / (mm/s)" in page


def test_simulation_file_and_what_is_exported_of_it(analysed: tuple[Report, Path]) -> None:
    _, folder = analysed
    model = folder / "report" / "model.json"
    content = json.loads(model.read_text(encoding="utf-8"))
    assert content["axis"] == "linear"
    units = {s: p["unit"] for row in content["terms"] for s, p in row.get("parameters", {}).items()}
    assert units["J"] == "kg"
    assert units["f_c"] == "N"
    assert units["f_v"] == "N*s/m"
    simulation = Simulation.load(model)
    assert simulation.value("motor.inertia", "J") == pytest.approx(MASS, rel=0.05)
    formulas = formulas_of(simulation)
    assert {p.name: p.unit for p in formulas.parameters}["motor_inertia_J"] == "kg"
    assert formulas.input("motor_velocity") == ("m/s", "speed of the motor")
    assert formulas.unit_of("motor_torque") == "N"
    for text in (to_modelica(formulas), to_python(formulas), header(formulas)):
        assert not re.search(r"N[*·]m|\brad\b", text)


def test_rows_of_terms_left_out(analysed: tuple[Report, Path]) -> None:
    report, folder = analysed
    only = ("motor.inertia",)
    rows = leave_one_out(
        report.data,
        Simulation.nominal(),
        ["motor_torque"],
        report.findings,
        folder / "out",
        lambda _what, _share: None,
        effects=only,
    )
    assert re.search(r"^J = .* kg$", rows[0].parameters), rows[0]
    assert in_metres(rows[0].parameters) == rows[0].parameters
