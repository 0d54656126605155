"""Find, read and validate bench files; turn every mistake into one sentence."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass, replace
from difflib import get_close_matches
from hashlib import sha256
from importlib import resources
from pathlib import Path

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from bench.configuration.model import BenchConfiguration
from bench.errors import ConfigurationError

Location = tuple[int | str, ...]
"""Keys, and places in lists from 0, that lead to a value of a file."""

_SHIPPED = resources.files("bench.configuration") / "benches"


@dataclass(frozen=True, slots=True)
class BenchFile:
    """A bench configuration with the text it came from (recordings keep the text as it was in force)."""

    configuration: BenchConfiguration
    text: str
    origin: str

    @property
    def digest(self) -> str:
        """Hash of the text: two recordings with equal digest were made under the same configuration."""
        return sha256(self.text.encode()).hexdigest()


def shipped_benches() -> tuple[str, ...]:
    """Names of the benches that come with the program."""
    return tuple(
        sorted(entry.name.removesuffix(".toml") for entry in _SHIPPED.iterdir() if entry.name.endswith(".toml"))
    )


def load_bench(name_or_path: str | Path) -> BenchFile:
    """Load a bench by the name of a shipped one or by the path of a file.

    Raises
    ------
    ConfigurationError
        In one sentence: file, key, value, what is wrong with it and what would be right.
    """
    text, origin = find_text(str(name_or_path), shipped_benches(), "benches", "bench")
    return parse_bench(text, origin)


def find_text(name: str, shipped: tuple[str, ...], folder: str, what: str) -> tuple[str, str]:
    """Return text and origin of a shipped file or of a file on disk.

    Raises
    ------
    ConfigurationError
        If there is neither.
    """
    path = Path(name)
    if name in shipped:
        return (resources.files("bench.configuration") / folder / f"{name}.toml").read_text("utf-8"), f"{name}.toml"
    if path.suffix == "" and not path.exists():
        raise ConfigurationError(f'there is no {what} "{name}"; name one of {", ".join(shipped)} or the path of a file')
    try:
        return path.read_text("utf-8"), str(path)
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise ConfigurationError(f"{what} file {path} cannot be read: {why}") from error


def parse_bench(text: str, origin: str) -> BenchFile:
    """Parse and validate the TOML text of a bench file (see :func:`load_bench`)."""
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigurationError(f"{origin} is not valid TOML: {error}") from error
    try:
        configuration = BenchConfiguration.model_validate(data)
    except ValidationError as error:
        raise ConfigurationError(explain(error, origin)) from error
    return BenchFile(configuration, text, origin)


def on_interface(file: BenchFile, interface: str) -> BenchFile:
    """Return the bench file with its bus on a network interface through SOEM, all else unchanged.

    Raises
    ------
    ConfigurationError
        If the file does not say its master and interface on lines of their own.
    """
    text = file.text
    for key, value in (("master", "soem"), ("interface", interface)):
        text, count = re.subn(rf'(?m)^{key}\s*=\s*"[^"]*"', f'{key} = "{value}"', text)
        if count != 1:
            raise ConfigurationError(f"{file.origin}: bus.{key} must stand once, on a line of its own, to be replaced")
    return parse_bench(text, f"{file.origin} on {interface}")


def concealing(file: BenchFile, seed: int) -> BenchFile:
    """Return the bench file with its emulated plant drawn from a seed, with concealed physics.

    The text stays as it is: recordings keep it, and nothing in them may say what is concealed.

    Raises
    ------
    ConfigurationError
        If the bench is not emulated in the program's own process.
    """
    bus = file.configuration.bus
    if not bus.in_process or bus.plant is None:
        raise ConfigurationError(f"{file.origin}: physics can be concealed in an emulated plant only (bus.master)")
    return playing(file, f"{bus.plant}?conceal={seed}")


def playing(file: BenchFile, plant: str) -> BenchFile:
    """Return the bench file with another plant behind its emulated bus, the text unchanged."""
    configuration = file.configuration
    bus = configuration.bus.model_copy(update={"plant": plant})
    return replace(file, configuration=configuration.model_copy(update={"bus": bus}))


_REASONS: dict[str, str] = {
    "missing": "the key is missing and must be given",
    "extra_forbidden": "there is no such key; remove it or correct its spelling",
}


def explain(error: ValidationError, origin: str) -> str:
    """Turn a validation error into one sentence: file, key, value, reason, what would be right."""
    details = _made_by_the_user(error.errors(include_url=False))
    # a misspelt key shows up twice, as missing and as unknown: the unknown one says more
    first = min(details, key=lambda detail: detail["type"] != "extra_forbidden")
    meant = _meant(details)
    key = _key(first["loc"])
    reason = _REASONS.get(first["type"], first["msg"].removeprefix("Value error, "))
    if first["loc"] in meant:
        reason = f'there is no such key, "{meant[first["loc"]]}" is missing and may be meant'
    value = first["input"]
    shown = "" if first["type"] == "missing" or isinstance(value, dict) else f" = {_shortened(value)}"
    others = len(details) - len(meant) - 1
    more = f" (and {others} more)" if others else ""
    return ": ".join(part for part in (origin, f"{key}{shown}", f"{reason}{more}") if part)


def _made_by_the_user(details: list[ErrorDetails]) -> list[ErrorDetails]:
    """Leave out what only follows: a list whose entry is wrong counts as too short as well, and so do those above."""
    return [
        detail
        for detail in details
        if not any(
            len(other["loc"]) > len(detail["loc"]) and other["loc"][: len(detail["loc"])] == detail["loc"]
            for other in details
        )
    ]


def _meant(details: list[ErrorDetails]) -> dict[Location, str]:
    """The missing key that each unknown key may stand for, by the unknown one's location."""
    absent = [detail["loc"] for detail in details if detail["type"] == "missing"]
    found: dict[Location, str] = {}
    for detail in details:
        if detail["type"] != "extra_forbidden":
            continue
        beside = [str(loc[-1]) for loc in absent if loc[:-1] == detail["loc"][:-1]]
        for name in get_close_matches(str(detail["loc"][-1]), beside, n=1, cutoff=0.5):
            found[detail["loc"]] = name
            absent.remove((*detail["loc"][:-1], name))
    return found


def _key(location: Location) -> str:
    key = ""
    for part in location:
        key += f"[{part + 1}]" if isinstance(part, int) else f".{part}" if key else str(part)
    return key


def _shortened(value: object) -> str:
    text = f'"{value}"' if isinstance(value, str) else str(value)
    return text if len(text) <= 60 else text[:57] + "…"
