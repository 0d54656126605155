"""Runs of some recordings, read once more: what is asked of few of them is not kept of all."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.recordings.prepared import prepare
from bench.mismatch.recordings.rows import Rows, fine_rows
from bench.mismatch.recordings.vibration import Run, run_of


def runs_of(data: Dataset, channel: str, recordings: Sequence[int]) -> list[Run]:
    """A channel's longest steady runs in the ``recordings``, by their numbers, as their spectra were made of."""
    out = []
    for _, group in groupby(sorted(recordings), key=lambda number: id(data.parts[number].recording)):
        numbers = list(group)
        whole = prepare(data.parts[numbers[0]].recording, numbers[0], data.folder)
        found = [run_of(data.parts[number].cut(whole, number), channel) for number in numbers]
        out += [run for run in found if run is not None]
    return out


def finely(data: Dataset, channel: str, recordings: Sequence[int], step: float) -> Iterator[tuple[int, Rows]]:
    """Rows of a torque, each of about ``step`` s, in the ``recordings`` that have it and samples as close, by their
    numbers; those of one file together.
    """
    close = [number for number in recordings if data.parts[number].recording.sample_rate * step > 0.5]
    for _, group in groupby(sorted(close), key=lambda number: id(data.parts[number].recording)):
        numbers = list(group)
        recording = data.parts[numbers[0]].recording
        whole = prepare(recording, numbers[0], data.folder, data.travelled.get(str(recording.path), 0.0))
        if channel in whole.measured:
            for number in numbers:
                yield number, fine_rows(data.parts[number].cut(whole, number), channel, step)
