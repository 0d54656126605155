"""Figures of cycles made up to the microsecond, and the sentences where there is no C loop."""

from __future__ import annotations

import io
import shutil
import tarfile
from pathlib import Path

import numpy as np
import pytest

from bench.cycle.host import StealLog
from bench.cycle.jitter import c_loop
from bench.cycle.jitter.figures import EDGES_US, Distribution, Notes, RateFigures, figures

PERIOD_NS = 500_000


def notes(n: int = 1000, scale: int = 1) -> Notes:
    slot = np.arange(n)
    due = slot * PERIOD_NS
    woke = due + 10_000 * scale
    back = woke + 50_000 * scale
    return Notes(slot, due, woke, back, back + 5_000 * scale, np.full(n, 9))


def test_times_are_told_apart() -> None:
    found = figures(notes(), StealLog(), PERIOD_NS)
    assert (found.wake.median, found.trip.median, found.cycle.median) == (10.0, 50.0, 65.0)
    assert (found.missed, found.lost, found.wrong, found.beside_stolen) == (0, 0, 0, 0)
    assert sum(found.cycle.histogram) == found.cycles == 1000
    assert len(found.cycle.histogram) == len(EDGES_US)


def test_missed_lost_and_wrong_cycles_are_counted_apart() -> None:
    made = notes()
    made.slot[500:] += 3
    made.wkc[100], made.wkc[200:202] = -1, 3
    found = figures(made, StealLog(), PERIOD_NS)
    assert (found.missed, found.lost, found.wrong) == (3, 1, 2)
    assert sum(found.trip.histogram) == 999  # a frame that did not come back has no round trip


def test_losses_beside_stolen_time_are_known() -> None:
    log = StealLog()
    log._moments.append(100 * PERIOD_NS)
    made = notes()
    made.wkc[101] = made.wkc[900] = -1
    made.slot[150:] += 2
    assert figures(made, log, PERIOD_NS).beside_stolen == 3
    assert not StealLog().near(made.due).any()


def test_the_ratio_is_that_of_the_whole_cycle() -> None:
    slow, fast = figures(notes(scale=3), StealLog(), PERIOD_NS), figures(notes(scale=2), StealLog(), PERIOD_NS)
    assert RateFigures(2000.0, slow, fast).ratio == pytest.approx((1.5, 1.5))
    assert RateFigures(2000.0, slow, None).ratio is None
    assert RateFigures(2000.0, slow, fast).as_dict()["python"]["cycle"]["median"] == 195.0


def test_a_distribution_has_no_time_left_out() -> None:
    found = Distribution.of(np.array([0, 9_999, 10_000, 200_000_000]))
    assert found.histogram[:2] == (2, 1)
    assert found.histogram[-1] == 1


def test_without_a_compiler_there_is_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda _: None)
    found = c_loop.build(tmp_path)
    assert isinstance(found, c_loop.Unavailable)
    assert "no C compiler" in found.reason


def test_a_source_that_is_none_is_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(c_loop.shutil, "which", lambda _: "cc")
    wrong = tmp_path / "wrong.tar.gz"
    wrong.write_bytes(b"no archive")
    empty = tmp_path / "empty.tar.gz"
    with tarfile.open(empty, "w:gz") as archive:
        archive.addfile(tarfile.TarInfo("readme"), io.BytesIO())
    for source, text in ((tmp_path, "no source of SOEM"), (wrong, "no archive"), (empty, "no source of SOEM")):
        found = c_loop.build(tmp_path, source)
        assert isinstance(found, c_loop.Unavailable)
        assert text in found.reason


def test_cycles_that_began_a_period_late_are_counted() -> None:
    made = notes()
    made.woke[300:304] += 4 * PERIOD_NS - 10_000
    made.woke[600] += PERIOD_NS // 2
    assert figures(made, StealLog(), PERIOD_NS).late == 4
