"""Names that become files and folders: of campaigns, recordings, places. One rule for run, service and export."""

from __future__ import annotations

import unicodedata

from bench.errors import BenchError, ConfigurationError

LONGEST = 120
"""Characters; with what is added to it (numbers, endings, times) a name stays below the 255 bytes of a file."""
_LONGEST_BYTES = 200


def why_no_name(name: object) -> str | None:
    """Return why a text cannot name a file or folder, None if it can."""
    if not isinstance(name, str):
        return f"is {type(name).__name__}, no text"
    if not name.strip():
        return "is empty"
    if len(name) > LONGEST:
        return f"has {len(name)} characters, {LONGEST} are the most"
    if any(unicodedata.category(letter).startswith("C") for letter in name):
        return "holds a control character, or another that cannot be printed"
    if len(name.encode()) > _LONGEST_BYTES:
        return f"takes {len(name.encode())} bytes, {_LONGEST_BYTES} are the most"
    if "/" in name or "\\" in name:
        return "holds a slash: it is a name, not a path"
    if name.startswith(".") or name != name.strip():
        return "begins with a dot, or begins or ends with a blank"
    return None


def require_name(name: str, what: str, error: type[BenchError] = ConfigurationError) -> str:
    """Return a name as it is; ``what`` it is of, for the sentence.

    Raises
    ------
    BenchError
        Of type ``error``, if it cannot name a file or folder.
    """
    why = why_no_name(name)
    if why is not None:
        raise error(f"{what} {_printable(str(name)[:LONGEST])} {why}")
    return name


def _printable(text: str) -> str:
    """Return a text in quotes, what cannot be printed written out."""
    return '"' + "".join(letter if letter.isprintable() else f"\\u{ord(letter):04x}" for letter in text) + '"'
