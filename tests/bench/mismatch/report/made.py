"""A comparison made by hand: a frame, a channel's rows, a discovery in them. All is known, nothing is analysed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from bench.mismatch.discovery import ChannelOutcome, Discovery, RefittedAlternative, Structure
from bench.mismatch.recordings.dataset import Dataset, Member
from bench.mismatch.recordings.motion import Manner
from bench.mismatch.recordings.prepared import Folder
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.report.candidates import Candidate, Range, frame_of
from bench.simulation.frame import Frame, concatenate
from bench.simulation.terms import LIBRARY

RATIO = 185.0
COVERED = Range(1000.0, 0.02, 0.17, 22.0, 40.0, 0.0, 0.0)
START = 1_800_000_000.0
HELD_OUT = (4, 9, 14, 19)
SPEEDS, TORQUES = (0.02, 0.06, 0.1, 0.17), (-1000.0, -300.0, 0.0, 400.0, 1000.0)


def campaign(each: int = 60, temperature: bool = True) -> Frame:
    """Twenty recordings: every speed at every torque, directions in turn, warmer and warmer."""
    parts = []
    points = [(v, t) for t in TORQUES for v in SPEEDS]
    for number, (speed, torque) in enumerate(points):
        side = 1.0 if (number + number // 4) % 2 == 0 else -1.0
        frame = frame_of(Candidate("constant_velocity", torque, side * speed), COVERED, RATIO)
        frame = frame.take(np.arange(each) % frame.size)
        elapsed = np.asarray(0.25 * np.arange(each), dtype=np.float64)
        warm = 22.0 + (0.9 * ((number * 7) % 20) if temperature else 0.0)
        parts.append(
            replace(
                frame,
                recording=np.full(each, number, dtype=np.int64),
                elapsed=elapsed,
                time=600.0 * number + elapsed,
                temperature=np.full(each, warm),
                theta=side * speed * elapsed,
                q=side * speed * elapsed,
                travel=2.0 * number + speed * elapsed,
                step=np.where(np.arange(each) > 0, 0.25, 0.0),
                count=np.full(each, 100.0),
            )
        )
    return concatenate(parts)


def revolutions(speeds: Sequence[float], torques: Sequence[float], each: int) -> Frame:
    """Recordings of one steady revolution of ``each`` rows: every speed at every torque, either way."""
    points = [(side * v, t) for t in torques for v in speeds for side in (1.0, -1.0)]
    few = campaign(each=1).take(np.zeros(len(points) * each, dtype=np.int64))
    speed, torque = (np.repeat([p[k] for p in points], each) for k in (0, 1))
    side, turned = np.sign(speed), np.tile(np.arange(each) * 2.0 * np.pi / each, len(points))
    return replace(
        few,
        recording=np.repeat(np.arange(len(points)), each),
        theta=turned * side,
        velocity=speed,
        direction=side,
        last_direction=side,
        torque=torque,
        torque_level=torque,
        temperature=np.full(few.size, 25.0),
        steady=np.ones(few.size),
        step=2.0 * np.pi / each / np.abs(speed),
        time=np.arange(few.size, dtype=np.float64),
        elapsed=turned / np.abs(speed),
    )


def dataset(
    frame: Frame, channel: str, rows: Rows, kinds: dict[int, str] | None = None, held: Any = HELD_OUT
) -> Dataset:
    """The data set of such recordings; those of ``held`` are held out."""
    members = []
    for number in range(int(frame.recording.max()) + 1):
        own = frame.recording == number
        setpoint = SimpleNamespace(
            load_torque=float(np.median(frame.torque[own])),
            velocity=float(np.median(frame.velocity[own])),
            temperature=float(np.median(frame.temperature[own])),
        )
        kind = (kinds or {}).get(number, "constant_velocity")
        recording: Any = SimpleNamespace(
            recording_id=f"r{number:02d}",
            kind=kind,
            specs={},
            channels=("load_torque", "temperature"),
            setpoint=setpoint,
            gearbox=SimpleNamespace(ratio=RATIO),
        )
        out = number in held
        members.append(Member(number, recording, (kind, 0.0, 0.0, 0.0), out, -1 if out else number, f"r{number:02d}"))
    folder = Folder(START, Manner(0.3, 0.06, 1000.0))
    return Dataset(members, [("bad.h5", "bad.h5 <ends> early")], folder, {channel: rows})


def discovery(channel: str, effect: str, added: Any, variables: tuple[str, ...], **more: Any) -> Discovery:
    """A discovery with plain words where nothing else is said."""
    values: dict[str, Any] = {
        "effect": effect,
        "status": "unknown" if effect == "unknown" else "named",
        "confidence": 0.9,
        "channel": channel,
        "words": "something <odd>",
        "equation": "tau_m += d*f_s*exp(-(abs(w_m)/w_s)**2)",
        "variables": variables,
        "parameters": ({"symbol": "f_s", "value": 0.4, "unit": "N*m", "std": 0.02},),
        "added": np.asarray(added, dtype=np.float64),
        "gain": 100.0,
        "p_value": 1e-3,
        "simulation_rows": (),
    }
    return Discovery(**(values | more))


def outcome(
    frame: Frame, channel: str, discoveries: list[Discovery], sigma: float = 0.02, held: Any = HELD_OUT
) -> ChannelOutcome:
    """A channel whose model leaves white noise of ``sigma`` a sample, 25 a row; one row in seven is not usable."""
    rng = np.random.default_rng(3)
    number = np.full(frame.size, 25.0)
    whole = np.sin(frame.time)
    rows = Rows(frame, whole + rng.normal(0.0, sigma / 5.0, frame.size), number)
    usable = np.arange(frame.size) % 7 != 3
    held_out = usable & np.isin(frame.recording, held)
    scores = {"as_given": None, "before": 3.0 * sigma, "after": sigma}
    some = bool(held_out.any())
    return ChannelOutcome(
        channel,
        rows,
        usable,
        held_out,
        whole,
        whole - sum((d.added for d in discoveries), np.zeros(frame.size)),
        0.9 * sigma,
        0.05 * sigma,
        "repeats",
        discoveries,
        Structure(0.3, "trees over everything recorded, 200 surrogates"),
        scores if some else dict.fromkeys(scores),
        {} if some else scores,
    )


def stribeck(frame: Frame) -> Any:
    """Stribeck friction: below some 8 rad/s of the motor."""
    form = LIBRARY["friction.stribeck"].forms["motor_torque"][0]
    return form.columns(frame, (8.0,))[:, 0] * 0.4


def alternative(effect: str, left: Any, as_good: bool = False) -> RefittedAlternative:
    """An alternative that predicts a little worse."""
    return RefittedAlternative(effect, f"the <alternative> {effect}", 5.0, 2.0, 0.04, as_good, left)


def write_nothing(path: Path) -> list[str]:
    """Names of the files in a folder."""
    return sorted(p.name for p in path.iterdir()) if path.exists() else []
