"""Some recordings, read once more: what is asked of few of them is not kept of all."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.recordings.prepared import Prepared, prepare
from bench.mismatch.recordings.rows import Rows, fine_rows
from bench.mismatch.recordings.vibration import Run, run_of


def runs_of(data: Dataset, channel: str, recordings: Sequence[int]) -> list[Run]:
    """A channel's longest steady runs in the ``recordings``, by their numbers, as their spectra were made of."""
    found = (run_of(prepared, channel) for _, prepared in _prepared(data, recordings))
    return [run for run in found if run is not None]


def finely(data: Dataset, channel: str, recordings: Sequence[int], step: float) -> Iterator[tuple[int, Rows]]:
    """Rows of a torque, each of about ``step`` s, in the ``recordings`` that have it and samples as close, by their
    numbers.
    """
    close = [number for number in recordings if data.parts[number].recording.sample_rate * step > 0.5]
    for number, prepared in _prepared(data, close):
        if channel in prepared.measured:
            yield number, fine_rows(prepared, channel, step)


def _prepared(data: Dataset, recordings: Sequence[int]) -> Iterator[tuple[int, Prepared]]:
    """The ``recordings``, by their numbers; blocks of one file are read together."""
    for _, group in groupby(sorted(recordings), key=lambda number: id(data.parts[number].recording)):
        numbers = list(group)
        recording = data.parts[numbers[0]].recording
        whole = prepare(recording, numbers[0], data.folder, data.travelled.get(str(recording.path), 0.0))
        for number in numbers:
            yield number, data.parts[number].cut(whole, number)
