"""What changed since the last campaign, in three lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bench.trend.limits import LEAST
from bench.trend.quantities import Quantity
from bench.trend.series import Series

_MOST = 3


@dataclass(frozen=True, slots=True)
class Changed:
    """A quantity of the last two campaigns, SI: whether it changed beyond both uncertainties, over all together."""

    quantity: Quantity
    before: float
    after: float
    p_value: float
    changed: bool


def three_lines(
    series: Sequence[Series],
    compared: Sequence[Changed],
    campaigns: int,
    names: Sequence[str],
    waiting: int,
) -> tuple[str, ...]:
    """Return three sentences: what changed, the strongest changes, what is outside of its limits.

    ``names`` are the folders that were identified, oldest first; ``waiting`` of all ``campaigns`` are not yet.
    """
    missing = f" {waiting} of {campaigns} campaigns are not identified yet." if waiting else ""
    if len(names) < 2:
        there = "No campaign is identified" if not names else f"Only {names[0]} is identified"
        return (f"{there}; what changed takes two.{missing}",)
    hit = [c for c in compared if c.changed]
    first = (
        f"Since {names[-2]}: {len(hit)} of {len(compared)} quantities of {names[-1]} changed beyond the uncertainty of"
        f" both (one false alarm in twenty such comparisons).{missing}"
    )
    return first, _strongest(hit, compared), _outside_limits(series, names[-1])


def _strongest(hit: Sequence[Changed], compared: Sequence[Changed]) -> str:
    if hit:
        more = len(hit) - _MOST
        rest = f"; and {more} more" if more > 0 else ""
        return "Changed: " + "; ".join(_in_words(c) for c in hit[:_MOST]) + rest + "."
    if compared:
        return f"The largest difference for its uncertainty: {_in_words(compared[0])}."
    return "They have no quantity in common."


def _in_words(c: Changed) -> str:
    before, after = c.before * c.quantity.scale, c.after * c.quantity.scale
    unit = c.quantity.unit
    share = "" if before == 0.0 else f", {100.0 * (after / before - 1.0):+.2g} %"
    return f"{c.quantity.name} {before:.4g} → {after:.4g} {unit} (p {c.p_value:.1g}{share})"


def _outside_limits(series: Sequence[Series], last: str) -> str:
    judged, out = 0, []
    for one in series:
        point = one.points[-1]
        if point.folder != last or point.limits is None:
            continue
        judged += 1
        if point.outside:
            scale, limits = one.quantity.scale, point.limits
            sides = f"{limits.lower * scale:.4g} … {limits.upper * scale:.4g} {one.quantity.unit}"
            out.append(f"{one.quantity.name} {point.value.value * scale:.4g}, limits {sides}")
    if not judged:
        return f"There are no limits yet: they take {LEAST} earlier campaigns with the quantity."
    if not out:
        return f"All {judged} quantities that have limits are within them."
    more = f"; and {len(out) - _MOST} more" if len(out) > _MOST else ""
    return f"Outside of their limits: {len(out)} of {judged}: {'; '.join(out[:_MOST])}{more}."
