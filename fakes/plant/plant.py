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
from fakes.plant.stepping import Parts, step_block
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
        # contiguous, as some plants' are not: another layout would be compiled a second time
        shape = map(np.ascontiguousarray, (series.orders, series.amplitude, series.phase, series.offset))
        drag = np.zeros((0, 0))
        self._overlay: Overlay | None = None
        if truth.effects or truth.laws:
            # brings the analyser's library with it: only plants that play one pay
            from fakes.plant.overlay import Overlay

            self._overlay = Overlay(truth, cycle_time_s)
            drag = self._overlay.drag
        self._ledger = Ledger(truth.ledger, len(truth.hidden)) if truth.ledger else None
        self._parts = Parts(
            plant=plant_parameters(truth, cycle_time_s),
            drives=drive_parameters(truth, cycle_time_s),
            state=np.zeros(1, PLANT_STATE),
            states=np.zeros(2, DRIVE_STATE),
            conditions=np.zeros(1, CONDITIONS),
            words=seed_words(seed),
            series=(*shape, series.box.array()),
            te=np.zeros((3, 2, series.orders.size + 1)),
            sine_cosine=np.zeros((2, series.orders.size)),
            faults=self.faults.rows,
            active=np.zeros(self.faults.rows.size, np.bool_),
            drag=drag,
            hidden=arrays(truth.hidden),
        )
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
        from fakes.plant.simulation import truth_from_simulation

        return cls(truth_from_simulation(Path(simulation), read_plant(base)), seed, cycle_time_s)

    @property
    def time_s(self) -> float:
        """Plant time since the start."""
        return int(self._parts.state["cycle"][0]) * self.cycle_time_s

    @property
    def state(self) -> dict[str, Any]:
        """A copy of the true state (bench frame, SI, °C), both drives' own under ``input_drive`` and ``load_drive``."""
        values: dict[str, Any] = {name: self._parts.state[name][0].item() for name in PLANT_STATE.names or ()}
        for key, row in (("input_drive", INPUT), ("load_drive", LOAD)):
            values[key] = {name: self._parts.states[name][row].item() for name in DRIVE_STATE.names or ()}
        return values

    def step(self, commands: NDArray[Any], measurements: NDArray[Any] | None = None) -> NDArray[Any]:
        """Run one cycle for each row of ``commands`` (n,) and return the measurements (n,) at each cycle's end.

        Args:
            commands: of ``COMMAND_DTYPE``, contiguous.
            measurements: array (n,) of ``MEASUREMENT_DTYPE`` to fill instead of a new one.

        Raises:
            PlantError: a wrong type or shape.
        """
        return self._run(commands, measurements, traced=self._overlay is not None)[0]

    def step_traced(self, commands: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """As :meth:`step`; return also the true state after each cycle, (n,) of ``TRACE``."""
        return self._run(commands, None, traced=True)

    def _run(
        self, commands: NDArray[Any], measurements: NDArray[Any] | None, *, traced: bool
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        if commands.dtype != COMMAND_DTYPE or commands.ndim != 1:
            raise PlantError("plant commands must be a one-dimensional array of COMMAND_DTYPE")
        if measurements is None:
            measurements = np.empty(commands.size, MEASUREMENT_DTYPE)
        if measurements.dtype != MEASUREMENT_DTYPE or measurements.shape != commands.shape:
            raise PlantError("plant measurements must be an array of MEASUREMENT_DTYPE, as long as the commands")
        trace = np.empty(commands.size if traced else 0, TRACE)
        before = int(self._parts.state["cycle"][0])
        shown = np.empty((commands.size if self._ledger else 0, len(self.truth.hidden), len(SHOWN)), np.float32)
        step_block(self._parts, np.ascontiguousarray(commands), measurements, trace, shown)
        if self._overlay:
            self._overlay.add(trace, before, measurements)
        if self._ledger:
            self._ledger.add(before, shown, measurements)
        return measurements, trace

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
        parts = self._parts
        arrays = (parts.state, parts.states, parts.words, parts.te, parts.sine_cosine, parts.faults, *parts.hidden[2:])
        return arrays if self._overlay is None else (*arrays, *self._overlay.changing)

    def _begin(self) -> None:
        """Put the bench at rest, without load, at its first temperature."""
        truth, parts = self.truth, self._parts
        parts.state["temperature"] = truth.heat.initial
        parts.state["housing"] = truth.heat.initial
        parts.state["surroundings"] = truth.heat.ambient
        parts.state["sensed_temperature"] = truth.heat.initial
        parts.state["te_weight"] = 1.0
        orders, amplitude, phase, offset, box = parts.series
        aim(parts.te[2], amplitude, phase, offset, box, 0.0, 0.0, truth.heat.initial, 1.0)
        parts.te[0] = parts.te[2]
        place(parts.sine_cosine, orders, 0.0)
        rest = float(parts.te[2, 0, -1] + np.sum(parts.te[2, 1, :-1]))
        parts.state["load_angle"] = rest
        parts.state["te"] = rest
        for row, angle in ((INPUT, 0.0), (LOAD, rest)):
            values = parts.drives[row]
            counts = np.floor(values["polarity"] * angle * values["encoder_scale"] + values["encoder_zero"])
            parts.states["counts"][row] = int(counts)
        # brakes are closed and thermometers have been read before anybody looks
        parts.states["off_time"] = 1.0
        parts.state["lubricant_reading"] = truth.heat.initial
        parts.state["ambient_reading"] = truth.heat.ambient
