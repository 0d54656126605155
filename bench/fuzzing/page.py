"""The table of a fuzzing run as a page of Markdown."""

from __future__ import annotations

from collections.abc import Sequence

from bench.fuzzing.readers import CAUGHT, READ, REFUSED, TOLD
from bench.fuzzing.run import WRONG, Tally

_HEAD = """# What becomes of spoiled files

Valid files, each spoiled at random in one way at up to eight places (bits flipped, bytes zeroed, cut, inserted; half of
the places in the first 8 KiB), and read by what reads them in use: recordings are opened, read to the last sample,
and validated; an unfinished one is repaired as well; models, benches, campaigns and mappings are loaded; a
journal is opened as the next run would. Samples are compared in SI with those that were written.

| column | what it counts |
| --- | --- |
| refused | one sentence that names the file |
| as written | read, and every sample is right (what was spoiled means nothing, or is text that may be so) |
| reported | not as it was written, and said so: cut short, a problem, not valid |
| caught | the HDF5 library crashed in a child process; one sentence, the program went on |
| crash, hang, traceback | of the program itself |
| silent | wrong samples and no word, or takes forgotten without one |
| lost | the spoiled file, or one beside it, gone or changed |

"""
_NAMES = {
    "h5": "recording (`.h5`)",
    "part": "unfinished recording (`.part`)",
    "model": "simulation (`model.json`)",
    "bench": "bench (TOML)",
    "campaign": "campaign (TOML)",
    "mapping": "mapping (TOML)",
    "journal": "journal (`journal.sqlite`)",
}


def page(tallies: Sequence[Tally], command: str, seed: int, revision: str) -> str:
    """Return the whole page."""
    columns = (REFUSED, READ, TOLD, CAUGHT, *WRONG)
    names = ("refused", "as written", "reported", "caught", *(name.removeprefix("source ") for name in WRONG))
    rows = [f"| file | done of asked | {' | '.join(names)} |", "| --- |" + " ---: |" * (1 + len(columns))]
    for tally in tallies:
        counts = " | ".join(f"{tally.outcomes[column]:,}" for column in columns)
        rows.append(f"| {_NAMES[tally.kind]} | {tally.done:,} of {tally.asked:,} | {counts} |")
    wrong = [
        f"- {_NAMES[tally.kind]}, case {number}: {outcome}{f' ({text})' if text else ''}"
        for tally in tallies
        for number, outcome, text in tally.wrong[:20]
    ]
    listed = "\n## What may not be\n\n" + "\n".join(wrong) + "\n" if wrong else ""
    made = f"Made by `{command}` with seed {seed} at revision {revision or 'unknown'}.\n\n"
    return _HEAD + made + "\n".join(rows) + "\n" + listed
