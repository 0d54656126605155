"""The stored result of coverage as Markdown: by symbol, by kind of coefficient, and what comparisons call changed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.stats import beta

from bench.identification.comparison.coverage import LIMIT
from bench.identification.comparison.power import CHANGES, SHARES

GOAL = (0.92, 0.98)
_UNITS = {
    "f_c": "N·m", "f_v": "N·m·s/rad", "f_vT": "N·m·s/(rad·K)", "f_l": "1", "J": "kg·m²", "tau_0": "N·m", "C": "J/K",
    "R": "K/W", "T_amb": "°C", "f_b": "N·m", "J_L": "kg·m²", "z_0": "N·m",
}  # fmt: skip
_KINDS = {"A": "amplitudes", "phi": "phases", "absent": "amplitudes of orders that the plant lacks", "a0": "a₀"}


def interval(right: int, tries: int) -> tuple[float, float]:
    """Clopper and Pearson's 95 % interval of a share."""
    low = float(beta.ppf(0.025, right, tries - right + 1)) if right else 0.0
    high = float(beta.ppf(0.975, right + 1, tries - right)) if right < tries else 1.0
    return low, high


def _count_covered(z: Sequence[float | None]) -> tuple[int, int]:
    known = np.asarray([v for v in z if v is not None])
    return int((np.abs(known) <= LIMIT).sum()), int(known.size)


def _verdict(right: int, tries: int) -> str:
    low, high = interval(right, tries)
    share = right / tries
    if GOAL[0] <= share <= GOAL[1]:
        return "yes"
    return "not distinguishable" if low <= GOAL[1] and high >= GOAL[0] else "no"


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _head(cells: Sequence[str]) -> list[str]:
    return [_row(cells), _row(["---"] * len(cells))]


def symbols(campaigns: Sequence[Mapping[str, Any]]) -> list[str]:
    """Lines of the table by symbol of the slow equations."""
    out = _head(
        ["symbol", "truth", "mean found", "scatter of found", "stated", "covered", "95 % interval", "92 to 98 %"]
    )
    for symbol, unit in _UNITS.items():
        rows = [c["parameters"][symbol] for c in campaigns if symbol in c["parameters"]]
        if not rows:
            out.append(_row([symbol, "", "not determined", "", "", "", "", ""]))
            continue
        out.append(_symbol(symbol, unit, rows, "std", "z"))
        if any(r.get("repeat_std", r["std"]) < r["std"] for r in rows):
            out.append(_symbol(f"{symbol}, without what recordings share", unit, rows, "repeat_std", "repeat_z"))
    return out


def _symbol(name: str, unit: str, rows: Sequence[Mapping[str, Any]], std: str, z: str) -> str:
    """Line of one symbol, by the standard deviations and deviates under these keys; rows without count as they are."""
    off = np.asarray([r["value"] - r["truth"] for r in rows])
    truth, stated = (
        float(np.mean([r["truth"] for r in rows])),
        float(np.sqrt(np.mean([r.get(std, r["std"]) ** 2 for r in rows]))),
    )
    right, tries = _count_covered([r.get(z, r["z"]) for r in rows])
    low, high = interval(right, tries)
    scatter = f"{off.std(ddof=1):.2g}" if off.size > 1 else ""
    return _row([
        name, f"{truth:.4g} {unit}", f"{truth + off.mean():.6g}", scatter, f"{stated:.2g}",
        f"{right} of {tries} ({100 * right / tries:.1f} %)", f"{100 * low:.0f} to {100 * high:.0f} %",
        _verdict(right, tries),
    ])  # fmt: skip


def series(campaigns: Sequence[Mapping[str, Any]]) -> list[str]:
    """Lines of the table of the transmission error's coefficients by direction and kind."""
    out = _head(["direction", "coefficients", "number", "covered", "lowest and highest campaign", "92 to 98 %"])
    for direction in ("positive", "negative"):
        for kind, name in _KINDS.items():
            each = [_count_covered(c["series"][direction].get(kind, ())) for c in campaigns if direction in c["series"]]
            right, tries = sum(r for r, _ in each), sum(n for _, n in each)
            if not tries:
                continue
            shares = [r / n for r, n in each]
            # coefficients of one campaign share their noise, so no interval is made of their number
            verdict = "yes" if GOAL[0] <= right / tries <= GOAL[1] else "no"
            bounds = f"{100 * min(shares):.0f} to {100 * max(shares):.0f} %"
            out.append(_row([direction, name, str(tries), f"{100 * right / tries:.1f} %", bounds, verdict]))
    return out


def comparisons(pairs: Sequence[Mapping[str, Any]]) -> list[str]:
    """Lines on false changes and on the changes found."""
    wrong = [p for p in pairs if p["changed"]]
    low, high = interval(len(wrong), len(pairs))
    campaigns = len({seed for p in pairs for seed in (p["before"], p["after"])})
    listed = "; ".join(f"{p['before']} and {p['after']}: {', '.join(p['changed'])}" for p in wrong)
    out = [
        f"{len(wrong)} of {len(pairs)} comparisons of the same plant call something changed "
        f"({100 * len(wrong) / len(pairs):.1f} %, 95 % interval {100 * low:.0f} to {100 * high:.0f} %; promised is "
        f"at most 5 %)."
        + (f" They are: {listed}." if listed else "")
        + (
            f" The pairs are of {campaigns} campaigns, so they are not independent and the interval is too narrow."
            if 2 * len(pairs) > campaigns
            else ""
        ),
        "",
        *_head(["changed is", *(f"by {100 * share:g} %" for share in SHARES)]),
    ]
    for name in CHANGES:
        tried = [p["power"][name] for p in pairs if p["power"][name] is not None]
        found = [f"found in {sum(one[i] for one in tried)} of {len(tried)}" for i in range(len(SHARES))]
        out.append(_row([name, *(found if tried else ["not in these models"] * len(SHARES))]))
    return out


def page(content: Mapping[str, Any]) -> str:
    """Return the whole page from a stored result."""
    campaigns, pairs = content["campaigns"], content["pairs"]
    seeds = sorted(c["seed"] for c in campaigns)
    commits = sorted({c["commit"][:12] for c in campaigns if c["commit"]})
    parts: list[tuple[str, Callable[[], list[str]]]] = [
        ("Slow equations", lambda: symbols(campaigns)),
        ("Transmission error", lambda: series(campaigns)),
    ]
    if pairs:
        parts.append(("Comparisons", lambda: comparisons(pairs)))
    lines = [
        "# Do the intervals hold the truth?",
        "",
        f"{len(campaigns)} of {content.get('asked') or len(campaigns)} short campaigns asked for (seeds {seeds[0]} to "
        f"{seeds[-1]}), on the emulated bench `{content['bench']}`, weaker orders on;",
        "95 % intervals. Made by",
        f"`{content['command']}`; commits {', '.join(commits) or 'not known'}.",
    ]
    for title, make in parts:
        lines += ["", f"## {title}", "", *make()]
    return "\n".join(lines) + "\n"
