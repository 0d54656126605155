"""One pass over a recording: everything identification needs of it, in a few hundred kilobytes.

The steady window is reduced to sums over angle (:mod:`.sums`) in a few blocks of time each, so that torque and
temperature may change within a recording; the whole recording to blocks of 50 ms; the paper's method to its harmonics.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.identification.band_limited import band_limited_rows
from bench.identification.blocks import Blocks, make_blocks
from bench.identification.paper_harmonics import Harmonics, paper_harmonics
from bench.identification.rows import Rows
from bench.identification.sums import angle_sums
from bench.identification.windows import SteadyWindow, counting_bias, lost_cycles, spike_mask, steady_window
from bench.recording import Recording

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
TURN = 2.0 * np.pi
ANGLE_STEPS = 2.0**32
"""Angles of kept samples are stored as this many steps a turn (1.5 nrad)."""
MAX_BAD_SHARE = 0.05


@dataclass(frozen=True, slots=True)
class ReductionOptions:
    """What to reduce to: integer ``orders`` and ``notch_orders``, blocks a window, reach of the proposal spectrum."""

    orders: tuple[int, ...]
    notch_orders: tuple[int, ...] = (150, 300)
    blocks: int = 16
    spectrum_reach: int = 5000
    band_limit_hz: float | None = None
    kinds: tuple[str, ...] = ("constant_velocity", "validation", "free")

    @property
    def reach(self) -> int:
        """Highest order of the sums; somewhat above the highest order fitted, so that its noise can be seen."""
        return max([*self.orders, *self.notch_orders, 1]) + 12

    @property
    def block_count(self) -> int:
        """Fewer blocks where orders are high, so that memory stays bounded."""
        return int(np.clip(self.blocks * 320 // self.reach, 1, self.blocks))


@dataclass(frozen=True, slots=True)
class SteadySums:
    """The steady window of one recording in B blocks, M = ``reach``; rad. ``reference`` is taken off the error.

    Attributes
    ----------
    torque, velocity, temperature : (B,) means of the block (N·m, rad/s at the load side, °C).
    unit : (B, 2M + 1) sums of 1; ``error`` : (B, M + 1) of the transmission error; ``torque_change`` : (B, M + 1) of
        the load torque less its block mean.
    error_square : Σ of the squared error over the window.
    spectrum : (S + 1,) power |Σ TE·exp(imθ)|²·(2/N)² of the window, orders 0 … S: squared amplitudes.
    angle, sample : (N,) samples kept for residuals: angle in 2⁻³² turns, error less ``reference`` (float32).
    resolution : rad, one count of the motor encoder at the load side (0 where not quantised).
    counting_bias : rad, standard deviation of the mean error that counting leaves at this speed.
    """

    window: SteadyWindow
    reference: float
    torque: FloatArray
    velocity: FloatArray
    temperature: FloatArray
    unit: ComplexArray
    error: ComplexArray
    torque_change: ComplexArray
    error_square: float
    spectrum: NDArray[np.float32]
    angle: NDArray[np.uint32]
    sample: NDArray[np.float32]
    resolution: float
    counting_bias: float


@dataclass(frozen=True, slots=True)
class Reduction:
    """What one recording contributes; ``steady`` and ``paper`` are None where its transmission error cannot be used.

    ``linear`` is True for an axis in m and N; ``limited`` holds band-limited rows, for recordings from elsewhere.
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

    @property
    def validation(self) -> bool:
        """Whether the recording is kept from every fit, to be scored."""
        return self.kind == "validation"


def _repaired(
    recording: Recording, channels: dict[str, FloatArray], said: list[str]
) -> tuple[dict[str, FloatArray], NDArray[np.bool_]]:
    """Drop channels that are mostly not numbers; elsewhere bridge such samples and mark their rows."""
    kept: dict[str, FloatArray] = {}
    bad_rows = np.zeros(channels["time"].size, dtype=bool)
    for name, values in channels.items():
        bad = ~np.isfinite(values)
        if not bad.any():
            kept[name] = values
            continue
        first = int(np.argmax(bad))
        if bad.mean() > MAX_BAD_SHARE:
            said.append(
                f"{recording.recording_id}: channel '{name}' is not a number in {100 * bad.mean():.1f} % of its "
                f"samples (first at {first}); the channel is not used."
            )
            continue
        said.append(
            f"{recording.recording_id}: channel '{name}' is not a number in {int(bad.sum())} samples "
            f"(first at {first}); those rows are left out."
        )
        rows = np.arange(values.size)
        kept[name] = np.interp(rows, rows[~bad], values[~bad])
        bad_rows |= bad
    return kept, bad_rows


def _read(recording: Recording, said: list[str]) -> tuple[dict[str, FloatArray], NDArray[np.int64]]:
    names = [name for name in CHANNELS if name in recording.specs]
    for angle, velocity in (("motor_angle", "motor_velocity"), ("load_angle", "load_velocity")):
        if angle not in recording.specs and velocity in recording.specs:
            names.append(velocity)
    channels = recording.read_si(names)
    gaps = np.empty(0, dtype=np.int64)
    if "cycle" in recording.specs:
        gaps, lost = lost_cycles(recording.raw("cycle").astype(np.int64))
        if lost:
            said.append(
                f"{recording.recording_id}: 'cycle' steps over {lost} lost cycles in {gaps.size} places (first before "
                f"sample {int(gaps[0])}); the samples that are there are used."
            )
    return channels, gaps


def _steady_mask(recording: Recording, size: int) -> NDArray[np.bool_]:
    mask = np.zeros(size, dtype=bool)
    for part in recording.steady():
        mask[part] = True
    return mask


def _block_slices(start: int, stop: int, count: int) -> Iterable[slice]:
    edges = np.linspace(start, stop, count + 1).astype(np.int64)
    return (slice(int(edges[i]), int(edges[i + 1])) for i in range(count))


def _steady_sums(
    channels: dict[str, FloatArray], theta: FloatArray, error: FloatArray, bad: NDArray[np.bool_],
    window: SteadyWindow, options: ReductionOptions, resolution: float,
) -> SteadySums:  # fmt: skip
    part = slice(window.start, window.stop)
    good = ~bad
    rows_good = good[part]
    reference = float(error[part][rows_good].mean())
    reach, count = options.reach, options.block_count
    means = np.zeros((3, count))
    unit = np.empty((count, 2 * reach + 1), dtype=np.complex128)
    first = np.empty((count, reach + 1), dtype=np.complex128)
    second = np.empty((count, reach + 1), dtype=np.complex128)
    missing = np.full(theta.size, np.nan)
    torque = channels.get("load_torque", missing)
    temperature = channels.get("temperature", missing)
    for b, rows in enumerate(_block_slices(window.start, window.stop, count)):
        keep = good[rows]
        angle = theta[rows][keep]
        load = torque[rows][keep]
        time = channels["time"][rows][keep]
        centred = time - time.mean()
        means[:, b] = load.mean(), float(centred @ angle / (centred @ centred)), temperature[rows][keep].mean()
        value = error[rows][keep] - reference
        unit[b], both = angle_sums(angle, np.ones_like(angle), value, 2 * reach)
        first[b] = both[: reach + 1]
        change = np.zeros_like(load) if np.isnan(load).any() else load - load.mean()
        second[b] = angle_sums(angle, change, np.zeros_like(change), reach)[0]
    kept_theta, kept = theta[part][rows_good], error[part][rows_good] - reference
    limit = min(options.spectrum_reach, max(kept.size // (3 * window.revolutions), 1))
    whole = angle_sums(kept_theta, kept, np.zeros_like(kept), limit)[0]
    turns = kept_theta / TURN
    advance = abs(kept_theta[-1] - kept_theta[0]) / (resolution * (part.stop - part.start - 1)) if resolution else 0.0
    bias = counting_bias(advance, part.stop - part.start) if resolution else 0.0
    return SteadySums(
        window, reference, means[0], means[1], means[2], unit, first, second, float(kept @ kept),
        (np.abs(whole) ** 2 * (2.0 / kept.size) ** 2).astype(np.float32),
        ((turns - np.floor(turns)) * ANGLE_STEPS).astype(np.uint64).astype(np.uint32),
        kept.astype(np.float32), resolution, resolution * bias,
    )  # fmt: skip


def _transmission(
    recording: Recording,
    channels: dict[str, FloatArray],
    bad_rows: NDArray[np.bool_],
    ratio: float,
    options: ReductionOptions,
    said: list[str],
) -> tuple[SteadySums | None, Harmonics | None]:
    name = recording.recording_id
    missing = [c for c in ("motor_angle", "load_angle") if c not in channels]
    if missing:
        said.append(f"{name}: there is no usable channel '{missing[0]}', so no transmission error follows from it.")
        return None, None
    theta = channels["motor_angle"] / ratio
    window = steady_window(recording, theta)
    if isinstance(window, str):
        said.append(window)
        return None, None
    error = channels["load_angle"] - theta
    bad = bad_rows.copy()
    stretch = slice(window.segment_start, window.segment_stop)
    wild = spike_mask(error[stretch])
    bad[stretch] |= wild
    if wild.any():
        said.append(f"{name}: {int(wild.sum())} single wild samples of the transmission error are left out.")
    spec = recording.specs["motor_angle"]
    resolution = abs(spec.scale) / ratio if np.issubdtype(np.dtype(spec.dtype), np.integer) else 0.0
    steady = _steady_sums(channels, theta, error, bad, window, options, resolution)
    good = ~bad[stretch]
    paper = paper_harmonics(theta[stretch][good], error[stretch][good], options.orders, options.notch_orders)
    return steady, paper


def reduce_recording(path: Path | str | Recording, options: ReductionOptions) -> Reduction:
    """Read one recording once and reduce it; what cannot be used is said in ``sentences``.

    Raises RecordingError where nothing of it can be used.
    """
    recording = path if isinstance(path, Recording) else Recording.open(path)
    said = [f"{recording.recording_id}: {problem}" for problem in recording.problems]
    channels, gaps = _read(recording, said)
    if "time" not in channels or recording.size < 2:
        raise RecordingError(f"{recording.path}: holds no samples that can be used.")
    channels, bad_rows = _repaired(recording, channels, said)
    if "time" not in channels:
        raise RecordingError(f"{recording.path}: 'time' is not a number in many samples, so nothing can be used.")
    ratio = recording.gearbox.ratio
    steady, paper = None, None
    if recording.kind in options.kinds:
        if ratio is None:
            said.append(f"{recording.recording_id}: the gearbox ratio is missing, so no transmission error follows.")
        else:
            steady, paper = _transmission(recording, channels, bad_rows, ratio, options, said)
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
        tuple(said),
    )
