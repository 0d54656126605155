"""Seals of plants with concealed physics: the hash that is shown beforehand, and the breaking of the seal."""

from __future__ import annotations

import hashlib
import json
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from bench.configuration import BenchFile, concealing
from bench.errors import ConfigurationError
from bench.proof.make import ProofError

ENTRY_POINT_GROUP = "bench.sealed"
SEAL = "concealed.sha256"
"""file beside the recordings with the hash of what is concealed, and nothing else of it"""


def load_sealed() -> Any:
    """The module that knows what a plant conceals (entry point group ``bench.sealed``).

    Raises
    ------
    ProofError
        None is installed.
    """
    for point in entry_points(group=ENTRY_POINT_GROUP):
        return point.load()
    raise ProofError(f"nothing is installed that knows plants: the entry point group {ENTRY_POINT_GROUP} is empty.")


def opened(file: BenchFile, seed: int) -> tuple[dict[str, Any], str]:
    """What the seed conceals in the bench's plant, and the hash of it.

    Raises
    ------
    ConfigurationError
        The bench has no emulated plant.
    """
    plant = concealing(file, seed).configuration.bus.plant
    try:
        content: dict[str, Any] = load_sealed().concealed_in(plant)
    except ValueError as error:
        raise ConfigurationError(str(error)) from error
    return content, hash_of(content)


def hash_of(content: dict[str, Any]) -> str:
    """SHA-256 of a truth, the same whatever order its keys have."""
    return hashlib.sha256(json.dumps(content, sort_keys=True, allow_nan=False).encode()).hexdigest()


def seal(folder: Path, digest: str) -> None:
    """Write the hash beside recordings."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / SEAL).write_text(f"{digest}\n", encoding="utf-8")


def unbroken(folder: Path, digest: str) -> bool:
    """Whether the hash beside the recordings is this one.

    Raises
    ------
    ProofError
        There is none.
    """
    path = folder / SEAL
    if not path.is_file():
        raise ProofError(f"{folder} has no seal ({SEAL}); it was not recorded with --conceal.")
    return path.read_text(encoding="utf-8").strip() == digest
