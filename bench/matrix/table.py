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

"Struck at" is the true speed of the load side and the true torque at the sensor when the fault struck, as amounts;
from {speed:.0f} °/s and {load:.0f} N·m on a row counts as struck in motion and under load. "Peaks" are the largest
true motor speed, load speed and torque, with the distance of the samples; where they were looked at they were judged
against the envelope ({envelope}), whatever the sensors said. Times count from the strike and
are those of the slowest try. "Not seen" means that nobody looked; "–" that there was nothing to see. A row with several
tries is right only if every one is; one in real time of which a try was not right is struck {rate} times in all, so
that what is shown is a rate. A bench on real frames that does not come to move is started again, three times at most,
before it is struck. For rows that stop the bench it is also checked that torque does not come back by
itself, and for all that record, that what was recorded reads back. What limits and rungs mean: [safety](safety.md).

Made by `bench benchmark faults --table docs/faults.md --store docs/faults.json`. {sources}

"""
_COLUMNS = (
    "| fault | what | struck at | found as | after | brought to rest by | at rest without torque after | "
    "drives left in | peaks | tries right |"
)
_RULE = "| --- " * 10 + "|"
_NOTES = {
    PLANT: "In process and in bench time; the shafts are looked at in every bus cycle.",
    SETUP: "Met before anything moves, but for `default_settings`.",
    SLOW: "In process and in real time, with an age limit of 1 s for the reading and the frozen reading not judged.",
    HOST: "In process and in bench time; the shafts are looked at in every bus cycle where a bench runs.",
    SERVICE: "Processes of their own with an emulated bench inside; nobody looks at their shafts.",
    WIRE: "Real frames between processes, real time, shafts looked at by order to the emulator, which waits for no"
    f" processor where it may (SCHED_FIFO), as slaves do not. Loosened: {LOOSENED}.",
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
    parts.append("".join(f"| `{o.name}` | {_plain(o.told) or NOT_SEEN} |\n" for o in outcomes if o.told or o.cause))
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
