"""Identifications of campaigns, kept beside the folders of recordings: ``.identified/FOLDER/`` below their root.

What is kept is made of the recordings alone and can be thrown away. It is of one state of its folder: where recordings
came since, the campaign is identified anew. A campaign that cannot be identified is kept with the reason.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.errors import BenchError, ConfigurationError
from bench.identification import Identification, Options, identify_folder, to_simulation
from bench.identification.statistics.freedom import parameter_freedom
from bench.identification.validation import BOUND, mean_inputs
from bench.simulation import Parameter, Simulation
from bench.trend.friction import reference_friction
from bench.trend.quantities import Value
from bench.whole import write_whole

FOLDER = ".identified"
FORMAT = "bench-trend"
VERSION = 3
_TERMS = {"f_l": "friction.load_dependent", "R": "thermal.convection", "C": "thermal.loss_heating"}


@dataclass(frozen=True, slots=True)
class Identified:
    """What a campaign was identified with.

    ``model`` is None where it could not be, and ``why`` says why. ``measured`` has by direction least and most of τ
    N·m, |q̇| °/s and °C of its steady recordings; ``noise`` the RMS in rad beside all fitted orders, by direction;
    ``friction`` N·m by (°/s, °C).
    """

    folder: str
    model: Simulation | None
    why: str
    measured: dict[str, tuple[tuple[float, ...], tuple[float, ...]]]
    noise: dict[str, Value]
    friction: dict[tuple[float, float], Value]

    def parameter(self, symbol: str) -> Value | None:
        """A parameter of the model with its standard deviation, None where it has none."""
        if self.model is None:
            return None
        term = self.model.terms.get(_TERMS[symbol])
        found: Parameter | None = None if term is None else term.parameters.get(symbol)
        if term is None or found is None or not found.std:
            return None
        return Value(found.value, found.std, parameter_freedom(term, symbol))


def stamp_of(folder: Path) -> str:
    """Fingerprint of the recordings of a folder, which changes with them: their names, sizes and times of change."""
    seen = sorted((p.name, p.stat().st_size, p.stat().st_mtime_ns) for p in folder.iterdir() if p.suffix == ".h5")
    return hashlib.sha256(json.dumps(seen).encode()).hexdigest()


def keep(found: Identification, folder: Path, stamp: str) -> None:
    """Keep an identification of a folder that had ``stamp`` when it was begun.

    Raises
    ------
    OSError
        If there is no room for it beside the folder.
    """
    friction = reference_friction(found.reductions, found.gearbox.ratio)
    store(
        Identified(folder.name, to_simulation(found), "", _measured_ranges(found), _noise(found), friction),
        folder,
        stamp,
    )


def store(one: Identified, folder: Path, stamp: str) -> None:
    """Write what a folder was identified with, or why it could not be."""
    place = _folder_of(folder)
    place.mkdir(parents=True, exist_ok=True)
    if one.model is None:
        (place / "model.json").unlink(missing_ok=True)
    else:
        one.model.save(place / "model.json")
    entry = {
        "format": FORMAT,
        "version": VERSION,
        "folder": folder.name,
        "stamp": stamp,
        "measured": one.measured,
        "noise": {name: _row(value) for name, value in one.noise.items()},
        "friction": [[*at, *_row(value)] for at, value in one.friction.items()],
        "why": one.why,
    }
    write_whole(place / "trend.json", json.dumps(entry, indent=1, ensure_ascii=False, allow_nan=False))


def load(folder: Path) -> Identified | None:
    """Return what is kept of a folder as it is now; None where nothing is, or not of this state of it."""
    place = _folder_of(folder)
    try:
        entry = json.loads((place / "trend.json").read_text("utf-8"))
        if entry["format"] != FORMAT or entry["version"] != VERSION or entry["stamp"] != stamp_of(folder):
            return None
        model = None if entry["why"] else Simulation.load(place / "model.json")
        return Identified(
            folder.name,
            model,
            entry["why"],
            {name: (tuple(low), tuple(high)) for name, (low, high) in entry["measured"].items()},
            {name: _value(row) for name, row in entry["noise"].items()},
            {(row[0], row[1]): _value(row[2:]) for row in entry["friction"]},
        )
    except (OSError, ValueError, KeyError, TypeError, ConfigurationError):
        # absent or spoiled: it is made anew, nothing of it is anybody's
        return None


def identify(folder: Path, jobs: int = 1, progress: Callable[[int, int], None] | None = None) -> Identified:
    """Identify a folder of recordings, keep the result, and return it; where that is not possible, the reason."""
    stamp = stamp_of(folder)
    try:
        keep(identify_folder(folder, Options(jobs=jobs), progress), folder, stamp)
    except BenchError as error:
        store(Identified(folder.name, None, str(error), {}, {}, {}), folder, stamp)
    kept = load(folder)
    return kept or Identified(folder.name, None, "recordings came while it was identified", {}, {}, {})


def _folder_of(folder: Path) -> Path:
    return folder.absolute().parent / FOLDER / folder.name


def _row(value: Value) -> list[float | None]:
    return [value.value, value.std, value.freedom if math.isfinite(value.freedom) else None]


def _value(row: list[float | None]) -> Value:
    value, std, freedom = row
    if value is None or std is None:
        raise ValueError("a value without a standard deviation")
    return Value(float(value), float(std), math.inf if freedom is None else float(freedom))


def _steady(found: Identification) -> dict[str, list[tuple[str, tuple[float, float, float]]]]:
    """Recordings that were fitted, by direction: name and mean inputs."""
    out: dict[str, list[tuple[str, tuple[float, float, float]]]] = {}
    for r in found.reductions:
        if r.steady is not None and not r.validation:
            name = "positive" if r.steady.window.direction > 0 else "negative"
            out.setdefault(name, []).append((r.recording_id, mean_inputs(r.steady)))
    return out


def _measured_ranges(found: Identification) -> dict[str, tuple[tuple[float, ...], tuple[float, ...]]]:
    out = {}
    for name, rows in _steady(found).items():
        inputs = np.array([[torque, np.degrees(abs(rate)), heat] for _, (torque, rate, heat) in rows])
        if np.isfinite(inputs).all():
            out[name] = tuple(inputs.min(axis=0).tolist()), tuple(inputs.max(axis=0).tolist())
    return out


def _noise(found: Identification) -> dict[str, Value]:
    """What a series of the chosen orders leaves of each recording itself: mean, and its own error over recordings."""
    out = {}
    for name, sign in (("positive", 1), ("negative", -1)):
        rows = [s.rmse[BOUND] for s in found.scores if s.kind != "validation" and s.direction == sign]
        if len(rows) > 2:
            spread = float(np.std(rows, ddof=1)) / math.sqrt(len(rows))
            out[name] = Value(float(np.mean(rows)), spread, len(rows) - 1.0)
    return out
