"""The simulation over the measurement: the model's order spectrum at the conditions of a measured revolution."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bench.service.process.revolution import BINS, HIGHEST_ORDER

if TYPE_CHECKING:
    from bench.simulation import TransmissionErrorModel

Message = dict[str, Any]


def model_of(path: Path) -> TransmissionErrorModel | None:
    """Return the transmission error of a simulation file, None if it holds none.

    Raises
    ------
    BenchError
        If the file is no simulation file.
    """
    from bench.simulation import Simulation

    return Simulation.load(path).transmission_error()


def curve(model: TransmissionErrorModel, torque: float, velocity: float, temperature: float) -> NDArray[np.float64]:
    """Return the model's transmission error over a revolution without mean, rad, shape (BINS,).

    ``torque`` in N·m, ``velocity`` load side in rad/s (its sign is the direction), ``temperature`` in °C.
    """
    theta = (np.arange(BINS) + 0.5) * (2.0 * np.pi / BINS)
    sign = 1.0 if velocity >= 0.0 else -1.0
    one = np.ones(BINS)
    error = model.evaluate(theta, torque * one, velocity * one, temperature * one, sign * one)
    return np.asarray(error - error.mean())


def spectrum(error: NDArray[np.float64]) -> NDArray[np.float64]:
    """Amplitude in rad at the orders 1 … HIGHEST_ORDER of a curve over one revolution."""
    return np.asarray(np.abs(np.fft.rfft(error))[1 : HIGHEST_ORDER + 1] * (2.0 / error.size))


class Overlay:
    """Adds the model to ``spectrum`` messages on their way to the pages, in a thread of its own."""

    def __init__(self, publish: Callable[[Message], None]) -> None:
        self._publish = publish
        self._model: TransmissionErrorModel | None = None
        self.path: Path | None = None
        self.last: Message | None = None
        self._busy: asyncio.Task[None] | None = None

    def choose(self, path: Path | None) -> None:
        """Draw this simulation file from now on; None for no model (see :func:`model_of` for what is refused)."""
        self._model = None if path is None else model_of(path)
        self.path = path

    def take(self, message: Message) -> None:
        """Publish a message with the model in it; while one is being computed further ones go without."""
        if self._model is None or "amplitude" not in message or (self._busy is not None and not self._busy.done()):
            self._out(message)
            return
        self._busy = asyncio.get_running_loop().create_task(self._with_model(self._model, message))

    def add(self, message: Message) -> Message:
        """Return the message with the model at its conditions, as it is if there is no model."""
        if self._model is None:
            return message
        error = curve(self._model, message["torque"], message["velocity"], message["temperature"])
        if not np.isfinite(error).all():
            # this direction of motion was never identified
            return message
        return {
            **message,
            "model": [float(f"{value:.4g}") for value in spectrum(error)],
            "model_curve": [float(f"{value:.4g}") for value in error.reshape(512, -1).mean(axis=1)],
        }

    async def _with_model(self, model: TransmissionErrorModel, message: Message) -> None:
        self._out(await asyncio.to_thread(self.add, message))

    def _out(self, message: Message) -> None:
        self.last = message
        self._publish(message)
