"""MDF files of test benches and vehicles (``.mf4``, ``.mdf``). Needs the extra ``mdf`` (asammdf)."""

from __future__ import annotations

import weakref
from collections import Counter
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.importing.formats.source import Variable, at_index, missing_package, one_dimensional, unknown_variable


class MdfSource:
    """An MDF file: channels by name, or as ``group/name`` (groups from 0) where a name stands in several groups.

    Every group has a clock of its own, its master channel; which one a channel has is its ``clock``.
    """

    notes: tuple[str, ...] = ()

    def __init__(self, path: Path) -> None:
        try:
            from asammdf import MDF
        except ImportError:
            raise missing_package(path, "MDF", "asammdf", "mdf") from None
        self._path = path
        try:
            self._file: Any = MDF(path)
            self._places = self._found()
        except Exception as error:
            _close_half_built(error)
            raise RecordingError(f"{path}: is not a readable MDF file ({error}).") from error
        # its own destructor comes too late: the file may be collected before the reader that would close it
        weakref.finalize(self, self._file.close)

    def variables(self) -> list[Variable]:
        """Name the channels; masters first in their group."""
        found = []
        for name, (group, index) in self._places.items():
            whole = self._file.groups[group]
            master = self._file.masters_db.get(group)
            clock = None if master is None or index == master else self._name(group, master)
            unit = str(getattr(whole.channels[index], "unit", "") or "") or ("s" if index == master else "")
            kind = "time stamps" if index == master else "channel"
            found.append(Variable(name, (int(whole.channel_group.cycles_nr),), kind, unit, clock=clock))
        return found

    def read(self, variable: str | None, column: int | None = None, row: int | None = None) -> NDArray[Any]:
        """Read a channel in the unit the file gives it; a master as seconds."""
        if variable not in self._places:
            raise unknown_variable(self._path, variable, self._places)
        group, index = self._places[variable]
        where = f"{self._path}: {variable}"
        try:
            if index == self._file.masters_db.get(group):
                return one_dimensional(self._file.get_master(group), column, row, where)
            signal = self._file.get(group=group, index=index)
            if signal.samples.dtype.kind not in "biuf":  # a number that the file turns into words
                signal = self._file.get(group=group, index=index, raw=True)
        except Exception as error:
            raise RecordingError(f"{where} cannot be read ({error}).") from error
        return one_dimensional(signal.samples, column, row, where)

    location = staticmethod(at_index)

    @property
    def started_at(self) -> datetime | None:
        """Start of the measurement, as its header says."""
        start = self._file.header.start_time
        return start if isinstance(start, datetime) else None

    def _found(self) -> dict[str, tuple[int, int]]:
        every = [
            (channel.name, group, index)
            for group, whole in enumerate(self._file.groups)
            for index, channel in enumerate(whole.channels)
        ]
        self._counts = Counter(name for name, _, _ in every)
        return {self._name(group, index): (group, index) for _, group, index in every}

    def _name(self, group: int, index: int) -> str:
        name = str(self._file.groups[group].channels[index].name)
        return name if self._counts[name] == 1 else f"{group}/{name}"


def _close_half_built(error: Exception) -> None:
    """Close readers that failed half-built: left alone, their destructor would print that it cannot close them."""
    trace = error.__traceback__
    while trace is not None:
        half: Any = trace.tb_frame.f_locals.get("self")
        if type(half).__name__ in ("MDF3", "MDF4"):
            for name in ("_file", "header", "identification"):  # what ``close`` asks for and the failure left out
                if not hasattr(half, name):
                    setattr(half, name, None)
            with suppress(AttributeError):  # it fails with the file's own error, which is passed on
                half.close()
        trace = trace.tb_next
