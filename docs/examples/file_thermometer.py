"""A driver of one's own in one file: a thermometer whose temperature another program writes into a text file."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drivers.errors import DriverError, SensorError
from drivers.pt100.measurement import Measurement, Range, from_temperature


@dataclass(frozen=True, slots=True)
class FileThermometer:
    """Reads °C from the first line of ``path``; the bench asks it from a thread of its own, so it may be slow."""

    name: str
    path: Path
    limits: Range

    def measure(self) -> Measurement:
        """Return the reading, or raise SensorError with the reason: the bench stops then, it never guesses."""
        try:
            value = float(self.path.read_text("utf-8").splitlines()[0])
        except (OSError, ValueError, IndexError) as error:
            why = f"{self.path} holds no temperature ({error}); is its writer running?"
            raise SensorError(f"{self.name}: {why}") from error
        return from_temperature(self.name, value, self.limits)

    def close(self) -> None:
        """There is nothing to let go of."""


def file_thermometer(name: str, options: Mapping[str, Any]) -> FileThermometer:
    """Make one from the ``options`` of the bench file: ``path``."""
    if set(options) != {"path"}:
        raise DriverError(f"{name}: options are {sorted(options)}, they should be exactly path")
    return FileThermometer(name, Path(options["path"]), Range())
