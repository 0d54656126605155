"""Taring by hand: the torque sensor is read at rest, without voltage on the drives; the measured zero is reported."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from bench.commissioning.torque_zero import torque_zero
from bench.configuration import BenchFile
from bench.cycle.rig import Rig
from bench.errors import DeviceError
from bench.safety.acts import latch_of

TARE_S = 2.0
"""So long the sensor is read."""


def tare(file: BenchFile, folder: Path, stopped: Callable[[], bool], *, seed: int = 0) -> dict[str, Any]:
    """Return the end of a taring as a message: zero and standard deviation in N·m, readings, s; gives no torque.

    ``folder`` is where an emulated bench keeps its latch; ``stopped`` is asked at every block of cycles.

    Raises
    ------
    DeviceError
        If a drive has voltage, the motor turns, or what the sensor reads is no zero.
    """
    bench = file.configuration
    counts: list[np.ndarray[Any, np.dtype[np.int16]]] = []
    with Rig(file, seed=seed, real_time=True, latch=latch_of(file, folder)) as rig:
        block_s = rig.link.assembly.block * bench.bus.cycle_time
        for _ in range(max(1, round(TARE_S / block_s))):
            if stopped():
                return {"kind": "interrupted", "cause": "OPERATOR", "text": "stopped before the sensor was tared"}
            seen = rig.link.hold(block_s)
            _require_rest(rig, float(np.abs(seen.inputs.motor_velocity).max()))
            counts.append(seen.raw["load_torque"].copy())
        terminal = rig.link.assembly.torque_terminal
        found = torque_zero(bench, terminal.volt_per_count, np.concatenate(counts))
    text = (
        f"the unloaded torque sensor reads {found.zero:+.3g} N·m (standard deviation {found.deviation:.2g} N·m"
        f" of {found.readings} readings in {TARE_S:g} s)"
    )
    return {"kind": "finished", "cause": "NONE", "text": text, "tare": asdict(found)}


def _require_rest(rig: Rig, speed: float) -> None:
    powered = [role for role, state in rig.drive_states.items() if state == "OPERATION_ENABLED"]
    if powered:
        raise DeviceError(f"taring needs drives without voltage, and {powered[0].replace('_', ' ')} has it")
    if speed > rig.bench.motion.standstill * rig.bench.gearbox.ratio:
        raise DeviceError(f"taring needs the bench at rest, and the motor turns at {speed:.3g} rad/s")
