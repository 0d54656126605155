"""What a concealed folder hides: the sealed answer a report is scored against."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any, Literal

Status = Literal["named", "ambiguous", "unknown"]

#: The compared channels and their SI units.
CHANNELS: dict[str, str] = {
    "transmission_error": "rad",
    "motor_torque": "N·m",
    "temperature": "°C",
    "load_torque": "N·m",
}


@dataclass(frozen=True, slots=True)
class Parameter:
    """A true parameter in the vocabulary's natural form; other forms carry none that could be compared."""

    symbol: str
    value: float
    unit: str


@dataclass(frozen=True, slots=True)
class Location:
    """Where an effect acts; an empty entry means that the truth makes no claim about it.

    Attributes:
        conditions: ``velocity`` (abs, rad/s load side), ``load_torque`` (N·m), ``temperature`` (°C) as [low, high];
            ``direction`` as ``positive``, ``negative`` or ``both``.
        core, core_windows: the inner part of conditions and windows, where most of it is: what is told may end
            anywhere between the two.
        orders: per output revolution; order_sizes: RMS of each in rad where they differ, to weigh them by.
        angle_windows: pairs in rad of the input angle modulo 2π.
        time_window: two ISO 8601 times or None.
        measured: the smallest range of each quantity that holds nine tenths of the energy of the excess; span: what
            the recordings cover; measured_direction: the direction it is in.
        recordings: energy of the excess in each recording, by its id, in the channel's unit squared times samples.
    """

    conditions: dict[str, Any] = field(default_factory=dict)
    orders: tuple[float, ...] = ()
    order_sizes: tuple[float, ...] = ()
    angle_windows: tuple[tuple[float, float], ...] = ()
    time_window: tuple[str, str] | None = None
    core: dict[str, Any] = field(default_factory=dict)
    core_windows: tuple[tuple[float, float], ...] = ()
    measured: dict[str, tuple[float, float]] = field(default_factory=dict)
    span: dict[str, tuple[float, float]] = field(default_factory=dict)
    measured_direction: str = ""
    recordings: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ConcealedEffect:
    """One effect as it was put in.

    Attributes:
        effect: vocabulary id, or ``unknown``.
        status: what an honest report would say of it.
        also: other vocabulary ids that the folder's design cannot tell from it (status ``ambiguous``).
        form: the mathematical form nature took, for people.
        channels: where it shows, strongest first.
        in_library: whether the analyser's library has this form, as far as the examiner knows; None for a nominal
            term and where form is no question.
        strength: excess RMS over its active samples after the nominal is refitted, over the noise RMS of
            ``channels[0]``; None for a nominal term that is switched off.
        too_faint: whether it was drawn so small that nobody could see it: it is no part of the score.
    """

    effect: str
    status: Status
    form: str
    channels: tuple[str, ...]
    strength: float | None
    location: Location = field(default_factory=Location)
    parameters: tuple[Parameter, ...] = ()
    also: tuple[str, ...] = ()
    in_library: bool | None = None
    too_faint: bool = False


@dataclass(frozen=True, slots=True)
class Truth:
    """The answer to one folder.

    Attributes:
        folder: the name under which the recordings are handed out; it says nothing of the case.
        noise_by_recording: the same of each recording by its id; of the temperature over all its samples.
        noise_rms: true per-sample noise of each compared channel over the steady samples, in the channel's SI unit,
            everything included that no model could predict (offsets between recordings too).
        switched_off: nominal terms disabled in the simulation the analyser is given.
    """

    case: str
    group: str
    seed: int
    folder: str
    verdict: Literal["match", "mismatch"]
    effects: tuple[ConcealedEffect, ...]
    noise_rms: dict[str, float]
    noise_by_recording: dict[str, dict[str, float]]
    switched_off: tuple[str, ...] = ()
    note: str = ""

    def to_dict(self) -> dict[str, Any]:
        """The truth as JSON-ready values, with its format named."""
        return {"format": "bench-truth", "format_version": "1.1", **asdict(self)}
