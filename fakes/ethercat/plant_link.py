"""What the slaves need of a plant: commands in, measurements out, snapshots. :class:`fakes.plant.Plant` offers it."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

Rows = npt.NDArray[np.void]


class PlantLike(Protocol):
    """Time-domain plant behind the slaves.

    ``step`` takes rows of :data:`COMMAND_DTYPE` (one a cycle) and returns as many rows of measurements.
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


COMMAND_DTYPE = np.dtype(
    [
        ("input_enable", "u1"),
        ("input_mode", "i1"),
        ("input_velocity", "f8"),
        ("input_torque", "f8"),
        ("input_quick_stop", "u1"),
        ("load_enable", "u1"),
        ("load_mode", "i1"),
        ("load_velocity", "f8"),
        ("load_torque", "f8"),
        ("load_quick_stop", "u1"),
    ]
)
