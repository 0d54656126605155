"""The systemd unit of the service, made for the settings it is printed with."""

from __future__ import annotations

import shlex
import sys
import tempfile
from pathlib import Path

from bench.safety.paths import state_root

_UNIT = """\
# Made by: bench serve --systemd-unit
# Put it at /etc/systemd/system/gearbench.service, then: systemctl daemon-reload && systemctl enable --now gearbench
[Unit]
Description=Gearbox bench: runs, recordings, operator's page
After=network.target

[Service]
Type=notify
NotifyAccess=main
ExecStart={command}
WorkingDirectory={folder}
User={user}
# Fed only while the run process speaks and its recording grows.
WatchdogSec=20
Restart=on-failure
RestartSec=2
# SIGTERM to every process brings the bench to rest and finishes the recording; it has this long for it.
KillMode=control-group
TimeoutStopSec=90
# Only run processes keep these; the web process gives them away before it opens its port.
AmbientCapabilities=CAP_NET_RAW CAP_NET_ADMIN CAP_SYS_NICE CAP_IPC_LOCK
CapabilityBoundingSet=CAP_NET_RAW CAP_NET_ADMIN CAP_SYS_NICE CAP_IPC_LOCK
LimitMEMLOCK=infinity
LimitRTPRIO=90
NoNewPrivileges=yes
ProtectSystem=strict
ProtectHome=read-only
# Recordings; what is on record of a bench (a stop, its commissioning); locks, in the very folder in which a shell of
# this user looks for them, so that bench run joins this service's queue.
ReadWritePaths={folder} {state} {temporary}
PrivateTmp=no
# Compiled loops.
CacheDirectory=gearbench
Environment=NUMBA_CACHE_DIR=/var/cache/gearbench

[Install]
WantedBy=multi-user.target
"""


def unit(arguments: list[str], folder: Path, user: str) -> str:
    """Return the unit; ``arguments`` are those of ``bench serve`` that are to stand in it.

    The folder of the benches' state is made, for systemd starts nothing that may write where nothing is.
    """
    command = shlex.join([str(Path(sys.executable).with_name("bench")), "serve", *arguments])
    state = state_root().absolute()
    state.mkdir(parents=True, exist_ok=True)
    return _UNIT.format(
        command=command, folder=folder.absolute(), user=user, state=state, temporary=tempfile.gettempdir()
    )
