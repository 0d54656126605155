"""Build the minimal C loop on SOEM, as pysoem's source distribution carries it, and run it."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tarfile
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np

from bench.cycle.jitter.figures import Notes
from bench.errors import DeviceError

_SOURCE_FILE = Path(__file__).with_name("cycle_loop.c")
_SOURCES = (
    "soem/osal/linux/osal.c",
    "soem/oshw/linux/oshw.c",
    "soem/oshw/linux/nicdrv.c",
    *(f"soem/soem/ethercat{part}.c" for part in ("base", "coe", "config", "dc", "foe", "main", "print", "soe")),
    "src/soem/soem_config.c",
)
_HEADERS = ("soem/oshw/linux", "soem/osal/linux", "soem/oshw", "soem/osal", "soem/soem", "src/soem")
_WORDS = 6


@dataclass(frozen=True, slots=True)
class Unavailable:
    """Why there is no C loop, a sentence."""

    reason: str


def build(folder: Path, source: Path | None = None) -> Path | Unavailable:
    """Compile the loop into ``folder`` and return the program.

    Parameters
    ----------
    source : pysoem's source distribution, packed or unpacked; None has pip download that of the installed version.
    """
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        return Unavailable("there is no C compiler (cc, gcc or clang) on this machine")
    found = _unpack_source(folder, source)
    if isinstance(found, Unavailable):
        return found
    program = folder / "cycle_loop"
    command = [compiler, "-O2", "-w", "-o", str(program), "-DEC_VER2", "-DUSE_SOEM_CONFIG_H"]
    command += [f"-I{found / header}" for header in _HEADERS]
    command += [str(_SOURCE_FILE), *(str(found / part) for part in _SOURCES), "-lpthread", "-lrt"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        return Unavailable(f"the C loop does not compile: {_last_line(done.stderr)}")
    return program


def run(program: Path, interface: str, rate: float, seconds: float, priority: int | None, cpu: int | None) -> Notes:
    """Run the loop and return its notes.

    Raises
    ------
    DeviceError
        With what the loop says, if it does not come to its end.
    """
    out = program.with_name("notes")
    command = [
        str(program),
        interface,
        str(round(1e9 / rate)),
        str(round(seconds * rate)),
        str(priority or 0),
        str(out),
    ]
    if cpu is not None and shutil.which("taskset"):
        command = ["taskset", "-c", str(cpu), *command]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise DeviceError(f"the C loop ended with exit code {done.returncode}: {_last_line(done.stderr)}")
    notes = np.fromfile(out, np.int64).reshape(-1, _WORDS)
    return Notes(*notes.T)


def _unpack_source(folder: Path, source: Path | None) -> Path | Unavailable:
    if source is not None and source.is_dir():
        return source if (source / _SOURCES[0]).exists() else Unavailable(f"{source} holds no source of SOEM")
    if source is None:
        wanted = f"pysoem=={version('pysoem')}"
        command = [sys.executable, "-m", "pip", "download", "-q", "--no-binary", "pysoem", "--no-deps", wanted]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            return Unavailable(f"the source of {wanted} cannot be downloaded: {_last_line(done.stderr)}")
        source = next(folder.glob("pysoem-*.tar.gz"))
    try:
        with tarfile.open(source) as archive:
            # the argument ``filter`` came with Python 3.11.4
            archive.extraction_filter = getattr(tarfile, "data_filter", None)
            archive.extractall(folder)
    except (OSError, tarfile.TarError) as error:
        return Unavailable(f"{source} is no archive of a source distribution: {error}")
    found = [path.parents[3] for path in folder.glob(f"*/{_SOURCES[0]}")]
    return found[0] if found else Unavailable(f"{source} holds no source of SOEM")


def _last_line(text: str) -> str:
    lines = [line for line in text.splitlines() if line.strip()]
    return lines[-1].strip() if lines else "it says nothing"
