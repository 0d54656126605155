"""Campaigns with and without a change, generated, looked at by the twin, and what came of each."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from bench.identification import Options, identify_folder, to_simulation
from bench.proof.make import load_examiner, write_generated
from bench.recording import Recording
from bench.twin.finding import found
from bench.twin.streams import AT_ONE_POINT
from bench.twin.watch import Watch

BENCHES = 10
"""benches drawn; each is identified once, from a campaign of its own"""
STRENGTHS = {"clear": (1.0, 1.8), "faint": (0.28, 0.42)}
"""in units of the noise of a sample; the proof of the mismatch analysis draws from the same"""
WITHOUT = "none"


@dataclass(frozen=True, slots=True)
class Case:
    """One campaign: ``change`` and ``level`` are ``none`` where nothing begins; ``number`` makes its seed."""

    number: int
    bench: int
    change: str
    level: str
    strength: float

    @property
    def key(self) -> str:
        """Key in the store."""
        return f"{self.change}/{self.level}/{self.number}"


def cases(with_change: int, without: int) -> list[Case]:
    """Campaigns in the order in which they are run: those with a change spread evenly among those without."""
    changes = list(load_examiner().CHANGES)
    levels = list(STRENGTHS)
    out: list[tuple[float, Case]] = []
    for k in range(with_change):
        level = levels[(k // len(changes)) % len(levels)]
        rng = np.random.default_rng([17, k])
        case = Case(k + 1, k % BENCHES + 1, changes[k % len(changes)], level, float(rng.uniform(*STRENGTHS[level])))
        out.append(((k + 0.5) / with_change, case))
    for k in range(without):
        out.append(((k + 0.5) / without, Case(1001 + k, k % BENCHES + 1, WITHOUT, WITHOUT, 0.0)))
    return [case for _, case in sorted(out, key=lambda pair: pair[0])]


def model_of(bench: int, work: Path) -> Path:
    """The model of a bench, identified from a campaign in which nothing begins; made unless it is there."""
    path = work / f"model-{bench:03d}.json"
    if not path.exists():
        work.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(dir=work) as place:
            for made in load_examiner().known_by(bench).recordings():
                write_generated(Path(place), "known", made)
            to_simulation(identify_folder(Path(place), Options())).save(path)
    return path


def run(case: Case, work: Path) -> dict[str, Any]:
    """Run one campaign past the twin; a row of the store.

    ``points``: recordings at one point; ``began``: index among them of the first with the change; ``noticed``: of that
    after which the alarm came; ``told_since``: of that from which the twin says it is; ``channel``: where.
    """
    model = model_of(case.bench, work)
    change = None if case.change == WITHOUT else case.change
    campaign = load_examiner().watched(case.bench, case.number, change, case.strength)
    watch, began, spent, looked, latest = Watch(model), None, 0.0, 0, 0.0
    first_finding = None
    with TemporaryDirectory(dir=work) as place:
        for number, made in enumerate(campaign.recordings()):
            write_generated(Path(place), "watched", made)
            if made.kind in AT_ONE_POINT and began is None and campaign.since is not None and number >= campaign.since:
                began = watch.points
            at = time.process_time()
            if watch.add(Recording.open(Path(place) / f"{made.name}.h5")):
                first_finding = found(watch)
            took = time.process_time() - at
            if watch.tested:
                spent, looked, latest = spent + took, looked + 1, max(latest, took)
    return {
        "key": case.key,
        "bench": case.bench,
        "number": case.number,
        "change": case.change,
        "level": case.level,
        "strength": round(case.strength, 3),
        "points": len(watch.seen),
        "tested": watch.tested,
        "began": began,
        "noticed": watch.alarmed,
        "told_since": None if first_finding is None else first_finding.since,
        "channel": None if first_finding is None else first_finding.streams[0].stream.channel,
        "true_channel": campaign.channel,
        "told": [] if first_finding is None else [changed.words for changed in first_finding.streams],
        "strongest": round(max((seen.evidence for seen in watch.seen), default=0.0), 2),
        "evidence": [round(seen.evidence, 2) for seen in watch.seen],
        "look_s": round(spent / looked, 4) if looked else None,
        "longest_look_s": round(latest, 4) if looked else None,
        "unread": len(watch.unread),
        "without": dict(watch.without),
    }
