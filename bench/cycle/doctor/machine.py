"""Processors, kernel and clock."""

from __future__ import annotations

import os
import platform
import time
from pathlib import Path

import numpy as np

from bench.cycle.doctor.finding import Finding, advice, bad, good
from bench.cycle.host import steal_s

_PUNCTUAL_CLOCKS = frozenset({"tsc", "kvm-clock", "arch_sys_counter", "hyperv_clocksource_tsc_page"})
_WAKES, _PERIOD_NS = 500, 1_000_000
_LATE_US = 250.0
"""Half a cycle of 2 kHz."""


def processors(root: Path = Path("/sys/devices/system/cpu")) -> list[Finding]:
    """Count processors, find isolated ones, look at what governs their frequency."""
    allowed = len(os.sched_getaffinity(0))
    found = []
    if allowed == 1:
        found.append(
            advice("processors", "1 for this program: bus, rig and writer take turns", "a second one, kept for the bus")
        )
    else:
        found.append(good("processors", f"{allowed} for this program"))
    isolated = _text(root / "isolated")
    if isolated:
        found.append(good("isolated processors", isolated))
    else:
        found.append(
            advice(
                "isolated processors",
                "none: ordinary programs share every processor, and newer kernels give them a millisecond of it now"
                " and then, whatever real-time work is due",
                f"boot with isolcpus={max(0, (os.cpu_count() or 1) - 1)} and 'processor' in the bench file",
            )
        )
    governors = {_text(path) for path in root.glob("cpu[0-9]*/cpufreq/scaling_governor")}
    if not governors:
        found.append(good("processor frequency", "not governed by this system"))
    elif governors == {"performance"}:
        found.append(good("processor frequency", "performance"))
    else:
        found.append(
            advice("processor frequency", ", ".join(sorted(governors)), "cpupower frequency-set -g performance")
        )
    return found


def kernel(root: Path = Path("/sys/kernel")) -> list[Finding]:
    """Whether the kernel preempts itself for real-time work."""
    name = "kernel"
    if _text(root / "realtime") == "1":
        return [good(name, f"{platform.release()} with PREEMPT_RT")]
    change = "a kernel with PREEMPT_RT, where cycles under load matter"
    return [advice(name, f"{platform.release()} without PREEMPT_RT: its own work may delay a cycle", change)]


def clock(root: Path = Path("/sys/devices/system/clocksource/clocksource0")) -> list[Finding]:
    """Which clock the kernel reads, and what reading it costs."""
    name, source = "clock", _text(root / "current_clocksource") or "unknown"
    begin = time.perf_counter_ns()
    for _ in range(10_000):
        time.monotonic_ns()
    cost = (time.perf_counter_ns() - begin) / 10_000
    text = f"{source}, {cost:.0f} ns to read"
    if source in _PUNCTUAL_CLOCKS or (source == "unknown" and cost < 500.0):
        return [good(name, text)]
    return [bad(name, text, "a clock source that is read within the processor (tsc): kernel option clocksource=tsc")]


def wake_up(priority: int) -> list[Finding]:
    """Sleep to 500 deadlines, in real time if that is allowed: how late it was, and what the host took meanwhile."""
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
        how = f"SCHED_FIFO {priority}"
    except PermissionError:
        how = "ordinary scheduling"
    stolen = steal_s()
    late = np.zeros(_WAKES)
    try:
        due = time.monotonic_ns() + _PERIOD_NS
        for i in range(_WAKES):
            time.sleep(max(0, due - time.monotonic_ns()) * 1e-9)
            late[i] = time.monotonic_ns() - due
            due += _PERIOD_NS
    finally:
        os.sched_setscheduler(0, *before)
    stolen = steal_s() - stolen
    median, p99, most = (np.percentile(late, (50, 99, 100)) / 1000.0).tolist()
    text = f"late by {median:.0f} µs (median), {p99:.0f} µs (99 %), {most:.0f} µs (most), {how}"
    found = []
    if p99 <= _LATE_US:
        found.append(good("wake-up", text))
    else:
        found.append(bad("wake-up", text, "real-time scheduling, an isolated processor, less beside it"))
    if stolen > 0.0:
        found.append(
            advice(
                "host", f"took {stolen * 1000:.0f} ms away during half a second", "a machine of its own: no virtual one"
            )
        )
    return found


def _text(path: Path) -> str:
    try:
        return path.read_text().strip()
    except OSError:
        return ""
