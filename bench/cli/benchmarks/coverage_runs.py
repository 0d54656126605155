"""Short campaigns on the emulated bench, one after the other, each in a process of its own and each resumable."""

from __future__ import annotations

import random
import subprocess
import sys
from pathlib import Path

from bench.errors import BenchError

_COMMAND = (sys.executable, "-c", "from bench.cli import main; main()")
_DONE = "finished"
_TEXT = """format = "bench-campaign"
format_version = "1.0"
name = "coverage-{seed}"
title = "Short campaign {seed} for coverage"

[[stages]]
name = "points"
order = "temperature"

[[stages.points]]
sequence = "constant_velocity"
load_torques = [{torques}]
velocities = [{velocities}]
temperatures = ["as found", {temperatures}]
"""
#: Ranges from which each campaign draws its levels, so that no two share the encoder's counting at the same speeds:
#: shares of the load motor's rated torque, deg/s, °C.
TORQUES = ((-0.55, -0.43), (-0.09, 0.09), (0.43, 0.55))
SPEEDS = ((5.7, 6.3), (7.6, 8.4), (9.5, 10.4))
TEMPERATURES = ((28.5, 30.0), (36.0, 38.0))


def campaign_text(seed: int, rated_torque: float) -> str:
    """A campaign of 54 points: 3 torques × 3 speeds, both ways × 3 temperatures, levels drawn with ``seed``.

    ``rated_torque`` is the load motor's in N·m.
    """
    draw = random.Random(seed)

    def levels(ranges: tuple[tuple[float, float], ...], digits: int) -> list[float]:
        return [round(draw.uniform(*bounds), digits) for bounds in ranges]

    speeds, temperatures = levels(SPEEDS, 3), levels(TEMPERATURES, 1)
    torques = [round(rated_torque * share, 1) for share in levels(TORQUES, 4)]
    return _TEXT.format(
        seed=seed,
        torques=", ".join(f'"{t} N*m"' for t in torques),
        velocities=", ".join(f'"{sign * v} deg/s"' for v in speeds for sign in (1, -1)),
        temperatures=", ".join(f'"{t} degC"' for t in temperatures),
    )


def recordings(seed: int, work: Path, bench: str, rated_torque: float) -> Path:
    """Folder of campaign ``seed`` below ``work``; runs it, or goes on with it, unless it is finished.

    ``rated_torque`` is the load motor's in N·m.

    Raises
    ------
    BenchError
        The campaign does not come to its end; with what it said.
    """
    folder = work / f"campaign-{seed:03d}"
    mark = folder / _DONE
    if mark.exists():
        return folder
    work.mkdir(parents=True, exist_ok=True)
    plan = work / f"campaign-{seed:03d}.toml"
    plan.write_text(campaign_text(seed, rated_torque), "utf-8")
    arguments = ["run", str(plan), "--bench", bench, "--seed", str(seed), "--out", str(folder), "--json"]
    done = subprocess.run([*_COMMAND, *arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise BenchError(f"Campaign {seed} ended with exit code {done.returncode}: {done.stderr.strip()}")
    mark.write_text("", "utf-8")
    return folder
