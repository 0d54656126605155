"""Progress of a campaign on the terminal: what runs now, how far, how long still."""

from __future__ import annotations

import time
from collections.abc import Sequence
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, TaskProgressColumn, TextColumn
from rich.progress import Task as Row
from rich.text import Text

from bench.campaigns.listener import Expected
from bench.campaigns.planning.plan import Plan
from bench.campaigns.planning.schedule import Task
from bench.campaigns.taken import Status, Taken
from bench.cli._plain import escaped
from bench.cli._text import duration_text

_OPENING = "opening the bench (the first run compiles)"


class _Remaining(ProgressColumn):
    """Remaining wall time, from the speed so far."""

    def render(self, task: Row) -> Text:
        if not task.completed or task.total is None or task.elapsed is None:
            return Text("…")
        rest = max(0.0, task.total - task.completed) * task.elapsed / task.completed
        return Text(f"{duration_text(rest)} left", style="cyan")


class ProgressListener:
    """Shows a campaign's progress in bench time; as a context manager it owns the display."""

    def __init__(self, total_s: float, console: Console, quiet: bool) -> None:
        self._progress = Progress(
            BarColumn(30),
            TaskProgressColumn(),
            _Remaining(),
            TextColumn("{task.fields[temperature]}"),
            TextColumn("[bold]{task.description}[/]"),
            console=console,
            disable=quiet,
            transient=True,
            refresh_per_second=5,
        )
        self._row = self._progress.add_task(_OPENING, total=total_s, temperature="")
        self._start: float | None = None
        self._last_update = 0.0

    def __enter__(self) -> ProgressListener:
        """Start the display."""
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop the display."""
        self._progress.stop()

    def planned(self, campaign_id: str, plan: Plan, points: Sequence[Expected]) -> None:
        """The bench is open: its lubricant may be warmer than assumed, so the time is another."""
        self._progress.update(self._row, total=plan.duration_s)

    def paused(self, now: bool, why: str = "") -> None:
        """Show that points wait."""
        if now:
            self._progress.update(self._row, description=f"paused: {why}" if why else "paused by the operator")

    def noticed(self, text: str) -> None:
        """Print what is not as it should be."""
        self._progress.console.print(f"[yellow]note:[/] {escaped(text)}", soft_wrap=True)

    def started(self, task: Task, recording_id: str) -> None:
        """Show the point that begins."""
        what = f"heating to {task.point.temperature:.1f} °C" if task.is_preparation else task.point.label
        self._progress.update(self._row, description=escaped(what))

    def advanced(self, bench_time_s: float, temperature: float) -> None:
        """Move the bar, at most twenty times a second."""
        if self._start is None:
            self._start = bench_time_s
        now = time.monotonic()
        if now - self._last_update > 0.05:
            self._last_update = now
            self._progress.update(self._row, completed=bench_time_s - self._start, temperature=f"{temperature:.1f} °C")

    def finished(self, taken: Taken) -> None:
        """Print a line for a recording that did not pass."""
        if taken.status is not Status.DONE:
            self._progress.console.print(
                f"[yellow]{escaped(taken.recording_id)}[/] ({escaped(taken.label)}): {escaped(taken.note)}",
                soft_wrap=True,
            )
