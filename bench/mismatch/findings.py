"""What was found, as the report has it: one finding an effect, with status, confidence, location, parameters and
evidence.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.stats import chi2

from bench.mismatch import bands
from bench.mismatch.judge import Alternative, Found
from bench.mismatch.locate import Location
from bench.simulation.frame import FloatArray
from bench.simulation.terms import LIBRARY

AMBIGUOUS_GAIN = 3.0
AMBIGUOUS_SHARE = 0.12
"""of the gain: an alternative that explains all but this is as good, unless it is further off than its error"""
AMBIGUOUS_ERRORS = 1.7
ALIKE = 0.012
"""of the gain: an alternative that loses less is as good, however sure the difference: the design shows hardly any"""
AT_MOST = 0.3
"""of the gain: what an alternative within one standard error may lose"""
UNKNOWN_NAME = "structure that no term of the library explains"


@dataclass(slots=True)
class Finding:
    """One finding of the report."""

    effect: str
    status: str
    confidence: float
    channel: str
    location: Location
    equation: str
    parameters: list[dict[str, Any]]
    gain: float
    rmse_before: float
    rmse_after: float
    alternatives: list[dict[str, Any]] = field(default_factory=list)
    also_in: list[str] = field(default_factory=list)
    numbers: int = 1
    next_experiment: dict[str, Any] | None = None
    source: Any = None
    form: str = ""
    point: tuple[float, ...] = ()
    more: list[Finding] = field(default_factory=list)
    """the same effect in other channels or at other orders, told with this one"""

    @property
    def name(self) -> str:
        """The effect in words."""
        return LIBRARY[self.effect].name if self.effect in LIBRARY else UNKNOWN_NAME

    @property
    def p_value(self) -> float:
        """Of the likelihood ratio, for all looks at a bank of some hundred candidates."""
        return float(min(1.0, 300.0 * chi2.sf(2.0 * max(self.gain, 0.0), self.numbers + 1)))

    def to_json(self) -> dict[str, Any]:
        """The finding as the report has it."""
        return {
            "effect": self.effect,
            "name": self.name,
            "status": self.status,
            "confidence": round(self.confidence, 3),
            "channel": self.channel,
            "also_in": self.also_in,
            "location": self.location.to_json(),
            "equation": self.equation,
            "parameters": self.parameters,
            "evidence": {
                "held_out_rmse_before": self.rmse_before,
                "held_out_rmse_after": self.rmse_after,
                "p_value": self.p_value,
            },
            "alternatives": self.alternatives,
            **({"next_experiment": self.next_experiment} if self.next_experiment else {}),
        }


def parameters(channel: str, found: Found) -> list[dict[str, Any]]:
    """Linear and nonlinear parameters of a found term, with units and standard deviations."""
    entry = found.entry
    if entry.effect == "unknown":
        coefficients = [
            {"symbol": f"c_{i}", "value": float(v), "unit": "1", "std": float(s)}
            for i, (v, s) in enumerate(zip(found.coefficients, _std(found), strict=True))
        ]
        return coefficients + (bands.parameters(channel, entry.form, entry.point) if entry.point else [])
    form = next(f for f in LIBRARY[entry.effect].forms[channel] if f.name == entry.form)
    out = [
        {"symbol": symbol.symbol, "value": float(v), "unit": symbol.unit, "std": float(s)}
        for symbol, v, s in zip(form.linear, found.coefficients, _std(found), strict=True)
    ]
    deviation = entry.deviation or tuple(0.0 for _ in entry.point)
    for symbol, value, std in zip(form.nonlinear, entry.point, deviation, strict=True):
        out.append({"symbol": symbol.symbol, "value": float(value), "unit": symbol.unit, "std": std})
    return out


def free_equation(channel: str, found: Found) -> str:
    """The equation of a free function."""
    entry = found.entry
    if entry.point:
        return bands.equation(channel, entry.form)
    return f"{channel} += f({', '.join(entry.variables)}), free form"


def _std(found: Found) -> FloatArray:
    return np.asarray(np.sqrt(np.maximum(np.diag(found.covariance), 0.0)))


def as_good(alternative: Alternative, found: Found) -> bool:
    """Whether an alternative cannot be told from the chosen term: within a standard error, or within little of the
    gain. A term of the nominal simulation is not doubted for a curve that only comes near it.
    """
    gain = found.gain
    if alternative.contains:
        return False
    if found.entry.effect in LIBRARY and LIBRARY[found.entry.effect].nominal:
        return alternative.loss < AMBIGUOUS_GAIN
    if alternative.loss < ALIKE * gain:
        return True
    if alternative.strained:
        return False
    if alternative.loss < alternative.error and alternative.loss < AT_MOST * gain:
        return True
    near = max(AMBIGUOUS_GAIN, AMBIGUOUS_ERRORS * alternative.error)
    return alternative.loss < near and alternative.loss < AMBIGUOUS_SHARE * gain


def alternatives_json(found: Found, rmse: float) -> list[dict[str, Any]]:
    """The alternatives as the report has them, with what speaks against each."""
    out = []
    for alternative in found.alternatives[:4]:
        told = as_good(alternative, found)
        why = (
            "contains the finding as a special case and gains nothing beyond it"
            if alternative.contains
            else "explains the recordings as well: they cannot tell the two apart"
            if told
            else f"loses {alternative.loss:.0f} of log-likelihood on recordings left out "
            f"(standard error {alternative.error:.0f}; the finding gains {found.gain:.0f})"
        )
        share = min(max(alternative.loss / max(found.gain, 1e-9), 0.0), 1.0)
        out.append({"effect": alternative.entry.effect, "held_out_rmse": rmse * (1.0 + 0.5 * share), "why_not": why})
    return out


def confidence(status: str, gain: float, loss: float) -> float:
    """How likely the name is right: by how much it gains, and by how far the next name is behind.

    The curve was set on folders with concealed effects (``bench prove``).
    """
    strength = 1.0 - np.exp(-max(gain, 0.0) / 25.0)
    apart = 1.0 - np.exp(-max(loss, 0.0) / 10.0)
    if status == "ambiguous":
        return float(0.75 + 0.1 * strength * (1.0 - apart))
    if status == "unknown":
        return float(0.5 + 0.45 * strength)
    return float(np.clip(0.35 + 0.63 * strength * apart, 0.05, 0.98))
