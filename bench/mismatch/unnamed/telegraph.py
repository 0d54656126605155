"""Telegraphs: what is left jumps between two levels at random, as a bearing seat or a contact that is loose does.

Two descriptions of the residual in steady motion are compared, each with an offset of each piece of a recording that is
not known: a chain of two levels with white noise (Rabiner, Proc. IEEE 77 (1989) 257), and Gaussian noise whose spectrum
may be the same (two first-order processes and white noise). The chain is fitted to every other recording and asked of
the rest, and the other way round; the Gaussian noise is fitted to the recordings that are asked. Such a split
likelihood ratio is above 1/p in a share p of all folders at most, whatever the noise's spectrum (Wasserman, Ramdas and
Balakrishnan, PNAS 117 (2020) 16880).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from bench.mismatch import criteria
from bench.mismatch.regression.state import Search
from bench.mismatch.unnamed.binned import BIN_S, Pieces, binned, in_steady_motion
from bench.mismatch.unnamed.gaussian_noise import best_likelihood
from bench.mismatch.unnamed.two_levels import Chain, added, fitted_chain, jumps, log_likelihood
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import factor

FACTORS = ("1", "d")
"""what the jumps may be multiplied with: nothing, or the direction, as friction is"""
FEWEST_JUMPS = 10.0
"""jumps up and down in the campaign below which nobody can say that they come at random: of so many their rate is known
to a third"""


@dataclass(frozen=True, slots=True)
class Telegraph:
    """Two levels: what they are multiplied with, their distance, mean stays (s) in the lower and the upper one, and the
    p-value; ``course`` (n,): what it adds to each row of the channel, about the mean of its piece.

    How uncertain distance and stays are is not known: the noise of the chain is white, that of a channel is not.
    """

    times: str
    height: float
    stays: tuple[float, float]
    p_value: float
    course: FloatArray


def telegraph(search: Search) -> Telegraph | None:
    """The clearest telegraph in what a channel's model leaves in steady motion; None where none can be told."""
    shown = in_steady_motion(search)
    if shown is None:
        return None
    frame = shown.frame
    looks: list[Telegraph] = []
    for times in FACTORS:
        pieces = binned(frame, shown.left * factor(times, frame), shown.number)
        if pieces is None:
            return None
        found = _look(pieces, criteria.LEAST_STRENGTH * search.model.floor)
        if found is not None:
            course = np.zeros(search.model.problem.rows.size)
            values = added(pieces, found[0])[pieces.piece, pieces.bin]
            course[shown.rows[pieces.rows]] = values * factor(times, frame)[pieces.rows]
            chain, chance = found
            # single bins that stand out are no evidence of jumps; where there are jumps they are short stays
            chain = fitted_chain(pieces.every_bin()) or chain
            stays = (BIN_S / chain.leave[0], BIN_S / chain.leave[1])
            p = max(min(1.0, len(FACTORS) * chance), criteria.LEAST_P)
            looks.append(Telegraph(times, chain.height, stays, p, course))
    return min(looks, key=lambda t: t.p_value, default=None)


def _look(pieces: Pieces, least: float) -> tuple[Chain, float] | None:
    """The chain of all pieces and its p-value; None where there is none that lasts and is of the ``least`` size that is
    reported of anything, or Gaussian noise says as much.
    """
    halves = [np.unique(pieces.recording, return_inverse=True)[1] % 2 == k for k in (0, 1)]
    ratios = []
    for fitted, rest in (halves, halves[::-1]):
        chain = fitted_chain(pieces.some(fitted))
        if chain is None or not chain.lasting or chain.size < least:
            return None
        ratios.append(_ratio(pieces.some(rest), chain))
        if ratios[-1] is None:
            return None
    whole = fitted_chain(pieces)
    if whole is None or not whole.lasting or jumps(pieces, whole) < FEWEST_JUMPS:
        return None
    e_value = float(logsumexp(np.array(ratios, dtype=np.float64)) - np.log(2.0))
    return whole, float(np.exp(-max(e_value, 0.0)))


def _ratio(pieces: Pieces, chain: Chain) -> float | None:
    """Logarithm of the likelihood of a chain over that of the best Gaussian noise; None where it is below one."""
    of_chain = log_likelihood(pieces, chain)
    ratio = of_chain - best_likelihood(pieces, of_chain)
    return ratio if ratio > 0.0 else None
