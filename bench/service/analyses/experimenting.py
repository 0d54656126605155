"""An investigation in its own process: it looks and designs; the service, which has the bench, runs what it asks for.

An experiment is asked for in a line of JSON (``asks``: number, campaign file, folder, time, plan); the answer is a line
on standard input, with ``bench_time_s`` of the run or ``problem``, a sentence.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from bench.campaigns import load_campaign, make_plan
from bench.configuration import BenchConfiguration, BenchFile, load_bench, on_interface, playing
from bench.errors import LimitError
from bench.investigate.loop import LOOK, Goal
from bench.investigate.loop import investigate as go

Progress = Callable[..., None]
SAID = "said.txt"
"""what it said, line by line, with the time of day"""
_SHOWN = ("report.html", "report.json", "model.json")
SECONDS_AN_HOUR = 3600.0


@dataclass(frozen=True, slots=True)
class Investigation:
    """What was asked: budget of bench time in h, most experiments, confidence each finding has to reach; the bench.

    ``alone``: experiments after the first begin without a yes where the bench allows it; ``real_time``: pace of an
    emulated bench.
    """

    bench: str
    interface: str | None = None
    plant: str | None = None
    hours: float = 8.0
    experiments: int = 5
    confidence: float = 0.7
    alone: bool = False
    real_time: bool = False

    def file(self) -> BenchFile:
        """The bench as its runs have it."""
        file = load_bench(self.bench)
        file = file if self.interface is None else on_interface(file, self.interface)
        return file if self.plant is None else playing(file, self.plant)


class AskingLab:
    """The bench, used through the service.

    ``report_progress`` sends a request to the service; ``hear`` waits for the line with its answer.
    """

    def __init__(self, bench: BenchConfiguration, report_progress: Progress, hear: Callable[[], str]) -> None:
        self._bench, self._report_progress, self._hear = bench, report_progress, hear
        self._celsius: float | None = None

    @property
    def bench(self) -> BenchConfiguration:
        """Its configuration."""
        return self._bench

    def celsius(self, last: float) -> float:
        """As the last recording ended; an emulated bench is a new one each time, as cold as its surroundings."""
        self._celsius = self._bench.nominal.ambient_temperature if self._bench.bus.in_process else last
        return self._celsius

    def run(self, campaign: Path, folder: Path, after: datetime) -> float:
        """Have a campaign run; hours of bench time. Raises LimitError where it came to no end."""
        plan = make_plan(load_campaign(str(campaign)), self._bench, self._celsius)
        number = int(folder.name.rsplit("-", 1)[-1])
        asks: dict[str, Any] = {"number": number, "campaign": str(campaign.absolute())}
        asks |= {"folder": str(folder.absolute()), "after": after.isoformat(), "plan": plan.as_dict()}
        self._report_progress(f"experiment {number} waits", asks=asks)
        line = self._hear()
        answer = json.loads(line) if line else {"problem": "the service ended"}
        if "problem" in answer:
            raise LimitError(f"experiment {number}: {answer['problem']}")
        return float(answer["bench_time_s"]) / SECONDS_AN_HOUR


def investigate(
    recordings: Path, out: Path, asked: Investigation, report_progress: Progress, hear: Callable[[], str]
) -> str:
    """Investigate a folder into ``out``; why it ended, in a sentence. Raises as :func:`bench.investigate.loop` does."""
    share = 0.0

    def say(what: str, **more: Any) -> None:
        nonlocal share
        if "asks" in more:
            share = min(0.95, more["asks"]["number"] / (asked.experiments + 1))
        with (out / SAID).open("a", encoding="utf-8") as said:
            said.write(f"{datetime.now().astimezone().isoformat(timespec='seconds')} {what}\n")
        _show_last_look(out)
        report_progress(what, share, **more)

    out.mkdir(parents=True, exist_ok=True)
    lab = AskingLab(asked.file().configuration, say, hear)
    log = go(recordings, out, lab, Goal(asked.confidence, asked.hours, asked.experiments), report_progress=say)
    _show_last_look(out)
    return f"{log.state['ended']}; {log.state['sentence']}"


def _show_last_look(out: Path) -> None:
    """Put the last look's report and model where those of any analysis lie."""
    looks = sorted(out.glob(f"{LOOK}-*"), key=lambda path: int(path.name.rsplit("-", 1)[-1]))
    whole = [look for look in looks if (look / _SHOWN[0]).exists()]
    for name in _SHOWN if whole else ():
        shutil.copyfile(whole[-1] / name, out / name)
