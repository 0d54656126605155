"""Scatter: what is left has no mean, but some recordings scatter more than others, and a recorded state tells which.

The scatter of a recording is the power of its steady part over all frequencies, lines left out. Recordings are put in
order by each state (speed, load, temperature, time) and cut in two; the clearest difference is compared with that of
recordings shuffled. More scatter at higher speed is no finding: every machine vibrates more, and no simulation of the
slow physics claims how much.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from bench.mismatch import criteria
from bench.mismatch.discovery import ABOVE, BELOW
from bench.mismatch.recordings.vibration import NYQUIST_SHARE, Density
from bench.mismatch.regression.maxima import tail_probability
from bench.mismatch.regression.noise import LOWEST_HZ
from bench.simulation.frame import FloatArray, Frame, IntArray

SURROGATES = 1000
FEWEST_RECORDINGS = 12
"""recordings in all below which none is told from the others"""
FEWEST_LOUD = 3
"""recordings of a state that scatter more: two agree by chance in one of a hundred orders"""
ABOUT = 41
"""frequencies whose median tells the noise at one"""
UNITS = {"speed": "rad/s", "torque": "N*m", "load": "N*m", "temperature": "°C", "time": "s of the campaign"}
"""of the states"""


@dataclass(frozen=True, slots=True)
class Scatter:
    """Which state scatters more: name of the quantity, side of ``limit`` on which, its ``recordings`` with the mean
    square (unit²) of each beyond the others' median; ratio of root mean squares; chance among shuffled recordings.
    """

    quantity: str
    side: str
    limit: float
    recordings: tuple[int, ...]
    squares: tuple[float, ...]
    usual: float
    louder: float
    p_value: float


def scatter(densities: Sequence[Density], frame: Frame, steady: FloatArray, seed: int) -> Scatter | None:
    """The state whose recordings scatter most beyond the others; None where too few were steady, or none does.

    ``steady`` (n,): weights of the frame's rows in steady motion.
    """
    usable = [d for d in densities if steady[frame.recording == d.recording].sum() > 0.0]
    # a load that is driven up and down shakes what is measured: that is no scatter of the state
    kept = [d for d in usable if _keeps_its_load(frame, (frame.recording == d.recording) & (steady > 0.0))]
    usable = kept if len(kept) >= FEWEST_RECORDINGS else usable
    if len(usable) < FEWEST_RECORDINGS:
        return None
    squares = np.array([_mean_square(d) for d in usable])
    # by rank: a recording whose load swings is far louder than any noise, whatever its state
    size = (1.0 + np.argsort(np.argsort(squares))).astype(np.float64)
    states = _states(usable, frame, steady)
    cuts = [
        (name, side, order[:k] if side == BELOW else order[::-1][:k], _limit(values, order, k, side))
        for name, values in states
        for order in [np.argsort(values, kind="stable")]
        for side in (BELOW, ABOVE)
        for k in range(FEWEST_LOUD, len(usable) // 2 + 1)
        if _parted(values, order, k, side)
    ]
    if not cuts:
        return None
    inside = np.zeros((len(cuts), len(usable)))
    for row, (_, _, chosen, _) in enumerate(cuts):
        inside[row, chosen] = 1.0
    found = _differences(inside, size[None])[0]
    rng = np.random.default_rng([seed, 11])
    shuffled = np.array([rng.permutation(size) for _ in range(SURROGATES)])
    largest = _differences(inside, shuffled).max(axis=1)
    loudest = int(np.argmax(found))
    name, side, chosen, limit = cuts[loudest]
    if (name, side) == ("speed", ABOVE):
        return None
    others = np.setdiff1d(np.arange(len(usable)), chosen)
    usual = float(np.median(squares[others]))
    ratio = float(np.median(squares[chosen])) / max(usual, 1e-300)
    if ratio < criteria.MORE_THAN_NOISE**2:
        return None
    p = float(np.clip(tail_probability(largest, float(found[loudest]), 0.0), criteria.LEAST_P, 1.0))
    strongest = chosen[np.argsort(-squares[chosen])]
    return Scatter(
        name,
        side,
        limit,
        tuple(usable[k].recording for k in strongest),
        tuple(float(max(squares[k] - usual, 0.0)) for k in strongest),
        usual,
        float(np.sqrt(ratio)),
        p,
    )


def _keeps_its_load(frame: Frame, rows: NDArray[np.bool_]) -> bool:
    """Whether the load of some rows of a frame is one level."""
    largest = float(np.max(np.abs(frame.torque), initial=0.0))
    return float(np.std(frame.torque_level[rows])) <= criteria.KEEPS_ITS_LOAD * largest


def _mean_square(one: Density) -> float:
    """Mean square of a recording's steady part over the frequencies of noise, lines left out."""
    first, last = int(np.ceil(LOWEST_HZ / one.step)), int(NYQUIST_SHARE * one.rate / one.step)
    power = np.asarray(one.power[first:last], dtype=np.float64)
    level = median_filter(power, ABOUT, mode="nearest")
    return float(np.sum(np.where(power > criteria.LINE_POWER * level, level, power)) * one.step)


def _states(densities: Sequence[Density], frame: Frame, steady: FloatArray) -> list[tuple[str, FloatArray]]:
    """Quantities with their mean in each recording (r,).

    The speed is the first: where another quantity changed with it, it is the speed.
    """

    def means(values: FloatArray) -> FloatArray:
        return np.array([np.average(values[r], weights=steady[r]) for r in rows])

    rows = [np.flatnonzero((frame.recording == d.recording) & (steady > 0.0)) for d in densities]
    return [
        ("speed", means(np.abs(frame.velocity))),
        ("torque", means(frame.torque_level)),
        ("load", means(np.abs(frame.torque_level))),
        ("temperature", means(frame.temperature)),
        ("time", means(frame.time)),
    ]


def _parted(values: FloatArray, order: IntArray, k: int, side: str) -> bool:
    """Whether a state's values differ at the cut: recordings of one setting stay together."""
    at = k if side == BELOW else values.size - k
    below, above = float(values[order[at - 1]]), float(values[order[at]])
    return above - below > 1e-2 * max(abs(below), abs(above))


def _limit(values: FloatArray, order: IntArray, k: int, side: str) -> float:
    at = k if side == BELOW else values.size - k
    return float(0.5 * (values[order[at - 1]] + values[order[at]]))


def _differences(inside: FloatArray, ranks: FloatArray) -> FloatArray:
    """Standardised rank sums (m, cuts) of the recordings inside a cut (Wilcoxon, Biometrics Bull. 1 (1945) 80)."""
    number, every = inside.sum(axis=1), ranks.shape[1]
    expected = 0.5 * number * (every + 1.0)
    spread = np.sqrt(number * (every - number) * (every + 1.0) / 12.0)
    return np.asarray((ranks @ inside.T - expected) / spread)
