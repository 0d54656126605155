"""One pass over a recording: everything identification needs of it, in a few hundred kilobytes.

The steady window is reduced to sums over angle (:mod:`.sums`) in a few blocks of time each, so that torque and
temperature may change within a recording; the whole recording to blocks of 50 ms; the paper's method to its harmonics.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.identification.samples.band_limited import band_limited_rows
from bench.identification.samples.blocks import Blocks, make_blocks
from bench.identification.samples.paper_harmonics import Harmonics, paper_harmonics
from bench.identification.samples.rounding import rounded_twice, with_single_rounding
from bench.identification.samples.rows import Rows
from bench.identification.samples.spikes import spikes
from bench.identification.samples.steady import ReductionOptions, SteadySums, steady_sums
from bench.identification.samples.thermometer import beyond_pt100
from bench.identification.samples.windows import lost_cycles, steady_window
from bench.recording import Recording
from bench.recording.times import not_increasing

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

CHANNELS = (
    "time",
    "motor_angle",
    "load_angle",
    "motor_torque",
    "load_torque",
    "load_motor_torque",
    "temperature",
    "ambient_temperature",
)
THERMOMETERS = ("temperature", "ambient_temperature")
MAX_BAD_SHARE = 0.05


@dataclass(frozen=True, slots=True)
class Reduction:
    """What one recording contributes; ``steady`` and ``paper`` are None where its transmission error cannot be used.

    ``linear`` is True for an axis in m and N; ``limited`` holds band-limited rows, for recordings from elsewhere.
    ``load_count`` is one count of the load's encoder in rad, infinite where it is not known.
    """

    recording_id: str
    kind: str
    ratio: float
    started: float
    setpoint: tuple[float, float, float]
    linear: bool
    blocks: Blocks
    limited: Rows | None
    steady: SteadySums | None
    paper: Harmonics | None
    sentences: tuple[str, ...]
    load_count: float = float("inf")

    @property
    def validation(self) -> bool:
        """Whether the recording is kept from every fit, to be scored."""
        return self.kind == "validation"


def _repaired(
    recording: Recording, channels: dict[str, FloatArray], sentences: list[str]
) -> tuple[dict[str, FloatArray], NDArray[np.bool_]]:
    """Drop channels without numbers, or of an open thermometer, in too many samples; else bridge and mark these."""
    kept: dict[str, FloatArray] = {}
    bad_rows = np.zeros(channels["time"].size, dtype=bool)
    for name, values in channels.items():
        bad, is_so = ~np.isfinite(values), "is not a number"
        if name in THERMOMETERS and (open_ := beyond_pt100(values)).any():
            bad, is_so = bad | open_, "is at an end of a PT100's range (circuit open or shorted) or not a number"
        if not bad.any():
            kept[name] = values
            continue
        first = int(np.argmax(bad))
        if bad.mean() > MAX_BAD_SHARE:
            sentences.append(
                f"{recording.recording_id}: channel '{name}' {is_so} in {100 * bad.mean():.1f} % of its "
                f"samples (first at {first}); the channel is not used."
            )
            continue
        sentences.append(
            f"{recording.recording_id}: channel '{name}' {is_so} in {int(bad.sum())} samples "
            f"(first at {first}); those rows are left out."
        )
        rows = np.arange(values.size)
        kept[name] = np.interp(rows, rows[~bad], values[~bad])
        bad_rows |= bad
    return kept, bad_rows


def _read(
    recording: Recording, sentences: list[str], torque_step: float | None = None
) -> tuple[dict[str, FloatArray], NDArray[np.int64]]:
    names = [name for name in CHANNELS if name in recording.specs]
    for angle, velocity in (("motor_angle", "motor_velocity"), ("load_angle", "load_velocity")):
        if angle not in recording.specs and velocity in recording.specs:
            names.append(velocity)
    twice = torque_step is not None and rounded_twice(recording.specs.get("motor_torque"), torque_step)
    channels = recording.read_si([name for name in names if not (twice and name == "motor_torque")])
    if twice and torque_step is not None:
        channels["motor_torque"] = with_single_rounding(
            recording.raw("motor_torque"), recording.specs["motor_torque"], torque_step
        )
    if (problem := not_increasing(channels["time"])) is not None:
        raise RecordingError(f"{recording.recording_id}: time {problem}")
    gaps = np.empty(0, dtype=np.int64)
    if "cycle" in recording.specs:
        gaps, lost = lost_cycles(recording.raw("cycle").astype(np.int64))
        if lost:
            sentences.append(
                f"{recording.recording_id}: 'cycle' steps over {lost} lost cycles in {gaps.size} places (first before "
                f"sample {int(gaps[0])}); the samples that are there are used."
            )
    return channels, gaps


def _steady_mask(recording: Recording, size: int) -> NDArray[np.bool_]:
    mask = np.zeros(size, dtype=bool)
    for part in recording.steady():
        mask[part] = True
    return mask


def _count(recording: Recording, channel: str) -> float:
    """One count of an encoder's channel; infinite where the channel is not of whole numbers."""
    spec = recording.specs.get(channel)
    return abs(spec.scale) if spec is not None and np.issubdtype(np.dtype(spec.dtype), np.integer) else float("inf")


def _transmission(
    recording: Recording,
    channels: dict[str, FloatArray],
    bad_rows: NDArray[np.bool_],
    ratio: float,
    options: ReductionOptions,
    sentences: list[str],
) -> tuple[SteadySums | None, Harmonics | None]:
    name = recording.recording_id
    missing = [c for c in ("motor_angle", "load_angle") if c not in channels]
    if missing:
        sentences.append(
            f"{name}: there is no usable channel '{missing[0]}', so no transmission error follows from it."
        )
        return None, None
    theta = channels["motor_angle"] / ratio
    window = steady_window(recording, theta)
    if isinstance(window, str):
        sentences.append(window)
        return None, None
    error = channels["load_angle"] - theta
    count = _count(recording, "motor_angle")
    resolution = count / ratio if np.isfinite(count) else 0.0
    bad = bad_rows.copy()
    stretch = slice(window.segment_start, window.segment_stop)
    wild = spikes(error[stretch], 0.3 * resolution)
    bad[stretch] |= wild
    if wild.any():
        sentences.append(f"{name}: {int(wild.sum())} single wild samples of the transmission error are left out.")
    steady = steady_sums(channels, theta, error, bad, window, options, resolution)
    good = ~bad[stretch]
    paper = paper_harmonics(theta[stretch][good], error[stretch][good], options.orders, options.notch_orders)
    return steady, paper


def reduce_recording(path: Path | str | Recording, options: ReductionOptions) -> Reduction:
    """Read one recording once and reduce it; what cannot be used is said in ``sentences``.

    Raises RecordingError where nothing of it can be used.
    """
    recording = path if isinstance(path, Recording) else Recording.open(path)
    sentences = [f"{recording.recording_id}: {problem}" for problem in recording.problems]
    channels, gaps = _read(recording, sentences, options.torque_step)
    if "time" not in channels or recording.size < 2:
        raise RecordingError(f"{recording.path}: holds no samples that can be used.")
    channels, bad_rows = _repaired(recording, channels, sentences)
    if "time" not in channels:
        raise RecordingError(f"{recording.path}: 'time' is not a number in many samples, so nothing can be used.")
    ratio = recording.gearbox.ratio
    steady, paper = None, None
    if recording.kind in options.kinds:
        if ratio is None:
            sentences.append(
                f"{recording.recording_id}: the gearbox ratio is missing, so no transmission error follows."
            )
        else:
            steady, paper = _transmission(recording, channels, bad_rows, ratio, options, sentences)
    setpoint = recording.setpoint
    return Reduction(
        recording.recording_id,
        recording.kind,
        ratio or 1.0,
        recording.started_at.timestamp(),
        (setpoint.load_torque, setpoint.velocity, setpoint.temperature),
        recording.specs["motor_angle"].unit == "m" if "motor_angle" in recording.specs else False,
        make_blocks(
            channels,
            recording.sample_rate,
            _steady_mask(recording, recording.size),
            np.concatenate([gaps, np.flatnonzero(bad_rows)]),
        ),
        band_limited_rows(channels, recording.sample_rate, ratio or 1.0, 0, options.band_limit_hz)
        if recording.source == "import"
        else None,
        steady,
        paper,
        tuple(sentences),
        _count(recording, "load_angle"),
    )
