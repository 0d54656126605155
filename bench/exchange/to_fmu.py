"""A simulation as an FMU for co-simulation, FMI 2.0 or 3.0: C inside, compiled by the compiler of this computer."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import tempfile
import uuid
import zipfile
from pathlib import Path
from xml.sax.saxutils import quoteattr

from bench.errors import ConfigurationError
from bench.exchange import fmi2, fmi3, to_c
from bench.exchange.written import OUTPUT, START, Formulas

IDENTIFIER = "model"
_FORMS = {"2.0": fmi2, "3.0": fmi3}
_FLAGS = ("-std=c99", "-O2", "-fPIC", "-shared", "-ffp-contract=off")
"""no fused products: rounding as in our own prediction"""
_LONGEST_S = 300.0


def compiler() -> str:
    """The C compiler: ``CC``, else cc, gcc or clang. Raises ConfigurationError where there is none."""
    named = os.environ.get("CC", "").split()
    for name in (*named[:1], "cc", "gcc", "clang"):
        found = shutil.which(name)
        if found is not None:
            return found
    raise ConfigurationError(
        "an FMU holds compiled C, and there is no C compiler here (cc, gcc or clang; or CC); install one, or export "
        "with --to c and compile it elsewhere."
    )


def write_fmu(formulas: Formulas, target: Path, version: str = "3.0", name: str = "simulation") -> None:
    """Write an FMU with its sources.

    Raises
    ------
    ConfigurationError
        There is no compiler, or it fails.
    """
    form = _FORMS[version]
    compiler_path = compiler()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        sources = {"model.h": to_c.header(formulas), "model.c": to_c.source(formulas), "fmi.c": form.SOURCE}
        for file, text in sources.items():
            (folder / file).write_text(text, encoding="utf-8")
        library = folder / f"{IDENTIFIER}{'.dylib' if platform.system() == 'Darwin' else '.so'}"
        command = [compiler_path, *_FLAGS, "model.c", "fmi.c", "-lm", "-o", library.name]
        try:
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=_LONGEST_S)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise ConfigurationError(f"{compiler_path} cannot compile the simulation ({error}).") from error
        if done.returncode:
            raise ConfigurationError(
                f"{compiler_path} cannot compile the simulation: {done.stderr.strip().splitlines()[:1]}."
            )
        token = str(uuid.uuid5(uuid.NAMESPACE_OID, sources["model.c"]))
        description = form.description(name, IDENTIFIER, token, _variables(formulas))
        part = target.with_name(f".{target.name}.{os.getpid()}.new")
        with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("modelDescription.xml", description)
            archive.write(library, f"binaries/{form.PLATFORM[platform.system()](platform.machine())}/{library.name}")
            for file, text in sources.items():
                archive.writestr(f"sources/{file}", text)
        part.replace(target)


def _variables(formulas: Formulas) -> list[dict[str, str]]:
    """Variables in the order of their value references: inputs, outputs, parameters."""
    out = []
    for name in formulas.inputs:
        out.append(_variable(name, "input", "continuous", *formulas.input(name), 0.0))
    for name in formulas.outputs:
        channel = name.removeprefix(OUTPUT)
        meaning = formulas.words(f"{channel.replace('_', ' ')}, simulated")
        out.append(_variable(name, "output", "continuous", formulas.unit_of(channel), meaning))
    for parameter in formulas.parameters:
        variability = "fixed" if parameter.name == START else "tunable"
        out.append(
            _variable(parameter.name, "parameter", variability, parameter.unit, parameter.meaning, parameter.value)
        )
    return out


def _variable(
    name: str, causality: str, variability: str, unit: str, meaning: str, start: float | None = None
) -> dict[str, str]:
    out = {"name": name, "causality": causality, "variability": variability, "description": meaning, "unit": unit}
    if start is not None:
        out["start"] = repr(float(start))
    return {key: quoteattr(value) for key, value in out.items() if value}
