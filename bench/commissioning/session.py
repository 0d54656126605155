"""One commissioning from the first slave to the signed record."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from bench.commissioning import signs, slaves
from bench.commissioning.guide import Guide, Nobody
from bench.commissioning.record import Commissioned, StepRecord, Zero, digest, record_path, require_commissioned
from bench.commissioning.trial import Trial, slow
from bench.commissioning.zero import find_zero, require_zero
from bench.configuration import BenchConfiguration, BenchFile
from bench.cycle.rig import Rig
from bench.errors import LimitError
from bench.safety import Act, LatchFile, Standing
from bench.safety.paths import latch_path


@dataclass(frozen=True, slots=True)
class Step:
    """One step of the table: what it is called, what it does, and whether both drives need torque for it."""

    name: str
    title: str
    what: str
    enabled: bool
    do: Callable[[Trial], str]


STEPS: tuple[Step, ...] = (
    Step("identities", "Slaves", "identity and order of every slave", False, slaves.identities),
    Step("limits", "Limits in the drives", "written, read back, compared", False, slaves.limits),
    Step("safety", "Safety circuits", "emergency stop and safe torque off inputs", False, slaves.safety_circuits),
    Step("tare", "Torque sensor at rest", "its zero without load", False, slaves.tare),
    Step("brakes", "Brakes", "the load motor pushes softly against the closed brake", False, signs.brakes),
    Step("encoders", "Signs of motion", "the input motor turns slowly both ways", True, signs.encoders),
    Step("torques", "Signs of torque", "a little load is put on while turning", True, signs.torques),
)
"""Every step before the zero, in their order: nothing moves before what stands above it has passed."""


def commission(file: BenchFile, guide: Guide, by: str, *, only_zero: bool = False, seed: int = 0) -> Commissioned:
    """Try a bench out and return its record, which is kept in the bench's state folder if it has one.

    ``only_zero`` finds the encoders' zero again, as after a power cut, on a bench that has passed.

    Raises
    ------
    LimitError
        If the operator does not want to go on, a limit of the trial was broken, or an earlier stop was not resumed.
    DeviceError
        With what is wrong and what would be right, if a step does not pass.
    """
    bench = file.configuration
    path = record_path(bench)
    before = require_commissioned(bench) if only_zero else None
    steps = () if only_zero else STEPS
    tried = slow(file)
    latch = latch_of(bench)
    _resume(latch, guide, by)
    with Rig(tried, seed=seed, latch=latch) as rig:
        rig.reset_faults()
        trial = Trial(file, rig, guide, by)
        enabled = False
        done = []
        for number, step in enumerate(steps, 1):
            guide.step(number, len(steps) + 1, step.title, step.what)
            if step.enabled and not enabled:
                enabled = _enable(rig, guide)
            trial = replace(trial, values={})
            text = step.do(trial)
            guide.show(text)
            done.append(StepRecord(step.name, text, trial.values))
        guide.step(len(steps) + 1, len(steps) + 1, "Zero of the encoders", "passed slowly and unloaded, twice")
        if not enabled:
            _enable(rig, guide)
        trial = replace(trial, values={})
        text, zero = find_zero(trial)
        guide.show(text)
        done.append(StepRecord("zero", text, trial.values))
    if before is not None:
        record = before.with_zero(zero)
    else:
        now = datetime.now(UTC).isoformat(timespec="seconds")
        record = Commissioned(bench.name, bench.bus.interface, digest(bench), now, by, tuple(done), zero)
    if path is not None:
        _look_again(file, zero)
        record.save(path)
    return record


def latch_of(bench: BenchConfiguration) -> LatchFile:
    """Return the latch of a bench: a stop while it is tried out is a stop like any other."""
    return LatchFile(None if bench.bus.in_process else latch_path(bench, Path()))


def _resume(latch: LatchFile, guide: Guide, by: str) -> None:
    """Go on after a stop that was acknowledged and reset, if the operator says so; after any other refuse."""
    standing = latch.read()
    if standing.standing is Standing.RESET and guide.ask(f"The bench was stopped ({standing.text}). Try it out again?"):
        latch.act(Act.RESUME, by)
    latch.read().require_clear()


def _enable(rig: Rig, guide: Guide) -> bool:
    if not guide.ask("The drives are given torque, a share of their limits, and the shafts turn. Is everybody clear?"):
        raise LimitError("the operator did not want the shafts to move; nothing was recorded")
    rig.enable()
    return True


def _look_again(file: BenchFile, zero: Zero) -> None:
    """Open the bench once more as every run will: its own limits written, read back and compared, its zero kept."""
    with Rig(file, zero=zero) as rig:
        slaves.limits(Trial(file, rig, Nobody(), zero.by))
        require_zero(rig, zero)
