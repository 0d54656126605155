"""Results of an examination as they are stored: every score, and how they came about."""

from __future__ import annotations

import json
import math
import shlex
import subprocess
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from bench.campaigns.records.provenance import revision
from bench.errors import BenchError
from bench.proof.analyse import Job, analyser_digest
from bench.proof.score import CaseScore, EffectScore
from bench.proof.statistics import reliability, summarise
from bench.version import PACKAGE

FORMAT, FORMAT_VERSION = "bench-proof", "1.1"
#: Options of a command line that change nothing of what comes out.
_OF_NO_ACCOUNT = ("--out", "--jobs", "--dask", "--table", "--store")
_FLAGS_OF_NO_ACCOUNT = ("--done", "--keep")


class ResultsError(BenchError):
    """A stored result cannot be read."""


@dataclass(frozen=True, slots=True)
class Provenance:
    """How a table came about.

    Attributes:
        command: the line that makes it again. seeds: of the exam. commit: of the program, empty where it is not known.
        analyser: SHA-256 over its sources. asked: folders asked for, by set. seal: over all truths.
    """

    command: str
    seeds: tuple[int, ...]
    commit: str
    analyser: str
    asked: dict[str, int]
    seal: str = ""

    @property
    def summary(self) -> str:
        """One line for people."""
        seeds = f"seed{'s' if len(self.seeds) > 1 else ''} {', '.join(map(str, self.seeds))}"
        changed = " with changes" if self.commit.endswith("+changes") else ""
        commit = f"commit `{self.commit[:12]}`{changed}" if self.commit else "commit not known"
        return f"`{self.command}`; {seeds}; {commit}; analyser `{self.analyser[:12]}`"


@dataclass(frozen=True, slots=True)
class Stored:
    """A result as it is read back."""

    provenance: Provenance
    scores: tuple[CaseScore, ...]
    severity: bool = False


def provenance(arguments: Sequence[str], jobs: Sequence[Job], seal: str) -> Provenance:
    """How a result of these jobs came about; ``arguments`` are the command line's, the program's name left out."""
    return Provenance(
        command=command_line(arguments),
        seeds=tuple(sorted({job.seed for job in jobs})),
        commit=commit(),
        analyser=analyser_digest(),
        asked=dict(Counter(job.group for job in jobs)),
        seal=seal,
    )


def commit() -> str:
    """The commit the program runs from, ``+changes`` behind it where sources differ; empty outside a work tree."""
    root = PACKAGE.parent
    git = ["git", "-C", str(root)]
    try:
        head = subprocess.run([*git, "rev-parse", "HEAD"], capture_output=True, text=True, check=True).stdout.strip()
        changed = subprocess.run(
            [*git, "status", "--porcelain", "--", "bench", "fakes"], capture_output=True, text=True, check=True
        ).stdout
    except (OSError, subprocess.CalledProcessError):
        return revision()
    return f"{head}+changes" if changed.strip() else head


def command_line(arguments: Sequence[str]) -> str:
    """The command without what says only where and with how many processes it runs."""
    kept: list[str] = []
    words = iter(arguments)
    for word in words:
        if word in _FLAGS_OF_NO_ACCOUNT:
            continue
        name, equals, _value = word.partition("=")
        if name not in _OF_NO_ACCOUNT:
            kept.append(word)
        elif not equals:
            next(words, None)
    return shlex.join(["bench", *kept])


def as_json(scores: Sequence[CaseScore], how: Provenance, severity: bool = False) -> dict[str, Any]:
    """Everything the Markdown shows, and every score."""
    groups = list(dict.fromkeys(s.group for s in scores))
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "provenance": asdict(how),
        "severity": severity,
        "groups": [plain(asdict(summarise(g, [s for s in scores if s.group == g]))) for g in groups],
        "calibration": reliability(scores),
        "cases": [plain({**asdict(s), "every_point_right": s.every_point_right}) for s in scores],
    }


def store(path: Path, content: Mapping[str, Any]) -> None:
    """Write a result; one line a case, so that a version control shows which ones changed."""
    head = {key: value for key, value in content.items() if key != "cases"}
    cases = ",\n".join(json.dumps(case, allow_nan=False, ensure_ascii=False) for case in content["cases"])
    text = json.dumps(head, indent=1, allow_nan=False, ensure_ascii=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'{text[:-2]},\n "cases": [\n{cases}\n]\n}}\n', encoding="utf-8")


def load(path: Path) -> Stored:
    """Read a stored result.

    Raises
    ------
    ResultsError
        The file is no such result.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if content["format"] != FORMAT or content["format_version"] != FORMAT_VERSION:
            raise ResultsError(f"{path}: {content['format']} {content['format_version']} is not {FORMAT_VERSION}.")
        provenance = content["provenance"]
        how = Provenance(**{**provenance, "seeds": tuple(provenance["seeds"])})
        return Stored(how, tuple(scores_of(content["cases"])), bool(content["severity"]))
    except (ValueError, KeyError, TypeError) as error:
        raise ResultsError(f"{path}: is no stored result of bench prove ({error}).") from error


def scores_of(cases: Iterable[Mapping[str, Any]]) -> Iterable[CaseScore]:
    """The scores that :func:`as_json` wrote."""
    for case in cases:
        values = {key: value for key, value in case.items() if key != "every_point_right"}
        values["residual"] = math.nan if values["residual"] is None else values["residual"]
        values["effects"] = tuple(EffectScore(**{k: _tuple(v) for k, v in e.items()}) for e in values["effects"])
        values["confidences"] = tuple((float(p), bool(right)) for p, right in values["confidences"])
        values["false_companions"] = tuple(values["false_companions"])
        yield CaseScore(**values)


def _tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def plain(values: Any) -> Any:
    """NaN has no place in JSON: None instead."""
    if isinstance(values, Mapping):
        return {key: plain(value) for key, value in values.items()}
    if isinstance(values, list | tuple):
        return [plain(value) for value in values]
    return None if isinstance(values, float) and math.isnan(values) else values
