"""Equations of several parts as one: no symbol stands for two things."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

_NAME = re.compile(r"(?<!\w)[^\W\d]\w*")
Row = Mapping[str, Any]


def renamed(text: str, names: Mapping[str, str]) -> str:
    """A text with other names in place of some; only whole ones."""
    return _NAME.sub(lambda found: names.get(found[0], found[0]), text)


def together(parts: Sequence[tuple[str, Sequence[Row]]]) -> tuple[str, tuple[Row, ...]]:
    """Equations with their parameters as one equation with all of them; the first keep their symbols, later ones that
    are alike get a number.
    """
    taken = {name for text, _ in parts for name in _NAME.findall(text)}
    used: set[str] = set()
    texts: list[str] = []
    parameters: list[Row] = []
    for text, rows in parts:
        symbols = [str(row["symbol"]) for row in rows]
        names: dict[str, str] = {}
        for name in dict.fromkeys(_base_names(symbols)):
            if name in used:
                names[name] = _free(name, taken)
                taken.add(names[name])
        used |= {names.get(name, name) for name in _base_names(symbols)}
        texts.append(renamed(text, names))
        parameters += [{**row, "symbol": renamed(s, names)} for row, s in zip(rows, symbols, strict=True)]
    return "; ".join(dict.fromkeys(texts)), tuple(parameters)


def _base_names(symbols: Iterable[str]) -> list[str]:
    """Names of parameters and of the functions that tables are values of; quantities of several have none of theirs."""
    return [found[0] for symbol in symbols if (found := _NAME.match(symbol))]


def _free(name: str, taken: set[str]) -> str:
    number = 2
    while f"{name}_{number}" in taken:
        number += 1
    return f"{name}_{number}"
