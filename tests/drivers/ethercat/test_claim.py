"""Two masters on one interface: the second is refused, until the first has gone, however it went."""

import os
import subprocess
import sys
from types import SimpleNamespace
from typing import Any, cast

import pytest

from drivers.errors import BusError
from drivers.ethercat import EtherCatBus
from drivers.ethercat.claim import Claim


class Opened:
    """A master that can only be opened."""

    slaves: tuple[Any, ...] = ()

    def __init__(self, error: Exception | None = None) -> None:
        self.opened, self._error = 0, error

    def open(self, interface: str) -> None:
        self.opened += 1
        if self._error is not None:
            raise self._error

    def close(self) -> None:
        pass


def bus(master: Opened, interface: str) -> EtherCatBus:
    spec = SimpleNamespace(name="x", outputs=(), inputs=(), position=1)
    return EtherCatBus(cast(Any, master), interface, [cast(Any, spec)], nonblocking_socket=False)


def test_a_second_master_is_refused_before_it_sends_a_frame() -> None:
    first, second = Opened(), Opened()
    with bus(first, "lo"), pytest.raises(BusError, match=f"in use by another master .process {os.getpid()}."):
        bus(second, "lo").open()
    assert (first.opened, second.opened) == (1, 0)
    with bus(second, "lo"):
        assert second.opened == 1


def test_a_master_that_could_not_open_lets_the_interface_go() -> None:
    with pytest.raises(BusError, match="CAP_NET_RAW"):
        bus(Opened(ConnectionError()), "lo").open()
    with bus(Opened(), "lo"):
        pass


def test_what_is_no_interface_of_this_computer_is_claimed_by_nobody() -> None:
    with bus(Opened(), "no-interface"), bus(Opened(), "no-interface"):
        pass


def test_a_claim_goes_with_its_process() -> None:
    code = (
        "import sys\nfrom drivers.ethercat.claim import Claim\n"
        "claim = Claim('lo')\nclaim.take()\nprint(flush=True)\nsys.stdin.read()"
    )
    holder = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert holder.stdout is not None
    holder.stdout.readline()
    claim = Claim("lo")
    with pytest.raises(BusError, match=f"process {holder.pid}"):
        claim.take()
    holder.kill()
    holder.communicate()
    claim.take()
    claim.release()
