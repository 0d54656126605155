"""Several folders, or several terms left out, at once: on this machine's processes or on a Dask cluster.

Every task is a process's own and gives the same result wherever it runs. Workers read the recordings themselves, so
those of a cluster must see the same folders under the same paths.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.errors import BenchError, ConfigurationError
from bench.mismatch.leave_one_out import Question
from bench.mismatch.mapping import over
from bench.mismatch.report.left_out import LeftOut
from bench.mismatch.run import run


@dataclass(frozen=True, slots=True)
class Task:
    """One folder to compare, or several as one data set."""

    recordings: Path | tuple[Path, ...]
    out: Path
    simulation: Path | None = None
    leaving_out: bool = False


@dataclass(frozen=True, slots=True)
class Result:
    """Result of a task: its report, or the sentence that gives the reason why there is none."""

    task: Task
    report: dict[str, Any] | None
    sentence: str


def tasks_of(
    folders: Sequence[Path],
    out: Path,
    simulation: Path | None = None,
    leaving_out: bool = False,
    together: bool = False,
) -> list[Task]:
    """One task a folder: ``out`` itself for one folder, for several a folder in it of each one's name; one task of all
    where they are compared ``together``.

    Raises ConfigurationError where two folders have the same name.
    """
    if len(folders) == 1:
        return [Task(folders[0], out, simulation, leaving_out)]
    if together:
        return [Task(tuple(folders), out, simulation, leaving_out)]
    names = [folder.resolve().name for folder in folders]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ConfigurationError(
            f"two folders are called {twice[0]}, their reports would stand in the same place; compare them one by one"
        )
    return [Task(f, out / name, simulation, leaving_out) for f, name in zip(folders, names, strict=True)]


def compare(task: Task) -> Result:
    """Compare one folder; an error of the folder is reported, not raised, so that the others go on."""
    try:
        report = run(task.recordings, task.out, task.simulation, leaving_out=task.leaving_out)
    except BenchError as error:
        return Result(task, None, str(error))
    content: dict[str, Any] = json.loads((task.out / "report.json").read_text(encoding="utf-8"))
    return Result(task, content, report.sentence)


def compare_all(tasks: Sequence[Task], jobs: int = 1, dask: str | None = None) -> Iterator[Result]:
    """Compare many folders, in their order."""
    yield from over(compare, tasks, jobs, dask)


def terms_over(jobs: int, dask: str | None) -> Callable[[Callable[[Question], LeftOut], Sequence[Question]], Any]:
    """The map that :func:`bench.mismatch.leave_one_out.leave_one_out` takes."""
    return lambda function, questions: over(function, questions, jobs, dask)
