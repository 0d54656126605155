"""What may be said of the shafts after a press of STOP: seen at rest or not, and after how long on which clock."""

from __future__ import annotations

LONGEST_WAY_NS = 600 * 10**9
"""A stamp that arrives later than this is of a clock that is wrong."""


def is_own_time(pressed_at_ns: int, arrived_at_ns: int) -> bool:
    """Whether a press may have been at this Unix time (ns), by the clock of the computer it arrived at.

    A stamp that lies ahead of its own arrival is of another clock.
    """
    return 0 <= arrived_at_ns - pressed_at_ns <= LONGEST_WAY_NS


def after_press_s(pressed_at_ns: int, rest_seen_at_ns: int | None) -> float | None:
    """Return the time from a press until both shafts were seen at rest, s, both by the Unix clock (ns).

    None where that is not known: nobody stamped it, or it was seen before the press.
    """
    if rest_seen_at_ns is None or rest_seen_at_ns < pressed_at_ns:
        return None
    return (rest_seen_at_ns - pressed_at_ns) / 1e9


def rest_text(at_rest: bool, after_s: float | None, bench_to_rest_s: float | None) -> str:
    """Return the sentence on the shafts.

    Parameters
    ----------
    at_rest : whether both were seen at rest.
    after_s : from the press until then, s of the clock; None where it is not known.
    bench_to_rest_s : from the begin of the stop until then, s of a bench whose time is not the clock's; else None.
    """
    if not at_rest:
        return "nobody saw the shafts at rest"
    if after_s is not None:
        return f"{after_s:.2f} s after the press both shafts were seen at rest"
    if bench_to_rest_s is not None:
        return (
            f"both shafts were seen at rest, {bench_to_rest_s:.2f} s after the stop began by the bench's own time, "
            "which is not the clock's"
        )
    return "both shafts were seen at rest; how long after the press is not known"
