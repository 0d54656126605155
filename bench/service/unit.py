"""The systemd unit of the service, made for the settings it is printed with."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

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
ReadWritePaths={folder}
PrivateTmp=no
RuntimeDirectory=gearbench
Environment=BENCH_RUNTIME=/run/gearbench

[Install]
WantedBy=multi-user.target
"""


def unit(arguments: list[str], folder: Path, user: str) -> str:
    """Return the unit; ``arguments`` are those of ``bench serve`` that are to stand in it."""
    command = shlex.join([str(Path(sys.executable).with_name("bench")), "serve", *arguments])
    return _UNIT.format(command=command, folder=folder.absolute(), user=user)
