"""Make the folders of an exam: recordings where the analyser looks, the sealed truth where it does not."""

from __future__ import annotations

import json
import shutil
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from bench.errors import ProofError
from bench.proof.seal import TRUTHS, seal_of, write_truth
from bench.recording import write_recording
from bench.recording.header import ChannelSpec, Event, Gearbox, RecordingHeader, Segment, Setpoint

ENTRY_POINT_GROUP = "bench.concealed"
RECORDINGS, SIMULATIONS = "recordings", "simulation"


def load_examiner() -> Any:
    """The first generator found under the entry point group ``bench.concealed``.

    Raises
    ------
    ProofError
        No generator is installed.
    """
    for point in entry_points(group=ENTRY_POINT_GROUP):
        return point.load()
    raise ProofError(
        f"no generator of concealed cases is installed: the entry point group {ENTRY_POINT_GROUP} is empty."
    )


def list_cases(
    examiner: Any, groups: list[str], seed: int, count: int | None, held_back: bool, clutter: bool = False
) -> list[Any]:
    """Cases of the groups in order; ``count`` limits each group; ``clutter`` adds weak orders to every bench."""
    known = tuple(examiner.GROUPS)
    unknown = [group for group in groups if group not in known]
    if unknown:
        raise ProofError(f"there is no set {unknown[0]!r}; the sets are {', '.join(known)}.")
    return [case for group in groups for case in examiner.cases(group, seed, count, held_back, clutter)]


def make_case(examiner: Any, case: Any, out: Path) -> Path:
    """Make one folder unless it is already sealed; returns the path of its truth.

    ``out/recordings/<alias>`` holds the recordings and nothing else, ``out/truth/<case>.json`` the truth, beside it its
    SHA-256; ``out/simulation/<alias>.json`` is the simulation the analyser is given, where terms are switched off. The
    alias, the campaign's id and those of the recordings say nothing of the case.
    """
    folder, truth_path = out / RECORDINGS / case.alias, out / TRUTHS / f"{case.name}.json"
    if truth_path.exists() and seal_of(truth_path) is not None:
        return truth_path
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    opened = examiner.open_folder(case)
    for recording in opened.recordings():
        write_generated(folder, case.alias, recording)
    truth = opened.truth().to_dict()
    if truth["switched_off"]:
        _write_simulation(out / SIMULATIONS / f"{case.alias}.json", truth["switched_off"])
    write_truth(truth_path, truth)
    return truth_path


def simulation_for(out: Path, folder: str) -> Path | None:
    """The simulation file that a folder of recordings comes with, if any."""
    path = out / SIMULATIONS / f"{folder}.json"
    return path if path.exists() else None


def _write_simulation(path: Path, switched_off: list[str]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    gearbox = {"ratio": 185.0, "z1": 24, "z2": 96, "z3": 45, "z4": 46}
    terms = [{"effect": term, "enabled": False} for term in switched_off]
    content = {"format": "bench-simulation", "format_version": "1.0", "gearbox": gearbox, "terms": terms}
    path.write_text(json.dumps(content, indent=1))


def write_generated(folder: Path, campaign: str, recording: Any) -> None:
    """Write one generated recording of a campaign into a folder."""
    torque, velocity, temperature = recording.setpoint
    header = RecordingHeader(
        recording_id=recording.name,
        campaign_id=campaign,
        kind=recording.kind,
        started_at=recording.started_at,
        sample_rate=recording.rate_hz,
        source="emulator",
        setpoint=Setpoint(torque, velocity, temperature),
        gearbox=Gearbox(185.0, 24, 96, 45, 46),
        zero_id="zero-1",
        software={"name": "bench"},
    )
    channels = {}
    for name, channel in recording.channels.items():
        raw = np.asarray(channel.raw)
        channels[name] = (raw, ChannelSpec.of(name, dtype=str(raw.dtype), scale=channel.scale))
    path = folder / f"{recording.name}.h5"
    ends = recording.channels["time"].raw.size
    segments = [Segment(name, start, ends if stop < 0 else stop) for name, start, stop in recording.segments]
    write_recording(path, header, channels, segments, [Event(*event) for event in recording.events])
    if not recording.complete:
        _cut(path, recording.segments)


def _cut(path: Path, segments: tuple[tuple[str, int, int], ...]) -> None:
    """Leave the file as a power cut would: ``complete`` false and the last segment open."""
    with h5py.File(path, "r+") as file:
        file.attrs["complete"] = False
        file["segments/stop"][...] = np.array([stop for _name, _start, stop in segments], dtype=np.int64)
