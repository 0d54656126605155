"""A stack of plays counts as hysteresis only where the recordings exercise its memory."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.bank import Bank, Noise
from bench.mismatch.columns import layout
from bench.mismatch.linear import starts_and_folds
from bench.mismatch.memories import exercised
from bench.simulation.frame import Frame, concatenate
from bench.simulation.terms import TRANSMISSION_ERROR
from tests.bench.simulation.terms.frames import frame

LOADS = (-900.0, -600.0, -300.0, 300.0, 600.0, 900.0)
SPEEDS = (0.05, 0.08, 0.12, 0.17)
EACH = 40


def _campaign(path: np.ndarray) -> Frame:
    """Recordings of forty rows at six loads and four speeds in both directions; ``path`` scales the load in each."""
    one = frame().take(np.arange(EACH))
    parts = []
    for number, (load, speed, turn) in enumerate(itertools.product(LOADS, SPEEDS, (1.0, -1.0))):
        parts.append(
            replace(
                one,
                recording=np.full(EACH, number),
                time=one.elapsed + 100.0 * number,
                torque=load * path,
                velocity=np.full(EACH, turn * speed),
                direction=np.full(EACH, turn),
                last_direction=np.full(EACH, turn),
                temperature=np.full(EACH, 25.0 + 4.0 * (number % 5)),
                steady=np.ones(EACH),
            )
        )
    return concatenate(parts)


@pytest.mark.parametrize(("path", "kept"), [("steady", False), ("up and down", True)])
def test_stacks_stay_where_the_load_goes_up_and_down(path: str, kept: bool) -> None:
    rise = np.linspace(0.0, 1.0, EACH // 2)
    rows = _campaign(np.ones(EACH) if path == "steady" else np.concatenate([rise, rise[::-1]]))
    whole = layout(TRANSMISSION_ERROR, rows)
    starts, folds = starts_and_folds(rows, np.arange(48))
    noise = Noise(np.full(rows.size, 1e-6), np.zeros(rows.size), (0.0,))
    bank = Bank(np.zeros(rows.size), starts, folds, whole.columns, whole.prior, noise, whole.precision)
    left = exercised(bank, whole, whole.named)
    assert any(e.form == "stack" for e in left) is kept
    assert any(e.form == "play" for e in left)
    assert {e.effect for e in left} == {e.effect for e in whole.named}
