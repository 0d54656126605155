"""Names of the channels of a file: datasets of ``/channels``, and in place of a folder of ours the names in it."""

from __future__ import annotations

from collections.abc import Iterator

import h5py

AUXILIARY = "aux/"
"""Begins the name of a quantity that is no channel of the bench, such as ``aux/oil_pressure``."""
SIMULATED = "simulated/"
"""Begins the name of what a simulation says of a channel, such as ``simulated/motor_torque``."""
RESIDUAL = "residual/"
"""Begins the name of what is measured less what is simulated."""
FOLDERS = tuple(name.rstrip("/") for name in (AUXILIARY, SIMULATED, RESIDUAL))


def channel_names(group: h5py.Group) -> Iterator[str]:
    """Give the name of each member of ``/channels``, whatever it is; in place of a folder of ours its members'."""
    for name in group:
        if name not in FOLDERS or group.get(name, getclass=True, getlink=False) is not h5py.Group:
            yield name
            continue
        yield from (f"{name}/{member}" for member in group[name])
