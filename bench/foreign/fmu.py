"""Functional mock-up units: FMI 2.0 and 3.0, co-simulation and model exchange, run by FMPy (an optional extra).

In co-simulation an input counts from the beginning of a step to its end. So that a step ends with what was measured
then, inputs are given one step ahead.
"""

from __future__ import annotations

import atexit
import re
import shutil
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from bench.errors import ConfigurationError
from bench.foreign.base import PREDICTED, Base, Channels, Free, Values
from bench.foreign.inputs import SMOOTH, unit_of
from bench.foreign.mapping import Mapping as VariableMapping
from bench.foreign.mapping import Variable, load_mapping
from bench.importing.units import Unit
from bench.importing.units import unit_of as read_unit
from bench.signals import BY_NAME
from bench.simulation.frame import FloatArray, IntArray

_TYPES = {"co-simulation": "CoSimulation", "model-exchange": "ModelExchange"}
KINDS = {fmi_name: name for name, fmi_name in _TYPES.items()}
"""how an FMU is run, in words, by FMPy's name of it"""
REALS = ("Real", "Float64", "Float32")
_CHANNEL_UNITS = {name: signal.unit for name, signal in BY_NAME.items()} | {"transmission_error": "rad"}
GIVEN = tuple(dict.fromkeys((*BY_NAME, *SMOOTH)))
"""names of channels that an FMU may be given"""


@dataclass(frozen=True, slots=True)
class Fmu:
    """An FMU with its mapping; the FMU is unpacked once in each process."""

    source: str
    """file that was named: the FMU or its mapping"""
    path: str
    mapping: VariableMapping
    kind: str = "fmu"

    def run(self, inputs: Mapping[str, FloatArray], values: Values) -> Channels:
        """Run the FMU along a recording. Raises ConfigurationError where it fails or a channel is missing."""
        fmpy, description, folder = unpack_fmu(self.path)
        time = inputs["time"] - inputs["time"][0]
        kind = fmi_type(self.mapping, description, self.path)
        step = 1.0 / self.mapping.rate if self.mapping.rate else float(np.median(np.diff(time)))
        variables = {v.name: v for v in description.modelVariables}
        named = [("time", np.float64), *((name, np.float64) for name in self.mapping.inputs)]
        rows, at = _table(time, step, kind == "CoSimulation")
        table = np.zeros(rows.size, dtype=named)
        table["time"] = at
        for name, variable in self.mapping.inputs.items():
            if variable.channel not in inputs:
                near = get_close_matches(variable.channel, inputs, n=1)
                meant = f"; did you mean '{near[0]}'?" if near else f"; it has {', '.join(sorted(inputs))}."
                raise ConfigurationError(
                    f"{self.source}: inputs.{name}: the recording has no channel '{variable.channel}'{meant}"
                )
            unit = _unit(variable, variables[name], f"{self.source}: inputs.{name}")
            table[name] = ((inputs[variable.channel] / variable.scale - unit.offset) / unit.factor)[rows]
        try:
            result = fmpy.simulate_fmu(
                folder,
                validate=False,
                start_time=0.0,
                stop_time=float(time[-1]),
                output_interval=step,
                fmi_type=kind,
                start_values={**self.mapping.start, **values},
                input=table if self.mapping.inputs else None,
                output=list(self.mapping.outputs),
                model_description=description,
            )
        except Exception as error:  # an FMU is somebody else's program; what it says is passed on
            raise ConfigurationError(f"{self.source}: the FMU fails: {type(error).__name__}: {error}.") from error
        out: Channels = {}
        for name, variable in self.mapping.outputs.items():
            unit = _unit(variable, variables[name], f"{self.source}: outputs.{name}")
            si = (np.asarray(result[name], dtype=np.float64) * unit.factor + unit.offset) * variable.scale
            out[variable.channel] = np.interp(time, result["time"], si)
        if "load_angle" in out:
            out["transmission_error"] = out.pop("load_angle") - inputs["theta"]
        return out


def _table(time: FloatArray, step: float, ahead: bool) -> tuple[IntArray, FloatArray]:
    """Samples given to an FMU, and from when on each counts; ``ahead``: a step before its time, the first at once."""
    if not ahead:
        return np.arange(time.size), time
    later = np.flatnonzero(time >= 0.999 * step)
    # FMPy finds the value after a jump only where something stands before it
    rows = np.concatenate(([0, 0], later))
    begin = time[later] - step
    return rows, np.concatenate(([-step, 0.0], np.where(begin < 1e-6 * step, 0.0, begin)))


def open_fmu(path: Path, values: Values | None = None) -> Base:
    """Open an FMU, or a mapping of one; for an FMU alone a mapping of its name beside it counts, else names alike.

    Raises
    ------
    ConfigurationError
        FMPy or the file is not there; the mapping names what the FMU has not; nothing of the FMU is a channel.
    """
    beside = path.with_suffix(".toml")
    if path.suffix.lower() == ".toml" or beside.exists():
        mapping_path = path if path.suffix.lower() == ".toml" else beside
        mapping = load_mapping(mapping_path)
        file = mapping_path.parent / mapping.fmu
        if not file.is_file():
            raise ConfigurationError(
                f"{mapping_path}: fmu: there is no file '{mapping.fmu}' in the folder of this mapping; the FMU's name, "
                "or its path from there, would be right."
            )
        _, description, _ = unpack_fmu(str(file.resolve()))
        _check(mapping_path, mapping, description)
    else:
        file = path
        _, description, _ = unpack_fmu(str(file.resolve()))
        mapping = by_name(path, description)
    simulator = Fmu(str(path.resolve()), str(file.resolve()), mapping)
    starts = {v.name: v for v in description.modelVariables}
    free = tuple(
        Free(name, _start(path, name, mapping, starts[name]), starts[name].unit or "1", parameter.step)
        for name, parameter in mapping.parameters.items()
    )
    return Base.of(simulator, free, values)


def by_name(path: Path, description: Any) -> VariableMapping:
    """The mapping of an FMU whose variables bear the names of channels. Raises ConfigurationError where none does."""
    inputs, outputs = {}, {}
    for variable in description.modelVariables:
        name = re.sub(r"[^a-z0-9]+", "_", variable.name.lower()).strip("_")
        if variable.type not in REALS:
            continue
        if variable.causality == "input" and name in GIVEN:
            inputs[variable.name] = {"channel": name}
        elif variable.causality == "output" and name.removeprefix("simulated_") in (*PREDICTED, "load_angle"):
            outputs[variable.name] = {"channel": name.removeprefix("simulated_")}
    if not outputs:
        raise ConfigurationError(
            f"{path}: no output of the FMU is called as a channel ({', '.join(PREDICTED)}); write a mapping with "
            f"'bench import --look {path.name} --mapping {path.stem}.toml'."
        )
    return VariableMapping.model_validate({"fmu": path.name, "inputs": inputs, "outputs": outputs})


@lru_cache(maxsize=8)
def unpack_fmu(path: str) -> tuple[Any, Any, str]:
    """FMPy, the FMU's description, and the folder it is unpacked in until the program ends."""
    try:
        import fmpy
    except ImportError as error:
        raise ConfigurationError(f"{path}: FMUs need FMPy: pip install 'gearbench[fmu]'.") from error
    if not Path(path).is_file():
        raise ConfigurationError(f"{path}: there is no such file.")
    try:
        description = fmpy.read_model_description(path)
        folder = fmpy.extract(path)
    except Exception as error:  # whatever is wrong with a stranger's archive
        raise ConfigurationError(f"{path}: not readable as an FMU ({type(error).__name__}: {error}).") from error
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    if not str(description.fmiVersion).startswith(("2.", "3.")):
        raise ConfigurationError(f"{path}: FMI {description.fmiVersion} is not run; 2.0 and 3.0 are.")
    return fmpy, description, folder


def fmi_type(mapping: VariableMapping, description: Any, path: str) -> str:
    """How the FMU is run. Raises ConfigurationError where it cannot be run in that way."""
    has = {"co-simulation": description.coSimulation, "model-exchange": description.modelExchange}
    wanted: str | None = mapping.type or next((name for name, entry in has.items() if entry is not None), None)
    if wanted is None or has[wanted] is None:
        there = ", ".join(name for name, entry in has.items() if entry is not None) or "neither of the two"
        raise ConfigurationError(f"{path}: type is '{wanted}', the FMU has {there}.")
    return _TYPES[wanted]


def _check(path: Path, mapping: VariableMapping, description: Any) -> None:
    """Refuse a mapping that names variables or channels that are not there, or units that do not fit."""
    there = {v.name: v for v in description.modelVariables}
    for table in ("inputs", "outputs", "parameters", "start"):
        named: Iterable[str] = getattr(mapping, table)
        for name in named:
            if name not in there:
                of = [v.name for v in there.values() if v.causality == table.rstrip("s")] or list(there)
                raise ConfigurationError(
                    f"{path}: {table}.{name}: the FMU has no such variable; it has {', '.join(of[:20])}."
                )
    for name, variable in mapping.inputs.items():
        _unit(variable, there[name], f"{path}: inputs.{name}")
    for name, variable in mapping.outputs.items():
        if variable.channel not in (*PREDICTED, "load_angle"):
            raise ConfigurationError(
                f"{path}: outputs.{name}: '{variable.channel}' is not compared; it should be one of "
                f"{', '.join(PREDICTED)}, load_angle."
            )
        _unit(variable, there[name], f"{path}: outputs.{name}")


def declared_unit(variable: Any) -> str:
    """Unit that an FMU declares for a variable, itself or by its type; "" where there is none."""
    return getattr(variable, "unit", None) or getattr(variable.declaredType, "unit", None) or ""


def _unit(variable: Variable, fmu_variable: Any, where: str) -> Unit:
    """Conversion of a variable to SI: from the mapping's unit, else the FMU's own, else none."""
    said = variable.unit or declared_unit(fmu_variable)
    if not said:
        return Unit("", 1.0, 0.0)
    return read_unit(said, where, unit_of(variable.channel, _CHANNEL_UNITS))


def _start(path: Path, name: str, mapping: VariableMapping, variable: Any) -> float:
    value = mapping.start.get(name, variable.start)
    try:
        return float(value)
    except (TypeError, ValueError) as error:
        raise ConfigurationError(
            f"{path}: parameters.{name}: the FMU says no start value ({value!r}); give one under [start]."
        ) from error
