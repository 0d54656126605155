"""How far the offset's polynomial may bend: spread of its coefficients by the evidence of the recordings themselves.

Some twenty recordings a direction determine ten coefficients badly: free ones follow the noise and go astray at the
corners of the design that were held out. Linear coefficients (of speed and temperature) and those of second order get a
normal prior each, whose spread is where the marginal likelihood of all training recordings is highest (empirical Bayes,
MacKay, Neural Comput. 4 (1992) 415). The compliance and the constant stay free.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.bank import Bank, Fit
from bench.mismatch.regression.model import Block, add_base, fit_blocks, kept_small, prepare_bank
from bench.mismatch.regression.problem import NUISANCE, ChannelProblem
from bench.simulation.frame import FloatArray

_MONOMIALS = 10
_GROUPS = ((4, 5), (0, 1, 2, 6, 7, 8))
"""numbers of the monomials that are linear in speed and temperature, and of second order"""
_SPREADS = tuple(np.geomspace(0.003, 30.0, 13).tolist())
"""root mean square of what a coefficient contributes, in units of a row's noise, that is tried"""
_WIDER = tuple(np.geomspace(30.0, 3000.0, 7)[1:].tolist())
"""the same of the linear coefficients where the largest of these is the likeliest: a straight line may be as steep as
it is, a curve that is as steep runs away where no recording holds it
"""

_ZEROS = (1.0, 16.0, 256.0, 4096.0)
"""times the precision of the sensors' zeros that is tried: they differ from recording to recording by as much as data
sheets allow, a quarter of that, a sixteenth, or hardly at all
"""


def calibrated_alone(
    problem: ChannelProblem, residual: FloatArray, wider: float = 1.0
) -> tuple[Bank, list[Block], Fit]:
    """The simulation's blocks with their prior, fitted without any effect, in a bank whitened by the noise that a
    ``residual`` (training rows,) shows, so many times ``wider``.
    """
    bank, *_ = prepare_bank(problem, residual, wider)
    blocks = settled(problem, bank, add_base(problem, bank))
    return bank, blocks, fit_blocks(bank, blocks, bank.variances())


def zeros_settled(
    problem: ChannelProblem, bank: Bank, base: Sequence[Block], beside: Sequence[Block] = ()
) -> list[Block]:
    """The simulation's blocks with the likeliest size of what stands for zeros of sensors, given effects ``beside``.

    Zeros that need not be there cost: beside a free zero of each heating run little is left that tells a heat capacity.
    Recordings and the stretches of long ones are asked apart.
    """
    number = next((k for k, b in enumerate(base) if b.regressor.effect == NUISANCE), None)
    if number is None or not problem.spec.integral:
        return list(base)
    block = base[number]
    given = next(term for term in problem.base if term.regressor is block.regressor).precisions(len(block.indices))
    blocks = [*base, *beside]
    index = [i for b in blocks for i in b.indices]
    first = sum(len(b.indices) for b in base[:number])
    of_zeros = np.arange(first, first + len(block.indices))
    # those of recordings have one precision, those of stretches another
    kinds = given == given[0]
    normal = bank.normal(index, bank.variances()[-1])
    whole = np.concatenate([b.precision for b in blocks])
    shrunk = np.zeros(whole.size, dtype=bool)
    shrunk[of_zeros] = True
    best, kept = -np.inf, given
    for of_recordings in _ZEROS:
        for of_stretches in _ZEROS if not kinds.all() else (1.0,):
            tried = given * np.where(kinds, of_recordings, of_stretches)
            whole[of_zeros] = tried
            found = _evidence(normal.gram, normal.right, normal.squares, whole, shrunk)
            if found > best:
                best, kept = found, tried
    out = list(base)
    out[number] = replace(block, precision=kept)
    return out


def settled(problem: ChannelProblem, bank: Bank, base: Sequence[Block], beside: Sequence[Block] = ()) -> list[Block]:
    """The simulation's blocks with the likeliest prior of the offset's coefficients, given effects ``beside``; others
    as they are. Without an effect that is there, offsets of the recordings take its place, and coefficients stay small.

    The recordings' own offsets are bounded by what their means leave.
    """
    del problem
    offset = next((k for k, b in enumerate(base) if b.regressor.effect == "te.offset"), None)
    if offset is None:
        return list(base)
    block = base[offset]
    energy = np.array([float(np.mean(bank.columns.column(i) ** 2)) for i in block.indices])
    groups = [np.array([k for k in range(len(energy)) if k % _MONOMIALS in g and energy[k] > 0.0]) for g in _GROUPS]
    index = [i for b in (*base, *beside) for i in b.indices]
    means = [i for b in (*base, *beside) if not kept_small(b) for i in b.indices]
    bank.bound_offsets(means, criteria.ERROR_RATE_OF_A_CHANNEL)
    first = sum(len(b.indices) for b in base[:offset])
    plain = np.concatenate([b.precision for b in (*base, *beside)])
    normals = [bank.normal(index, variance) for variance in bank.variances()[::3]]

    def precision(spreads: tuple[float, float]) -> FloatArray:
        out = np.zeros(len(energy))
        for group, spread in zip(groups, spreads, strict=True):
            out[group] = energy[group] / spread**2
        return out

    def evidence(spreads: tuple[float, float]) -> float:
        whole = plain.copy()
        whole[first : first + len(energy)] = precision(spreads)
        shrunk = np.zeros(whole.size, dtype=bool)
        shrunk[first : first + len(energy)] = whole[first : first + len(energy)] > 0.0
        found = (_evidence(n.gram, n.right, n.squares, whole, shrunk) - 0.5 * n.cost for n in normals)
        return max((one for one in found if np.isfinite(one)), default=-np.inf)

    best = max(itertools.product(_SPREADS, _SPREADS), key=evidence)
    wider = [(best[0], *_WIDER) if best[0] == _SPREADS[-1] else best[:1], best[1:]]
    best = max(itertools.product(*wider), key=evidence)
    out = list(base)
    out[offset] = replace(block, precision=precision(best))
    return out


def _evidence(
    gram: FloatArray,
    right: FloatArray,
    squares: float,
    precision: FloatArray,
    shrunk: np.ndarray[tuple[int], np.dtype[np.bool_]],
) -> float:
    """Logarithm of the marginal likelihood of a model with prior precisions (k,), those of ``shrunk`` coefficients
    proper.
    """
    energy = np.diag(gram) + precision
    scale = np.sqrt(np.where(energy > 0.0, energy, 1.0))
    normal = gram / scale[:, None] / scale[None, :] + np.diag(precision / scale**2 + 1e-9)
    lower = np.linalg.cholesky(normal)
    half = np.linalg.solve(lower, right / scale)
    volume = float(np.sum(np.log(np.diag(lower))) + np.sum(np.log(scale)))
    return float(-0.5 * (squares - half @ half) - volume + 0.5 * np.sum(np.log(precision[shrunk])))
