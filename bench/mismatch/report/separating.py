"""Points at which alternative explanations differ most: T-optimality between regressors.

Where one explanation were true, how far would the other, refitted to all recordings and the new points together, be off
(Atkinson and Fedorov, Biometrika 62 (1975) 57; Hunter and Reiner, Technometrics 7 (1965) 307)? With the alternative's
design X on a point's rows, the covariance C of its parameters from the recordings, and d the difference of the two
predictions, the expected gain of log-likelihood is dᵀ(σ²I + XCXᵀ)⁻¹d/2. Points are added one by one, each the one that
raises the least gain over all pairs most. σ² is the mean square of what the final model leaves of a row.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.mismatch.discovery import ChannelOutcome
from bench.mismatch.regression.problem import nominal_base
from bench.mismatch.regression.regressors import Named, Regressor
from bench.mismatch.report.candidates import Range, candidates, frame_of
from bench.mismatch.report.finding import Finding, name_of
from bench.mismatch.report.rules import Proposal
from bench.mismatch.report.truth import Truth, is_regressor, truth_of
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms import LIBRARY, TEMPERATURE

POINTS = 4
MOST_ALTERNATIVES = 3
WARM = 0.5
"""what the gain of a point counts that needs warming up: that takes an hour"""
ENOUGH = 40.0
"""expected gain of log-likelihood at which no further point is asked for"""
LEAST_STEP = 1.01
"""by which factor a further point has to raise the gain"""
MOST_ROWS = 20_000
"""rows of the recordings that the alternatives are refitted to: every k-th where there are more"""
LEAST_COLUMN = 1e-3
"""root mean square in the recordings that an alternative's column has at least: columns are of the order of one"""
RIDGE = 1e-9
"""relative: prior precision of coefficients that the recordings do not determine"""


def separating(finding: Finding, covered: Range, ratio: float) -> Proposal | None:
    """The points at which a finding and its equals differ most, each refitted; None where none tells them apart."""
    truth = truth_of(finding.discovery)
    alternatives = [a.effect for a in finding.alternatives if a.as_good and is_regressor(a.effect, finding.channel)]
    alternatives = list(dict.fromkeys(e for e in alternatives if e != finding.effect))[:MOST_ALTERNATIVES]
    if truth is None or not alternatives or finding.channel == TEMPERATURE:
        return None
    measured = Measured.of(finding, truth.term.effect)
    listed = list(candidates(covered))
    frames = [frame_of(c, covered, ratio) for c in listed]
    looks = [look for effect in alternatives for look in both_ways(measured, truth, effect, frames)]
    if not looks:
        return None
    chosen: list[int] = []
    least = 0.0
    while len(chosen) < POINTS and least < ENOUGH:
        gains = {k: min(look.gain([*chosen, k]) for look in looks) for k in range(len(listed)) if k not in chosen}
        best = max(gains, key=lambda k: min(gains[k], 2.0 * ENOUGH) * (1.0 if listed[k].temperature is None else WARM))
        if gains[best] <= LEAST_STEP * least:
            break
        least = gains[best]
        chosen.append(best)
    if not chosen:
        return None
    names = " and ".join(name_of(e) for e in (finding.effect, *alternatives))
    why = (
        f"at these points {names} differ most, each refitted to everything measured: "
        f"expected gain of log-likelihood {least:.0f} at least"
    )
    return Proposal(why, tuple(listed[k] for k in chosen))


@dataclass(frozen=True, slots=True)
class Measured:
    """The recordings as a design: frame of some rows, regressors of the simulation, variance of what a row leaves."""

    channel: str
    frame: Frame
    base: tuple[Regressor, ...]
    rows: FloatArray
    """1 where a row of the frame was fitted, else 0"""
    each: float
    """how many rows one stands for"""
    variance: float

    @classmethod
    def of(cls, finding: Finding, effect: str) -> Measured:
        """The recordings in which a finding is, as alternatives of ``effect`` are refitted to them."""
        outcome: ChannelOutcome = finding.outcome
        fitted = outcome.usable & ~outcome.held_out & (outcome.rows.number > 0)
        stride = max(1, -(-outcome.rows.size // MOST_ROWS))
        base: list[Regressor] = [t.regressor for t in nominal_base(finding.channel, (effect,))]
        variance = float(np.mean(outcome.left[fitted] ** 2)) if fitted.any() else outcome.floor**2
        frame = outcome.rows.frame.take(slice(None, None, stride))
        same = np.append(False, frame.recording[1:] == frame.recording[:-1])
        frame = replace(frame, step=np.where(same, np.diff(frame.elapsed, prepend=0.0), 0.0))
        rows = fitted[::stride].astype(np.float64)
        return cls(finding.channel, frame, tuple(base), rows, float(stride), max(variance, 1e-300))

    def design(self, frame: Frame, term: Named) -> FloatArray:
        """Columns (n, k) of the simulation and a term; finite ones."""
        columns = [r.columns(frame) for r in (*self.base, term)]
        stacked = np.hstack(columns)
        return np.where(np.isfinite(stacked), stacked, 0.0)


@dataclass(frozen=True, slots=True)
class Fit:
    """A term fitted in place of a truth, beside the simulation: its coefficients with their covariance."""

    term: Named
    coefficients: FloatArray
    covariance: FloatArray
    missed: float
    """sum of squares that it does not follow"""
    shifted: float
    """sum of squares of what the simulation beside it takes over"""

    def term_coefficients(self) -> FloatArray:
        """The term's own coefficients (k,)."""
        return self.coefficients[self.coefficients.size - len(self.term.form.linear) :]


def fitted_to(measured: Measured, effect: str, truth: FloatArray) -> Fit | None:
    """The form and point of an effect that, beside the simulation, come nearest to a truth (rows,).

    Where the recordings do not tell forms apart, the one for which the simulation has to change least: a term that is
    zero while the simulation follows the truth in its place explains nothing.
    """
    fits: list[Fit] = []
    for form in LIBRARY[effect].forms[measured.channel]:
        for point in form.grid(measured.frame):
            found = _at(measured, Named(LIBRARY[effect], measured.channel, form, point), truth)
            if found is not None:
                fits.append(found)
    least = min((fit.missed for fit in fits), default=0.0)
    # one more in twice the log-likelihood: within one standard error
    alike = [fit for fit in fits if fit.missed <= least + measured.variance / measured.each]
    return min(alike, key=lambda fit: fit.shifted, default=None)


def _at(measured: Measured, term: Named, truth: FloatArray) -> Fit | None:
    x = measured.design(measured.frame, term) * measured.rows[:, None]
    y = truth * measured.rows
    scale = np.sqrt(np.sum(x**2, axis=0))
    # a column next to nothing in the recordings could be given any size where nothing was measured
    if not np.any(scale[x.shape[1] - len(term.form.linear) :] > LEAST_COLUMN * np.sqrt(y.size)):
        return None
    scale = np.where(scale > 0.0, scale, 1.0)
    inner = x / scale
    inverse = np.linalg.inv(inner.T @ inner + RIDGE * np.eye(inner.shape[1]))
    beta = inverse @ (inner.T @ y)
    missed = float(np.sum((y - inner @ beta) ** 2))
    covariance = inverse * measured.variance / measured.each / np.outer(scale, scale)
    base = beta.size - len(term.form.linear)
    shifted = float(np.sum((inner[:, :base] @ beta[:base]) ** 2))
    return Fit(term, beta / scale, covariance, missed, shifted)


def both_ways(
    measured: Measured, truth: Truth, effect: str, frames: Sequence[Frame], most_rows: int | None = None
) -> list[Look]:
    """The alternative where the finding is true, and the finding where the alternative is true; of each frame
    ``most_rows`` count, spread evenly, all where None.
    """
    wrong = fitted_to(measured, effect, truth.on(measured.frame))
    if wrong is None:
        return []
    other = Truth(wrong.term, wrong.term_coefficients())
    back = fitted_to(measured, truth.term.effect, other.on(measured.frame))
    looks = [Look(measured, truth, wrong, frames, most_rows)]
    return looks if back is None else [*looks, Look(measured, other, back, frames, most_rows)]


class Look:
    """How far an explanation would be off at each candidate if another holds; both calibrated on the recordings."""

    def __init__(
        self, measured: Measured, true: Truth, wrong: Fit, frames: Sequence[Frame], most_rows: int | None = None
    ) -> None:
        self._covariance, self._variance = wrong.covariance, measured.variance
        self._parts: list[tuple[FloatArray, FloatArray]] = []
        for frame in frames:
            x = measured.design(frame, wrong.term)
            d = true.on(frame) - x @ wrong.coefficients
            # a memory runs through all rows, so they are picked last
            kept = np.unique(np.linspace(0, frame.size - 1, min(most_rows or frame.size, frame.size)).astype(int))
            self._parts.append((x[kept], d[kept]))

    def gain(self, chosen: Sequence[int]) -> float:
        """Expected log-likelihood by which the points ``chosen`` together speak against the wrong explanation."""
        x = np.vstack([self._parts[k][0] for k in chosen])
        d = np.concatenate([self._parts[k][1] for k in chosen])
        # (σ²I + XCXᵀ)⁻¹ by the lemma of Woodbury: C may be large where the recordings determine little
        scale = np.sqrt(np.maximum(np.diag(self._covariance), 1e-300))
        inner = x * scale
        core = np.linalg.pinv(self._covariance / scale[:, None] / scale[None, :], rcond=1e-10)
        right = inner.T @ d / self._variance
        left = d @ d / self._variance - right @ np.linalg.solve(core + inner.T @ inner / self._variance, right)
        return float(max(0.5 * left, 0.0))
