"""Runs of some recordings, read once more: what is asked of few of them is not kept of all."""

from __future__ import annotations

from collections.abc import Sequence
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


def finely(data: Dataset, channel: str, number: int, step: float) -> Rows | None:
    """Rows of a torque, each of ``step`` s, in the recording of a ``number``; None where it has no such channel."""
    part = data.parts[number]
    whole = prepare(part.recording, number, data.folder)
    return fine_rows(part.cut(whole, number), channel, step) if channel in whole.measured else None
