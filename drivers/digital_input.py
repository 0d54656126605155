"""A digital input terminal: the example of a whole driver, and the one that watches e-stop and safe torque off.

Entry point ``digital_input`` of the group ``bench.drivers``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.devices import Place, build
from drivers.entries import Entry
from drivers.errors import DriverError
from drivers.ethercat.slave import Pdo, SlaveSpec


@dataclass(slots=True)
class DigitalInput:
    """Terminal with up to eight inputs in one byte of process data.

    Parameters
    ----------
    place : where it is and what it must be.
    names : names of the inputs, from bit 0.
    active_low : inputs that say "on" with 0 V: a broken wire then reads as "on", which is what a stop input wants.
    entry : process data entry of the byte.
    tx_pdo : PDO that carries it.
    coe : the terminal has an object dictionary (most digital ones do not).
    """

    place: Place
    names: tuple[str, ...]
    active_low: tuple[str, ...] = ()
    entry: str = "6000:01"
    tx_pdo: int = 0x1A00
    coe: bool = False
    _inputs: NDArray[Any] | None = None

    @property
    def spec(self) -> SlaveSpec:
        """The slave as the bus should find it."""
        place = self.place
        pdo = Pdo(self.tx_pdo, (Entry(self.entry, "u1"),), fixed=True)
        return SlaveSpec(
            place.name,
            place.position,
            place.vendor,
            place.product,
            tx_pdos=(pdo,),
            revision=place.revision,
            coe=self.coe,
        )

    def attach(self, outputs: NDArray[Any] | None, inputs: NDArray[Any] | None) -> None:
        """Take the terminal's inputs."""
        self._inputs = inputs

    def read(self, name: str, n: int) -> NDArray[np.bool_]:
        """States (n,) of one input over the block just exchanged."""
        if self._inputs is None:
            raise DriverError(f"{self.place.name} has no process data yet; attach() comes before the first cycle")
        if name not in self.names:
            raise DriverError(f"{self.place.name} has no input '{name}'; it has {', '.join(self.names)}")
        high = (self._inputs[self.entry][:n] >> self.names.index(name) & 1).astype(np.bool_)
        return ~high if name in self.active_low else high


def digital_input(place: Place, options: Mapping[str, Any]) -> DigitalInput:
    """Make a digital input terminal from a configuration file's options."""
    lists = {key: tuple(value) if isinstance(value, list) else value for key, value in options.items()}
    return build(DigitalInput, place.name, lists, place=place, _inputs=None)
