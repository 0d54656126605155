"""The seals of an examination: of the truth of a generated folder, and of a plant with concealed physics.

Beside a truth, or beside recordings, stands the SHA-256 of what is concealed; it is shown before anybody analyses.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from bench.configuration import BenchFile, concealing
from bench.errors import ConfigurationError, ProofError
from bench.whole import write_whole

TRUTHS = "truth"
ENTRY_POINT_GROUP = "bench.sealed"
SEAL = "concealed.sha256"
"""file beside the recordings with the hash of what is concealed, and nothing else of it"""


def write_truth(path: Path, truth: dict[str, Any]) -> None:
    """Write a truth, and its SHA-256 beside it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    content = json.dumps(truth, indent=1, allow_nan=False, default=float).encode()
    path.write_bytes(content)
    path.with_suffix(".sha256").write_text(f"{hashlib.sha256(content).hexdigest()}  {path.name}\n")


def read_truth(path: Path) -> dict[str, Any]:
    """Read a truth and check its seal.

    Raises
    ------
    ProofError
        The seal is missing or broken.
    """
    sealed = seal_of(path)
    content = path.read_bytes()
    if sealed is None or hashlib.sha256(content).hexdigest() != sealed:
        raise ProofError(f"{path}: the seal is missing or broken, the case should be made anew.")
    truth: dict[str, Any] = json.loads(content)
    return truth


def seal_of(path: Path) -> str | None:
    """The SHA-256 written beside a truth, or None."""
    beside = path.with_suffix(".sha256")
    return beside.read_text().split()[0] if beside.exists() else None


def seal_of_seals(out: Path) -> str:
    """SHA-256 over the seals of every truth under ``out``, in the cases' order: one line to publish beforehand."""
    digest = hashlib.sha256()
    for _name, path in iter_truths(out):
        digest.update((seal_of(path) or "").encode())
    return digest.hexdigest()


def iter_truths(out: Path) -> Iterator[tuple[str, Path]]:
    """(case name, truth path) of every sealed case under ``out``."""
    for path in sorted((out / TRUTHS).glob("*.json")):
        yield path.stem, path


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


def seal(folder: Path, digest: str | None) -> None:
    """Write the hash beside recordings; one that is there is never replaced, and None writes nothing.

    Raises
    ------
    ConfigurationError
        As :func:`require_same_seal` does.
    """
    require_same_seal(folder, digest)
    if digest is not None and not (folder / SEAL).exists():
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(folder / SEAL, f"{digest}\n")


def require_same_seal(folder: Path, digest: str | None) -> None:
    """Refuse a folder whose recordings are of another plant than a run would have; nothing is written.

    ``digest`` is the hash of what the run conceals, None for a run that conceals nothing.

    Raises
    ------
    ConfigurationError
        The folder has the seal of another seed, a seal that this run would not have, or recordings without a seal.
    """
    path = folder / SEAL
    if path.is_file():
        if digest is None:
            raise ConfigurationError(
                f"{folder} is sealed ({SEAL}), its plant has concealed physics; give the same --conceal as before, or "
                "another folder with --out"
            )
        if path.read_text(encoding="utf-8").strip() != digest:
            raise ConfigurationError(
                f"{folder} is sealed ({SEAL}) with another hash than this bench has with this --conceal; give the same "
                "--conceal and --bench as before, or another folder with --out"
            )
    elif digest is not None and any(folder.glob("*.h5*")):
        raise ConfigurationError(
            f"{folder} holds recordings that were made without --conceal; leave it out, or give another folder with "
            "--out"
        )


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
