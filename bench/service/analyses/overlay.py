"""The model over the measurement: its transmission error and order spectrum at the conditions of a measured revolution.

Computed here, beside the pages, and never in the run's process: while one revolution is worked out further ones go
without.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bench.service.process.revolution import BINS, HIGHEST_ORDER

if TYPE_CHECKING:
    from bench.twin.revolution import RevolutionModel

Message = dict[str, Any]
_CURVE = 512


def model_of(path: Path) -> RevolutionModel:
    """Return the model of a simulation file. Raises BenchError if the file is none."""
    # heavy: only a service that draws a model pays for it
    from bench.twin.revolution import RevolutionModel

    return RevolutionModel(path)


def spectrum(error: NDArray[np.float64]) -> NDArray[np.float64]:
    """Amplitude in rad at the orders 1 … HIGHEST_ORDER of a curve over one revolution."""
    return np.asarray(np.abs(np.fft.rfft(error))[1 : HIGHEST_ORDER + 1] * (2.0 / error.size))


class Overlay:
    """Adds the model to ``spectrum`` messages on their way to the pages, in a thread of its own.

    Drawn is the model that watches the run (:meth:`watch`), until somebody chooses another; else the one chosen.
    """

    def __init__(self, publish: Callable[[Message], None]) -> None:
        self._publish = publish
        self._chosen: tuple[Path, RevolutionModel] | None = None
        self._watching: tuple[Path, RevolutionModel] | None = None
        self.last: Message | None = None
        self._busy: asyncio.Task[None] | None = None

    @property
    def path(self) -> Path | None:
        """Simulation file that is drawn; None for none."""
        drawn = self._watching or self._chosen
        return None if drawn is None else drawn[0]

    def choose(self, path: Path | None) -> None:
        """Draw this simulation file from now on; None for no model (see :func:`model_of` for what is refused)."""
        self._chosen = None if path is None else (path, model_of(path))
        self._watching = None

    def watch(self, path: Path | None) -> None:
        """Draw the model that watches the run; None when that run is over. Refuses as :meth:`choose` does."""
        self._watching = None if path is None else (path, model_of(path))

    def take(self, message: Message) -> None:
        """Publish a message with the model in it; while one is being computed further ones go without."""
        busy = self._busy is not None and not self._busy.done()
        if self.path is None or "amplitude" not in message or busy:
            self._publish_message(message)
            return
        self._busy = asyncio.get_running_loop().create_task(self._with_model(message))

    def add(self, message: Message) -> Message:
        """Return the message with the model at its conditions, as it is if there is no model.

        Added are ``model``, ``model_curve``, ``model_band`` (half of it) and ``model_inside``, the share of the
        revolution in it; ``model_why`` says why one of them is not there.
        """
        drawn = self._watching or self._chosen
        if drawn is None:
            return message
        from bench.twin.revolution import INSIDE, Conditions

        known = [message.get(name) for name in ("torque", "velocity", "temperature")]
        torque, velocity, temperature = (np.nan if value is None else float(value) for value in known)
        also = {name: float(value) for name, value in message.get("also", {}).items()}
        found = drawn[1].at(Conditions(torque, velocity, temperature, also), BINS)
        out = {**message, "model_why": found.why}
        if found.error is None:
            return out
        model = _bin_means(found.error)
        out |= {"model": _short(spectrum(found.error)), "model_curve": _short(model)}
        if found.half is not None:
            half = _bin_means(found.half)
            inside = np.abs(np.asarray(message["curve"], dtype=np.float64) - model) <= half
            out |= {"model_band": _short(half), "model_inside": float(inside.mean())}
            out |= {"model_band_share": INSIDE, "model_left": found.left}
        return out

    async def _with_model(self, message: Message) -> None:
        self._publish_message(await asyncio.to_thread(self.add, message))

    def _publish_message(self, message: Message) -> None:
        self.last = message
        self._publish(message)


def _bin_means(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Means over the parts of the revolution that pages draw."""
    return np.asarray(values.reshape(_CURVE, -1).mean(axis=1))


def _short(values: NDArray[np.float64]) -> list[float]:
    return [float(f"{value:.4g}") for value in values]
