"""Rows that are met before anything moves: the wrong devices, and a drive that comes back as it left the factory."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from bench.configuration import BenchConfiguration, BenchFile
from bench.cycle.assembly import Assembly, assemble
from bench.cycle.rig import Rig
from bench.errors import DeviceError, LimitError
from bench.matrix.outcome import Outcome
from bench.matrix.plant import (
    judge_end,
    judge_shafts,
    judge_stop,
    motion,
    read_back,
    record,
    strike_cycle,
    with_block,
)
from bench.matrix.rows import Row
from bench.matrix.shafts import Shafts
from bench.protocols import Phase, Segment
from bench.safety import Act, LatchFile

_REST = (Phase(Segment.DWELL, 0.5, 0.0, 0.0),)


def run_setup_row(row: Row, file: BenchFile, folder: Path, seed: int = 0) -> Outcome:
    """Record once on the right bench, then meet the wrong one: it must be refused with a sentence, at rest."""
    outcome = Outcome(row.name, row.text, row.kind)
    if row.name == "default_settings":
        return _default_settings(row, outcome, with_block(file, row.block), folder, seed)
    assembly = assemble(file.configuration, seed=seed, real_time=False)
    with Rig(file, assembly=assembly) as rig:
        rig.enable()
        _, shafts = record(rig, file, folder, "earlier", _REST)
    wrong = BenchFile(_WRONG[row.name](file.configuration), file.text, file.origin)
    other = assemble(wrong.configuration, seed=seed, real_time=False)
    master: Any = other.master
    if row.name == "missing_slave":
        master.faults.apply("slave_lost", "safety_terminal")
    try:
        with Rig(wrong, assembly=other):
            outcome.reaction = "opened"
            outcome.require(False, "the bench was opened")
    except DeviceError as error:
        outcome.sentence, outcome.reaction = str(error), "refused"
    outcome.require(
        row.expected_text in outcome.sentence, f"the sentence does not say '{row.expected_text}': {outcome.sentence}"
    )
    _at_rest(outcome, other)
    outcome.struck = Shafts(None, master).at(master.bench.cycle)
    read_back(outcome, folder, {"earlier": shafts})
    return outcome


def _swap_places(bench: BenchConfiguration) -> BenchConfiguration:
    """The torque terminal's and the thermometer's place changed."""
    places = {"torque_terminal": 4, "temperature_terminal": 3}
    slaves = [s.model_copy(update={"position": places.get(s.role, s.position)}) for s in bench.bus.slaves]
    return _with_slaves(bench, tuple(sorted(slaves, key=lambda s: s.position)))


def _other_device(bench: BenchConfiguration) -> BenchConfiguration:
    slaves = [
        s.model_copy(update={"product": s.product ^ 0xFF}) if s.role == "input_drive" else s for s in bench.bus.slaves
    ]
    return _with_slaves(bench, tuple(slaves))


def _with_slaves(bench: BenchConfiguration, slaves: tuple[Any, ...]) -> BenchConfiguration:
    return bench.model_copy(update={"bus": bench.bus.model_copy(update={"slaves": slaves})})


_WRONG: dict[str, Callable[[BenchConfiguration], BenchConfiguration]] = {
    "wrong_order": _swap_places,
    "wrong_identity": _other_device,
    "missing_slave": lambda bench: bench,
}


def _default_settings(row: Row, outcome: Outcome, file: BenchFile, folder: Path, seed: int) -> Outcome:
    """The load drive loses its power while it turns, and comes back: without limits, and must not get torque so."""
    bench = file.configuration
    assembly = assemble(bench, seed=seed, real_time=False)
    master: Any = assembly.master
    latch = LatchFile(folder / "latch.json")
    with Rig(file, assembly=assembly, latch=latch) as rig:
        rig.enable()
        _, earlier = record(rig, file, folder, "earlier", _REST)
        at, offset = strike_cycle(rig), master.bench.cycle - rig.link.cycle
        master.faults.apply("slave_lost", "load_drive", at_cycle=at)
        end, shafts = record(rig, file, folder, "struck", motion(bench, row.last_s))
        shafts.silence(1.0)
        judge_end(row, outcome, rig, end, shafts)
        judge_stop(row, outcome, rig, shafts, at, offset)
        outcome.struck = shafts.at(at)
        judge_shafts(outcome, bench, shafts)
        master.faults.clear("slave_lost", "load_drive")
    lost = _limit_of(assembly)
    latch.act(Act.ACKNOWLEDGE, "matrix")
    with Rig(file, assembly=assembly, latch=latch) as rig:
        outcome.require(_limit_of(assembly) < lost, "the drive's torque limit was not written again")
        _at_rest(outcome, assembly)
        rig.reset_faults()
        latch.act(Act.RESET, "matrix")
        try:
            rig.enable()
            outcome.require(False, "torque came back without being resumed")
        except LimitError:
            latch.act(Act.RESUME, "matrix")
            rig.enable()
            end, again = record(rig, file, folder, "resumed", _REST)
            outcome.require(end.kind.name == "FINISHED", f"the bench does not run after its three acts: {end.text}")
    outcome.drives = {drive.role: drive.state.name for drive in master.bench.drives}
    read_back(outcome, folder, {"earlier": earlier, "struck": shafts, "resumed": again})
    return outcome


def _limit_of(assembly: Assembly) -> int:
    """Return the load drive's torque limit (0x6072), per mille."""
    master: Any = assembly.master
    limit: int = master.bench.drive("load_drive").dictionary.integer(0x6072)
    return limit


def _at_rest(outcome: Outcome, assembly: Assembly) -> None:
    master: Any = assembly.master
    bench = master.bench
    outcome.drives = {drive.role: drive.state.name for drive in bench.drives}
    powered = [drive.role for drive in bench.drives if drive.power.powered]
    outcome.require(not powered, f"{', '.join(powered)} had torque")
    outcome.require(abs(bench.plant.state["motor_velocity"]) < 0.01, "a shaft moved")
