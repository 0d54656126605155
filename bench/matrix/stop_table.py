"""The page of Markdown that ``bench benchmark stop`` writes: every press, as it was seen."""

from __future__ import annotations

from collections.abc import Sequence

from bench.matrix.stop_times import Row

OFF_AFTER_RUNG_S = 0.2
"""The drives have lost their torque so long after the rung that takes it away, at the latest."""

_HEAD = """# How long STOP takes

Made by `bench benchmark stop --table docs/stop-times.md --store docs/stop-times.json` (needs root rights). The
emulated bench is at the other end of a veth pair and has real-time scheduling if the system allows it (SCHED_FIFO).
It rotates at 10 °/s under 350 N·m. Then something is broken, and half a second later STOP is pressed. All times begin
with the press and are observed at the emulated bench: when the last drive lost its torque, and when both shafts stood
still. *Page* and *second browser* press STOP as the page does: they send it to the service and to the stop listener
of the run at the same time. *Shell* is `bench stop`; its time includes the start of the command. A missing time was
not observed within {watched:.0f} s. Each row is one press. No press was repeated to get a better time; a row is
measured again only after the error it showed was corrected. A bench that did not begin to rotate under load is
started again, three times at most, before STOP is pressed.

*Rung* is the step of the stop ladder that takes the torque away, as reported by the listener of the run or by the
record of the stop. *Later* is the time from this report to drives without torque (at most {off:g} s is right). *Seen
to* is the longest time between two observations of the emulated bench; no other time is known more exactly. A run
that hangs reports no rung: its bus process gets no new set values and stops the drives by itself, without a press.
Its time then says only how much of this stop was left, and can be zero. If the disk is full or read-only, the
recording may fail before the press, and the press comes during a stop.

{made}

{summary}

| broken | pressed | torque off, s | at rest, s | rung | later, s | seen to, s | answer |
| --- | --- | --- | --- | --- | --- | --- | --- |
"""


def page(rows: Sequence[Row], watched_s: float) -> str:
    """Return the page."""
    lines = [_HEAD.format(watched=watched_s, off=OFF_AFTER_RUNG_S, made=_provenance(rows), summary=_summary(rows))]
    lines += [
        f"| {row.condition} | {row.press} | {_s(row.torque_off_s)} | {_s(row.at_rest_s)} | {row.rung or '–'} |"
        f" {_s(row.rung_to_off_s)} | {_s(row.apart_s)} | {_cell(row.note or row.answer)} |\n"
        for row in rows
    ]
    reasons = [f"- {row.condition}, {row.press}: {_cell(why)}\n" for row in rows if (why := reason(row)) is not None]
    if reasons:
        lines.append("\n## Rows that are not as they should be\n\n" + "".join(reasons))
    return "".join(lines)


def _provenance(rows: Sequence[Row]) -> str:
    """Of which day, program and machine the rows are."""
    places = "; ".join(dict.fromkeys(row.made for row in rows if row.made))
    loads = [row.load for row in rows if row.load is not None]
    load = f" Load of the machine (five minutes): {min(loads):.1f} to {max(loads):.1f}." if loads else ""
    return f"Rows are of {places or 'an unknown day'}.{load}"


def reason(row: Row) -> str | None:
    """Why a row is not as it should be, from what was seen; None where the torque went in time.

    Without a rung the torque has to be gone within :data:`OFF_AFTER_RUNG_S` of the press.
    """
    if row.note:
        return row.note
    if row.torque_off_s is None:
        return "the drives were not seen without torque"
    unled = row.rung_to_off_s is None
    late_s = row.torque_off_s if row.rung_to_off_s is None else row.rung_to_off_s
    if late_s <= OFF_AFTER_RUNG_S:
        return None
    since = "the press, and nobody said which rung took it away" if unled else f"the rung ({row.rung})"
    looks = "" if row.apart_s is None else f"; looks were up to {row.apart_s:.2f} s apart"
    return f"torque off {late_s:.2f} s after {since}{looks}"


def _summary(rows: Sequence[Row]) -> str:
    right = sum(reason(row) is None for row in rows)
    offs = [row.torque_off_s for row in rows if row.torque_off_s is not None]
    longest = f"; the longest time from press to torque off is {max(offs):.2f} s" if offs else ""
    return f"{right} of {len(rows)} rows are as expected{longest}."


def _s(value: float | None) -> str:
    return "–" if value is None else f"{round(value, 2) + 0.0:.2f}"  # without the sign of a zero


def _cell(text: str) -> str:
    return " ".join(text.replace("|", "/").split())
