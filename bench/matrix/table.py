"""The matrix as a page: what was struck when, what was found and how soon, how it came to rest, what was said."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from bench.matrix.outcome import IN_MOTION, UNDER_LOAD, Outcome
from bench.matrix.rows import HOST, PLANT, SERVICE, SETUP, SLOW, WIRE
from bench.matrix.run import RATE_TRIES
from bench.matrix.summary import share, sources, summary
from bench.matrix.worker import LOOSENED

_HEAD = """# What happens when something breaks

{summary}

*Struck at* is the true speed of the load side and the true torque at the sensor at the moment of the injection,
without sign. From {speed:.0f} °/s and {load:.0f} N·m on, a row counts as injected in motion and under load. *Peaks*
are the largest true motor speed, load speed and torque, with the time between two samples. They are judged against
the envelope ({envelope}), whatever the sensors show. Times begin with the injection and are those of the slowest try.
*Not seen* means that nobody observed it; "–" means that there was nothing to observe. A row with several tries is
right only if every try is right. If a try in real time is not right, the row is tried {rate} times, so that the table
shows a rate. A bench on real frames that does not begin to move is started again before the injection, three times at
most. For rows that stop the bench, the program also checks that torque does not come back by itself; for all rows
that record, that the recordings can be read. [Safety](safety.md) explains limits and rungs.

Made by `bench benchmark faults --table docs/faults.md --store docs/faults.json`. {sources}

"""
_COLUMNS = (
    "| fault | what | struck at | found as | after | brought to rest by | at rest without torque after | "
    "drives left in | peaks | tries right |"
)
_RULE = "| --- " * 10 + "|"
_NOTES = {
    PLANT: "Inside the program and in bench time; the shafts are observed in every bus cycle.",
    SETUP: "Injected before anything moves, except `default_settings`.",
    SLOW: "Inside the program and in real time. The age limit of a reading is 1 s, and a frozen reading is not judged.",
    HOST: "Inside the program and in bench time; if a bench runs, its shafts are observed in every bus cycle.",
    SERVICE: "Separate processes with an emulated bench inside; their shafts are not observed.",
    WIRE: "Real frames between processes, in real time. The emulator has real-time scheduling if the system allows it"
    f" (SCHED_FIFO), and reports the shafts on request. Limits that are relaxed: {LOOSENED}.",
}
NOT_SEEN = "not seen"


def page(outcomes: Sequence[Outcome], envelope: str) -> str:
    """Return the whole page; ``envelope`` in words."""
    head = _HEAD.format(
        summary=summary(outcomes),
        speed=math.degrees(IN_MOTION),
        load=UNDER_LOAD,
        rate=RATE_TRIES,
        envelope=envelope,
        sources=sources(outcomes),
    )
    parts = [head]
    for kind in dict.fromkeys(outcome.kind for outcome in outcomes):
        rows = [outcome for outcome in outcomes if outcome.kind == kind]
        parts.append(f"## {kind[0].upper()}{kind[1:]}\n\n{_NOTES[kind]}\n\n{_COLUMNS}\n{_RULE}\n")
        parts.append("".join(_row(outcome) for outcome in rows) + "\n")
    parts.append("## What the operator reads\n\n| fault | sentence |\n| --- | --- |\n")
    parts.append(
        "".join(f"| `{o.name}` | {_plain(o.sentence) or NOT_SEEN} |\n" for o in outcomes if o.sentence or o.cause)
    )
    failed = [outcome for outcome in outcomes if not outcome.passed]
    parts.append("\n" + share(outcomes) + "\n")
    parts.append("".join(f"\n- `{o.name}`: {_plain('; '.join(o.problems))}" for o in failed) + ("\n" if failed else ""))
    return "".join(parts)


def _row(outcome: Outcome) -> str:
    drives = sorted({state.lower().replace("_", " ") for state in outcome.drives.values()})
    stopped = not outcome.reaction
    cells = (
        f"`{outcome.name}`",
        outcome.text,
        _struck(outcome),
        outcome.cause.lower().replace("_", " ") or outcome.reaction or NOT_SEEN,
        _seconds(outcome.found_s, stopped),
        " → ".join(outcome.rungs) or (NOT_SEEN if stopped else "–"),
        _seconds(outcome.stopped_s, stopped),
        ", ".join(drives) or NOT_SEEN,
        _peaks(outcome),
        f"{outcome.right} of {outcome.tries}",
    )
    return "| " + " | ".join(cells) + " |\n"


def _struck(outcome: Outcome) -> str:
    if outcome.struck is None:
        return NOT_SEEN
    return f"{math.degrees(outcome.struck[0]):.0f} °/s, {outcome.struck[1]:.0f} N·m"


def _peaks(outcome: Outcome) -> str:
    if outcome.peaks is None or outcome.sampled_s is None:
        return "not judged"
    motor, load, torque = outcome.peaks
    return f"{motor:.0f} rad/s, {load:.2f} rad/s, {torque:.0f} N·m ({1e3 * outcome.sampled_s:.3g} ms)"


def _seconds(value: float | None, stopped: bool) -> str:
    if value is None:
        return NOT_SEEN if stopped else "–"
    return f"{1e3 * value:.3g} ms" if value < 0.1 else f"{value:.2f} s" if value < 100.0 else f"{value:.0f} s"


def _plain(text: str) -> str:
    """Leave out what is different every time: folders, process numbers and cycles."""
    text = re.sub(r"http:\S+", "http://…,", text)
    text = re.sub(r"(?<!:)/\S*/|\bmatrix-\w+", "", text).replace("|", "/").strip()
    return re.sub(r"process \d+", "process …", re.sub(r"cycle \d+ and \d+", "cycle … and …", text))
