"""A bench identified once, and campaigns of it: one in which nothing begins, one in which a zero walks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from bench.identification import Options, identify_folder, to_simulation
from bench.proof.make import load_examiner, write_generated

BENCH = 9101
WALKS = "the torque sensor's zero walks"


@dataclass(frozen=True)
class Known:
    """``model`` of the bench; folders of recordings; ``since``: name of the first recording with the change."""

    model: Path
    without: Path
    walks: Path
    since: str


@pytest.fixture(scope="session")
def known(tmp_path_factory: pytest.TempPathFactory) -> Known:
    place = tmp_path_factory.mktemp("twin")
    examiner = load_examiner()
    names = {}
    for name, campaign in (
        ("known", examiner.known_by(BENCH)),
        ("without", examiner.watched(BENCH, 1)),
        ("walks", examiner.watched(BENCH, 2, WALKS, 2.5)),
    ):
        (place / name).mkdir()
        names[name] = []
        for made in campaign.recordings():
            write_generated(place / name, name, made)
            names[name].append(made.name)
    since = names["walks"][examiner.watched(BENCH, 2, WALKS, 2.5).since]
    to_simulation(identify_folder(place / "known", Options(orders=(1, 3, 46)))).save(place / "model.json")
    return Known(place / "model.json", place / "without", place / "walks", since)
