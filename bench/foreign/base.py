"""A simulation from elsewhere with the values of its parameters, as the analysis evaluates it."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from bench.errors import ConfigurationError
from bench.recording import Recording
from bench.simulation.frame import FloatArray
from bench.simulation.terms import CHANNEL_UNITS

PREDICTED = tuple(CHANNEL_UNITS)
"""channels that a simulation may predict"""
BY = " by "
"""between a channel and a parameter in the name of a sensitivity"""
KEY = "base"
"""of a simulation file: the simulation from elsewhere on which it stands"""

Values = Mapping[str, float]
Channels = dict[str, FloatArray]


class Simulator(Protocol):
    """Something that predicts channels; it must be picklable, for processes that read recordings."""

    @property
    def kind(self) -> str:
        """fmu, python or columns."""
        ...

    @property
    def source(self) -> str:
        """What it was opened from."""
        ...

    def run(self, inputs: Mapping[str, FloatArray], values: Values) -> Channels:
        """Predict channels (n,), SI, from the inputs of a recording (:mod:`bench.foreign.inputs`)."""
        ...


@dataclass(frozen=True, slots=True)
class Free:
    """A parameter that may be recalibrated: its ``value`` as given; ``step`` of the finite difference."""

    name: str
    value: float
    unit: str = "1"
    step: float | None = None

    def difference(self, at: float) -> float:
        """Step of the finite difference at a value, by default a thousandth of the larger of both."""
        return self.step or 1e-3 * max(abs(at), abs(self.value)) or 1e-3


@dataclass(frozen=True, slots=True)
class Base:
    """A simulator with its free parameters and the values they have; ``store``: folder for its results."""

    simulator: Simulator
    free: tuple[Free, ...] = ()
    values: tuple[float, ...] = ()
    store: Path | None = None

    @classmethod
    def of(cls, simulator: Simulator, free: tuple[Free, ...] = (), values: Values | None = None) -> Base:
        """A simulator with its parameters at ``values``; those that are not given keep their own value."""
        given = dict(values or {})
        return cls(simulator, free, tuple(float(given.get(parameter.name, parameter.value)) for parameter in free))

    def at(self, values: Values) -> Base:
        """The same simulator at other values of its free parameters."""
        return replace(
            self, values=tuple(float(values.get(p.name, v)) for p, v in zip(self.free, self.values, strict=True))
        )

    @property
    def named(self) -> dict[str, float]:
        """Values of the free parameters by name."""
        return {parameter.name: value for parameter, value in zip(self.free, self.values, strict=True)}

    def predict(self, recording: Recording, inputs: Callable[[], Mapping[str, FloatArray]]) -> Channels:
        """Predict a recording: each channel (n,), and its sensitivities ``CHANNEL by PARAMETER``.

        ``inputs`` is called only where no result is stored yet. Raises ConfigurationError where the simulation fails
        or does not give numbers of the right length.
        """
        path = self._path(recording)
        if path is not None and path.exists():
            with np.load(path) as kept:
                return {name: kept[name] for name in kept.files}
        given = inputs()
        out = self._run(recording, given, self.named)
        for parameter, value in zip(self.free, self.values, strict=True):
            step = parameter.difference(value)
            more, less = (
                self._run(recording, given, self.named | {parameter.name: value + s * step}) for s in (0.5, -0.5)
            )
            for channel in more:
                out[f"{channel}{BY}{parameter.name}"] = (more[channel] - less[channel]) / step
        if path is not None:
            part = path.with_name(f"{os.getpid()}-{path.name}")
            with part.open("wb") as file:
                np.savez(file, **out)  # type: ignore[arg-type]
            part.replace(path)
        return out

    def _run(self, recording: Recording, inputs: Mapping[str, FloatArray], values: Values) -> Channels:
        out: Channels = {}
        where = f"{self.simulator.source} on {recording.path.name}"
        for name, predicted in self.simulator.run(inputs, values).items():
            if name not in PREDICTED:
                raise ConfigurationError(
                    f"{where}: predicts '{name}', which is none of the channels compared: {', '.join(PREDICTED)}."
                )
            array = np.asarray(predicted, dtype=np.float64)
            if array.shape != (recording.size,):
                raise ConfigurationError(
                    f"{where}: {name} has shape {array.shape}, it should have one value a sample, ({recording.size},)."
                )
            bad = int(np.sum(~np.isfinite(array)))
            if bad:
                raise ConfigurationError(f"{where}: {name} is no number at {bad} of {recording.size} samples.")
            out[name] = array
        if not out:
            raise ConfigurationError(f"{where}: predicts no channel; it should one of {', '.join(PREDICTED)}.")
        return out

    def _path(self, recording: Recording) -> Path | None:
        if self.store is None:
            return None
        said = json.dumps([self.simulator.kind, self.simulator.source, self.values, str(recording.path.resolve())])
        return self.store / f"{hashlib.sha256(said.encode()).hexdigest()[:24]}.npz"

    def to_json(self, beside: Path) -> dict[str, Any]:
        """As a simulation file in the folder ``beside`` has it; a file is named relative to that."""
        source = self.simulator.source
        file = os.path.relpath(source, beside) if self.simulator.kind == "fmu" else source
        parameters = {
            parameter.name: {"value": v, "unit": parameter.unit}
            for parameter, v in zip(self.free, self.values, strict=True)
        }
        return {"kind": self.simulator.kind, "source": file, "parameters": parameters}
