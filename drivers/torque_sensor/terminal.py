"""Analogue input terminal of ±10 V: entry point ``analog_input`` of the group ``bench.drivers``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers import analog
from drivers.devices import Place, build
from drivers.entries import Entry
from drivers.errors import DriverError
from drivers.ethercat.slave import Pdo, SlaveSpec


@dataclass(slots=True)
class AnalogInput:
    """One channel of an analogue input terminal (profile 5001): status word and value.

    Parameters
    ----------
    place : where it is and what it must be.
    full_scale_v : voltage at ``full_scale_count``, V.
    full_scale_count : count at that voltage.
    bits : resolution; the highest and lowest count are taken as saturated.
    status, value : process data entries.
    tx_pdo : PDO that carries them.
    """

    place: Place
    full_scale_v: float = 10.0
    full_scale_count: int = 32768
    bits: int = 16
    status: str = "6000:01"
    value: str = "6000:11"
    tx_pdo: int = 0x1A00
    _inputs: NDArray[Any] | None = None

    @property
    def spec(self) -> SlaveSpec:
        """The slave as the bus should find it."""
        place = self.place
        pdo = Pdo(self.tx_pdo, (Entry(self.status, "u2"), Entry(self.value, "i2")), fixed=True)
        return SlaveSpec(
            place.name, place.position, place.vendor, place.product, tx_pdos=(pdo,), revision=place.revision
        )

    @property
    def volt_per_count(self) -> float:
        """Scale of a count, V."""
        return self.full_scale_v / self.full_scale_count

    def attach(self, outputs: NDArray[Any] | None, inputs: NDArray[Any] | None) -> None:
        """Take the terminal's inputs."""
        self._inputs = inputs

    def counts(self, n: int) -> NDArray[np.int16]:
        """Counts (n,) of the block just exchanged."""
        values: NDArray[np.int16] = self._block(n)[self.value]
        return values

    def usable(self, n: int) -> NDArray[np.bool_]:
        """Mask (n,) of readings the terminal vouches for and that are not at the ends of its range.

        A saturated count is no measurement even where a terminal sets no over-range bit.
        """
        block = self._block(n)
        limit = (1 << (self.bits - 1)) - 1
        within = np.abs(block[self.value].astype(np.int32)) < limit
        return analog.usable(block[self.status]) & within

    def _block(self, n: int) -> NDArray[Any]:
        if self._inputs is None:
            raise DriverError(f"{self.place.name} has no process data yet; attach() comes before the first cycle")
        return self._inputs[:n]


def analog_input(place: Place, options: Mapping[str, Any]) -> AnalogInput:
    """Make an analogue input terminal from a configuration file's options."""
    return build(AnalogInput, place.name, options, place=place, _inputs=None)
