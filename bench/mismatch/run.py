"""``bench mismatch`` from end to end: recordings in; report.json, report.html and model.json out."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from bench.foreign.base import Base
from bench.mismatch import score, simulation_file
from bench.mismatch.analysis import Analysis, Progress, analyse, compared_channels
from bench.mismatch.better_window import better_window, leaves_less
from bench.mismatch.detection_limits import limits, one_way
from bench.mismatch.given import Given, says_span, with_span
from bench.mismatch.leave_one_out import Map, leave_one_out
from bench.mismatch.memory import give_back
from bench.mismatch.recordings.dataset import Dataset, enough
from bench.mismatch.recordings.loading import load
from bench.mismatch.recordings.source import Paths
from bench.mismatch.reference import MOST_ROUNDS, Reference, is_nonlinear, open_reference, values_of, with_reference
from bench.mismatch.report.content import Compared
from bench.mismatch.report.experiment import proposed
from bench.mismatch.report.finding import conclude
from bench.mismatch.report.page import page
from bench.mismatch.report.report import Report
from bench.mismatch.report.verdict import UNDETERMINED, judged
from bench.mismatch.unnamed.passed_on import without_passed_on
from bench.mismatch.unnamed.rest import unexplained
from bench.mismatch.wrong_parameters import by_channel, wrong_parameters
from bench.simulation.linear import of_linear_axis
from bench.simulation.model import TEETH, Simulation
from bench.simulation.terms import LIBRARY, LOAD_TORQUE, MOTOR_TORQUE
from bench.whole import write_whole

AS_GIVEN, BEFORE, AFTER = "as_given", "before", "after"


def run(
    recordings: Paths,
    out: Path,
    simulation: Path | None = None,
    progress: Progress | None = None,
    leaving_out: bool = False,
    elsewhere: Map | None = None,
    jobs: int = 1,
) -> Report:
    """Compare the simulation with recordings (a folder, or several as one data set) and write the report into ``out``;
    a large folder is read on ``jobs`` processes.

    With ``leaving_out`` every nominal term is switched off in turn as well (``elsewhere`` maps them over other
    processes). Raises RecordingError where nothing can be read, ConfigurationError where the simulation file is wrong.
    """
    with TemporaryDirectory() as store:
        return _run(recordings, out, open_reference(simulation, Path(store)), progress, leaving_out, elsewhere, jobs)


def _run(
    recordings: Paths,
    out: Path,
    reference: Reference,
    progress: Progress | None,
    leaving_out: bool,
    elsewhere: Map | None,
    jobs: int,
) -> Report:
    report_progress = progress or (lambda _what, _share: None)
    base = reference.base
    # a simulation that was handed over is compared with rates as it was found with
    known = says_span(reference.simulation) if reference.kind == "model" else None
    reading: Progress = lambda what, share: report_progress(what, 0.3 * share)  # noqa: E731
    data = load(recordings, reading, jobs, base, reference.waves, known)
    given = reference.given(data)
    waves = data.folder.manner.follows_waves
    unlike = given.gearbox.unlike(data.ratio) if reference.kind == "model" else ""
    channels, skipped = compared_channels(data, _calibrated_orders(reference, data, given))
    report = Report(UNDETERMINED, enough(data), data, skipped=skipped)
    report.simulation = Compared(reference.kind, reference.file)
    completed = given
    if not channels and not report.why:
        report.why = "no channel is there to compare: " + "; ".join(skipped)
    if not report.why:
        searching: Progress = lambda what, share: report_progress(what, 0.3 + 0.5 * share)  # noqa: E731
        analysis = analyse(data, Given.of(given, base), channels, searching)
        for _ in range(MOST_ROUNDS):
            if base is None or not is_nonlinear(data, analysis, values_of(analysis, base)[0]):
                break
            base = base.at(values_of(analysis, base)[0])
            data = load(recordings, None, jobs, base, waves, known)
            report.data = data
            analysis = analyse(data, Given.of(given, base), channels, searching)
        completed = _of_file(analysis, data)
        span = None if base is not None else better_window(data, completed)
        if span is not None:
            again = load(recordings, None, jobs, None, waves, span)
            if compared_channels(again, _calibrated_orders(reference, again, given))[0] == channels:
                other = analyse(again, Given.of(given, base), channels, searching)
                improved = _of_file(other, again)
                if leaves_less(again, improved, (data, completed)):
                    data, analysis, completed = again, other, improved
                    report.data = data
        report_progress("scoring what was held out", 0.8)
        scored(analysis, data, given if reference.kind != "nominal" else None, completed, reference.base)
        give_back()
        if base is not None and reference.base is not None:
            completed = with_reference(completed, base.at(values_of(analysis, base)[0]), out)
            for channel, wrong in by_channel(wrong_parameters(analysis, reference.base, base)).items():
                analysis.outcomes[channel].discoveries += wrong
        report.outcomes = tuple(analysis.outcomes.values())
        for outcome in report.outcomes:
            unexplained(outcome)
            outcome.notes += [limits(outcome, data), *one_way(outcome)]
        if {LOAD_TORQUE, MOTOR_TORQUE} <= analysis.outcomes.keys():
            load_densities = data.density.get(LOAD_TORQUE, ())
            without_passed_on(analysis.outcomes[LOAD_TORQUE], analysis.outcomes[MOTOR_TORQUE], load_densities)
        anew = () if base is None else tuple(p.name for p in base.free)
        report.simulation = replace(report.simulation, recalibrated=(*_changed_values(completed, given), *anew))
        findings = conclude(report.outcomes, data)
        report.findings = proposed(findings, data, out)
        report.verdict, report.why = judged(report.outcomes, report.findings)
        if leaving_out:
            # whatever becomes of the terms left out, what was found is kept
            _write(report, completed, out, unlike)
            report.left_out = leave_one_out(
                data,
                given,
                channels,
                report.findings,
                recordings,
                lambda what, _: report_progress(f"without {what}", 0.9),
                elsewhere,
            )
    report_progress("writing the report", 0.95)
    _write(report, completed, out, unlike)
    report_progress("done", 1.0)
    return report


def _of_file(analysis: Analysis, data: Dataset) -> Simulation:
    """The improved simulation as its file has it: what is scored is what the file will say."""
    improved = simulation_file.improved(analysis, data.gearbox)
    if data.folder.manner.free:
        improved = with_span(improved, data.folder.manner.smoothing)
    return Simulation.from_json(json.loads(json.dumps(improved.to_json())))


def _calibrated_orders(reference: Reference, data: Dataset, given: Simulation) -> tuple[float, ...]:
    """Orders that the simulation has of the transmission error of this gearbox; none of one whose teeth nobody said,
    where the nominal simulation has those of another.
    """
    teeth = any(getattr(data.gearbox, name, None) is not None for name in TEETH)
    return Given.of(given).orders if reference.kind == "model" or teeth else ()


def _write(report: Report, completed: Simulation, out: Path, unlike: str) -> None:
    """Write a report, its page and the ``completed`` simulation; ``unlike``: what a given one says of another gearbox,
    empty where nothing. Recordings that were loaded anew have their notes anew.
    """
    if unlike and unlike not in report.data.notes:
        report.data.notes.append(unlike)
    out.mkdir(parents=True, exist_ok=True)
    (of_linear_axis(completed) if report.data.linear else completed).save(out / "model.json")
    write_whole(out / "report.json", json.dumps(report.to_json(), indent=1, allow_nan=False) + "\n")
    write_whole(out / "report.html", page(report))


def scored(
    analysis: Analysis, data: Dataset, given: Simulation | None, completed: Simulation, handed: Base | None = None
) -> None:
    """Put root mean squares per sample into the outcomes: of held-out recordings, or of those fitted where none is.

    ``handed``: a simulation from elsewhere as it was handed over; each score is of its values at that stage.
    """
    models = {BEFORE: simulation_file.recalibrated(analysis, data.gearbox), AFTER: completed}
    if given is not None:
        models[AS_GIVEN] = given
    held = [m for m in data.members if m.held_out]
    found: dict[str, dict[str, float | None]] = {channel: {} for channel in analysis.outcomes}
    for names, on in _stages(analysis, data, tuple(models), handed):
        errors = score.rmse(on, analysis, {name: models[name] for name in names}, held or data.members)
        for channel, scores in errors.items():
            found[channel] |= scores
    for channel, outcome in analysis.outcomes.items():
        scores = {AS_GIVEN: None, **found[channel]}
        if held:
            outcome.rmse = scores
        else:
            outcome.in_sample = scores


def _stages(
    analysis: Analysis, data: Dataset, names: tuple[str, ...], handed: Base | None
) -> Iterator[tuple[tuple[str, ...], Dataset]]:
    """Models that are scored together, and the recordings less what the simulation from elsewhere says of them then."""
    base = data.folder.base
    if base is None or handed is None:
        yield names, data
        return
    values = {
        AS_GIVEN: handed.named,
        BEFORE: values_of(analysis, base, False)[0],
        AFTER: values_of(analysis, base)[0],
    }
    for name in names:
        yield (name,), replace(data, folder=replace(data.folder, base=base.at(values[name])))


def _changed_values(completed: Simulation, given: Simulation) -> tuple[str, ...]:
    """Symbols of nominal terms whose values are not those of the given simulation."""
    out = []
    for effect, term in completed.terms.items():
        if effect not in LIBRARY or not LIBRARY[effect].nominal or not term.enabled:
            continue
        before = given.terms.get(effect)
        out += [f"{effect}.{s}" for s, p in term.parameters.items() if before is None or before.parameters.get(s) != p]
        if term.coefficients is not None and (before is None or before.coefficients is None):
            out.append(effect)
    return tuple(out)
