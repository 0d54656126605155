"""From a folder of recordings to a validated model: both methods on the same data, and the slow equations."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from bench.errors import BenchError, RecordingError
from bench.identification.balances.heat import HeatFit, identify_heat
from bench.identification.balances.instant import systematic
from bench.identification.balances.load_side import identify_load_side
from bench.identification.balances.slow_equations import friction_of
from bench.identification.samples.reduction import Reduction, reduce_recording
from bench.identification.samples.rounding import find_step
from bench.identification.samples.steady import ReductionOptions
from bench.identification.samples.windows import Skipped
from bench.identification.selection import select
from bench.identification.series.orders import Proposal, nuisance_orders, propose
from bench.identification.series.paper import identify_paper
from bench.identification.series.refined import RefinedDirection, identify_direction
from bench.identification.series.ripple import find_ripple
from bench.identification.statistics.regression import LinearFit
from bench.identification.validation import Score, score
from bench.processes import over
from bench.recording import Recording, RecordingFolder
from bench.simulation import Gearbox, TransmissionErrorModel
from bench.simulation.orders import nominal_orders

METHODS = ("refined", "paper")
Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Options:
    """What to identify with. ``orders`` None takes the paper's choice for the gearbox of the recordings.

    ``notch_orders`` are the load motor's ripple; None finds them in the load torque.
    """

    orders: tuple[float, ...] | None = None
    notch_orders: tuple[int, ...] | None = None
    jobs: int = 1
    band_limit_hz: float | None = None


@dataclass(frozen=True, slots=True)
class Identification:
    """Everything the command found; the report and the model file are made of it."""

    folder: Path
    gearbox: Gearbox
    orders: tuple[float, ...]
    notch_orders: tuple[int, ...]
    reductions: tuple[Reduction, ...]
    refined: dict[str, RefinedDirection]
    models: dict[str, TransmissionErrorModel]
    scores: tuple[Score, ...]
    proposals: tuple[Proposal, ...]
    friction: LinearFit
    load_side: LinearFit
    heat: HeatFit
    skipped: tuple[Skipped, ...]
    sentences: tuple[str, ...]

    @property
    def linear(self) -> bool:
        """Whether the axis is linear (m and N in place of rad and N·m)."""
        return any(r.linear for r in self.reductions)


def _reduce_or_skip(recording: Recording, options: ReductionOptions) -> Reduction | Skipped:
    """Reduce one recording; one that fails is skipped with its sentence, the others go on."""
    try:
        return reduce_recording(recording, options)
    except RecordingError as error:
        return Skipped(recording.recording_id, str(error))


@contextmanager
def _single_threaded() -> Iterator[None]:
    """Let processes started meanwhile use one thread each for linear algebra."""
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def reduce_all(
    recordings: Sequence[Recording], options: ReductionOptions, jobs: int, progress: Progress | None
) -> Iterator[Reduction | Skipped]:
    """Reduce recordings in ``jobs`` processes, in their order."""
    work = partial(_reduce_or_skip, options=options)
    total = len(recordings)
    apart = jobs > 1 and total >= 8
    with _single_threaded() if apart else nullcontext():
        for number, result in enumerate(over(work, recordings, jobs if apart else 1, chunk=2), 1):
            yield result
            if progress:
                progress(number, total)


def _gearbox(recordings: Sequence[Recording]) -> Gearbox:
    for r in recordings:
        if r.gearbox.ratio is not None:
            g = r.gearbox
            return Gearbox(float(r.gearbox.ratio), g.z1, g.z2, g.z3, g.z4)
    raise RecordingError("No recording names its gearbox ratio; /gearbox should have the attribute 'ratio'.")


def _direction_of(reduction: Reduction) -> str | None:
    if reduction.steady is None:
        return None
    return "positive" if reduction.steady.window.direction > 0 else "negative"


def identify_folder(folder: Path | str, options: Options, progress: Progress | None = None) -> Identification:
    """Identify everything the recordings of a folder determine.

    ``progress`` is called with (recordings done, recordings in all). Raises RecordingError where the folder holds no
    usable recording.
    """
    opened = RecordingFolder.open(folder)
    recordings, skipped = select(opened)
    if not recordings:
        reason = f" ({skipped[0].why})" if skipped else ""
        raise RecordingError(f"{folder}: holds no recording that can be used{reason}")
    gearbox = _gearbox(recordings)
    orders: tuple[float, ...] = options.orders or nominal_orders(gearbox)
    if any(f < 1 for f in orders):
        raise BenchError(f"Harmonic orders should be 1 or higher, not {min(orders):g}.")
    notch, ripple_text = (options.notch_orders, "") if options.notch_orders is not None else find_ripple(recordings)
    step = find_step(recordings)
    reduction_options = ReductionOptions(orders, notch, band_limit_hz=options.band_limit_hz, torque_step=step)
    reductions: list[Reduction] = []
    for result in reduce_all(recordings, reduction_options, options.jobs, progress):
        if isinstance(result, Skipped):
            skipped.append(result)
        else:
            reductions.append(result)
            skipped += [Skipped(result.recording_id, why) for why in result.sentences]
    training = [r for r in reductions if not r.validation]
    load_side, sentences = identify_load_side(training, notch)
    if ripple_text:
        sentences.append(ripple_text)
    friction, more = friction_of(training)
    sentences += more
    friction = replace(friction, systematic=systematic(recordings, friction))
    heat = identify_heat(training, friction.values.get("tau_0", 0.0), friction.values.get("J", 0.0))
    sentences += heat.sentences
    proposals = propose(reductions, gearbox, orders, notch)
    nuisance = nuisance_orders(proposals, notch, reduction_options.highest_order, orders)
    refined: dict[str, RefinedDirection] = {}
    paper: dict[str, Any] = {"positive": None, "negative": None}
    for name in ("positive", "negative"):
        group = [r for r in training if _direction_of(r) == name]
        series = identify_direction(group, orders, notch, name, nuisance)
        paper[name] = identify_paper(group, orders)
        if series is None and any(r.steady is not None for r in training):
            sentences.append(
                f"No recording with a steady revolution in {name} direction: its series is not identified."
            )
        elif series is not None:
            refined[name] = series
            sentences += series.sentences
    if not refined:
        sentences.append(
            "No recording gives a transmission error over a steady revolution: its series is not identified."
        )
    models: dict[str, TransmissionErrorModel] = {}
    if refined:
        sets = {name: result.fourier for name, result in refined.items()}
        models["refined"] = TransmissionErrorModel(sets.get("positive"), sets.get("negative"))
        models["paper"] = TransmissionErrorModel(paper["positive"], paper["negative"])
    scored = [score(r, models, orders, notch) for r in reductions]
    return Identification(
        Path(folder),
        gearbox,
        orders,
        notch,
        tuple(reductions),
        refined,
        models,
        tuple(s for s in scored if s is not None),
        proposals,
        friction,
        load_side,
        heat,
        tuple(skipped),
        tuple(sentences),
    )


def with_proposed_orders(found: Identification, options: Options) -> Options:
    """Return options with the proposed orders added to those used (the ripple's left out)."""
    extra = {p.order for p in found.proposals if p.order not in found.notch_orders}
    return replace(options, orders=tuple(sorted({*found.orders, *extra})), notch_orders=found.notch_orders)
