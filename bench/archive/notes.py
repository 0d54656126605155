"""What people say of recordings afterwards: comments, tags, that one is archived. Lines in a file of the folder.

Recordings never change once they are finished, and an index may be thrown away: so notes are lines of JSON in
``notes.jsonl`` beside the recordings. A line is never changed; taking a tag away or bringing something back is a line
of its own.
"""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path

from bench.errors import ConfigurationError

FILE = "notes.jsonl"
KINDS = ("comment", "tag", "untag", "archive", "restore", "person")
"""``person`` names who had a campaign run; the others are acts of whoever looks at it later."""
LONGEST = 2000
"""Characters of a note."""


@dataclass(frozen=True, slots=True)
class Note:
    """One line: when (ISO 8601 with offset), by whom, of which kind; ``file`` is empty for the whole folder."""

    at: str
    by: str
    kind: str
    text: str = ""
    file: str = ""


def add_note(folder: Path, note: Note) -> None:
    """Append a note to a folder; it is on the disk when this returns.

    Raises
    ------
    ConfigurationError
        If the kind is none, the text too long or missing where it says everything.
    OSError
        If the folder takes no file.
    """
    if note.kind not in KINDS:
        raise ConfigurationError(f'a note cannot be of kind "{note.kind}"; it is one of {", ".join(KINDS)}')
    if not note.text.strip() and note.kind not in ("archive", "restore"):
        raise ConfigurationError(f"a {note.kind} needs a text")
    if len(note.text) > LONGEST:
        raise ConfigurationError(f"the note has {len(note.text)} characters, {LONGEST} are the most")
    line = json.dumps(asdict(note), ensure_ascii=False).encode("utf-8", "replace") + b"\n"
    descriptor = os.open(folder / FILE, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW, 0o644)
    try:
        os.write(descriptor, line)
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def read_notes(folder: Path) -> list[Note]:
    """Return the notes of a folder, oldest first; a line that was cut or is none is left out, the others stand."""
    try:
        lines = (folder / FILE).read_text("utf-8", "replace").split("\n")
    except OSError:
        return []
    notes = []
    for line in lines:
        try:
            entry = json.loads(line)
            note = Note(**entry)
        except (ValueError, TypeError):
            continue
        if note.kind in KINDS and all(isinstance(part, str) for part in asdict(note).values()):
            notes.append(note)
    return notes
