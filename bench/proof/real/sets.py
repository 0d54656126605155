"""Public data sets, a TOML file each in ``sets``: source, licence, files with checksums, how to import them, and the
expert's regression. The recordings themselves are the reader's to fetch.
"""

from __future__ import annotations

import hashlib
import tomllib
from importlib import resources
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from bench.errors import ConfigurationError

AUXILIARY = "aux/"


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class PublicFile(_Strict):
    """A file to fetch: its name in the reader's folder, its place in the source, its checksum."""

    name: str
    at: str
    sha256: str = Field(pattern="[0-9a-f]{64}")


class ExpertTerm(_Strict):
    """One regressor of the expert: ``column`` is a formula of the recorded quantities; ``effect`` the id by which the
    analyser would call it, or ``aux/NAME``; several with ``|`` between where the recordings do not tell them apart;
    empty where nothing is asked of the analyser (an offset).
    """

    symbol: str
    column: str
    unit: str
    effect: str = ""


class Expert(_Strict):
    """What an expert does with the set by hand.

    Rates are those of a zero-phase Butterworth filter of 4th order and ``derivative_hz``. ``also``: effects that the
    expert would not call wrong, though the regression has no term of them. ``how``: why these terms.
    """

    channel: str = "motor_torque"
    derivative_hz: float = Field(gt=0)
    how: str
    terms: Annotated[tuple[ExpertTerm, ...], Field(min_length=1)]
    also: tuple[str, ...] = ()

    @property
    def effects(self) -> tuple[str, ...]:
        """What the analyser should say, each once."""
        return tuple(dict.fromkeys(term.effect for term in self.terms if term.effect))


class FirstSight(_Strict):
    """What came out when a set was seen for the first time: at which ``commit`` and on which day (``date``, UTC), what
    was ``said``, the held-out RMSE over the expert's (``ratio``; None where nothing came out), and what was changed
    ``since`` with the set in view.
    """

    commit: str
    date: str
    said: str
    ratio: float | None = None
    since: str = "nothing"


class RealSet(_Strict):
    """A public set. ``apart``: nothing was changed in the analyser with its results in view."""

    name: str
    title: str
    source: str
    licence: str
    apart: bool = False
    files: Annotated[tuple[PublicFile, ...], Field(min_length=1)]
    mapping: str
    """text of the mapping file of the import"""
    expert: Expert
    first: FirstSight | None = None
    remark: str = ""
    """what was found out about a poor result; Markdown"""

    def missing(self, folder: Path) -> list[str]:
        """Sentences of the files that are not there or not the published ones; empty where all are."""
        out = []
        for file in self.files:
            path = folder / self.name / file.name
            if not path.is_file():
                out.append(f"{path} is not there; it is {file.at}")
            elif hashlib.sha256(path.read_bytes()).hexdigest() != file.sha256:
                out.append(f"{path} is another file than {file.at} (its SHA-256 differs)")
        return out


def load_set(text: str, where: str) -> RealSet:
    """A set from its table. Raises ConfigurationError, which begins with ``where``."""
    try:
        content: dict[str, Any] = tomllib.loads(text)
        return RealSet.model_validate(content)
    except tomllib.TOMLDecodeError as error:
        raise ConfigurationError(f"{where}: is no TOML ({error}).") from error
    except ValidationError as error:
        first = error.errors()[0]
        raise ConfigurationError(f"{where}: {'.'.join(str(p) for p in first['loc'])}: {first['msg']}.") from error


def all_sets() -> list[RealSet]:
    """The sets of this package, those set apart last, then by name."""
    files = [f for f in resources.files("bench.proof.real").joinpath("sets").iterdir() if f.name.endswith(".toml")]
    found = [load_set(f.read_text(encoding="utf-8"), f.name) for f in files]
    return sorted(found, key=lambda real: (real.apart, real.name))
