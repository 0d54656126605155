"""What a commissioning leaves: a JSON file in the bench's state folder, signed with a hash, checked before every run.

The hash covers the record and what matters of the bench file (parts, bus, limits), so that a record of another bench,
or of this one before it was changed, does not count.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

from bench.configuration import BenchConfiguration
from bench.errors import ConfigurationError, LimitError
from bench.safety.latch_file import write_durably
from bench.safety.paths import state_folder

FILE = "commissioning.json"
_FORMAT = {"format": "bench-commissioning", "format_version": "1.0"}
_TABLES = (
    "gearbox",
    "input_motor",
    "load_motor",
    "input_encoder",
    "load_encoder",
    "coupling",
    "torque_sensor",
    "bus",
    "limits",
    "commissioning",
)
"""Tables of the bench file that a commissioning is about."""


@dataclass(frozen=True, slots=True)
class StepRecord:
    """One step: its sentence, and the numbers that were seen (SI)."""

    name: str
    text: str
    values: dict[str, Any]


@dataclass(frozen=True, slots=True)
class Zero:
    """The common zero of both encoders.

    Attributes
    ----------
    zero_id : its name; recordings carry it.
    motor_angle : what is subtracted from the motor's angle beyond the bench file's zero, rad.
    spread : difference of the two reference approaches, rad at the load side.
    marker : number in both drives that a power cut takes away.
    at, by : when (ISO 8601) and by whom.
    """

    zero_id: str
    motor_angle: float
    spread: float
    marker: int
    at: str
    by: str


@dataclass(frozen=True, slots=True)
class Commissioned:
    """A bench that passed every step."""

    bench: str
    interface: str
    digest: str
    at: str
    by: str
    steps: tuple[StepRecord, ...]
    zero: Zero

    def with_zero(self, zero: Zero) -> Commissioned:
        """Return the record with another zero."""
        return replace(self, zero=zero)

    def save(self, path: Path) -> None:
        """Write the record with its signature."""
        content = _FORMAT | asdict(self)
        write_durably(path, {**content, "signature": _signature(content)})

    @classmethod
    def load(cls, path: Path) -> Commissioned:
        """Read a record.

        Raises
        ------
        ConfigurationError
            If it is not one, or was changed after it was signed.
        """
        try:
            content = json.loads(path.read_text("utf-8"))
            signature = content.pop("signature")
            if signature != _signature(content):
                raise ConfigurationError(f"{path} was changed after it was signed; run bench commission again")
            fields = {key: value for key, value in content.items() if key not in _FORMAT}
            steps = tuple(StepRecord(**step) for step in fields.pop("steps"))
            return cls(**{**fields, "steps": steps, "zero": Zero(**fields["zero"])})
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise ConfigurationError(f"{path} is no commissioning record ({error}); run bench commission") from error


def digest(bench: BenchConfiguration) -> str:
    """Hash of what matters of a bench file; comments, storage, nominal values and tuning do not."""
    return _hash({name: getattr(bench, name).model_dump(mode="json") for name in _TABLES})


def record_path(bench: BenchConfiguration) -> Path | None:
    """Return where the record of a bench stands; None for one emulated in this process, which needs none."""
    folder = state_folder(bench)
    return None if folder is None else folder / FILE


def require_commissioned(bench: BenchConfiguration) -> Commissioned | None:
    """Return the record of a bench; None for one emulated in this process, which is new every time.

    Raises
    ------
    LimitError
        If the bench has never passed, or was changed since.
    ConfigurationError
        If the record cannot be used.
    """
    path = record_path(bench)
    if path is None:
        return None
    where = f"bench {bench.name} on {bench.bus.interface}"
    if not path.exists():
        raise LimitError(
            f"{where} has never been commissioned; bench commission --bus {bench.bus.interface} comes first"
        )
    record = Commissioned.load(path)
    if record.digest != digest(bench):
        raise LimitError(
            f"parts, bus or limits of {where} are not those it was commissioned with on {record.at[:10]};"
            f" run bench commission --bus {bench.bus.interface} again"
        )
    return record


def _signature(content: dict[str, Any]) -> str:
    return _hash(content)


def _hash(content: dict[str, Any]) -> str:
    return sha256(json.dumps(content, sort_keys=True, separators=(",", ":")).encode()).hexdigest()
