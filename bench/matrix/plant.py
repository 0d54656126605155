"""Rows struck while the bench turns under load, in process: exact to the bus cycle, and quick."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from bench.campaigns.records.recorder import Recorder
from bench.configuration import BenchConfiguration, BenchFile
from bench.cycle.assembly import assemble
from bench.cycle.end import EndKind
from bench.cycle.rig import Rig
from bench.errors import LimitError
from bench.matrix.outcome import Envelope, Outcome
from bench.matrix.rows import Row
from bench.matrix.shafts import Shafts
from bench.protocols import Phase, Segment
from bench.recording import Gearbox, Recording, RecordingHeader, Setpoint
from bench.recording.validation import validate
from bench.safety import Cause, LatchFile, Standing

SPEED, LOAD_SHARE = 0.5, 0.25
"""Load-side speed in rad/s and share of limits.load_torque at which faults strike."""
_RAMP_S, _STRIKES_S = 2.5, 1.0
_WATCHDOGS_S, _AFTERWARDS_S = 0.8, 0.5
"""Looked at after a stop: where the drives' own watchdogs have to act, and where the bench was seen at rest."""
_LOAD_STANDSTILL = 0.02


@dataclass(frozen=True, slots=True)
class Strike:
    """A fault as the emulator's switch takes it."""

    name: str
    role: str | None = None
    value: float | None = None

    @staticmethod
    def of(text: str) -> Strike:
        """Read ``name[:slave][=value]``."""
        head, _, value = text.partition("=")
        name, _, role = head.partition(":")
        number = None if not value else float(int(value, 16)) if value.startswith("0x") else float(value)
        return Strike(name, role or None, number)


def motion(bench: Any, last_s: float) -> tuple[Phase, ...]:
    """Return phases: up to speed, load on, steady, load off, down; the load stands for a tenth of a second at least."""
    load = LOAD_SHARE * bench.limits.load_torque
    loading = load / bench.motion.torque_rate + 0.5
    return (
        Phase(Segment.RAMP_UP, _RAMP_S, SPEED, 0.0),
        Phase(Segment.RAMP_UP, loading, SPEED, load),
        Phase(Segment.STEADY, last_s, SPEED, load),
        Phase(Segment.RAMP_DOWN, loading, SPEED, 0.0),
        Phase(Segment.RAMP_DOWN, _RAMP_S, 0.0, 0.0),
    )


def strike_cycle(rig: Rig) -> int:
    """Return the emulated bench's cycle at which a motion that begins now is struck, a second into its load."""
    bench = rig.bench
    lead_s = _RAMP_S + LOAD_SHARE * bench.limits.load_torque / bench.motion.torque_rate + 0.5 + _STRIKES_S
    master: Any = rig.link.assembly.master
    return int(master.bench.cycle) + round(lead_s / bench.bus.cycle_time)


def with_block(file: BenchFile, block: int) -> BenchFile:
    """Return the bench with another number of cycles between two looks."""
    bus = file.configuration.bus.model_copy(update={"block": block})
    return BenchFile(file.configuration.model_copy(update={"bus": bus}), file.text, file.origin)


def run_plant_row(row: Row, file: BenchFile, folder: Path, seed: int = 0) -> Outcome:
    """Record once undisturbed, then strike, and look at everything that has to hold."""
    file = with_block(file, row.block)
    bench = file.configuration
    outcome = Outcome(row.name, row.text, row.kind)
    assembly = assemble(bench, seed=seed, real_time=False)
    master: Any = assembly.master
    with Rig(file, assembly=assembly, latch=LatchFile(folder / "latch.json")) as rig:
        rig.enable()
        earlier = record(rig, file, folder, "earlier", (Phase(Segment.DWELL, 0.5, 0.0, 0.0),))
        outcome.require(
            earlier[0].kind is EndKind.FINISHED, f"the bench did not run before the fault: {earlier[0].text}"
        )
        at, offset = strike_cycle(rig), master.bench.cycle - rig.link.cycle
        strike = Strike.of(row.fault)
        master.faults.apply(strike.name, strike.role, strike.value, at_cycle=at)
        end, shafts = record(rig, file, folder, "struck", motion(bench, row.last_s))
        if end.kind is not EndKind.FINISHED:
            blind = any(rung.rung == "stop sending" for stop in rig.stops for rung in stop.rungs)
            shafts.silence(_WATCHDOGS_S if blind else _AFTERWARDS_S)
        judge_end(row, outcome, rig, end, shafts)
        judge_stop(row, outcome, rig, shafts, at, offset)
        outcome.struck = shafts.at(at)
        judge_shafts(outcome, bench, shafts)
        master.faults.clear(strike.name, strike.role)
    read_back(outcome, folder, {"earlier": earlier[1], "struck": shafts})
    if not row.causes and row.expected_text:
        texts = [event.text for event in Recording.open(folder / "struck.h5").events if row.expected_text in event.text]
        outcome.sentence = next(iter(texts), "")
        outcome.require(bool(texts), f"the recording does not say '{row.expected_text}'")
        outcome.reaction += ", marked" if texts else ""
    return outcome


def record(rig: Rig, file: BenchFile, folder: Path, name: str, phases: tuple[Phase, ...]) -> tuple[Any, Shafts]:
    """Run phases into a recording, and look at the shafts meanwhile; return the end and what was seen."""
    recorder = Recorder(
        folder / f"{name}.h5", header(file, rig, name), rig.scaling, fast=True, ratio=file.configuration.gearbox.ratio
    )
    shafts = Shafts(recorder, rig.link.assembly.master)
    end = rig.run(phases, shafts, lambda: False)
    recorder.close(complete=end.kind is EndKind.FINISHED, accepted=None, quality=None)
    return end, shafts


def header(file: BenchFile, rig: Rig, name: str) -> RecordingHeader:
    """Return the header of a recording of the matrix."""
    return RecordingHeader(
        recording_id=name,
        campaign_id="faults",
        kind="dwell",
        started_at=datetime.now(UTC),
        sample_rate=1.0 / file.configuration.bus.cycle_time,
        source=rig.source,
        setpoint=Setpoint(),
        gearbox=Gearbox(file.configuration.gearbox.ratio),
        zero_id=rig.zero_id,
        config=file.text,
    )


def judge_end(row: Row, outcome: Outcome, rig: Rig, end: Any, shafts: Shafts, stops: int = 0) -> None:
    """Cause, sentence, latch and record; ``stops`` there were before."""
    if end.kind is EndKind.FINISHED:
        outcome.reaction = "runs on"
    if not row.causes:
        outcome.require(end.kind is EndKind.FINISHED, f"the bench stopped, it should have run on: {end.text}")
        return
    outcome.cause, outcome.sentence = end.cause.name, end.text
    outcome.require(end.kind is EndKind.TRIPPED, f"the bench did not stop ({end.kind.name})")
    outcome.require(end.cause.name in row.causes, f"the cause found is {end.cause.name}, not {' or '.join(row.causes)}")
    outcome.require(row.expected_text in end.text, f"the sentence does not say '{row.expected_text}': {end.text}")
    heard = end.cause is Cause.RECORDER or any(end.text in text for text in shafts.events)
    outcome.require(heard, "the recording's events do not say why")
    outcome.require(rig.latch.read().standing is Standing.STOPPED, "the stop is not latched")
    outcome.require(len(rig.stops) == stops + 1, f"there are {len(rig.stops) - stops} records of one stop")
    try:
        rig.enable()
    except LimitError:
        return
    outcome.require(False, "torque came back without the operator")


def judge_stop(row: Row, outcome: Outcome, rig: Rig, shafts: Shafts, at: int, offset: int) -> None:
    """Times from the fault to its being found, to rest, and to no torque; how the drives are left."""
    bench, step = rig.bench, rig.bench.bus.cycle_time
    master: Any = rig.link.assembly.master
    outcome.drives = {drive.role: drive.state.name for drive in master.bench.drives}
    if not row.causes:
        return
    if rig.stops:
        stop = rig.stops[-1]
        outcome.found_s = None if stop.cycle is None else max(0, stop.cycle + offset - at) * step
        outcome.rungs = tuple(rung.rung for rung in stop.rungs)
    rest, off = shafts.settled(at, bench.motion.standstill, _LOAD_STANDSTILL)
    outcome.rest_s, outcome.off_s = (None if cycle is None else (cycle - at) * step for cycle in (rest, off))
    outcome.require(rest is not None, "the shafts did not come to rest")
    outcome.require(off is not None, "a drive kept its torque")
    if outcome.stopped_s is not None:
        outcome.require(
            outcome.stopped_s <= row.within_s, f"stopped after {outcome.stopped_s:.2f} s, allowed {row.within_s:g} s"
        )
    for role, state in outcome.drives.items():
        outcome.require(state in row.standing, f"{role} was left in {state}")


def judge_shafts(outcome: Outcome, bench: BenchConfiguration, shafts: Shafts) -> None:
    """The true shafts stayed within their envelope, in every cycle."""
    envelope = Envelope.of(bench)
    outcome.peaks, outcome.sampled_s = shafts.peaks(), bench.bus.cycle_time
    bounds = (envelope.motor_speed, envelope.load_speed, envelope.torque)
    for what, peak, bound in zip(("motor speed", "load speed", "torque"), outcome.peaks, bounds, strict=True):
        outcome.require(peak <= bound, f"the true {what} reached {peak:.4g}, its envelope is {bound:.4g}")


def read_back(outcome: Outcome, folder: Path, seen: dict[str, Shafts]) -> None:
    """Every recording is valid, and holds row for row what the rig had handed over."""
    for name, shafts in seen.items():
        path = folder / f"{name}.h5"
        violations = validate(path).violations
        outcome.require(not violations, f"{path.name} is not valid: {'; '.join(map(str, violations[:1]))}")
        recording = Recording.open(path)
        rows = np.column_stack((recording.raw("cycle"), recording.raw("motor_angle")))
        outcome.require(np.array_equal(rows, np.concatenate(shafts.kept)), f"{path.name} does not hold what was seen")
        outcome.read_back += 1
