"""Rows of a folder for the peers: a few hundred samples of each recording with everything a regressor could need."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from bench.recording import Recording, RecordingFolder

Floats = NDArray[np.float64]

_ROWS_A_RECORDING = 1200
_REVERSAL = 75  # samples about a change of direction where the sign itself is in doubt
_STANDSTILL = 0.002  # rad/s at the load side, of a filtered velocity
PLAY_WIDTHS = (60.0, 150.0, 300.0)
DAHL_LENGTHS = (0.005, 0.02)
LAGS_S = (15.0, 60.0, 240.0)


@dataclass(frozen=True, slots=True)
class Rows:
    """Samples (M,) of a whole folder by name, and which recording each comes from.

    Names: ``te`` rad, ``theta`` rad, ``rate``, ``motor_rate`` rad/s, ``sign``, ``side``, ``acceleration`` rad/s²,
    ``torque``, ``torque_rate``, ``sensor``, ``motor_torque``, ``load_motor_torque`` N·m, ``temperature`` °C, ``hours``,
    ``travel`` rad, ``energy`` J, ``degree_seconds`` and ``elapsed`` s since the recording's start, play, Dahl and lag
    states. ``within`` marks samples in motion within the bounds of the simulation's polynomials, ``settled`` those
    away from any change of direction.
    """

    values: dict[str, Floats]
    recording: NDArray[np.int64]
    within: NDArray[np.bool_]
    settled: NDArray[np.bool_]
    names: tuple[str, ...] = ()

    def where(self, use: NDArray[np.bool_]) -> Rows:
        """Some of the rows."""
        return Rows(
            {k: v[use] for k, v in self.values.items()},
            self.recording[use],
            self.within[use],
            self.settled[use],
            self.names,
        )

    def __getitem__(self, name: str) -> Floats:
        """The samples of one quantity."""
        return self.values[name]


def read_rows(folder: Path, seed: int = 0) -> Rows:
    """Sample every usable recording of a folder."""
    rng = np.random.default_rng(seed)
    parts: list[dict[str, Floats]] = []
    owners: list[NDArray[np.int64]] = []
    names_of: list[str] = []
    within: list[NDArray[np.bool_]] = []
    settled: list[NDArray[np.bool_]] = []
    first = None
    travel = 0.0
    for index, recording in enumerate(RecordingFolder.open(folder).recordings):
        first = first or recording.started_at
        hours = (recording.started_at - first).total_seconds() / 3600.0
        whole = _whole(recording, hours, travel)
        travel = float(whole["travel"][-1])
        size = whole["time"].size
        chosen = np.sort(rng.choice(size, min(_ROWS_A_RECORDING, size), replace=False))
        parts.append({name: values[chosen] for name, values in whole.items()})
        parts[-1]["weight"] = np.full(chosen.size, size / chosen.size)
        names_of.append(recording.recording_id)
        owners.append(np.full(chosen.size, index))
        bounded = recording.kind not in ("heating", "cooling", "dwell")
        within.append((parts[-1]["sign"] != 0.0) & bounded)
        reversing = np.abs(np.gradient(whole["sign"])) > 0.0
        settled.append(uniform_filter1d(reversing.astype(np.float64), _REVERSAL)[chosen] < 1e-9)
    names = parts[0]
    values = {name: np.concatenate([part[name] for part in parts]) for name in names}
    return Rows(values, np.concatenate(owners), np.concatenate(within), np.concatenate(settled), tuple(names_of))


def _whole(recording: Recording, hours: float, travel: float) -> dict[str, Floats]:
    wanted = ("time", "motor_angle", "load_angle", "motor_torque", "load_torque", "load_motor_torque", "temperature")
    read: Mapping[str, Floats] = {name: recording.si(name) for name in wanted}
    ratio = recording.gearbox.ratio or 1.0
    time, theta = read["time"], read["motor_angle"] / ratio
    step = 1.0 / recording.sample_rate
    rate = uniform_filter1d(np.gradient(theta, step), 21)
    torque = uniform_filter1d(read["load_torque"], 7)
    sign = np.where(np.abs(rate) > _STANDSTILL, np.sign(rate), 0.0)
    motor_torque = read["motor_torque"]
    power = np.abs(motor_torque * rate * ratio - torque * rate)
    lagged = {f"lag_{lag:g}": _lag(power, step / lag) for lag in LAGS_S}
    return {
        "time": time,
        "te": read["load_angle"] - theta,
        "theta": theta,
        "rate": rate,
        "motor_rate": rate * ratio,
        "sign": sign,
        "side": _last(sign),
        "acceleration": uniform_filter1d(np.gradient(rate, step), 21),
        "torque": torque,
        "torque_rate": np.gradient(torque, step),
        "sensor": read["load_torque"],
        "motor_torque": motor_torque,
        "load_motor_torque": read["load_motor_torque"],
        "temperature": read["temperature"],
        "hours": hours + time / 3600.0,
        "elapsed": time,
        "travel": travel + np.cumsum(np.abs(rate)) * step,
        "energy": np.cumsum(power) * step,
        "degree_seconds": np.cumsum(uniform_filter1d(read["temperature"], 501)) * step,
        "fan_degree_seconds": np.cumsum(np.abs(rate) * (read["temperature"] - 20.0)) * step,
        **{f"play_{w:g}": _play(torque, w) for w in PLAY_WIDTHS},
        **{f"dahl_{x:g}": _dahl(theta, x) for x in DAHL_LENGTHS},
        **lagged,
    }


@njit(cache=True)
def _play(drive: Floats, half: float) -> Floats:
    out = np.empty(drive.size)
    z = 0.0
    for n in range(drive.size):
        z = min(max(z, drive[n] - half), drive[n] + half)
        out[n] = (drive[n] - z) / half
    return out


@njit(cache=True)
def _dahl(drive: Floats, length: float) -> Floats:
    out = np.empty(drive.size)
    z = 0.0
    last = drive[0]
    for n in range(drive.size):
        move = drive[n] - last
        last = drive[n]
        goal = 1.0 if move > 0.0 else -1.0
        z = goal + (z - goal) * np.exp(-abs(move) / length)
        out[n] = z
    return out


@njit(cache=True)
def _lag(drive: Floats, share: float) -> Floats:
    out = np.empty(drive.size)
    z = 0.0
    for n in range(drive.size):
        z += share * (drive[n] - z)
        out[n] = z / share
    return out


@njit(cache=True)
def _last(sign: Floats) -> Floats:
    out = np.empty(sign.size)
    z = 1.0
    for n in range(sign.size):
        if sign[n] != 0.0:
            z = sign[n]
        out[n] = z
    return out
