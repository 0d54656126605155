"""LabVIEW TDMS files; channels as ``group/channel``. Needs the extra ``tdms`` (npTDMS)."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.importing.formats.source import Variable, at_index, missing_package, one_dimensional, unknown_variable


class TdmsSource:
    """A TDMS file; unit, rate and start of a waveform are properties of its channel."""

    notes: tuple[str, ...] = ()

    def __init__(self, path: Path) -> None:
        try:
            from nptdms import TdmsFile
        except ImportError:
            raise missing_package(path, "TDMS", "npTDMS", "tdms") from None
        self._path = path
        try:
            file = TdmsFile.read(path)
        except Exception as error:
            raise RecordingError(f"{path}: is not a readable TDMS file ({error}).") from error
        self._channels: dict[str, Any] = {
            f"{group.name}/{channel.name}": channel for group in file.groups() for channel in group.channels()
        }

    def variables(self) -> list[Variable]:
        """Name the channels."""
        return [_variable(name, channel) for name, channel in self._channels.items()]

    def read(self, variable: str | None, column: int | None = None, row: int | None = None) -> NDArray[Any]:
        """Read a channel, scaled as the file says."""
        if variable not in self._channels:
            raise unknown_variable(self._path, variable, self._channels)
        return one_dimensional(self._channels[variable][:], column, row, f"{self._path}: {variable}")

    location = staticmethod(at_index)

    @property
    def started_at(self) -> datetime | None:
        """Start of the first waveform that has one; TDMS keeps UTC."""
        for channel in self._channels.values():
            start = channel.properties.get("wf_start_time")
            if isinstance(start, np.datetime64) and not np.isnat(start):
                return datetime.fromtimestamp(float(start.astype("datetime64[us]").astype(np.int64)) * 1e-6, UTC)
        return None


def _variable(name: str, channel: Any) -> Variable:
    step = channel.properties.get("wf_increment")
    return Variable(
        name,
        (len(channel),),
        str(channel.dtype),
        str(channel.properties.get("unit_string", "")),
        1.0 / float(step) if step else None,
    )
