"""Blocks of rows whose signs are drawn at random together: pieces of about one duration, or whole recordings."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from bench.simulation.frame import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class Units:
    """Blocks of rows whose signs are drawn: first row of each (blocks + 1,), and the recording each is in."""

    starts: IntArray
    recording: IntArray


def units(elapsed: FloatArray, starts: IntArray, duration: float) -> Units:
    """Cut recordings (first rows ``starts``) into blocks of about ``duration`` s."""
    first: list[int] = []
    owner: list[int] = []
    for r, (a, b) in enumerate(itertools.pairwise(starts)):
        span = float(elapsed[b - 1] - elapsed[a])
        number = max(1, round(span / duration))
        edges = np.searchsorted(elapsed[a:b], elapsed[a] + span * np.arange(number) / number) + a
        edges = np.unique(edges)
        first += [int(e) for e in edges]
        owner += [r] * edges.size
    return Units(np.array([*first, int(starts[-1])], dtype=np.int64), np.array(owner, dtype=np.int64))


def whole(blocks: Units) -> Units:
    """One unit a recording."""
    first = np.flatnonzero(np.diff(blocks.recording, prepend=-1))
    return Units(np.append(blocks.starts[:-1][first], blocks.starts[-1]), blocks.recording[first])
