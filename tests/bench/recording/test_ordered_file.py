"""Every state a kill can leave on the disk, one after another: each is a readable recording with all flushed rows."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.recording import Recording, RecordingWriter
from bench.recording.writing import ordered_file, sink
from tests.bench.recording import builders

SPREAD, AROUND = 260, 8
"""states all over the writing; writes before and after one that deepens an index, each of which leaves a state"""


class _Disk:
    """What has been written, write by write, and how many rows each commit had promised."""

    def __init__(self) -> None:
        self.writes: list[tuple[int, bytes] | int] = []
        self.promises: list[tuple[int, int]] = []


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> _Disk:
    log = _Disk()
    pwrite, ftruncate = os.pwrite, os.ftruncate

    def logged_pwrite(descriptor: int, data: Any, offset: int) -> int:
        log.writes.append((offset, bytes(data)))
        return pwrite(descriptor, data, offset)

    def logged_ftruncate(descriptor: int, size: int) -> None:
        log.writes.append(size)
        ftruncate(descriptor, size)

    monkeypatch.setattr(ordered_file.os, "pwrite", logged_pwrite)
    monkeypatch.setattr(ordered_file.os, "ftruncate", logged_ftruncate)
    return log


def _deepened(writes: list[tuple[int, bytes] | int]) -> list[int]:
    """Numbers of the writes with which a chunk index is a level deeper than any before."""
    out, deepest = [], 0
    for number, write in enumerate(writes, start=1):
        # version 1 B-tree: signature, type (1: chunks), level
        if not isinstance(write, int) and write[1][:5] == b"TREE\x01" and write[1][5] > deepest:
            deepest = write[1][5]
            out.append(number)
    return out


def _states(writes: list[tuple[int, bytes] | int], first: int) -> set[int]:
    """After how many writes the file is read: all over it, and after each write around those that deepen an index."""
    # closer at the beginning, where there is less to read
    spread = {first + round((len(writes) - first) * (number / SPREAD) ** 3) for number in range(SPREAD + 1)}
    around = (range(number - AROUND, number + AROUND + 1) for number in _deepened(writes))
    return {n for n in spread.union(*around) if first <= n <= len(writes)}


def _apply(descriptor: int, write: tuple[int, bytes] | int) -> None:
    if isinstance(write, int):
        os.truncate(descriptor, write)
    else:
        os.lseek(descriptor, write[0], os.SEEK_SET)
        os.write(descriptor, write[1])


@pytest.mark.parametrize(
    ("chunk_rows", "rows", "channels"), [(4, 4 * 70, 3), (1, 70, 2), pytest.param(1, 3700, 2, marks=pytest.mark.slow)]
)
def test_every_state_on_disk_is_readable(
    disk: _Disk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, chunk_rows: int, rows: int, channels: int
) -> None:
    # 64 chunks fill a node of the chunk index, 3700 make it three levels high: both splits happen in these runs.
    monkeypatch.setattr(sink, "_MIN_FLUSH_SPACING_S", 0.0)
    specs = builders.specs()[:channels]
    commit = ordered_file.OrderedFile.commit

    def promising_commit(self: ordered_file.OrderedFile) -> None:
        written = writers[0]._sink.rows_written if writers else 0
        commit(self)
        disk.promises.append((len(disk.writes), written))

    writers: list[RecordingWriter] = []
    monkeypatch.setattr(ordered_file.OrderedFile, "commit", promising_commit)
    data = builders.columns(0, rows)
    with RecordingWriter(tmp_path / "a.h5", builders.header("a"), specs, chunk_rows=chunk_rows) as writer:
        writers.append(writer)
        for start in range(0, rows, 4):
            writer.append({spec.name: data[spec.name][start : start + 4] for spec in specs})
            if start % 100 == 40:
                writer.begin_segment("steady")
                writer.event(start / 2000, "info", f"row {start}")

    promised = 0
    promises = dict(disk.promises)
    first = disk.promises[0][0]
    cut = tmp_path / "cut.h5"
    descriptor = os.open(cut, os.O_RDWR | os.O_CREAT)
    tested, states = 0, _states(disk.writes, first)
    for done, write in enumerate(disk.writes, start=1):
        _apply(descriptor, write)
        promised = max(promised, promises.get(done, 0))
        if done not in states:
            continue
        recording = Recording.open(cut)
        assert recording.size >= promised
        for name, values in recording.read_raw(recording.channels, 0, promised).items():
            assert np.array_equal(values, data[name][:promised])
        tested += 1
    os.close(descriptor)
    assert tested > 200
