"""What changed between two gearboxes, or one before and after wear: differences against their uncertainty.

A parameter counts as changed where its difference exceeds what chance explains with a family-wise error of 5 % over
all parameters looked at (Holm 1979). Standard deviations rest on few recordings, so differences follow Student's t and
vectors Hotelling's T², with the degrees of freedom that stand in the files. An order is compared as the vector
A·(cos φ, sin φ) at common operating points: phase and amplitude have no meaning of their own where an order is small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, f, norm, t

from bench.identification.loads import same_loads
from bench.identification.statistics.freedom import parameter_freedom, series_freedom
from bench.simulation import TERM_COUNT, FourierSet, Simulation, basis

FloatArray = NDArray[np.float64]

FAMILY_ERROR = 0.05
POINTS = (
    (0.0, 5.0, 30.0),
    (600.0, 5.0, 30.0),
    (-600.0, 5.0, 30.0),
    (0.0, 8.0, 30.0),
    (0.0, 5.0, 42.0),
)
"""Where orders are compared: N·m, deg/s (signed by the direction), °C; the middle of the paper's ranges and near."""


@dataclass(frozen=True, slots=True)
class Change:
    """One thing compared: ``before`` and ``after`` in ``unit``, how many standard deviations, and whether it counts.

    ``p_value`` is NaN where an uncertainty is missing, or conditions both have in common; nothing is claimed then.
    """

    what: str
    kind: str
    unit: str
    before: float
    after: float
    std: float
    p_value: float
    changed: bool = False


def _two_sided(difference: float, first: float, second: float, freedom: tuple[float, float]) -> tuple[float, float]:
    """Standard deviation of a difference, and the chance of one as large; Welch's degrees of freedom."""
    std = float(np.hypot(first, second))
    ratio = abs(difference) / max(std, 1e-300)
    share = (first / max(std, 1e-300)) ** 4 / freedom[0] + (second / max(std, 1e-300)) ** 4 / freedom[1]
    return std, float(2.0 * (t.sf(ratio, 1.0 / share) if share > 0.0 else norm.sf(ratio)))


def _vector_chance(distance: float, freedom: float) -> float:
    """Chance of a squared distance (in covariances) of two components as large: Hotelling's T²."""
    if not np.isfinite(freedom):
        return float(chi2.sf(distance, 2))
    if freedom <= 1.0:
        return 1.0
    return float(f.sf(distance * (freedom - 1.0) / (2.0 * freedom), 2, freedom - 1.0))


def _parameters(a: Simulation, b: Simulation) -> list[Change]:
    out = []
    for effect, term in a.terms.items():
        other = b.terms.get(effect)
        for symbol, first in term.parameters.items():
            second = other.parameters.get(symbol) if other is not None else None
            if second is None:
                continue
            p_value = std = float("nan")
            if first.std is not None and second.std is not None:
                freedom = parameter_freedom(term, symbol), parameter_freedom(other, symbol)
                std, p_value = _two_sided(second.value - first.value, first.std, second.std, freedom)
            out.append(Change(f"{effect} {symbol}", "parameter", first.unit, first.value, second.value, std, p_value))
    return out


def _vector(fourier: FourierSet, k: int, x: FloatArray) -> tuple[FloatArray, FloatArray | None]:
    """Vector (2,) of an order at monomials ``x`` (10,), and its covariance (2, 2)."""
    amplitude, phase = float(fourier.amplitude[k] @ x), float(fourier.phase[k] @ x)
    c, s = np.cos(phase), np.sin(phase)
    value = amplitude * np.array([c, s])
    if fourier.covariance is None:
        return value, None
    rows = np.zeros((2, 2 * TERM_COUNT))
    rows[0, :TERM_COUNT], rows[1, :TERM_COUNT] = c * x, s * x
    rows[0, TERM_COUNT:], rows[1, TERM_COUNT:] = -amplitude * s * x, amplitude * c * x
    return value, rows @ fourier.covariance[k] @ rows.T


def _same_terms(a: FourierSet, k: int, b: FourierSet, j: int) -> bool:
    """Whether both have the same terms of the polynomials: one that recordings do not determine is left at 0, exactly.

    Where only one has measured at several torques (speeds, temperatures), the other says nothing of where to compare.
    """
    assert a.covariance is not None
    assert b.covariance is not None
    return np.array_equal(np.diag(a.covariance[k]) > 0.0, np.diag(b.covariance[j]) > 0.0)


def _orders(a: FourierSet, b: FourierSet, direction: str, sign: float, freedom: tuple[float, float]) -> list[Change]:
    out = []
    for k, order in enumerate(a.orders):
        at = np.flatnonzero(b.orders == order)
        if at.size == 0:
            continue
        smallest, size_a, size_b, deviation = 1.0, 0.0, 0.0, float("nan")
        known = True
        for number, (torque, velocity, temperature) in enumerate(POINTS):
            x = basis(torque, sign * np.deg2rad(velocity), temperature)
            first, cov_a = _vector(a, k, x)
            second, cov_b = _vector(b, int(at[0]), x)
            if cov_a is None or cov_b is None or not _same_terms(a, k, b, int(at[0])):
                known = False
            else:
                total = cov_a + cov_b
                off = second - first
                distance = float(off @ np.linalg.pinv(total, hermitian=True) @ off)
                # the smaller of both counts: what the joint covariance rests on is between them and their sum
                smallest = min(smallest, _vector_chance(distance, min(freedom)))
                if number == 0:
                    deviation = float(np.sqrt(0.5 * np.trace(total)))
            if number == 0:
                size_a, size_b = float(np.hypot(*first)), float(np.hypot(*second))
        # The best of several points was taken: Bonferroni.
        p_value = min(1.0, smallest * len(POINTS)) if known else float("nan")
        out.append(Change(f"order {order:g}, {direction}", "order", "rad", size_a, size_b, deviation, p_value))
    return out


def _offset(
    a: FourierSet, b: FourierSet, direction: str, sign: float, freedom: tuple[float, float], same_range: bool
) -> Change:
    """Compliance, the part of a₀ that torque makes: −∂a₀/∂τ at the middle of the ranges.

    It is judged over one range of torques only: a polynomial over another range has another slope of the same curve.
    """
    x = basis(0.0, sign * np.deg2rad(5.0), 30.0)
    gradient = np.zeros(TERM_COUNT)
    gradient[3], gradient[6], gradient[7] = 1.0, x[4], x[5]
    first, second = -float(a.offset @ gradient), -float(b.offset @ gradient)
    p_value = std = float("nan")
    covariances = (a.offset_covariance, b.offset_covariance)
    # without several torques there is no term of the torque, and no compliance
    if same_range and all(covariance is not None and covariance[3, 3] > 0.0 for covariance in covariances):
        assert a.offset_covariance is not None
        assert b.offset_covariance is not None
        one, two = (float(np.sqrt(gradient @ c @ gradient)) for c in (a.offset_covariance, b.offset_covariance))
        std, p_value = _two_sided(second - first, one, two, freedom)
    return Change(f"compliance, {direction}", "compliance", "rad/(N*m)", first, second, std, p_value)


def holm(p_values: Sequence[float], level: float = FAMILY_ERROR) -> list[bool]:
    """Which hypotheses Holm's step-down rejects at a family-wise ``level``; NaN never is."""
    rejected = [False] * len(p_values)
    known = sorted((p, i) for i, p in enumerate(p_values) if np.isfinite(p))
    for rank, (p, i) in enumerate(known):
        if p > level / (len(known) - rank):
            break
        rejected[i] = True
    return rejected


def compare(before: Simulation, after: Simulation) -> list[Change]:
    """Compare two simulations: parameters, orders of both directions, compliance; changes that count come first."""
    changes = _parameters(before, after)
    first, second = before.transmission_error(), after.transmission_error()
    if first is not None and second is not None:
        for direction, sign in (("positive", 1.0), ("negative", -1.0)):
            a, b = first.direction(sign), second.direction(sign)
            if a is not None and b is not None:
                freedom = series_freedom(before, direction), series_freedom(after, direction)
                changes += _orders(a, b, direction, sign, freedom)
                changes.append(_offset(a, b, direction, sign, freedom, same_loads(before, after, direction)))
    verdicts = holm([c.p_value for c in changes])
    marked = [
        Change(c.what, c.kind, c.unit, c.before, c.after, c.std, c.p_value, verdict)
        for c, verdict in zip(changes, verdicts, strict=True)
    ]
    return sorted(marked, key=lambda c: (not c.changed, c.p_value if np.isfinite(c.p_value) else 2.0))


def to_json(changes: Sequence[Change]) -> list[dict[str, Any]]:
    """Return the changes as JSON values; NaN becomes null."""

    def number(value: float) -> float | None:
        return value if np.isfinite(value) else None

    return [
        {
            "what": c.what,
            "kind": c.kind,
            "unit": c.unit,
            "before": c.before,
            "after": c.after,
            "std": number(c.std),
            "p_value": number(c.p_value),
            "changed": c.changed,
        }
        for c in changes
    ]
