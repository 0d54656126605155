"""A veth pair for the tests of a session, and the emulator at its far end in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from pyroute2 import IPRoute
from pyroute2.netlink.exceptions import NetlinkError

from fakes.ethercat.wire.control import ControlClient

START_TIMEOUT_S = 60.0
PRIORITY = 71
"""Of an emulator, where real-time scheduling is allowed: it should not wait for the other tests."""


@dataclass(frozen=True)
class VethPair:
    """Names of both ends: ``near`` for the master, ``far`` for the emulator."""

    near: str
    far: str


@contextmanager
def veth_pair() -> Iterator[VethPair]:
    """Make a veth pair and take it away again; skips the test where that is not allowed."""
    pair = VethPair(f"gb{os.getpid() % 100_000}m", f"gb{os.getpid() % 100_000}s")
    try:
        route = IPRoute()
        route.link("add", ifname=pair.near, kind="veth", peer=pair.far)
    except (NetlinkError, OSError) as error:
        pytest.skip(f"no veth pair can be made here, so EtherCAT frames are not tested: {error}")
    try:
        for name in (pair.near, pair.far):
            with suppress(OSError):  # without IPv6 there is nothing to switch off
                Path(f"/proc/sys/net/ipv6/conf/{name}/disable_ipv6").write_text("1")
            route.link("set", index=route.link_lookup(ifname=name)[0], state="up")
        yield pair
    finally:
        route.link("del", index=route.link_lookup(ifname=pair.near)[0])
        route.close()


def real_time_allowed() -> bool:
    """Whether a program may ask for real-time scheduling here, without which a loaded machine delays it at will."""
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    except OSError:
        return False
    os.sched_setscheduler(0, *before)
    return True


class Emulator:
    """A running emulator; ``places`` says what it reported at its start."""

    def __init__(self, interface: str, folder: Path, **options: Any) -> None:
        control = folder / "control"
        given = {"interface": interface, "control": str(control), **options}
        if real_time_allowed():
            given.setdefault("priority", PRIORITY)
        command = [sys.executable, "-m", "fakes.ethercat.wire.service", json.dumps(given)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        if not line:
            _, error = self.process.communicate(timeout=START_TIMEOUT_S)
            if "PortError" in error and "not allowed" in error:
                pytest.skip("raw sockets are not allowed here, so EtherCAT frames are not tested")
            raise RuntimeError(f"the emulator did not start: {error}")
        self.places: dict[str, Any] = json.loads(line)
        self._control = ControlClient(control)

    def order(self, line: str) -> dict[str, Any]:
        """Give an order, see :mod:`fakes.ethercat.wire.control`."""
        return self._control.order(line)

    def stop(self) -> dict[str, Any]:
        """Stop and return the counters."""
        self.order("stop")
        self._control.close()
        out, error = self.process.communicate(timeout=START_TIMEOUT_S)
        assert self.process.returncode == 0, error
        counters: dict[str, Any] = json.loads(out)
        return counters
