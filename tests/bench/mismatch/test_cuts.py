"""The answer is the machine's, not the cut's: one recording cut in five ways, from import to report."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from bench.importing import Imported
from bench.mismatch.run import run
from tests.bench.importing import builders

SECONDS, RATE = 90.0, 50.0
DRAG, NOISE = 0.12, 0.02
"""N·m a bar; N·m"""
CHANNELS = 'motor_angle = {variable = "q", unit = "rad"}\nmotor_torque = {variable = "M", unit = "N*m"}'
UNEVEN = (0.0, 8.0, 21.0, 28.0, 40.0, 47.0, 60.0, 66.0, 79.0, 90.0)
CUTS = {
    "left to the analysis": {},
    "pieces of 6 s": {"top": "pieces = {seconds = 6}"},
    "pieces of 11 s": {"top": "pieces = {seconds = 11}"},
    "pieces of 30 revolutions": {"top": "pieces = {revolutions = 30}"},
    "cuts by hand": {
        "entry": "\n".join(
            [f"start_s = {UNEVEN[0]}\nstop_s = {UNEVEN[1]}"]
            + [
                f'[[recordings]]\nfile = "a.csv"\nrecording_id = "a-{k}"\nstart_s = {a}\nstop_s = {b}'
                for k, (a, b) in enumerate(pairwise(UNEVEN[1:]), 1)
            ]
        )
    },
}


def machine(path: Path) -> None:
    """Inertia, dry and viscous friction, and a drag that grows with an oil pressure no simulation knows."""
    rng = np.random.default_rng(14)
    time = np.arange(int(SECONDS * RATE)) / RATE
    corners = np.arange(0.0, SECONDS + 1.0, 3.0)
    speed = np.interp(time, corners, rng.uniform(-90.0, 90.0, corners.size))
    angle = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) / RATE)))
    pressure = 3.0 + 0.9 * np.sin(2 * np.pi * time / 23.0) + 0.4 * np.sin(2 * np.pi * time / 7.7)
    torque = 1.5e-3 * np.gradient(speed, time) + 0.35 * np.sign(speed) + 2.5e-3 * speed
    torque += DRAG * (pressure - 3.0) * np.sign(speed) + rng.normal(0.0, NOISE, time.size)
    builders.csv(path, t=np.round(time, 6), q=angle, M=torque, p=pressure)


@pytest.mark.parametrize("how", CUTS)
def test_the_same_recording_gives_the_same_answer_however_it_is_cut(tmp_path: Path, how: str) -> None:
    machine(tmp_path / "a.csv")
    done = builders.run(tmp_path, CHANNELS, aux='pressure = {variable = "p", unit = "bar"}', **CUTS[how])
    assert all(isinstance(item, Imported) for item in done), done
    report = run(tmp_path / "out", tmp_path / "report")
    assert report.verdict == "mismatch"
    assert [(f.effect, f.name) for f in report.findings] == [("unknown", "something that depends on aux/pressure")]
    (finding,) = report.findings
    (outcome,) = report.outcomes
    assert outcome.rmse["after"] == pytest.approx(NOISE, rel=0.1)
    # a steady speed is not in it
    least = rf"effects below {0.15 * outcome.floor:.2g} N\*m where they act .* nor orders above \d+ per output"
    assert any(re.search(least, note) for note in outcome.notes)
    # what it adds is the drag, whatever part of it the dry friction takes
    frame = outcome.rows.frame
    pressure = frame.aux["pressure"] / 1e5
    moving = outcome.usable & (np.abs(frame.omega) > 5.0)
    slope = np.polyfit(pressure[moving], finding.discovery.added[moving] * frame.direction[moving], 1)[0]
    assert slope == pytest.approx(DRAG, rel=0.05)
