"""The JSON schema of a campaign, made of the definitions that read its TOML: for forms, editors, other programs."""

from __future__ import annotations

import inspect
from dataclasses import MISSING, fields
from typing import Any, get_args, get_type_hints

from bench.campaigns.planning.file import BlockSection, CampaignFile
from bench.campaigns.planning.registry import sequence_class, sequence_names
from bench.configuration.quantities import UNITS
from bench.protocols import Unit

Schema = dict[str, Any]
AS_FOUND = "as found"
_NOT_OPTIONS = ("kind", "prepares_temperature")
_NUMBER = r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"


def campaign_schema() -> Schema:
    """Return the JSON schema (draft 2020-12) of a campaign file.

    Quantities are texts of a number and a unit: ``kind`` names the quantity, ``units`` what may be written. Below
    ``$defs`` stands one schema of options per installed sequence; ``BlockSection`` chooses by ``sequence``.
    """
    schema = CampaignFile.model_json_schema()
    block = schema["$defs"]["BlockSection"]
    for name, hint in get_type_hints(BlockSection, include_extras=True).items():
        unit = unit_of(hint)
        if unit is not None:
            block["properties"][name] |= {"items": quantity(unit.kind), "default": [f"0 {_si(unit.kind)}"]}
    as_found = {"const": AS_FOUND}
    block["properties"]["temperatures"] |= {
        "items": {"anyOf": [as_found, quantity("temperature")]},
        "default": [AS_FOUND],
    }
    names = sequence_names()
    block["properties"]["sequence"] |= {"enum": list(names)}
    block["allOf"] = [
        {
            "if": {"properties": {"sequence": {"const": name}}},
            "then": {"properties": {"options": {"$ref": f"#/$defs/{name}"}}},
        }
        for name in names
    ]
    schema["$defs"] |= {name: options_schema(name) for name in names}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def options_schema(name: str) -> Schema:
    """Return the schema of the options of a sequence; what is not given keeps its ``default``, in SI.

    Raises
    ------
    ConfigurationError
        If no installed package offers the sequence.
    """
    cls = sequence_class(name)
    hints = get_type_hints(cls, include_extras=True)
    properties: Schema = {}
    for field in fields(cls):
        if field.name in _NOT_OPTIONS:
            continue
        unit = unit_of(hints[field.name])
        entry = quantity(unit.kind) if unit else {"type": "integer" if hints[field.name] is int else "number"}
        if field.default is not MISSING:
            entry["default"] = field.default if unit is None else f"{field.default:g} {_si(unit.kind)}"
        properties[field.name] = entry
    return {
        "type": "object",
        "description": (inspect.getdoc(cls) or "").partition("\n\n")[0].replace("``", "").replace("\n", " "),
        "properties": properties,
        "additionalProperties": False,
    }


def quantity(kind: str) -> Schema:
    """Return the schema of a text that holds a number and a unit of a kind."""
    units = list(UNITS[kind])
    escaped = "|".join(_escape(unit) for unit in units)
    return {"type": "string", "kind": kind, "units": units, "pattern": rf"^\s*{_NUMBER}\s*({escaped})\s*$"}


def unit_of(hint: Any) -> Unit | None:
    """Return the kind of quantity a type hint declares, also that of the items of a tuple; None for none."""
    for part in (*getattr(hint, "__metadata__", ()), *get_args(hint)):
        found = part if isinstance(part, Unit) else unit_of(part) if get_args(part) else None
        if found is not None:
            return found
    return None


def _si(kind: str) -> str:
    return next(unit for unit, factor in UNITS[kind].items() if factor == 1.0)


def _escape(text: str) -> str:
    """Escape for a regular expression that JavaScript reads as well."""
    return "".join(f"\\{letter}" if letter in r"*/^.()+?[]{}|$\\" else letter for letter in text)
