"""A gearbox's campaigns, found by its serial number in the archive, with their series and what changed last."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from bench.archive import Index, Query
from bench.errors import ConfigurationError
from bench.identification.comparison.compare import FAMILY_ERROR, holm
from bench.trend import kept
from bench.trend.limits import Limits, chance_of_change
from bench.trend.quantities import Reference
from bench.trend.sentences import Changed, three_lines
from bench.trend.series import Point, Series, reference_of, series_of

INDEX = ".archive.sqlite"
Progress = Callable[[str, int, int], None]


@dataclass(frozen=True, slots=True)
class Campaign:
    """One folder of a gearbox; ``state`` is ``identified``, ``not yet`` or ``impossible``, the last with ``why``."""

    folder: str
    title: str
    started_s: float
    recordings: int
    state: str
    why: str = ""


@dataclass(frozen=True, slots=True)
class Trend:
    """A gearbox over its campaigns, oldest first; values are SI, ``quantity.scale`` leads to the unit for people."""

    gearbox: str
    reference: Reference | None
    campaigns: tuple[Campaign, ...]
    series: tuple[Series, ...]
    changed: tuple[Changed, ...]
    lines: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """For JSON: values in the units of ``unit``."""
        at = self.reference
        return {
            "gearbox": self.gearbox,
            "lines": list(self.lines),
            "reference": None if at is None else asdict(at),
            "campaigns": [
                {"folder": c.folder, "title": c.title, "started_s": c.started_s, "recordings": c.recordings}
                | {"state": c.state, "why": c.why}
                for c in self.campaigns
            ],
            "series": [
                {"key": s.quantity.key, "name": s.quantity.name, "unit": s.quantity.unit}
                | {"points": [_point(point, s.quantity.scale) for point in s.points]}
                for s in self.series
            ],
            "changed": [
                {"key": c.quantity.key, "before": c.before * c.quantity.scale, "after": c.after * c.quantity.scale}
                | {"unit": c.quantity.unit, "p_value": c.p_value, "changed": c.changed}
                for c in self.changed
            ],
        }


def index_of(root: Path) -> Index:
    """Return the index of a folder of campaigns as they are now; where the folder takes no file, one made anew."""
    place = root if os.access(root, os.W_OK) else Path(tempfile.mkdtemp(prefix="bench-trend-"))
    index = Index(root, place / INDEX)
    index.refresh()
    return index


def trend(root: str | Path, gearbox: str, jobs: int = 1) -> Trend:
    """Return a gearbox over the campaigns below a folder; those that are not identified yet are, which takes its time.

    Raises
    ------
    ConfigurationError
        If there is no campaign of this gearbox.
    """
    root = Path(root)
    index = index_of(root)
    identify_missing(root, gearbox, index, jobs=jobs)
    return trend_of(root, gearbox, index)


def since_last(folder: Path) -> tuple[str, ...]:
    """Return what changed from the last identified campaign of a folder's gearbox to this one; nothing without one.

    An identification says so in its report. Campaigns after this one are left out.
    """
    index = index_of(folder.parent)
    every = _folders(index, Query(limit=0))
    mine = next((one for one in every if one["name"] == folder.name), None)
    if mine is None or not mine["gearbox"]:
        return ()
    before = [one for one in every if one["gearbox"] == mine["gearbox"] and one["first_s"] <= mine["first_s"]]
    dated = [(float(one["first_s"]), kept.load(folder.parent / one["name"])) for one in before]
    known = [(at, one) for at, one in dated if one is not None and one.model is not None]
    if len(known) < 2 or known[-1][1].folder != folder.name:
        return ()
    series = series_of(known, reference_of([one for _, one in known]))
    names = [one.folder for _, one in known]
    return three_lines(series, _compare_last_two(series, names), len(names), names, 0)


def gearboxes(index: Index) -> dict[str, int]:
    """Return how many campaigns there are of each serial number; the empty one stands for recordings without."""
    found: dict[str, int] = {}
    for folder in _folders(index, Query(limit=0)):
        found[folder["gearbox"]] = found.get(folder["gearbox"], 0) + 1
    return dict(sorted(found.items()))


def trend_of(root: Path, gearbox: str, index: Index, since_s: float | None = None) -> Trend:
    """Return what is kept of a gearbox's campaigns below ``root``; :func:`identify_missing` makes what is not.

    ``since_s`` (Unix time in s) leaves out what was before, as after a repair.

    Raises
    ------
    ConfigurationError
        If the archive has nothing of this gearbox.
    """
    folders = _of_gearbox(index, gearbox, since_s)
    campaigns, dated = [], []
    for folder in folders:
        one = kept.load(root / folder["name"])
        state = "not yet" if one is None else "impossible" if one.model is None else "identified"
        campaigns.append(
            Campaign(
                folder["name"],
                folder["campaign"],
                folder["first_s"],
                folder["recordings"],
                state,
                "" if one is None else one.why,
            )
        )
        if one is not None and one.model is not None:
            dated.append((float(folder["first_s"]), one))
    reference = reference_of([one for _, one in dated])
    series = series_of(dated, reference)
    names = [one.folder for _, one in dated]
    changed = _compare_last_two(series, names)
    waiting = sum(one.state == "not yet" for one in campaigns)
    return Trend(
        gearbox,
        reference,
        tuple(campaigns),
        series,
        changed,
        three_lines(series, changed, len(campaigns), names, waiting),
    )


def identify_missing(
    root: Path,
    gearbox: str,
    index: Index,
    since_s: float | None = None,
    jobs: int = 1,
    progress: Progress | None = None,
) -> int:
    """Identify each campaign of a gearbox of which nothing is kept; return how many were.

    ``progress`` is called with the folder, recordings done and recordings in all.
    """
    done = 0
    for folder in _of_gearbox(index, gearbox, since_s):
        path = root / folder["name"]
        if kept.load(path) is None:
            kept.identify(path, jobs, None if progress is None else partial(progress, folder["name"]))
            done += 1
    return done


def _folders(index: Index, query: Query) -> list[dict[str, Any]]:
    """Folders of usable recordings, oldest first."""
    found = [one for one in index.search(query).folders if one["first_s"] is not None]
    return sorted(found, key=lambda one: (one["first_s"], one["name"]))


def _of_gearbox(index: Index, gearbox: str, since_s: float | None) -> list[dict[str, Any]]:
    every = _folders(index, Query(gearbox=gearbox, since=since_s, limit=0))
    found = [one for one in every if one["gearbox"] == gearbox]
    if not found:
        known = ", ".join(name for name in gearboxes(index) if name) or "none with a serial number"
        when = "" if since_s is None else " since then"
        raise ConfigurationError(f'there is no campaign of gearbox "{gearbox}"{when}; there are: {known}')
    return found


def _compare_last_two(series: tuple[Series, ...], names: list[str]) -> tuple[Changed, ...]:
    """Compare the last two campaigns that were identified, in every quantity both have; most certain first."""
    if len(names) < 2:
        return ()
    rows = []
    for one in series:
        by_folder = {point.folder: point.value for point in one.points}
        if names[-2] in by_folder and names[-1] in by_folder:
            before, after = by_folder[names[-2]], by_folder[names[-1]]
            rows.append((one.quantity, before.value, after.value, chance_of_change(before, after)))
    verdicts = holm([row[3] for row in rows], FAMILY_ERROR)
    found = [Changed(*row, verdict) for row, verdict in zip(rows, verdicts, strict=True)]
    return tuple(sorted(found, key=lambda c: c.p_value))


def _point(point: Point, scale: float) -> dict[str, Any]:
    return {
        "folder": point.folder,
        "started_s": point.started_s,
        "value": point.value.value * scale,
        "std": point.value.std * scale,
        "limits": None if point.limits is None else _limits(point.limits, scale),
        "outside": point.outside,
    }


def _limits(limits: Limits, scale: float) -> dict[str, float]:
    return {
        "centre": limits.centre * scale,
        "lower": limits.lower * scale,
        "upper": limits.upper * scale,
        "scatter": limits.scatter * scale,
        "campaigns": limits.campaigns,
    }
