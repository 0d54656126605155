"""Campaigns are loaded and planned in a child process, within limits: anybody may send any numbers."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any, TypeVar

from bench.campaigns import load_campaign, make_plan, parse_campaign
from bench.campaigns.records.journal import require_same
from bench.configuration import BenchFile
from bench.errors import ConfigurationError, LimitError
from bench.names import require_name
from bench.recording import guarded

PLAN_S = 20.0
"""Of processor time: the longest shipped campaign is planned in less than two seconds."""
LONGEST_S = 60 * 86400.0
"""No campaign is longer; what would be has a number in it that nobody meant."""
R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class Planned:
    """What the service has to know of a campaign that may be run."""

    name: str
    title: str
    folder: str


def plan(source: str, bench: BenchFile, limit_s: float = PLAN_S) -> dict[str, Any]:
    """Return the plan of a campaign from room temperature; see :func:`require_possible` for what is refused."""
    return guarded.call(Path(source), _plan, source, bench, limit_s)


def plan_text(text: str, bench: BenchFile, limit_s: float = PLAN_S) -> dict[str, Any]:
    """Return the plan of a campaign that is no file yet; as :func:`plan`."""
    return guarded.call(Path("the draft"), _plan_text, text, bench, limit_s)


def require_possible(source: str, bench: BenchFile, folder: str | None, run: str, root: Path) -> Planned:
    """Return what a campaign is called and its folder below ``root``: ``folder``, or one named after it and the run.

    Raises
    ------
    BenchError
        If it is wrong, would break a limit, is another than that of the folder, or takes too long or too much memory.
    """
    return guarded.call(Path(source), _possible, source, bench, folder, run, root)


def _plan(source: str, bench: BenchFile, limit_s: float) -> dict[str, Any]:
    return _with_time_limit(limit_s, lambda: make_plan(load_campaign(source), bench.configuration).as_dict())


def _plan_text(text: str, bench: BenchFile, limit_s: float) -> dict[str, Any]:
    return _with_time_limit(
        limit_s, lambda: make_plan(parse_campaign(text, "the draft"), bench.configuration).as_dict()
    )


def _possible(source: str, bench: BenchFile, folder: str | None, run: str, root: Path) -> Planned:
    def look() -> Planned:
        campaign = load_campaign(source)
        # refused here and now if it would break a limit; the run plans again from the temperature it finds
        planned = make_plan(campaign, bench.configuration)
        if not 0.0 <= planned.duration_s <= LONGEST_S:
            raise LimitError(
                f"the campaign would take {planned.duration_s / 86400.0:.3g} days, more than {LONGEST_S / 86400.0:.0f};"
                " look for a number that is far too large"
            )
        place = root / require_name(folder or f"{campaign.name}-{run}", "the folder")
        require_same(place, campaign, bench)
        return Planned(campaign.name, campaign.title, str(place))

    return _with_time_limit(PLAN_S, look)


def _with_time_limit(limit_s: float, function: Callable[[], R]) -> R:
    """Return what the function returns, if it takes no longer; time can be limited in a main thread only."""

    def late(number: int, frame: FrameType | None) -> None:
        raise ConfigurationError(
            f"the campaign could not be planned within {limit_s:.0f} s of processor time; look for a number that is far"
            " too large"
        )

    in_main = threading.current_thread() is threading.main_thread()
    before = signal.signal(signal.SIGPROF, late) if in_main else None
    try:
        if in_main:
            signal.setitimer(signal.ITIMER_PROF, limit_s)
        return function()
    except (MemoryError, OverflowError) as error:
        raise ConfigurationError(
            "the campaign could not be planned within the memory there is; look for a number that is far too large"
        ) from error
    finally:
        if in_main:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            signal.signal(signal.SIGPROF, before)
