"""A simulation file for other people's tools: Python, C, Modelica, FMU."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from bench.exchange import to_c
from bench.exchange.to_fmu import write_fmu
from bench.exchange.to_modelica import to_modelica
from bench.exchange.to_python import to_python
from bench.exchange.written import Formulas, identifier
from bench.whole import write_whole


def _python(formulas: Formulas, out: Path, name: str, _: str) -> list[Path]:
    return _write_files(out, {f"{identifier(name)}.py": to_python(formulas)})


def _c(formulas: Formulas, out: Path, name: str, _: str) -> list[Path]:
    del name
    return _write_files(out, {"model.h": to_c.header(formulas), "model.c": to_c.source(formulas)})


def _modelica(formulas: Formulas, out: Path, name: str, _: str) -> list[Path]:
    block = identifier(name).capitalize()
    return _write_files(out, {f"{block}.mo": to_modelica(formulas, block)})


def _fmu(formulas: Formulas, out: Path, name: str, version: str) -> list[Path]:
    out.mkdir(parents=True, exist_ok=True)
    target = out / f"{name}.fmu"
    write_fmu(formulas, target, version, name)
    return [target]


def _write_files(out: Path, files: dict[str, str]) -> list[Path]:
    out.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        write_whole(out / name, text)
    return [out / name for name in files]


WRITERS: dict[str, Callable[[Formulas, Path, str, str], list[Path]]] = {
    "python": _python,
    "c": _c,
    "modelica": _modelica,
    "fmu": _fmu,
}
"""writers of files into a folder; the last two arguments are the simulation's name and the version of FMI"""
