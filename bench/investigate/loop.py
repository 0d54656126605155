"""Analyse, experiment, analyse again: until all is named, nothing more can be gained, or the budget is spent."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Protocol

from bench.configuration import BenchConfiguration
from bench.errors import ConfigurationError
from bench.investigate.design import Experiment, bench_needs, best, by_rules
from bench.investigate.log import Log, Step, outcome_of
from bench.investigate.offer import extended_range, last_celsius, write_campaign
from bench.investigate.questions import Question, questions
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.report.candidates import Range
from bench.mismatch.report.report import Report
from bench.mismatch.run import run as compare
from bench.recording import RecordingFolder

EXPERIMENT, LOOK = "experiment", "look"
LEAST_GAP = timedelta(minutes=1)
"""between the last recording and the experiment that follows"""


class Lab(Protocol):
    """The bench that recordings came from."""

    @property
    def bench(self) -> BenchConfiguration:
        """Its bench file."""
        ...

    def celsius(self, last: float) -> float:
        """Temperature of the lubricant at which the next campaign begins, °C, if the last one ended at ``last``."""
        ...

    def run(self, campaign: Path, folder: Path, after: datetime) -> float:
        """Run a campaign, not before ``after``; the hours of bench time it took.

        Raises BenchError where it came to no end.
        """
        ...


@dataclass(frozen=True, slots=True)
class Goal:
    """How sure it is to be, and what it may cost: ``confidence`` of each finding, bench time in h, experiments."""

    confidence: float = 0.7
    hours: float = 8.0
    experiments: int = 5


@dataclass(frozen=True, slots=True)
class Scene:
    """What an experiment is chosen from."""

    questions: tuple[Question, ...]
    covered: Range
    ratio: float
    bench: BenchConfiguration
    celsius: float
    hours: float
    """that are left"""
    done: frozenset[tuple[str, ...]]
    """questions for which a rule of the field was run, with the rule"""

    @classmethod
    def of(cls, report: Report, lab: Lab, goal: Goal, log: Log) -> Scene:
        """The scene after a look at the recordings."""
        data = report.data
        covered = extended_range(Range.of(data), lab.bench)
        celsius = lab.celsius(last_celsius([rows.frame for rows in data.rows.values()]))
        left = goal.hours - log.hours
        found = questions(report.findings, goal.confidence)
        return cls(found, covered, data.ratio, lab.bench, celsius, left, log.done)


Choice = Callable[[Scene], Experiment | None]
Progress = Callable[[str], None]


def choose_experiment(scene: Scene) -> Experiment | None:
    """The designed experiment; a rule of the field where no design separates anything; None where neither does."""
    designed, _ = best(scene.questions, scene.covered, scene.ratio, scene.bench, scene.celsius, scene.hours)
    if designed is not None:
        return designed
    return by_rules(scene.questions, scene.covered, scene.bench, scene.celsius, scene.hours, set(scene.done))


def investigate(
    folder: Path,
    out: Path,
    lab: Lab,
    goal: Goal,
    choose: Choice = choose_experiment,
    report_progress: Progress = lambda _: None,
    first: Report | None = None,
    plan_only: bool = False,
) -> Log:
    """Run experiments on ``lab`` into ``out`` until the findings in ``folder`` are settled; the log, as written there.

    Experiments that ``out`` has already are looked at as well: it goes on where it was stopped. ``first``: the report
    on the folder, if it is there. ``plan_only``: the first experiment is designed and not run. Raises RecordingError
    and ConfigurationError as ``bench mismatch`` does, and what the lab raises; the log has what was done until then.
    """
    require_same_gearbox(folder, lab.bench)
    out.mkdir(parents=True, exist_ok=True)
    earlier = [p for p in sorted(out.glob(f"{EXPERIMENT}-*")) if p.is_dir() and any(p.glob("*.h5"))]
    folders = [folder, *earlier]
    log = Log.begun(folder, goal.confidence, goal.hours, out)
    report = first if first is not None and not earlier else _look(folders, out, report_progress)
    while True:
        scene = Scene.of(report, lab, goal, log)
        log.settle(report, scene.questions)
        report_progress(report.sentence)
        why = _over(report, scene, goal, log)
        experiment = None if why else choose(scene)
        if experiment is None:
            needs = [] if why else bench_needs(scene.questions, scene.covered, scene.ratio, scene.bench, scene.celsius)
            log.end(why or _nothing_more(scene), needs)
            return log
        number = len(folders)
        path = write_campaign(out / f"{EXPERIMENT}-{number}.toml", _title(scene.questions), number, experiment.points)
        report_progress(f"experiment {number}: {experiment.why}; {experiment.hours:.2f} h of bench time, {path}")
        if plan_only:
            log.add(Step(number, experiment, path.name))
            log.end("the next experiment is designed, as asked, and was not run", [])
            return log
        into = out / f"{EXPERIMENT}-{number}"
        hours = lab.run(path, into, _after(report.data))
        folders.append(into)
        report = _look(folders, out, report_progress)
        outcomes = tuple(outcome_of(question, report.findings) for question, _ in experiment.gains)
        log.add(Step(number, experiment, path.name, hours, outcomes))


def require_same_gearbox(folder: Path, bench: BenchConfiguration) -> None:
    """Refuse a bench that has another gearbox, or another encoder zero, than the recordings (ConfigurationError)."""
    for recording in RecordingFolder.open(folder).recordings:
        pairs = (
            ("gearbox", recording.gearbox_serial, bench.gearbox.serial),
            ("gear ratio", recording.gearbox.ratio, bench.gearbox.ratio),
        )
        for words, recorded, other in pairs:
            if recorded is not None and recorded != other:
                raise ConfigurationError(
                    f"{folder} has the {words} {recorded}, the bench file {bench.name} has {other}; name the bench "
                    "they were recorded on with --bench"
                )


def _look(folders: Sequence[Path], out: Path, report_progress: Progress) -> Report:
    report_progress(f"looks at {', '.join(str(f) for f in folders)}")
    return compare(tuple(folders), out / f"{LOOK}-{len(folders) - 1}")


def _over(report: Report, scene: Scene, goal: Goal, log: Log) -> str:
    """Why it ends before a choice; empty where it goes on."""
    if not scene.questions:
        return reason_to_stop(len(report.findings), report.why)
    if len(log.steps) >= goal.experiments:
        return f"{goal.experiments} experiments are run, as many as asked for"
    return "the budget of bench time is spent" if scene.hours <= 0.0 else ""


def reason_to_stop(findings: int, why: str) -> str:
    """Why nothing is asked after a report with so many ``findings``; ``why`` it found none, where it could not."""
    if findings:
        return "all is named"
    return f"undetermined: {why}" if why else "nothing is found that the simulation leaves out, so there is no question"


def _nothing_more(scene: Scene) -> str:
    """Whether more time would help."""
    more = choose_experiment(replace(scene, hours=float("inf")))
    if more is None:
        return "nothing more can be gained with what this bench does"
    return f"the next experiment takes {more.hours:.1f} h, {scene.hours:.1f} h are left of the budget"


def _title(questions: Sequence[Question]) -> str:
    return "; ".join(q.finding.name for q in questions[:3]).replace('"', "'").replace("\n", " ")


def _after(data: Dataset) -> datetime:
    """When the next campaign may begin: recordings stand in the order of their time."""
    end = max(float(rows.frame.time.max()) for rows in data.rows.values())
    return datetime.fromtimestamp(data.folder.start + end, UTC) + LEAST_GAP
