"""Spoil and read, in children that may crash or hang, and count what became of each file."""

from __future__ import annotations

import math
import os
import signal
import time
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from bench.fuzzing import samples
from bench.fuzzing.mutations import mutate
from bench.fuzzing.readers import LOST, READERS, SILENT, examine
from bench.recording import guarded

KINDS = tuple(READERS)
CRASH, HANG, TRACEBACK = "crash", "hang", "traceback"
WRONG = (CRASH, HANG, TRACEBACK, SILENT, LOST)
"""What may not happen."""
TIME_S = 120.0
"""After this long a file counts as hung; a reader gives up on it after 30 s."""

Progress = Callable[[str, int, int], None]


@dataclass(slots=True)
class Tally:
    """What became of the files of one kind; ``wrong`` names the cases that may not be, by their number."""

    kind: str
    asked: int
    done: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)
    wrong: list[tuple[int, str, str]] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether nothing happened that may not."""
        return not self.wrong

    def as_dict(self) -> dict[str, Any]:
        """Return everything for JSON."""
        return {
            "kind": self.kind,
            "asked": self.asked,
            "done": self.done,
            "outcomes": dict(self.outcomes),
            "wrong": [{"case": case, "outcome": outcome, "text": text} for case, outcome, text in self.wrong],
        }


def fuzz(
    kinds: Sequence[str],
    count: int,
    seed: int = 0,
    jobs: int = 1,
    progress: Progress | None = None,
    first: int = 0,
    most_s: float = math.inf,
) -> list[Tally]:
    """Spoil ``count`` files of each kind, from case ``first`` on, and read them; a case depends on seed and number.

    After ``most_s`` no further file is begun; the tallies say how many were done.
    """
    until = time.monotonic() + most_s
    with TemporaryDirectory(prefix="fuzz-") as folder:
        valid = samples.make(Path(folder))

        def one(kind: str) -> Tally:
            return _fuzz_kind(kind, valid[kind], range(first, first + count), seed, until, progress)

        with ThreadPoolExecutor(max(jobs, 1)) as pool:
            return list(pool.map(one, kinds))


def case(kind: str, valid: Path, seed: int, number: int) -> bytes:
    """Give the spoiled file of one case."""
    return mutate(valid.read_bytes(), np.random.default_rng([seed, KINDS.index(kind), number]))


def _fuzz_kind(kind: str, valid: Path, cases: range, seed: int, until: float, progress: Progress | None) -> Tally:
    tally = Tally(kind, len(cases))
    child = guarded.Child(inside=False)
    place = str(valid.parent / f"spoiled-{kind}-{os.getpid()}")
    if kind == "journal":
        place = str(valid.parent.parent / "spoiled-journal")
    try:
        for number in cases:
            if time.monotonic() > until:
                break
            spoiled = case(kind, valid, seed, number)
            question: Any = (examine, (kind, str(valid), spoiled, place), {}, TIME_S, None)
            try:
                returned, result = child.ask(question, TIME_S)
            except TimeoutError:
                outcome, text = HANG, f"no answer within {TIME_S:.0f} s"
            except guarded.Gone:
                code = child.end()
                outcome, text = CRASH, f"exit code {code}"
                if code == -signal.SIGXCPU:
                    outcome, text = HANG, f"no answer within {TIME_S:.0f} s of processor time"
            else:
                outcome = result if returned else TRACEBACK
                text = "" if returned else f"{type(result).__name__}: {result}"
            if outcome in (HANG, CRASH):
                child.end()
                child = guarded.Child(inside=False)
            tally.done += 1
            tally.outcomes[outcome] += 1
            if outcome in WRONG:
                tally.wrong.append((number, outcome, text))
            if progress is not None:
                progress(kind, tally.done, tally.asked)
    finally:
        child.end()
    return tally
