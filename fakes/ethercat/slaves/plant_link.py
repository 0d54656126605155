"""What the slaves need of a plant: commands in, measurements out, snapshots. :class:`fakes.plant.Plant` offers it."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from fakes.plant.images import COMMAND_DTYPE

__all__ = ["COMMAND_DTYPE", "PlantLike", "Rows"]

Rows = npt.NDArray[np.void]


class PlantLike(Protocol):
    """Time-domain plant behind the slaves.

    ``step`` takes rows of :data:`~fakes.plant.images.COMMAND_DTYPE`, one a cycle, and returns as many measurements.
    """

    def step(self, commands: Rows) -> Rows:
        """Advance by one cycle a row."""
        ...

    def snapshot(self) -> Any:
        """Return a token of the present state."""
        ...

    def restore(self, token: Any) -> None:
        """Go back to a token's state."""
        ...
