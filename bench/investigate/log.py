"""What was asked, expected and found: investigation.json, and the same as a text for a person."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bench.errors import ConfigurationError
from bench.investigate.design import Experiment
from bench.investigate.questions import Question, loss_of
from bench.mismatch.report.finding import Finding
from bench.mismatch.report.report import Report
from bench.mismatch.report.to_json import plain
from bench.whole import write_whole

FORMAT, FORMAT_VERSION = "bench-investigation", "1.0"
_HEAD = ("question", "open because", "expected gain", "what came", "became")


@dataclass(frozen=True, slots=True)
class Came:
    """What became of a question: gain of log predictive density of the present finding over its alternative (None:
    not computed), and in words.
    """

    gain: float | None
    words: str


@dataclass(frozen=True, slots=True)
class Step:
    """An experiment: its campaign file, hours it took and what came of each question; None and () until it is run."""

    number: int
    experiment: Experiment
    file: str
    hours: float | None = None
    came: tuple[Came, ...] = ()

    @property
    def keys(self) -> tuple[tuple[str, ...], ...]:
        """Questions it was run for."""
        return tuple(question.key for question, _ in self.experiment.gains)

    def to_json(self) -> dict[str, Any]:
        """The step as the log has it."""
        rows = []
        for k, (question, gain) in enumerate(self.experiment.gains):
            outcome = self.came[k] if k < len(self.came) else Came(None, "")
            finding = question.finding
            rows.append({
                "channel": finding.channel,
                "effect": finding.effect,
                "rivals": list(question.alternatives),
                "why": question.why,
                "expected_gain": gain,
                "came": outcome.gain,
                "became": outcome.words,
            })  # fmt: skip
        return {
            "number": self.number,
            "campaign": self.file,
            "why": self.experiment.why,
            "state": self.experiment.state,
            "points": [point.to_json() | {"options": dict(point.options)} for point in self.experiment.points],
            "expected_h": self.experiment.hours,
            "took_h": self.hours,
            "questions": rows,
        }


def outcome_of(question: Question, findings: Sequence[Finding]) -> Came:
    """What became of a question in a later analysis."""
    finding = question.finding
    there = [f for f in findings if f.channel == finding.channel]
    now = next((f for f in there if f.effect in (finding.effect, *question.alternatives)), None)
    if now is None:
        others = ", ".join(f"{f.effect} {f.status}" for f in there) or "nothing"
        return Came(None, f"no such finding any more; the channel has {others}")
    gains = []
    for alternative in question.alternatives:
        other = finding.effect if now.effect == alternative else alternative
        if now.effect not in (finding.effect, alternative):
            continue
        before, after = loss_of(finding, alternative), loss_of(now, other)
        if before is not None and after is not None:
            gains.append(after - before if now.effect == finding.effect else after + before)
    return Came(min(gains, default=None), f"{now.effect} {now.status}")


@dataclass(slots=True)
class Log:
    """The whole investigation. It is written anew after every change."""

    path: Path
    head: dict[str, Any]
    earlier: list[dict[str, Any]] = field(default_factory=list)
    """steps of an earlier run of the same investigation"""
    steps: list[Step] = field(default_factory=list)
    state: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def begun(cls, folder: Path, confidence: float, hours: float, out: Path) -> Log:
        """A log in ``out``; steps that are stored there already are kept."""
        path = out / "investigation.json"
        head: dict[str, Any] = {"format": FORMAT, "format_version": FORMAT_VERSION, "folder": str(folder)}
        head |= {"asked": {"confidence": confidence, "hours": hours}}
        before = _steps(path) if path.exists() else []
        return cls(path, head, [step for step in before if step["took_h"] is not None])

    @property
    def done(self) -> frozenset[tuple[str, ...]]:
        """Questions that an experiment was run for, each with why that experiment was."""
        now = {(*key, step.experiment.why) for step in self.steps for key in step.keys}
        before = {(*_key(row), step["why"]) for step in self.earlier for row in step["questions"]}
        return frozenset(now | before)

    @property
    def hours(self) -> float:
        """Bench time of all experiments, h."""
        return sum(float(step["took_h"]) for step in self.earlier) + sum(step.hours or 0.0 for step in self.steps)

    def settle(self, report: Report, questions: Sequence[Question]) -> None:
        """Store the present findings, and the questions that are open."""
        self.state |= {
            "verdict": report.verdict,
            "sentence": report.sentence,
            "findings": [
                {"effect": f.effect, "channel": f.channel, "status": f.status, "confidence": f.discovery.confidence}
                for f in report.findings
            ],
            "open": [{"effect": q.finding.effect, "channel": q.finding.channel, "why": q.why} for q in questions],
        }
        self.write()

    def add(self, step: Step) -> None:
        """Add an experiment."""
        self.steps.append(step)
        self.write()

    def end(self, why: str, needs: Sequence[str]) -> None:
        """Store why it ended, and what the bench would need to go on."""
        self.state |= {"ended": why, "bench_would_need": list(needs)}
        self.write()

    def to_json(self) -> dict[str, Any]:
        """The whole log."""
        steps = [*self.earlier, *(step.to_json() for step in self.steps)]
        out: dict[str, Any] = plain({**self.head, "hours": self.hours, "steps": steps, **self.state})
        return out

    def write(self) -> None:
        """Write investigation.json and investigation.md."""
        content = self.to_json()
        write_whole(self.path, json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
        write_whole(self.path.with_suffix(".md"), text(content))


def _steps(path: Path) -> list[dict[str, Any]]:
    """Steps of an earlier run. Raises ConfigurationError where the file is no such log."""
    try:
        content = json.loads(path.read_text("utf-8"))
    except ValueError as error:
        raise ConfigurationError(f"{path} is no JSON ({error}); give another folder with --out") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise ConfigurationError(f"{path} is no {FORMAT}; give another folder with --out")
    steps: list[dict[str, Any]] = content["steps"]
    return steps


def _key(row: dict[str, Any]) -> tuple[str, ...]:
    """The key of a question as it was stored."""
    return (row["channel"], *sorted({row["effect"], *row["rivals"]}))


def text(content: dict[str, Any]) -> str:
    """The log as Markdown."""
    lines = [f"# Investigation of {content['folder']}", "", content.get("sentence", "")]
    for step in content["steps"]:
        took = "not run" if step["took_h"] is None else f"{step['took_h']:.2f} h"
        lines += ["", f"## Experiment {step['number']} ({step['state']})", "", f"{step['why']}; `{step['campaign']}`."]
        lines += ["", f"Bench time: expected {step['expected_h']:.2f} h, took {took}.", ""]
        lines += [f"- {_point(point)}" for point in step["points"]]
        lines += [
            "",
            "| question | open because | expected gain | what came | became |",
            "| --- | --- | --- | --- | --- |",
        ]
        for row in step["questions"]:
            names = " or ".join((row["effect"], *row["rivals"]))
            cells = (names, row["why"], _number(row["expected_gain"]), _number(row["came"]), row["became"])
            lines.append(f"| {' | '.join(cells)} |")
    if "ended" in content:
        lines += ["", f"Ended: {content['ended']}. {content['hours']:.2f} h of bench time."]
    if content.get("bench_would_need"):
        lines += ["", "The bench would need:", "", *(f"- {need}" for need in content["bench_would_need"])]
    lines += ["", "Gains are natural logarithms of likelihood (expected) and of predictive density (what came)."]
    return "\n".join(lines) + "\n"


def _number(value: float | None) -> str:
    return "not computed" if value is None else f"{value:.1f}"


def _point(point: dict[str, Any]) -> str:
    text = f"{point['kind']}, {point['load_torque']:g} N·m, {point['velocity']:.3g} rad/s"
    text += f", {point['temperature']:g} °C" if "temperature" in point else ""
    return text + "".join(f", {key} {value.strip(chr(34))}" for key, value in point["options"].items())
