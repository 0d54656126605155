"""What makes a driver a driver: the shape that factories of the entry point group ``bench.drivers`` give back.

A driver of one's own is a dataclass of signals (its process data entries) with a little logic, and a factory::

    @dataclass(frozen=True, slots=True)
    class Brake:
        place: Place
        ...

    def brake(place: Place, options: Mapping[str, Any]) -> Brake: ...

registered in the ``pyproject.toml`` of any installed package::

    [project.entry-points."bench.drivers"]
    brake = "my_package.brake:brake"

A bench file then says ``driver = "brake"``. :mod:`drivers.digital_input` is a whole such driver in one file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from typing import Any, Protocol, TypeVar

from numpy.typing import NDArray

from drivers.errors import DriverError
from drivers.ethercat.slave import SlaveSpec

_T = TypeVar("_T")


@dataclass(frozen=True, slots=True)
class Place:
    """Where a device is and what it must be.

    Attributes
    ----------
    name : what the configuration calls it.
    position : place on the bus, from 1.
    vendor, product, revision : identity (0x1018); a revision of None takes any.
    cycle_time_s : period of the bus, s.
    """

    name: str
    position: int
    vendor: int
    product: int
    revision: int | None = None
    cycle_time_s: float = 0.0005


class Device(Protocol):
    """A device on the bus."""

    @property
    def spec(self) -> SlaveSpec:
        """The slave as the bus should find and configure it."""
        ...

    def attach(self, outputs: NDArray[Any] | None, inputs: NDArray[Any] | None) -> None:
        """Take the device's process data; None for a direction it has none of."""
        ...


def build(kind: type[_T], where: str, options: Mapping[str, Any], **given: Any) -> _T:
    """Make a configuration dataclass from a configuration file's options.

    Raises
    ------
    DriverError
        For an option that does not exist or one that is missing, with those that do.
    """
    names = {field.name for field in fields(kind) if field.init} - set(given)  # type: ignore[arg-type]
    unknown = sorted(set(options) - names)
    if unknown:
        raise DriverError(f"{where}: option '{unknown[0]}' is not known; the options are {', '.join(sorted(names))}")
    missing = [
        field.name
        for field in fields(kind)  # type: ignore[arg-type]
        if field.name in names - set(options) and field.default is MISSING and field.default_factory is MISSING
    ]
    if missing:
        raise DriverError(f"{where}: option '{missing[0]}' is missing; it should be given in the configuration")
    return kind(**given, **options)
