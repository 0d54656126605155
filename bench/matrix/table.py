"""The matrix as a page: fault, what was found and how soon, how the bench was brought to rest, what was said."""

from __future__ import annotations

import re
from collections.abc import Sequence

from bench.matrix.outcome import Outcome

_HEAD = """# What happens when something breaks

Every fault the emulated bench and its computer can have, struck while the bench turns at {speed:.0f} °/s under
{load:.0f} N·m, one after the other. For each the program itself checked: cause found, time until both shafts rest
without torque, how the drives are left, that the true shafts stayed within their envelope
({envelope}) whatever the sensors said, that the operator was told, that torque
does not come back by itself, and that everything recorded before reads back row for row. What limits and rungs mean:
[safety](safety.md).

Made by `bench benchmark faults --table docs/faults.md`; times are bench time, to the bus cycle for what is found in
process and to 20 ms for rest. Without torque the shafts of this bench stop by friction in about 0.3 s.

"""
_COLUMNS = "| fault | what | found as | after | brought to rest by | at rest without torque after | drives left in |"
_RULE = "| --- | --- | --- | --- | --- | --- | --- |"


def page(outcomes: Sequence[Outcome], speed_deg_s: float, load_nm: float, envelope: str) -> str:
    """Return the whole page."""
    parts = [_HEAD.format(speed=speed_deg_s, load=load_nm, envelope=envelope)]
    for kind in dict.fromkeys(outcome.kind for outcome in outcomes):
        rows = [outcome for outcome in outcomes if outcome.kind == kind]
        parts.append(f"## {kind[0].upper()}{kind[1:]}\n\n{_COLUMNS}\n{_RULE}\n")
        parts.append("".join(_row(outcome) for outcome in rows) + "\n")
    parts.append("## What the operator is told\n\n| fault | sentence |\n| --- | --- |\n")
    parts.append("".join(f"| `{outcome.name}` | {_plain(outcome.told)} |\n" for outcome in outcomes if outcome.told))
    failed = [outcome for outcome in outcomes if not outcome.passed]
    verdict = f"{len(outcomes) - len(failed)} of {len(outcomes)} rows are as they should be.\n"
    parts.append("\n" + verdict + "".join(f"\n- `{o.name}`: {'; '.join(o.problems)}" for o in failed))
    return "".join(parts)


def _row(outcome: Outcome) -> str:
    drives = sorted({state.lower().replace("_", " ") for state in outcome.drives.values()})
    found = outcome.cause.lower().replace("_", " ") or ("refused" if outcome.told and not outcome.rungs else "–")
    if outcome.cause == "" and "enabled" in drives:
        found = "runs on, marked" if outcome.told else "runs on"
    cells = (
        f"`{outcome.name}`",
        outcome.text,
        found,
        _seconds(outcome.found_s),
        " → ".join(outcome.rungs) or "–",
        _seconds(outcome.stopped_s),
        ", ".join(drives) or "–",
    )
    return "| " + " | ".join(cells) + " |\n"


def _seconds(value: float | None) -> str:
    if value is None:
        return "–"
    return f"{1e3 * value:.3g} ms" if value < 0.1 else f"{value:.2f} s" if value < 100.0 else f"{value:.0f} s"


def _plain(text: str) -> str:
    """Leave out what is different every time: folders, process numbers and cycles."""
    text = re.sub(r"http:\S+", "http://…,", text)
    text = re.sub(r"(?<!:)/\S*/|\bmatrix-\w+", "", text).replace("|", "/").strip()
    return re.sub(r"process \d+", "process …", re.sub(r"cycle \d+ and \d+", "cycle … and …", text))
