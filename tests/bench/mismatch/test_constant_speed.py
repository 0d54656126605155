"""One long recording at one speed, imported as the defaults do: its orders are found, whatever cuts it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bench.importing import Imported
from bench.mismatch import run as run_module
from bench.mismatch.leave_one_out import leave_one_out
from bench.mismatch.report.left_out import NOT_FOUND
from bench.mismatch.run import run
from bench.simulation.model import Simulation
from bench.simulation.terms import MOTOR_TORQUE
from tests.bench.importing import builders

SECONDS, RATE, TURNS = 60.0, 400.0, 1.5
"""s; Hz; revolutions a second"""
NOISE, ORDERS = 0.02, {6.0: 0.06, 17.0: 0.05}
"""N·m; amplitudes by order per revolution of the shaft"""
CHANNELS = 'motor_angle = {variable = "q", unit = "rad"}\nmotor_torque = {variable = "M", unit = "N*m"}'


def imported(folder: Path, waves: bool, **parts: str) -> Path:
    rng = np.random.default_rng(8)
    time = np.arange(int(SECONDS * RATE)) / RATE
    angle = 2.0 * np.pi * TURNS * time
    torque = 0.5 + rng.normal(0.0, NOISE, time.size)
    for order, amplitude in ORDERS.items() if waves else ():
        torque += amplitude * np.cos(order * angle + 0.3 * order)
    builders.csv(folder / "a.csv", t=np.round(time, 6), q=angle, M=torque)
    done = builders.run(folder, CHANNELS, **parts)
    assert all(isinstance(item, Imported) for item in done), done
    return folder / "out"


@pytest.mark.parametrize("parts", [{}, {"top": "pieces = {seconds = 6}"}], ids=["left to the analysis", "six seconds"])
def test_orders_of_three_times_the_noise_are_found(tmp_path: Path, parts: dict[str, str]) -> None:
    report = run(imported(tmp_path, True, **parts), tmp_path / "report")
    assert report.verdict == "mismatch", report.sentence
    # a wave over the output is told by its order, or as friction that is modulated m times a revolution
    found = {order for f in report.findings for order in f.discovery.orders}
    found |= {round(p["value"], 1) for f in report.findings for p in f.discovery.parameters if p["symbol"] == "m"}
    assert set(ORDERS) <= found
    (outcome,) = report.outcomes
    assert outcome.floor == pytest.approx(NOISE, rel=0.15)


def test_waves_found_anyway_are_no_other_name_of_a_term_left_out(tmp_path: Path) -> None:
    report = run(imported(tmp_path, True), tmp_path / "report")
    known = {f.effect for f in report.findings}
    (row,) = leave_one_out(
        report.data,
        Simulation.nominal(),
        [MOTOR_TORQUE],
        report.findings,
        tmp_path / "out",
        lambda *_: None,
        effects=("friction.viscous",),
    )
    assert set(row.said) <= known
    assert row.said
    assert row.outcome == NOT_FOUND
    assert "with the term, too" in row.why


def test_noise_alone_is_a_match(tmp_path: Path) -> None:
    report = run(imported(tmp_path, False), tmp_path / "report")
    assert not report.findings


def test_what_was_found_is_kept_whatever_becomes_of_the_terms_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object, **_more: object) -> None:
        raise ZeroDivisionError("beside this term nothing is left")

    monkeypatch.setattr(run_module, "leave_one_out", broken)
    with pytest.raises(ZeroDivisionError):
        run(imported(tmp_path, False), tmp_path / "report", leaving_out=True)
    assert json.loads((tmp_path / "report" / "report.json").read_text(encoding="utf-8"))["verdict"]
    assert (tmp_path / "report" / "report.html").is_file()
    assert (tmp_path / "report" / "model.json").is_file()
