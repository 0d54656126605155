"""What is in an FMU, and the mapping to begin with: each variable with the channel that its name and unit suggest.

A guess says that it is one; an output or a free parameter that nothing was guessed for stands in a remark, and has no
part in the comparison until somebody takes the mark away.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench.errors import ConfigurationError
from bench.foreign.base import PREDICTED
from bench.foreign.fmu import GIVEN, KINDS, REALS, declared_unit, fmi_type, unpack_fmu
from bench.foreign.inputs import unit_of
from bench.foreign.mapping import Mapping as VariableMapping
from bench.importing.formats.source import Variable
from bench.importing.looking.column import Column
from bench.importing.looking.entries import toml
from bench.importing.looking.names import channel_of, meaning
from bench.importing.units import si_of
from bench.importing.units import unit_of as read_unit
from bench.signals import BY_NAME

_SIMULATED = re.compile(r"^(simulated|predicted|model)_")
_ACCELERATION = re.compile(r"acc|(^|_)(alpha|qdd|ddq|a)(_|$)")
_UNITS = {name: signal.unit for name, signal in BY_NAME.items()}


@dataclass(frozen=True, slots=True)
class Found:
    """A variable of an FMU: ``causality`` input, output or parameter; the ``channel`` it may be, "" where none fits;
    ``sure``: it bears the channel's own name. ``start`` is its value before the run, None where the FMU says none.
    """

    name: str
    causality: str
    unit: str
    start: float | None
    channel: str = ""
    sure: bool = False


@dataclass(frozen=True, slots=True)
class Inventory:
    """What an FMU declares about itself."""

    path: Path
    title: str
    version: str
    kind: str
    variables: tuple[Found, ...]

    def of(self, causality: str) -> list[Found]:
        """Variables of one causality."""
        return [variable for variable in self.variables if variable.causality == causality]


def take_inventory(path: Path) -> Inventory:
    """Read what an FMU declares about itself. Raises ConfigurationError where it cannot be read or run."""
    _, description, _ = unpack_fmu(str(path.resolve()))
    kind = fmi_type(
        VariableMapping.model_validate({"fmu": path.name, "outputs": {"any": "motor_torque"}}), description, str(path)
    )
    taken: set[str] = set()
    found = []
    for variable in description.modelVariables:
        if variable.causality not in ("input", "output", "parameter") or variable.type not in REALS:
            continue
        channel, sure = (
            ("", False) if variable.causality == "parameter" else _channel(variable, variable.causality == "input")
        )
        if (variable.causality + channel) in taken:
            channel, sure = "", False
        taken.add(variable.causality + channel)
        found.append(
            Found(
                str(variable.name), variable.causality, declared_unit(variable), _number(variable.start), channel, sure
            )
        )
    return Inventory(path, str(description.modelName), str(description.fmiVersion), KINDS[kind], tuple(found))


def _number(text: Any) -> float | None:
    try:
        return float(text)
    except (TypeError, ValueError):
        return None


def _channel(variable: Any, given: bool) -> tuple[str, bool]:
    """The channel that a variable may be, and whether its name says so itself."""
    allowed = GIVEN if given else (*PREDICTED, "load_angle")
    plain = re.sub(r"[^a-z0-9]+", "_", str(variable.name).lower()).strip("_")
    plain = plain if given else _SIMULATED.sub("", plain)
    if plain in allowed:
        return plain, True
    unit = declared_unit(variable)
    likely = meaning(Column(Variable(str(variable.name), (2,), "float64", unit), np.zeros(2)))
    name = channel_of(likely) or ""
    if given and (si_of(unit) == "rad/s²" or (not unit and _ACCELERATION.search(plain))):
        name = f"{'load' if likely.load else 'motor'}_acceleration"
    return (name, False) if name in allowed and _fits(unit, name) else ("", False)


def _fits(unit: str, channel: str) -> bool:
    """Whether a unit fits the quantity of the channel; a variable without a unit fits any."""
    if not unit:
        return True
    try:
        read_unit(unit, "", unit_of(channel, _UNITS))
    except ConfigurationError:
        return False
    return True


def draft(found: Inventory, target: Path, changes: Mapping[str, Any] | None = None) -> str:
    """Text of a first mapping, to be saved at ``target``: guesses are marked, everything else is commented out.

    ``changes`` come before the guesses: ``outputs.tau`` a channel, ``parameters.d`` an empty table.

    Raises
    ------
    ConfigurationError
        Nothing that the FMU gives looks like a channel that can be compared; a change names what the FMU has not.
    """
    changed = {key: _text(value) if isinstance(value, str) else toml(value) for key, value in (changes or {}).items()}
    _refuse_unknown(found, changed)
    outputs = found.of("output")
    if not any(variable.channel or f"outputs.{variable.name}" in changed for variable in outputs):
        listed = ", ".join(f"{variable.name} [{variable.unit or 'no unit'}]" for variable in outputs) or "none"
        raise ConfigurationError(
            f"{found.path}: none of its outputs looks like a channel that is compared ({', '.join(PREDICTED)}, "
            f'load_angle); they are {listed}. Write {target} by hand: fmu = "{found.path.name}", and below [outputs] '
            '"NAME" = "motor_torque".'
        )
    file = Path(os.path.relpath(found.path.resolve(), target.resolve().parent)).as_posix()
    lines = [f"fmu = {_text(file)}  # FMI {found.version}, {found.kind}"]
    for table in ("input", "output"):
        some = found.of(table)
        if some:
            lines += ["", f"[{table}s]  # variable = channel", *(_mapping_line(one, changed) for one in some)]
    parameters = found.of("parameter")
    if parameters:
        lines += ["", "[parameters]  # those that may be recalibrated; take the mark away"]
        for parameter in parameters:
            given = changed.get(f"parameters.{parameter.name}")
            lines.append(
                f"{'# ' if given is None else ''}{_text(parameter.name)} = {given or '{}'}{_remark(parameter)}"
            )
    return "\n".join(lines) + "\n"


def _refuse_unknown(found: Inventory, changes: Mapping[str, str]) -> None:
    there = {f"{variable.causality}s.{variable.name}" for variable in found.variables}
    for key in changes:
        if key not in there:
            listed = ", ".join(sorted(there)[:20])
            raise ConfigurationError(f"{found.path}: --set {key}: the FMU has no such variable; it has {listed}.")


def _mapping_line(variable: Found, changes: Mapping[str, str]) -> str:
    given = changes.get(f"{variable.causality}s.{variable.name}")
    if given is not None:
        return f"{_text(variable.name)} = {given}  # given on the command line"
    if not variable.channel:
        return f'# {_text(variable.name)} = "?"{_remark(variable)}; nothing was guessed'
    value = _text(variable.channel)
    return f"{_text(variable.name)} = {value}{'' if variable.sure else '  # a guess, from its name and unit'}"


def _remark(variable: Found) -> str:
    start = "no start value" if variable.start is None else f"{variable.start:g}"
    return f"  # {start}{f' {variable.unit}' if variable.unit else ''}"


def _text(value: str) -> str:
    return json.dumps(value, ensure_ascii=False)
