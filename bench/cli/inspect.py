"""``bench inspect``: what a recording holds, what is wrong with it, and a picture."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bench.cli._plain import PlainConsole, escaped, line, say
from bench.cli.exit_codes import ExitCode

if TYPE_CHECKING:
    from rich.console import Console

    from bench.recording import Recording
    from bench.recording.validation import Validation

_ABSENT = "–"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="inspect")(inspect)


def inspect(
    file: Annotated[Path, typer.Argument(help="A recording (.h5), finished or not (.part).")],
    plot: Annotated[
        Path | None, typer.Option("--plot", help="Where the picture goes; default: beside the recording.")
    ] = None,
    no_plot: Annotated[bool, typer.Option("--no-plot", help="Draw no picture.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print everything as JSON.")] = False,
) -> None:
    """Show a recording: set point, channels with their range, segments, events, checks, and a plot as PNG.

    Angles and velocities are printed in degrees. Exit code 6 when the file does not meet the recording format.
    """

    from bench.recording import Recording
    from bench.recording.plot import plot_recording
    from bench.recording.statistics import channel_ranges
    from bench.recording.validation import validate

    recording = Recording.open(file)
    checks = validate(file)
    ranges = channel_ranges(recording)
    picture = None if no_plot else plot_recording(recording, plot or file.with_suffix(".png"))
    if as_json:
        say(json.dumps(_as_dict(recording, ranges, checks, picture), ensure_ascii=False))
    else:
        _print(PlainConsole(highlight=False, soft_wrap=True), recording, ranges, checks, picture)
    if not checks.valid:
        raise typer.Exit(ExitCode.NOT_VALID)


def _as_dict(
    recording: Recording, ranges: dict[str, tuple[float, float, float]], checks: Validation, picture: Path | None
) -> dict[str, Any]:
    from bench.recording.manifest import entry

    return {
        **entry(recording),
        "campaign_id": recording.campaign_id,
        "started_at": recording.started_at.isoformat(),
        "sample_rate": recording.sample_rate,
        "source": recording.source,
        "complete": recording.complete,
        "accepted": recording.accepted,
        "axis": "linear" if recording.linear else "rotary",
        "take": recording.take,
        "zero_id": recording.zero_id,
        "rows": recording.size,
        "channels": {
            name: {"unit": recording.specs[name].unit, "dtype": recording.specs[name].dtype}
            | {key: _finite(value) for key, value in zip(("min", "mean", "max"), ranges[name], strict=True)}
            for name in recording.channels
        },
        "segments": [{"name": s.name, "start": s.start, "stop": s.stop} for s in recording.segments],
        "events": [{"time": _finite(e.time), "level": e.level, "text": e.text} for e in recording.events],
        "valid": checks.valid,
        "violations": checks.violations,
        "notes": checks.notes,
        "plot": None if picture is None else str(picture),
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _print(
    console: Console,
    recording: Recording,
    ranges: dict[str, tuple[float, float, float]],
    checks: Validation,
    picture: Path | None,
) -> None:
    from rich.table import Table

    from bench.recording.statistics import shown_unit

    setpoint, seconds = recording.setpoint, recording.size / recording.sample_rate
    console.print(
        f"[bold]{escaped(recording.recording_id)}[/]  {escaped(recording.kind)}, {escaped(recording.source)}, ", end=""
    )
    console.print(f"{recording.started_at:%Y-%m-%d %H:%M:%S} UTC, campaign {line(recording.campaign_id)}", markup=False)
    console.print(
        f"{recording.size} rows at {recording.sample_rate:g} Hz ({seconds:.1f} s), "
        f"{'complete' if recording.complete else 'cut short'}, accepted: {_word(recording.accepted)}, "
        f"take: {_word(recording.take)}, encoder zero: {line(_word(recording.zero_id))}",
        markup=False,
    )
    force, speed, factor = ("N", "m/s", 1.0) if recording.linear else ("N·m", *shown_unit("rad/s"))
    console.print(
        f"set point: load {_value(setpoint.load_torque)} {force}, "
        f"velocity {_value(setpoint.velocity * factor)} {speed}, temperature {_value(setpoint.temperature)} °C",
        markup=False,
    )
    table = Table(box=None, header_style="bold", pad_edge=False)
    for heading in ("channel", "unit", "type", "min", "mean", "max"):
        table.add_column(heading, justify="left" if heading in ("channel", "unit", "type") else "right")
    for name, (low, mean, high) in ranges.items():
        spec = recording.specs[name]
        unit, factor = shown_unit(spec.unit)
        table.add_row(
            escaped(name), escaped(unit), spec.dtype, *(f"{value * factor:.6g}" for value in (low, mean, high))
        )
    console.print(table)
    for segment in recording.segments:
        length = (segment.stop - segment.start) / recording.sample_rate
        console.print(
            f"segment {line(segment.name)}: rows {segment.start} to {segment.stop} ({length:.2f} s)", markup=False
        )
    for event in recording.events:
        console.print(f"event at {event.time:.3f} s, {line(event.level)}: {line(event.text)}", markup=False)
    for check in _quality_lines(recording.quality):
        console.print(line(check), markup=False)
    for sentence in (*checks.violations, *checks.notes):
        console.print(line(sentence), markup=False, soft_wrap=True)
    console.print(f"recording format: {'valid' if checks.valid else 'NOT valid'}")
    if picture is not None:
        console.print(f"plot: {picture}", markup=False, soft_wrap=True)


def _quality_lines(quality: dict[str, Any]) -> list[str]:
    """Give a line for each check made right after the recording, in whatever form its writer kept it."""
    lines: list[str] = []
    for name, result in quality.items():
        if not isinstance(result, dict) or "passed" not in result:
            lines.append(f"check {name}: {result}")
            continue
        if result["passed"] is None:
            lines.append(f"check {name}: not looked at")
            continue
        bounds = [result.get("low"), result.get("high")]
        shown = " to ".join(_ABSENT if bound is None else f"{bound:g}" for bound in bounds)
        value = result.get("value")
        measured = "" if value is None else f", {value:g} (allowed {shown})"
        lines.append(f"check {name}: {'passed' if result['passed'] else 'FAILED'}{measured}")
    return lines


def _value(value: float) -> str:
    return f"{value:g}" if math.isfinite(value) else _ABSENT


def _word(value: object) -> str:
    """Print a value of the bench's own attributes, which may be absent."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return _ABSENT if value is None else str(value)
