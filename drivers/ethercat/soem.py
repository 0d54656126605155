"""The real master: entry point ``soem`` of the group ``bench.masters``."""

from __future__ import annotations

from typing import cast

import pysoem

from drivers.ethercat.protocols import Master


def soem_master() -> Master:
    """Return a new master on SOEM; it is opened on a network interface by the bus."""
    return cast(Master, pysoem.Master())
