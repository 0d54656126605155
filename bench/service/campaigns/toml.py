"""TOML of what a form holds: texts, numbers, lists, tables, and lists of tables. The standard library reads it only."""

from __future__ import annotations

import json
import math
from typing import Any

from bench.errors import ConfigurationError

_DEEPEST = 8


def toml(table: dict[str, Any]) -> str:
    """Return a table as TOML text; what the standard library reads from it is the table again.

    Raises
    ------
    ConfigurationError
        If it holds what TOML has no form for (null, a number that is none), or is nested too deep; names the key.
    """
    return "\n".join(_lines(table, ())).strip() + "\n"


def _lines(table: dict[str, Any], path: tuple[str, ...]) -> list[str]:
    if len(path) > _DEEPEST:
        raise ConfigurationError(f"{'.'.join(path)} is nested deeper than {_DEEPEST} tables")
    plain = {key: value for key, value in table.items() if not _is_tables(value)}
    lines = [f"{_key(key)} = {_value(value, (*path, key))}" for key, value in plain.items()]
    for key, tables in table.items():
        if key in plain:
            continue
        for one in tables:
            lines += ["", f"[[{'.'.join(_key(part) for part in (*path, key))}]]", *_lines(one, (*path, key))]
    return lines


def _is_tables(value: object) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(one, dict) for one in value)


def _value(value: object, path: tuple[str, ...]) -> str:
    if len(path) > 2 * _DEEPEST:
        raise ConfigurationError(f"{'.'.join(path[:3])} is nested too deep")
    match value:
        case bool():
            return "true" if value else "false"
        case int():
            return str(value)
        case float() if math.isfinite(value):
            return repr(value)
        case str():
            return _text(value, path)
        case list():
            return f"[{', '.join(_value(one, (*path, str(i))) for i, one in enumerate(value))}]"
        case dict():
            inner = ", ".join(f"{_key(key)} = {_value(one, (*path, key))}" for key, one in value.items())
            return f"{{ {inner} }}" if inner else "{}"
    raise ConfigurationError(f"{'.'.join(path)} is {json.dumps(value)}, which a campaign file cannot hold")


def _key(key: str) -> str:
    plain = bool(key) and all(letter.isascii() and (letter.isalnum() or letter in "-_") for letter in key)
    return key if plain else _text(key, (key,))


def _text(text: str, path: tuple[str, ...]) -> str:
    try:
        text.encode()
    except UnicodeEncodeError:
        raise ConfigurationError(f"{'.'.join(path)!r} holds half a character, which is no text") from None
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
