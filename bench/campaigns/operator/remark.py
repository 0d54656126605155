"""What an operator types, made fit for a record: one line of printable text. It can never end a recording."""

from __future__ import annotations

import unicodedata

from bench.errors import ConfigurationError

LONGEST = 500
"""Characters of a remark."""


def clean_remark(text: str) -> str:
    """Return a remark without control, escape and other invisible characters, its white space as single blanks.

    Raises
    ------
    ConfigurationError
        If nothing is left, or it is longer than :data:`LONGEST` characters.
    """
    if len(text) > LONGEST:
        raise ConfigurationError(f"the remark has {len(text)} characters, {LONGEST} are the most; write a shorter one")
    # categories C*: NUL and escape, line ends, marks that turn the direction of writing, halves of surrogate pairs
    plain = "".join(" " if unicodedata.category(letter).startswith(("C", "Z")) else letter for letter in text)
    cleaned = " ".join(plain.split())
    if not cleaned:
        raise ConfigurationError("the remark holds no character that can be printed; write some words")
    return cleaned
