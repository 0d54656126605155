"""How a folder of too few recordings is cut: by revolutions where something turns, by time elsewhere."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from bench.mismatch.recordings.pieces import ENOUGH, Piece, pieces
from bench.mismatch.recordings.split import split
from bench.recording import Recording
from bench.recording.header import Setpoint
from tests.bench.mismatch.test_folders import write

SPEED = 0.1
"""rad/s of the output in what ``write`` makes first"""


def cut(folder: Path, *revolutions: float) -> tuple[list[Piece], str]:
    """Recordings of steady motion through so many revolutions, cut."""
    made = []
    for number, own in enumerate(revolutions):
        made.append(write(folder, 6 * number, seconds=2.0 * np.pi * own / SPEED, rate=20.0))
    recordings = [Recording.open(path) for path in made]
    return pieces(recordings, split(recordings)[0].count(False))


def turned(piece: Piece) -> float:
    """Revolutions of the output in a piece."""
    first, last = (0, piece.recording.size) if piece.rows is None else piece.rows
    return float(np.ptp(piece.recording.si("load_angle", first, last))) / (2.0 * np.pi)


@pytest.mark.parametrize(("total", "number", "least"), [(17.0, 8, 2.0), (28.5, 14, 2.0), (10.0, 9, 1.05)])
def test_what_turns_is_cut_into_blocks_of_whole_revolutions(
    tmp_path: Path, total: float, number: int, least: float
) -> None:
    made, note = cut(tmp_path, total)
    assert len(made) == number >= ENOUGH
    # but for the gap between blocks
    assert min(turned(piece) for piece in made) >= least - 0.02
    assert "cannot be found" not in note


def test_where_revolutions_make_too_few_blocks_time_cuts_and_the_note_says_what_that_costs(tmp_path: Path) -> None:
    made, note = cut(tmp_path, 3.0)
    assert len(made) == 14
    assert max(turned(piece) for piece in made) < 0.3
    assert "their 3.0 revolutions do not make 8 blocks of one each" in note


def test_short_recordings_beside_a_long_one_stay_whole(tmp_path: Path) -> None:
    made, _ = cut(tmp_path, 1.2, 20.5)
    assert [piece.rows is None for piece in made] == [True] + [False] * 10
    assert min(turned(piece) for piece in made) >= 1.1


@pytest.mark.parametrize(("number", "whole"), [(6, False), (7, True)])
def test_recordings_of_which_too_few_are_left_once_one_is_held_out_are_cut(
    tmp_path: Path, number: int, whole: bool
) -> None:
    unknown = Setpoint(math.nan, math.nan, math.nan)
    recordings = [Recording.open(write(tmp_path, k, seconds=30.0, setpoint=unknown)) for k in range(number)]
    made, note = pieces(recordings, split(recordings)[0].count(False))
    assert all(piece.rows is None for piece in made) == whole
    assert note.startswith(f"{number} recordings to fit are too few to hold any out") != whole
