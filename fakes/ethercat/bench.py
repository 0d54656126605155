"""The slaves of the bench tied to a plant: a block of cycles in, a block of process data out.

Who serves the slaves (the in-process master, the frame-level responder) hands over the process images of those in
OPERATIONAL and gets their inputs written. The plant advances by one cycle a row, whatever state the slaves are in.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fakes.ethercat.drive.cia402 import Mode
from fakes.ethercat.drive.objects import RPM, DriveData
from fakes.ethercat.slaves.al import AlState
from fakes.ethercat.slaves.plant_link import COMMAND_DTYPE, PlantLike, Rows
from fakes.ethercat.slaves.safety_terminal import SafetyTerminal
from fakes.ethercat.slaves.servo import ServoDrive
from fakes.ethercat.slaves.slave import Image, Slave, SlaveState
from fakes.ethercat.slaves.terminals import AnalogInput, TemperatureInput

ROLES = ("input_drive", "load_drive", "torque_terminal", "temperature_terminal", "safety_terminal")
"""Order on the bus, from the master on."""

MILLI_RPM, MICRO_RPM = RPM | 0xFD << 24, RPM | 0xFA << 24


@dataclass(frozen=True, slots=True)
class BenchState:
    """Token of :meth:`EmulatedBench.snapshot`."""

    plant: Any
    cycle: int
    slaves: tuple[SlaveState, ...]


class EmulatedBench:
    """Slaves and plant.

    Parameters
    ----------
    plant : what moves.
    input_drive, load_drive : data of the two servo drives.
    cycle_time_s : bus cycle; the plant's step.
    without : roles of terminals the bus has not.
    """

    def __init__(
        self,
        plant: PlantLike,
        input_drive: DriveData,
        load_drive: DriveData,
        cycle_time_s: float,
        without: Collection[str] = (),
    ) -> None:
        self.plant = plant
        self.cycle_time_s = cycle_time_s
        self.cycle = 0
        self._measured: Rows | None = None
        self.drives = (
            ServoDrive(ROLES[0], input_drive, cycle_time_s, serial=1),
            ServoDrive(ROLES[1], load_drive, cycle_time_s, serial=2),
        )
        self.safety = SafetyTerminal(ROLES[4], self.drives, cycle_time_s, serial=5)
        terminals = (
            AnalogInput(ROLES[2], cycle_time_s, serial=3),
            TemperatureInput(ROLES[3], cycle_time_s, serial=4),
            self.safety,
        )
        self.terminals = tuple(terminal for terminal in terminals if terminal.role not in without)
        self.slaves: tuple[Slave, ...] = (*self.drives, *self.terminals)
        self.by_role: dict[str, Slave] = {slave.role: slave for slave in self.slaves}

    def drive(self, role: str) -> ServoDrive:
        """Return a servo drive by its role."""
        return next(drive for drive in self.drives if drive.role == role)

    @property
    def temperatures(self) -> tuple[float, float]:
        """Last PT100 readings of lubricant and surroundings, °C; ±10 000 where open or short."""
        if self._measured is None:
            return 20.0, 20.0
        last = self._measured[-1]
        return float(last["lubricant_temperature"]), float(last["ambient_temperature"])

    def run(self, outputs: Sequence[Image | None], inputs: Sequence[Image | None], cycles: int) -> None:
        """Run a block of cycles.

        ``outputs`` and ``inputs`` hold, slave by slave, structured rows (at least ``cycles``) or None: outputs of a
        slave that is not in OPERATIONAL are ignored, inputs of one that is not exchanging are not written.
        """
        valid = [
            rows if slave.al.state is AlState.OP else None for slave, rows in zip(self.slaves, outputs, strict=True)
        ]
        first = 0
        while first < cycles:
            first = self._run(valid, inputs, first, cycles)
        for slave, rows in zip(self.slaves, valid, strict=True):
            if rows is not None and slave.has_outputs:
                slave.keep_outputs(rows[cycles - 1].tobytes())

    def _run(self, outputs: Sequence[Image | None], inputs: Sequence[Image | None], first: int, cycles: int) -> int:
        """Serve the longest run from ``first`` on in which no drive changes its state; return where it ended."""
        stop = cycles
        for drive, rows in zip(self.drives, outputs, strict=False):
            stop = min(stop, drive.begin(rows, first, stop))
        commands = np.zeros(stop - first, COMMAND_DTYPE)
        for drive, rows in zip(self.drives, outputs, strict=False):
            drive.command(commands, rows, first, stop)
        measured, events = self._step(commands)
        stop = first + len(measured)
        for drive, rows, event in zip(self.drives, inputs, events, strict=False):
            drive.report(measured, rows, first, stop)
            drive.settle(len(measured), event)
        for terminal, rows in zip(self.terminals, inputs[len(self.drives) :], strict=True):
            terminal.report(measured, rows, first, stop, self.cycle)
        self.cycle += len(measured)
        self._measured = measured
        return stop

    def _step(self, commands: Rows) -> tuple[Rows, tuple[bool, ...]]:
        """Step the plant; where a drive reacts in the midst, go back and step up to that very cycle only."""
        token = self.plant.snapshot() if len(commands) > 1 and any(d.watching for d in self.drives) else None
        measured = self.plant.step(commands)
        found = [drive.first_event(measured) for drive in self.drives]
        rows = min((event + 1 for event in found if event is not None), default=len(commands))
        if rows < len(commands):
            self.plant.restore(token)
            measured = self.plant.step(commands[:rows])
        return measured, tuple(event == rows - 1 for event in found)

    def idle(self, cycles: int, outputs: Sequence[Image | None], inputs: Sequence[Image | None]) -> None:
        """Run cycles in which no frame came: every slave goes on with the outputs it had."""
        held = [None if rows is None else np.repeat(rows[-1:], cycles) for rows in outputs]
        self.run(held, inputs, cycles)

    def snapshot(self) -> BenchState:
        """Return a token of the present state of plant and slaves."""
        return BenchState(self.plant.snapshot(), self.cycle, tuple(slave.save() for slave in self.slaves))

    def restore(self, token: BenchState) -> None:
        """Go back to a token's state."""
        self.plant.restore(token.plant)
        self.cycle = token.cycle
        for slave, state in zip(self.slaves, token.slaves, strict=True):
            slave.load(state)


def input_drive_data(encoder_bits: int, rated_torque_n_m: float, maximum_torque_n_m: float) -> DriveData:
    """Return the data of an input drive: CSV, 0.001 rpm a unit."""
    return DriveData(1, encoder_bits, rated_torque_n_m, maximum_torque_n_m, 4000, MILLI_RPM, Mode.CSV)


def load_drive_data(encoder_bits: int, rated_torque_n_m: float, maximum_torque_n_m: float) -> DriveData:
    """Return the data of a load drive: CST, 10⁻⁶ rpm a unit."""
    return DriveData(2, encoder_bits, rated_torque_n_m, maximum_torque_n_m, 200, MICRO_RPM, Mode.CST)
