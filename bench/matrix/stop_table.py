"""The page of Markdown that ``bench benchmark stop`` writes: every press, as it was seen."""

from __future__ import annotations

from collections.abc import Sequence

from bench.matrix.stop_times import Row

OFF_AFTER_RUNG_S = 0.2
"""The drives have lost their torque so long after the rung that takes it away, at the latest."""

_HEAD = """# How long STOP takes

Made by `bench benchmark stop --table docs/stop-times.md` on an emulated bench at the far end of a veth pair (needs
root rights). The bench turns at 10 °/s under 350 N·m; then something is broken, and half a second later STOP is
pressed. Times count from the press and were seen at the far end: when the last drive lost its torque, when both
shafts stood still. *Page* and *second browser* press as a page does, the service and the run's own listener at once;
*shell* is `bench stop`, whose start counts. A time that is not there was not seen within {watched:.0f} s. Nothing
here was repeated until it looked better: each row is one press.

The *rung* is the one that takes the torque away, as the stop's record says it; the last column is how much later the
drives had none (at most {off:g} s are right). Where the run hangs, its bus process stops the drives by itself and no
record is written.

{notes}| broken | pressed | torque off, s | at rest, s | rung | from rung to torque off, s | told |
| --- | --- | --- | --- | --- | --- | --- |
"""


def page(rows: Sequence[Row], watched_s: float, notes: Sequence[str]) -> str:
    """Return the page; ``notes`` say what of the machine it was measured on matters."""
    said = "".join(f"{note}\n" for note in notes) + ("\n" if notes else "")
    lines = [_HEAD.format(watched=watched_s, off=OFF_AFTER_RUNG_S, notes=said)]
    lines += [
        f"| {row.condition} | {row.press} | {_s(row.torque_off_s)} | {_s(row.at_rest_s)} | {row.rung or '–'} |"
        f" {_s(row.rung_to_off_s)} | {_cell(row.note or row.told)} |\n"
        for row in rows
    ]
    return "".join(lines)


def _s(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"


def _cell(text: str) -> str:
    return " ".join(text.replace("|", "/").split())
