"""The table of a fuzzing run as a page of Markdown."""

from __future__ import annotations

from collections.abc import Sequence

from bench.fuzzing.readers import CAUGHT, READ, REFUSED, TOLD
from bench.fuzzing.run import WRONG, Tally

_HEAD = """# What happens with damaged files

Valid files are damaged at random, each in one way and at up to eight places (bits flipped; bytes zeroed, removed or
inserted; half of the places in the first 8 KiB). Then they are read as in normal use. Recordings are opened, read to
the last sample and validated, and unfinished recordings are repaired as well. Models, bench files, campaigns and
mappings are loaded. A journal is opened as by the next run. The samples are compared, in SI units, with those that
were written.

| column | what it counts |
| --- | --- |
| refused | refused with one sentence that names the file |
| as written | read, and every sample is right (the damaged bytes had no meaning, or were free text) |
| reported | different from what was written, and reported as such: cut short, a problem, not valid |
| caught | the HDF5 library crashed in a child process; the program printed one sentence and went on |
| crash, hang, traceback | of the program itself |
| silent | wrong samples, or forgotten recordings of a journal, without any message |
| lost | the damaged file, or a file beside it, was removed or changed |

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
    listed = "\n## Cases that must not happen\n\n" + "\n".join(wrong) + "\n" if wrong else ""
    made = f"Made by `{command}` with seed {seed} at revision {revision or 'unknown'}.\n\n"
    return _HEAD + made + "\n".join(rows) + "\n" + listed
