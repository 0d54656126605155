"""Capabilities, real-time scheduling, locked memory."""

from __future__ import annotations

import os
import resource
from pathlib import Path

from bench.cycle.doctor.finding import Finding, advice, bad, good

_CAPABILITIES = (
    (13, "CAP_NET_RAW", "raw sockets, without which there is no bus", True),
    (12, "CAP_NET_ADMIN", "opening the interface, which SOEM refuses without it", True),
    (23, "CAP_SYS_NICE", "real-time scheduling of the bus process", False),
    (14, "CAP_IPC_LOCK", "memory that is never paged out", False),
)
"""Bit in the capability sets (capabilities(7)), name, what for, whether nothing goes without it."""
_HOW = "run as root, or give it: AmbientCapabilities= of a systemd unit, or setcap on a Python of the bench's own"
_RING_BYTES = 64 << 20
"""What a bus process locks, at most."""


def capabilities(root: Path = Path("/proc")) -> list[Finding]:
    """Look at the effective capabilities of this process."""
    status = (root / "self/status").read_text()
    effective = int(next(line.split()[1] for line in status.splitlines() if line.startswith("CapEff")), 16)
    found = []
    for bit, name, what, needed in _CAPABILITIES:
        if effective >> bit & 1:
            found.append(good(name, f"granted: {what}"))
        else:
            say = bad if needed else advice
            found.append(say(name, f"not granted: {what}", _HOW))
    return found


def scheduling(priority: int, root: Path = Path("/proc")) -> list[Finding]:
    """Try real-time scheduling at a priority and look at the kernel's throttle."""
    found = [_fifo(priority)]
    throttle = root / "sys/kernel/sched_rt_runtime_us"
    period = root / "sys/kernel/sched_rt_period_us"
    if throttle.exists() and period.exists():
        share = int(throttle.read_text()) / int(period.read_text())
        if share < 0.0:
            found.append(good("real-time throttle", "off"))
        elif share >= 0.9:
            found.append(good("real-time throttle", f"{share:.0%} of a processor is allowed, the bus needs a third"))
        else:
            found.append(
                bad("real-time throttle", f"{share:.0%} of a processor", "sysctl kernel.sched_rt_runtime_us=950000")
            )
    return found


def _fifo(priority: int) -> Finding:
    name = "real-time scheduling"
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except PermissionError:
        limit = resource.getrlimit(resource.RLIMIT_RTPRIO)[1]
        return advice(
            name,
            f"SCHED_FIFO priority {priority} is refused, the limit is {limit}: cycles come late under load",
            f"CAP_SYS_NICE, or 'rtprio {priority}' for the user in /etc/security/limits.d",
        )
    os.sched_setscheduler(0, *before)
    return good(name, f"SCHED_FIFO priority {priority} is granted")


def locked_memory(root: Path = Path("/proc")) -> list[Finding]:
    """Look at how much memory may be locked."""
    name, limit = "locked memory", resource.getrlimit(resource.RLIMIT_MEMLOCK)[0]
    status = (root / "self/status").read_text()
    effective = int(next(line.split()[1] for line in status.splitlines() if line.startswith("CapEff")), 16)
    if effective >> 14 & 1 or limit == resource.RLIM_INFINITY:
        return [good(name, "without limit")]
    if limit >= _RING_BYTES * 8:
        return [good(name, f"{limit >> 20} MB")]
    return [advice(name, f"{limit >> 10} kB at most", "'memlock unlimited' for the user in /etc/security/limits.d")]
