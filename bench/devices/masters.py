"""What the bench itself uses of a master; the rest of its API is the bus's."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable


class Master(Protocol):
    """A bus master with the API of ``pysoem.Master``, as far as the bench uses it itself; the rest is the bus's."""

    state: int
    """AL state asked for by :meth:`write_state`, as in register 0x0120."""

    @property
    def expected_wkc(self) -> int:
        """Working counter of an undisturbed cycle."""
        ...

    def open(self, ifname: str) -> None:
        """Open the network interface; ConnectionError if that fails."""
        ...

    def close(self) -> None:
        """Close the network interface."""
        ...

    def config_init(self) -> int:
        """Find the slaves; their number, or 0 and less."""
        ...

    def config_map(self) -> int:
        """Map the process data of all slaves."""
        ...

    def config_dc(self) -> bool:
        """Set up distributed clocks."""
        ...

    def read_state(self) -> int:
        """Read the lowest AL state of all slaves."""
        ...

    def write_state(self) -> int:
        """Ask all slaves for the state in ``state``."""
        ...

    def state_check(self, expected_state: int, timeout: int) -> int:
        """Wait for a state of all slaves, ``timeout`` in µs; the state they have."""
        ...

    def send_processdata(self) -> int:
        """Send the outputs."""
        ...

    def receive_processdata(self, timeout: int) -> int:
        """Receive the inputs, ``timeout`` in µs; the working counter, -1 where no frame came."""
        ...


@runtime_checkable
class ReplayMaster(Protocol):
    """A master that can be put back to where it was; only an emulated one can."""

    def snapshot(self) -> Any:
        """Return a token of the whole state behind this master."""
        ...

    def restore(self, token: Any) -> None:
        """Return to the state of a snapshot."""
        ...
