"""The next experiment: a campaign whose points tell the remaining explanations of a finding apart."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bench.mismatch.dataset import Dataset
from bench.mismatch.findings import Finding

_STEADY = ("te.lost_motion", "te.hysteresis", "te.stiffness_nonlinear", "sensor.torque_hysteresis")
_SPEED = ("friction.stribeck", "friction.viscous_quadratic", "te.velocity_nonlinear")


def propose(finding: Finding, out: Path, number: int, data: Dataset) -> None:
    """Write ``next-<number>.toml`` and put it into the finding.

    The rule follows what tells the rivals apart: path dependence by torque staircases up and down and reversals; laws
    of speed by slow and fast points; time against temperature by repeating warm points after a cooling.
    """
    rivals = {finding.effect, *(a["effect"] for a in finding.alternatives)}
    variables = finding.location.text
    largest, fastest = _bounds(data)
    stages: list[dict[str, Any]] = []
    points: list[dict[str, Any]] = []
    if rivals & set(_STEADY):
        why = "a torque staircase up and down, reversals under preload: path dependence shows, a function of torque not"
        stages.append(
            {"sequence": "torque_ramp", "torques": [largest], "speeds": [5.0], "options": '{ steps = 5, hold = "2 s" }'}
        )
        stages.append(
            {
                "sequence": "reversal",
                "torques": [0.0, 0.5 * largest],
                "speeds": [2.5],
                "options": '{ amplitude = "10 deg", cycles = 3 }',
            }
        )
        points += [{"kind": "torque_ramp", "load_torque": largest, "velocity": float(np.radians(5.0))}]
        points += [{"kind": "reversal", "load_torque": 0.5 * largest, "velocity": float(np.radians(2.5))}]
    elif rivals & set(_SPEED) or "deg/s" in variables:
        why = "slow and fast points close together: the laws of speed part below a tenth of the fastest speed"
        speeds = [float(np.degrees(fastest) * s) for s in (0.1, 0.2, 0.5, 1.0)]
        stages.append({"sequence": "constant_velocity", "torques": [0.0], "speeds": speeds, "options": None})
        points += [{"kind": "constant_velocity", "load_torque": 0.0, "velocity": float(np.radians(v))} for v in speeds]
    else:
        why = "the same points warm, after cooling, and warm again: time goes on, the temperature comes back"
        stages.append(
            {
                "sequence": "constant_velocity",
                "torques": [0.0, 0.5 * largest],
                "speeds": [5.0, -5.0],
                "options": None,
                "temperatures": [35.0, 45.0],
            }
        )
        stages.append({"sequence": "cooling", "temperatures": [32.0]})
        stages.append(
            {
                "sequence": "constant_velocity",
                "torques": [0.0, 0.5 * largest],
                "speeds": [5.0, -5.0],
                "options": None,
                "temperatures": [35.0, 45.0],
            }
        )
        points += [
            {"kind": "constant_velocity", "load_torque": t, "velocity": float(np.radians(5.0)), "temperature": 35.0}
            for t in (0.0, 0.5 * largest)
        ]
    out.mkdir(parents=True, exist_ok=True)
    name = f"next-{number}.toml"
    (out / name).write_text(_toml(finding, number, stages), encoding="utf-8")
    finding.next_experiment = {"why": why, "file": name, "points": points}


def _bounds(data: Dataset) -> tuple[float, float]:
    """Largest load torque and fastest steady speed of the recordings: the new points stay within what the bench has
    done.
    """
    setpoints = [m.recording.setpoint for m in data.members]
    torque = [abs(s.load_torque) for s in setpoints if np.isfinite(s.load_torque)]
    speed = [
        abs(s.velocity)
        for m, s in zip(data.members, setpoints, strict=True)
        if np.isfinite(s.velocity) and m.recording.kind != "heating"
    ]
    return round(max(torque, default=0.0)), max(speed, default=0.1)


def _toml(finding: Finding, number: int, stages: list[dict[str, Any]]) -> str:
    lines = [
        f"# Tells apart what the recordings could not: {finding.name}.",
        'format = "bench-campaign"',
        'format_version = "1.0"',
        f'name = "next-{number}"',
        f'title = "Next experiment {number}"',
    ]
    for k, stage in enumerate(stages):
        lines += ["", "[[stages]]", f'name = "step {k + 1}"', 'order = "listed"', "", "[[stages.points]]"]
        lines.append(f'sequence = "{stage["sequence"]}"')
        for key, unit, field in (
            ("speeds", "deg/s", "velocities"),
            ("torques", "N*m", "load_torques"),
            ("temperatures", "degC", "temperatures"),
        ):
            if stage.get(key):
                values = ", ".join(f'"{v:g} {unit}"' for v in stage[key])
                lines.append(f"{field} = [{values}]")
        if stage.get("options"):
            lines.append(f"options = {stage['options']}")
    return "\n".join(lines) + "\n"
