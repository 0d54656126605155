"""One valid file of each kind, to be spoiled."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import UTC, datetime
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.campaigns import load_campaign
from bench.campaigns.records.journal import Journal
from bench.campaigns.taken import Status, Taken
from bench.configuration import load_bench
from bench.recording import (
    ChannelSpec,
    Event,
    Gearbox,
    RecordingHeader,
    RecordingWriter,
    Segment,
    Setpoint,
    write_recording,
)
from bench.simulation import FourierSet, Parameter, Simulation, Term, TransmissionErrorModel

RATE = 2000.0
ROWS = 3000
TAKES = 3

SPECS = (
    ChannelSpec.of("time", dtype="int64", scale=1 / RATE),
    ChannelSpec.of("motor_angle", scale=2 * math.pi / 8192, origin="input_drive/0x6064"),
    ChannelSpec.of("load_angle", scale=2 * math.pi / (1 << 25), origin="load_drive/0x6064"),
    ChannelSpec.of("motor_velocity", scale=1e-3),
    ChannelSpec.of("motor_torque", scale=0.0175),
    ChannelSpec.of("load_torque", scale=10000 / 32768, offset=1.5),
    ChannelSpec.of("load_motor_torque", scale=3.3),
    ChannelSpec.of("temperature", scale=0.1),
    ChannelSpec.of("cycle"),
)

MAPPING = """
campaign_id = "elsewhere"
kind = "free"
sample_rate = 2000.0
started_at = 2026-01-01T00:00:00Z

[gearbox]
ratio = 185.0

[channels.time]
variable = "t"
unit = "s"

[channels.load_angle]
variable = "q"
unit = "deg"
scale = 1.5

[[segments]]
name = "steady"
start = 0
stop = 1000

[[recordings]]
file = "a.csv"
recording_id = "a"
"""


def make(folder: Path) -> dict[str, Path]:
    """Write a valid file of each kind into ``folder``; by kind."""
    bench = resources.files("bench.configuration") / "benches" / "rh380n.toml"
    campaign = resources.files("bench.campaigns") / "library" / "quick.toml"
    texts = {"bench": bench.read_text("utf-8"), "campaign": campaign.read_text("utf-8"), "mapping": MAPPING}
    for name, text in texts.items():
        (folder / f"{name}.toml").write_text(text, "utf-8")
    return {
        "h5": recording(folder / "a.h5"),
        "part": part(folder / "b.h5"),
        "model": model(folder / "model.json"),
        **{name: folder / f"{name}.toml" for name in texts},
        "journal": journal(folder / "campaign"),
    }


def _header(name: str, config: str = "[bench]\nname = 'sample'\n") -> RecordingHeader:
    return RecordingHeader(
        name,
        "c1",
        "constant_velocity",
        datetime(2026, 11, 21, 9, tzinfo=UTC),
        RATE,
        "emulator",
        Setpoint(500.0, 12.6, 30.0),
        Gearbox(185.0, 24, 96, 45, 46),
        point_id="p001",
        take=1,
        zero_id="zero-1",
        config=config,
        software={"name": "gearbench", "version": "0", "revision": "abc"},
    )


def columns(start: int, stop: int) -> dict[str, NDArray[Any]]:
    """Rows of a recording that turns twice a second."""
    rows = np.arange(start, stop, dtype=np.int64)
    noise = np.random.default_rng(7).integers(-40, 41, ROWS)[start:stop]
    load = rows * (2 << 25) // int(RATE)
    return {
        "time": rows,
        "motor_angle": load * 185 // (1 << 12),
        "load_angle": load + noise,
        "motor_velocity": (2_324_000 + noise).astype(np.int32),
        "motor_torque": (300 + noise).astype(np.int16),
        "load_torque": (1600 + 3 * noise).astype(np.int16),
        "load_motor_torque": (150 + noise // 4).astype(np.int16),
        "temperature": (300 + rows // 1000).astype(np.int16),
        "cycle": rows + 12345,
    }


def recording(path: Path) -> Path:
    """A finished recording."""
    data = columns(0, ROWS)
    write_recording(
        path,
        _header(path.stem),
        {spec.name: (data[spec.name], spec) for spec in SPECS},
        [Segment("ramp_up", 0, 100), Segment("steady", 100, ROWS)],
        [Event(0.5, "info", "lubricant topped up")],
        accepted=True,
        quality={"travel": {"passed": True}},
    )
    return path


def part(path: Path) -> Path:
    """A recording as a kill in real time leaves it: whole chunks, and one in the making, stored as it is."""
    writer = RecordingWriter(path, _header(path.stem), SPECS)
    writer.begin_segment("steady")
    for start in range(0, ROWS, 250):
        writer.append(columns(start, start + 250))
    writer.abandon()
    return writer.part


def model(path: Path) -> Path:
    """A simulation file with a series and with terms that have parameters."""
    rng = np.random.default_rng(1)
    sets = [
        FourierSet(np.array([1.0, 46.0]), rng.normal(size=(2, 10)), rng.normal(size=(2, 10)), rng.normal(size=10))
        for _ in range(2)
    ]
    simulation = Simulation.nominal().with_transmission_error(TransmissionErrorModel(*sets))
    simulation = simulation.with_term(Term("friction.coulomb", parameters={"f_c": Parameter(0.5, "N*m", 0.01)}))
    simulation = simulation.with_term(Term("friction.viscous", parameters={"f_v": Parameter(0.002, "N*m*s/rad", 1e-4)}))
    simulation.save(path)
    return path


def taken(number: int) -> Taken:
    """A take that passed."""
    setpoint = {"load_torque": 0.0, "velocity": 0.1, "temperature": None}
    name = f"000{number}-dwell"
    return Taken(name, f"{name}.h5", "dwell", "a dwell", setpoint, f"p{number}", 1, Status.PENDING)


def journal(folder: Path) -> Path:
    """A campaign folder with its journal and recordings."""
    folder.mkdir()
    with Journal(folder, load_campaign("quick"), load_bench("rh380n")) as written:
        for number in range(1, TAKES + 1):
            one = taken(number)
            written.begin(one)
            recording(folder / one.file)
            written.end(replace(one, status=Status.DONE, samples=ROWS))
    return folder / "journal.sqlite"
