"""What a bus process does for the rig between two cycles: objects of the slaves, emergencies, recovery."""

from __future__ import annotations

from drivers.errors import BusError
from drivers.ethercat.emergency import EmergencyMessage
from drivers.ethercat.process.client import Client
from drivers.ethercat.process.remote_sdo import RemoteSdo
from drivers.ethercat.recovery import Recovery
from drivers.ethercat.sdo import SdoClient
from drivers.ethercat.slave import SlaveSpec


class Services:
    """The part of a bus that is asked now and then.

    Attributes
    ----------
    specs : the slaves in their order.
    """

    def __init__(self, specs: tuple[SlaveSpec, ...]) -> None:
        self.specs = specs
        self._client: Client | None = None

    def sdo(self, name: str) -> SdoClient:
        """Object dictionary of a slave. While the bus cycles, an access costs the cycles it takes."""
        if name not in {spec.name for spec in self.specs}:
            known = ", ".join(spec.name for spec in self.specs)
            raise BusError(f"'{name}' is no configured slave of this bus; it has {known}")
        return RemoteSdo(self._running_client.ask, name)

    def sdo_read(self, name: str, index: int, subindex: int, type_: str) -> int:
        """Read an integer object of a slave (:meth:`SdoClient.read`)."""
        return self.sdo(name).read(index, subindex, type_)

    def sdo_write(self, name: str, index: int, subindex: int, type_: str, value: int) -> None:
        """Write an integer object of a slave (:meth:`SdoClient.write`)."""
        self.sdo(name).write(index, subindex, type_, value)

    def emergencies(self) -> tuple[EmergencyMessage, ...]:
        """As :meth:`EtherCatBus.emergencies`."""
        messages: tuple[EmergencyMessage, ...] = self._running_client.ask("emergencies")
        return messages

    def recover(self) -> tuple[Recovery, ...]:
        """As :meth:`EtherCatBus.recover`; no cycle runs meanwhile."""
        steps: tuple[Recovery, ...] = self._running_client.ask("recover")
        return steps

    @property
    def _running_client(self) -> Client:
        if self._client is None:
            raise BusError("the bus process does not run; open() comes first")
        return self._client
