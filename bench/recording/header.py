"""What a recording says about itself: plain values, the same for whoever writes and whoever reads."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

from bench.signals import BY_NAME

FORMAT = "bench-recording"
FORMAT_VERSION = "1.0"

KINDS: tuple[str, ...] = (
    "constant_velocity",
    "validation",
    "heating",
    "cooling",
    "dwell",
    "reversal",
    "torque_ramp",
    "velocity_ramp",
    "free",
)
SOURCES: tuple[str, ...] = ("hardware", "emulator", "import")
AXES: tuple[str, ...] = ("rotary", "linear")
"""What a recording's angles and torques are: rad and N·m, or the metres and newtons of a linear axis."""
TEETH = ("z1", "z2", "z3", "z4")
"""Attributes of a gearbox's tooth numbers."""
SEGMENT_NAMES: tuple[str, ...] = ("ramp_up", "steady", "ramp_down", "dwell", "heat")

PART_SUFFIX = ".part"
"""A recording that is not finished is called ``<recording_id>.h5.part``."""


@dataclass(frozen=True, slots=True)
class Setpoint:
    """What was commanded; NaN where nothing was.

    ``load_torque`` N·m in the torque sensor's sign, ``velocity`` rad/s at the load side (signed), ``temperature`` °C.
    """

    load_torque: float = math.nan
    velocity: float = math.nan
    temperature: float = math.nan


@dataclass(frozen=True, slots=True)
class Gearbox:
    """Ratio u = motor angle / load angle, and tooth numbers where the gearbox has them (None where absent)."""

    ratio: float | None = None
    z1: int | None = None
    z2: int | None = None
    z3: int | None = None
    z4: int | None = None


@dataclass(frozen=True, slots=True)
class Segment:
    """A named stretch of samples; ``stop`` is exclusive."""

    name: str
    start: int
    stop: int


@dataclass(frozen=True, slots=True)
class Event:
    """A fault, a warning or an operator's remark, ``time`` in s since the first sample."""

    time: float
    level: str
    text: str


@dataclass(frozen=True, slots=True)
class ChannelSpec:
    """How one channel stands in the file: SI value = raw · ``scale`` + ``offset``.

    Attributes
    ----------
    name : dataset name in the group ``channels``.
    unit : SI unit of the scaled value.
    dtype : NumPy name of the raw values; integers as the device gave them, never ``float32``.
    origin : where the values come from, such as ``input_drive/0x6064``.
    """

    name: str
    unit: str
    dtype: str = "float64"
    scale: float = 1.0
    offset: float = 0.0
    description: str = ""
    origin: str = ""

    @classmethod
    def of(
        cls, name: str, *, dtype: str | None = None, scale: float = 1.0, offset: float = 0.0, origin: str = ""
    ) -> ChannelSpec:
        """Make the specification of a channel of :data:`bench.signals.SIGNALS`; unit and description from there."""
        signal = BY_NAME[name]
        return cls(name, signal.unit, dtype or signal.dtype, scale, offset, signal.description, origin)


@dataclass(frozen=True, slots=True)
class RecordingHeader:
    """Root attributes and provenance of a recording (recording format 1.0).

    ``started_at`` must be aware (UTC); ``sample_rate`` in Hz. The attributes after ``gearbox`` are the bench's own:
    readers do not require them. ``axis`` is one of :data:`AXES`, None where nothing says it.
    ``attributes`` are further root attributes, kept as they are.
    """

    recording_id: str
    campaign_id: str
    kind: str
    started_at: datetime
    sample_rate: float
    source: str
    setpoint: Setpoint = Setpoint()
    gearbox: Gearbox = Gearbox()
    point_id: str | None = None
    take: int | None = None
    zero_id: str | None = None
    gearbox_serial: str | None = None
    axis: str | None = None
    config: str | None = None
    software: Mapping[str, str] = field(default_factory=dict)
    attributes: Mapping[str, Any] = field(default_factory=dict)
