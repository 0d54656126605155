"""Plant files: a plant's truth read from TOML, each key known, numbers being numbers."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, fields
from importlib import resources
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

import numpy as np

from fakes.plant.errors import PlantError
from fakes.plant.hidden.kinds import read as read_hidden
from fakes.plant.parts import Ripple
from fakes.plant.transmission import Box, Scale, TransmissionError
from fakes.plant.truth import PlantTruth

FORMAT = "emulated-plant"
_T = TypeVar("_T")
_NOT_TABLES = ("name", "ripple", "transmission_error", "effects", "laws", "hidden", "ledger")
"""fields that are no table of a plant file"""


def read_plant(name: str | Path) -> PlantTruth:
    """Read a plant file: a path, or the name of one that ships (``rh380n``).

    Raises:
        PlantError: the file is missing or a key is unknown, missing or of the wrong type.
    """
    path = Path(name)
    if path.suffix != ".toml":
        path = Path(str(resources.files("fakes") / "plants" / f"{name}.toml"))
    if not path.is_file():
        raise PlantError(
            f"there is no plant file {name}; name one that ships ({', '.join(shipped_plants())}) or a .toml file"
        )
    with path.open("rb") as file:
        try:
            table = tomllib.load(file)
        except tomllib.TOMLDecodeError as error:
            raise PlantError(f"plant file {path} is not TOML: {error}") from error
    return _from_table(table, str(path))


def _from_table(table: Mapping[str, Any], where: str = "plant") -> PlantTruth:
    """Build the truth from a parsed plant file."""
    rest = dict(table)
    if rest.pop("format", None) != FORMAT:
        raise PlantError(f'{where}: key "format" must be "{FORMAT}"')
    if "simulation" in rest:
        return _of_simulation(rest, where)
    hints = get_type_hints(PlantTruth)
    values: dict[str, Any] = {"name": rest.pop("name", Path(where).stem)}
    for name in (f.name for f in fields(PlantTruth)):
        if name in _NOT_TABLES or (name == "numerics" and name not in rest):
            continue
        values[name] = _part(hints[name], rest.pop(name, None), f"{where}: {name}")
    values["ripple"] = tuple(
        _part(Ripple, row, f"{where}: ripple {i + 1}") for i, row in enumerate(rest.pop("ripple", []))
    )
    values["transmission_error"] = _transmission_error(
        rest.pop("transmission_error", None), f"{where}: transmission_error"
    )
    values["hidden"] = tuple(
        read_hidden(row, f"{where}: hidden {i + 1}") for i, row in enumerate(rest.pop("hidden", []))
    )
    if rest:
        raise PlantError(f"{where}: unknown key {next(iter(rest))!r}")
    return PlantTruth(**values)


def shipped_plants() -> tuple[str, ...]:
    """Return the names of the plant files that ship."""
    folder = resources.files("fakes") / "plants"
    return tuple(sorted(Path(item.name).stem for item in folder.iterdir() if item.name.endswith(".toml")))


def _of_simulation(table: Mapping[str, Any], where: str) -> PlantTruth:
    """Read a plant file that plays a simulation file (``simulation``) on the hardware of another plant (``base``)."""
    # the reader of simulation files brings the analyser's library with it: only plants that ask for it pay
    from fakes.plant.simulation import truth_from_simulation

    if set(table) - {"name", "simulation", "base"}:
        raise PlantError(f'{where}: beside "simulation" there may be "base" and "name" only')
    path = Path(where).parent / str(table["simulation"])
    return truth_from_simulation(path, read_plant(str(table.get("base", "rh380n"))))


def _part(kind: type[_T], table: Any, where: str) -> _T:
    """Build one part's dataclass; every key must be known, numbers must be numbers."""
    if not isinstance(table, Mapping):
        raise PlantError(f"{where}: the table is missing")
    hints = get_type_hints(kind)
    values: dict[str, Any] = {}
    for key, value in table.items():
        if key not in hints:
            raise PlantError(f"{where}: unknown key {key!r}; known are {', '.join(hints)}")
        whole = hints[key] is int
        if isinstance(value, bool) or not isinstance(value, int if whole else (int, float)):
            raise PlantError(f"{where}: {key} = {value!r} must be {'an integer' if whole else 'a number'}")
        values[key] = value if whole else float(value)
    for f in fields(kind):  # type: ignore[arg-type]
        if f.name not in values and f.default is MISSING:
            raise PlantError(f"{where}: key {f.name!r} is missing")
    return kind(**values)


def _polynomial(row: Any, where: str) -> list[float]:
    """Return ten coefficients."""
    if not isinstance(row, Sequence) or len(row) != 10 or not all(isinstance(v, int | float) for v in row):
        raise PlantError(f"{where} must be a list of ten numbers (the paper's terms 1 to 10)")
    return [float(v) for v in row]


def _transmission_error(table: Any, where: str) -> TransmissionError:
    """Read the series: ``scale``, ``box``, ``a0``, ``order`` rows, and ``weak_order`` rows where ``weak_orders``."""
    if not isinstance(table, Mapping):
        raise PlantError(f"{where}: the table is missing")
    known = {"scale", "box", "a0", "order", "weak_order", "weak_orders"}
    if set(table) - known:
        raise PlantError(
            f"{where}: unknown key {sorted(set(table) - known)[0]!r}; known are {', '.join(sorted(known))}"
        )
    scale = _part(Scale, table.get("scale"), f"{where}.scale")
    box = table.get("box", {})
    rows = [(row, False) for row in table.get("order", [])]
    if table.get("weak_orders", False):
        rows += [(row, True) for row in table.get("weak_order", [])]
    rows.sort(key=lambda item: float(item[0]["order"]))
    amplitude, phase = np.zeros((2, 2, len(rows), 10))
    for i, (row, _) in enumerate(rows):
        for d, direction in enumerate(("positive", "negative")):
            for key, target in (("A", amplitude), ("phi", phase)):
                label = f"{where}: order {row['order']}, {direction}.{key}"
                target[d, i] = scale.to_raw(np.array(_polynomial(row.get(direction, {}).get(key), label)))
    a0 = table.get("a0", {})
    offset = np.array([_polynomial(a0.get(d), f"{where}: a0.{d}") for d in ("positive", "negative")])
    return TransmissionError(
        orders=np.array([float(row["order"]) for row, _ in rows]),
        amplitude=1e-6 * amplitude,
        phase=phase,
        offset=1e-6 * scale.to_raw(offset),
        weak=np.array([weak for _, weak in rows], dtype=np.bool_),
        box=Box(*(_bounds(box.get(key), f"{where}.box.{key}") for key in ("torque", "velocity", "temperature"))),
    )


def _bounds(pair: Any, where: str) -> tuple[float, float]:
    """Return lower and upper bound."""
    if not isinstance(pair, Sequence) or len(pair) != 2 or not float(pair[0]) < float(pair[1]):
        raise PlantError(f"{where} must be [lower, upper]")
    return float(pair[0]), float(pair[1])
