"""Sentences of several files that differ in their numbers, told as one."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


def different_numbers(sentence: str) -> str:
    """A sentence without its numbers: of many files it is mostly the same."""
    return _NUMBER.sub("…", sentence)


def together(noted: Mapping[str, Sequence[str]], most: int) -> dict[str, list[str]]:
    """Names of the recordings by what was noted of them; sentences of more than ``most`` recordings that differ in
    their numbers alone are one, with the range of each number that differs: ``8 … 16 of 14129 … 15410 samples``.
    """
    alike: dict[tuple[str, ...], list[str]] = {}
    for sentence in noted:
        alike.setdefault(tuple(_NUMBER.split(sentence)), []).append(sentence)
    out: dict[str, list[str]] = {}
    for sentences in alike.values():
        names = list(dict.fromkeys(name for sentence in sentences for name in noted[sentence]))
        if len(names) > most:
            out[_ranges(sentences)] = names
        else:
            out |= {sentence: list(noted[sentence]) for sentence in sentences}
    return out


def _ranges(sentences: Sequence[str]) -> str:
    """Sentences of the same words as one, with the least and the largest of each of their numbers."""
    places = zip(*([match[0] for match in _NUMBER.finditer(sentence)] for sentence in sentences), strict=True)
    ends = ((min(numbers, key=float), max(numbers, key=float)) for numbers in places)
    ranges = iter([low if float(low) == float(high) else f"{low} … {high}" for low, high in ends])
    return _NUMBER.sub(lambda _: next(ranges), sentences[0])
