"""The emulated bench in the time domain: set values in, measurements out, cycle by cycle."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fakes.plant.errors import PlantError
from fakes.plant.faults import FaultTable
from fakes.plant.hidden.kinds import SHOWN, arrays
from fakes.plant.hidden.ledger import Ledger
from fakes.plant.images import COMMAND_DTYPE, MEASUREMENT_DTYPE
from fakes.plant.noise import seed_words
from fakes.plant.plant_file import read_plant
from fakes.plant.records import (
    CONDITIONS,
    DRIVE_STATE,
    INPUT,
    LOAD,
    PLANT_STATE,
    TRACE,
    drive_parameters,
    plant_parameters,
)
from fakes.plant.spec import plant_of
from fakes.plant.stepping import step_block
from fakes.plant.transmission import aim, place
from fakes.plant.truth import PlantTruth

if TYPE_CHECKING:
    from fakes.plant.overlay import Overlay


@dataclass(frozen=True, slots=True)
class Snapshot:
    """Everything that changes while a plant runs, copied."""

    arrays: tuple[NDArray[Any], ...]


class Plant:
    """A whole bench: input motor and drive, gearbox, torque sensor, coupling, load motor and drive, lubricant.

    The result does not depend on how cycles are grouped into blocks, and a restored snapshot replays bit by bit.

    Args:
        truth: the values the bench obeys.
        seed: of all noise.
        cycle_time_s: bus cycle.
    """

    def __init__(self, truth: PlantTruth, seed: int = 0, cycle_time_s: float = 0.0005) -> None:
        self.truth = truth
        self.cycle_time_s = cycle_time_s
        self.faults = FaultTable(cycle_time_s)
        series = truth.transmission_error
        self._plant = plant_parameters(truth, cycle_time_s)
        self._drives = drive_parameters(truth, cycle_time_s)
        # contiguous, as some plants' are not: another layout would be compiled a second time
        shape = map(np.ascontiguousarray, (series.orders, series.amplitude, series.phase, series.offset))
        self._series = (*shape, series.box.array())
        self._te = np.zeros((3, 2, series.orders.size + 1))
        self._turn = np.zeros((2, series.orders.size))
        self._active = np.zeros(self.faults.rows.size, np.bool_)
        self._state = np.zeros(1, PLANT_STATE)
        self._drive_states = np.zeros(2, DRIVE_STATE)
        self._conditions = np.zeros(1, CONDITIONS)
        self._drag = np.zeros((0, 0))
        self._overlay: Overlay | None = None
        if truth.effects or truth.laws:
            # brings the analyser's library with it: only plants that play one pay
            from fakes.plant.overlay import Overlay

            self._overlay = Overlay(truth, cycle_time_s)
            self._drag = self._overlay.drag
        self._hidden = arrays(truth.hidden)
        self._ledger = Ledger(truth.ledger, len(truth.hidden)) if truth.ledger else None
        self._words = seed_words(seed)
        self._begin()

    @classmethod
    def from_file(cls, name: str | Path, seed: int = 0, cycle_time_s: float = 0.0005) -> Plant:
        """Make a plant from a plant file: a path, or the name of one that ships.

        Behind a question mark the name may say what is concealed (:mod:`fakes.plant.spec`).

        Raises:
            PlantError: the file is missing or wrong.
        """
        return cls(plant_of(str(name)), seed, cycle_time_s)

    @classmethod
    def from_simulation(
        cls, simulation: str | Path, base: str | Path = "rh380n", seed: int = 0, cycle_time_s: float = 0.0005
    ) -> Plant:
        """Make a plant that plays a simulation file (``model.json``) with the drives and sensors of a plant file.

        Raises:
            PlantError: the plant cannot play a term of the simulation, or ``base`` is wrong.
            bench.errors.ConfigurationError: the simulation file is wrong.
        """
        from fakes.plant.simulation import simulated

        return cls(simulated(Path(simulation), read_plant(base)), seed, cycle_time_s)

    @property
    def time_s(self) -> float:
        """Plant time since the start."""
        return int(self._state["cycle"][0]) * self.cycle_time_s

    @property
    def state(self) -> dict[str, Any]:
        """A copy of the true state (bench frame, SI, °C), both drives' own under ``input_drive`` and ``load_drive``."""
        values: dict[str, Any] = {name: self._state[name][0].item() for name in PLANT_STATE.names or ()}
        for key, row in (("input_drive", INPUT), ("load_drive", LOAD)):
            values[key] = {name: self._drive_states[name][row].item() for name in DRIVE_STATE.names or ()}
        return values

    def step(self, commands: NDArray[Any], measurements: NDArray[Any] | None = None) -> NDArray[Any]:
        """Run one cycle for each row of ``commands`` (n,) and return the measurements (n,) at each cycle's end.

        Args:
            commands: of ``COMMAND_DTYPE``, contiguous.
            measurements: array (n,) of ``MEASUREMENT_DTYPE`` to fill instead of a new one.

        Raises:
            PlantError: a wrong type or shape.
        """
        if commands.dtype != COMMAND_DTYPE or commands.ndim != 1:
            raise PlantError("plant commands must be a one-dimensional array of COMMAND_DTYPE")
        if measurements is None:
            measurements = np.empty(commands.size, MEASUREMENT_DTYPE)
        if measurements.dtype != MEASUREMENT_DTYPE or measurements.shape != commands.shape:
            raise PlantError("plant measurements must be an array of MEASUREMENT_DTYPE, as long as the commands")
        trace = np.empty(commands.size if self._overlay else 0, TRACE)
        before = int(self._state["cycle"][0])
        told = np.empty((commands.size if self._ledger else 0, len(self.truth.hidden), len(SHOWN)), np.float32)
        step_block(
            self._plant,
            self._drives,
            self._state,
            self._drive_states,
            self._conditions,
            self._words,
            self._series,
            self._te,
            self._turn,
            self.faults.rows,
            self._active,
            self._drag,
            self._hidden,
            trace,
            told,
            np.ascontiguousarray(commands),
            measurements,
        )
        if self._overlay:
            self._overlay.add(trace, before, measurements)
        if self._ledger:
            self._ledger.add(before, told, measurements)
        return measurements

    def snapshot(self) -> Snapshot:
        """Return a token from which ``restore`` continues bit by bit; faults are part of it."""
        return Snapshot(tuple(array.copy() for array in self._changing))

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to a snapshot of this plant."""
        for array, saved in zip(self._changing, snapshot.arrays, strict=True):
            array[...] = saved

    @property
    def _changing(self) -> tuple[NDArray[Any], ...]:
        """Every array that a step or a fault changes."""
        hidden = self._hidden[2:]
        own = (self._state, self._drive_states, self._words, self._te, self._turn, self.faults.rows, *hidden)
        return own if self._overlay is None else (*own, *self._overlay.changing)

    def _begin(self) -> None:
        """Put the bench at rest, without load, at its first temperature."""
        truth = self.truth
        self._state["temperature"] = truth.heat.initial
        self._state["housing"] = truth.heat.initial
        self._state["surroundings"] = truth.heat.ambient
        self._state["sensed_temperature"] = truth.heat.initial
        self._state["te_weight"] = 1.0
        orders, amplitude, phase, offset, box = self._series
        aim(self._te[2], amplitude, phase, offset, box, 0.0, 0.0, truth.heat.initial, 1.0)
        self._te[0] = self._te[2]
        place(self._turn, orders, 0.0)
        rest = float(self._te[2, 0, -1] + np.sum(self._te[2, 1, :-1]))
        self._state["load_angle"] = rest
        self._state["te"] = rest
        for row, angle in ((INPUT, 0.0), (LOAD, rest)):
            values = self._drives[row]
            counts = np.floor(values["polarity"] * angle * values["encoder_scale"] + values["encoder_zero"])
            self._drive_states["counts"][row] = int(counts)
        # brakes are closed and thermometers have been read before anybody looks
        self._drive_states["off_time"] = 1.0
        self._state["lubricant_reading"] = truth.heat.initial
        self._state["ambient_reading"] = truth.heat.ambient
