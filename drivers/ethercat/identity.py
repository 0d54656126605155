"""Are the devices on the bus those of the configuration, and in its order?"""

from __future__ import annotations

from collections.abc import Sequence

from drivers.errors import BusError, IdentityError
from drivers.ethercat.protocols import Slave
from drivers.ethercat.slave import SlaveSpec


def check_specs(specs: Sequence[SlaveSpec]) -> tuple[SlaveSpec, ...]:
    """Return the slaves in the order of the bus.

    Raises
    ------
    BusError
        If names repeat, positions are not 1…n, or two slaves of one identity want different process data: SOEM copies
        the mapping from the first of equal vendor, product and revision to the others.
    """
    ordered = tuple(sorted(specs, key=lambda spec: spec.position))
    if len({spec.name for spec in ordered}) != len(ordered):
        raise BusError("two slaves have the same name; each name may stand once on a bus")
    positions = [spec.position for spec in ordered]
    if positions != list(range(1, len(ordered) + 1)):
        raise BusError(f"the slaves' positions are {positions}; they should count 1 to {len(ordered)} without a gap")
    for i, first in enumerate(ordered):
        for second in ordered[i + 1 :]:
            same = (first.vendor, first.product) == (second.vendor, second.product)
            if same and (first.rx_pdos, first.tx_pdos) != (second.rx_pdos, second.tx_pdos):
                raise BusError(
                    f"{first.name} and {second.name} have the same identity ({first.identity}) but different process "
                    "data; SOEM would map both alike, so give both the same PDOs"
                )
    return ordered


def check_identity(specs: Sequence[SlaveSpec], found: Sequence[Slave], interface: str) -> None:
    """Compare vendor, product and, where required, revision of every slave, in order.

    Raises
    ------
    IdentityError
        Naming the first place that differs and, where the devices are there in another order, saying so.
    """
    for spec, slave in zip(specs, found, strict=False):
        if not _matches(spec, slave):
            other = next((s for s in specs if _matches(s, slave)), None)
            hint = (
                f"that is what {other.name} should be, so check the order of the cables"
                if other
                else "check the device"
            )
            raise IdentityError(
                f"position {spec.position} on {interface} should be {spec.name} ({spec.identity}) but is "
                f"'{slave.name}' (vendor 0x{slave.man:08X}, product 0x{slave.id:08X}, revision 0x{slave.rev:08X}); "
                f"{hint}"
            )
    if len(found) < len(specs):
        missing = specs[len(found)]
        raise IdentityError(
            f"{interface} has {len(found)} slaves but {len(specs)} are configured; the first missing one is "
            f"{missing.name} at position {missing.position} ({missing.identity}), "
            "so check its supply and the cable before it"
        )
    if len(found) > len(specs):
        raise IdentityError(
            f"{interface} has {len(found)} slaves but {len(specs)} are configured; position {len(specs) + 1} is "
            f"'{found[len(specs)].name}', which should be configured or unplugged"
        )


def _matches(spec: SlaveSpec, slave: Slave) -> bool:
    return (spec.vendor, spec.product) == (slave.man, slave.id) and spec.revision in (None, slave.rev)
