"""How long a cyclic frame takes over a network interface: the figures of ``bench benchmark wire``.

The master is the one on SOEM, the slaves are the emulator in a process of its own; the frame carries the process data
of all slaves. What the machine itself took away meanwhile (steal time) is reported beside the figures.
"""

from __future__ import annotations

import gc
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench.cycle.host import steal_s
from bench.cycle.plugins import DRIVERS, MASTERS, plugin
from bench.devices import Master
from bench.errors import DeviceError

_OPERATIONAL = 0x08
_SETTLING_S = 10.0
_TIMEOUT_US = 20_000


@dataclass(frozen=True, slots=True)
class RoundTrip:
    """Figures of one run; times in µs from before sending to after receiving.

    ``lost`` frames came too late or not at all, ``wrong`` ones with another working counter than expected, ``missed``
    slots had passed before their frame could be sent. ``steal_s`` is time the host took from this machine. ``emulator``
    holds the counters of the far end.
    """

    cycles: int
    cycle_time_s: float
    lost: int
    wrong: int
    missed: int
    median_us: float
    p99_us: float
    p999_us: float
    maximum_us: float
    steal_s: float
    emulator: dict[str, Any]

    def as_dict(self) -> dict[str, Any]:
        """Return the figures for a script."""
        return asdict(self)


@contextmanager
def veth_pair() -> Iterator[tuple[str, str]]:
    """Make a veth pair and take it away again; yield the names of its ends (needs CAP_NET_ADMIN)."""
    near, far = f"bw{os.getpid() % 100_000}m", f"bw{os.getpid() % 100_000}s"
    _ip("link", "add", near, "type", "veth", "peer", "name", far)
    try:
        for name in (near, far):
            with suppress(OSError):  # without IPv6 there is nothing to switch off
                Path(f"/proc/sys/net/ipv6/conf/{name}/disable_ipv6").write_text("1")
            _ip("link", "set", name, "up")
        yield near, far
    finally:
        _ip("link", "del", near)


@contextmanager
def emulator(interface: str, cycle_time_s: float, *options: str) -> Iterator[dict[str, Any]]:
    """Run ``bench emulate`` on an interface; yield a dict that holds its counters once it has ended."""
    start = "from bench.cli import main; main()"
    command = [sys.executable, "-c", start, "emulate", "--interface", interface, "--json"]
    command += ["--cycle-time-ms", str(1000.0 * cycle_time_s), *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    counters: dict[str, Any] = {}
    try:
        assert process.stdout is not None
        if not process.stdout.readline():
            _, error = process.communicate()
            raise DeviceError(f"the emulator does not start on {interface}: {error.strip()}")
        yield counters
    finally:
        process.terminate()
        out, _ = process.communicate()
        if out.strip():
            counters.update(json.loads(out.strip().splitlines()[-1]))


def measure(interface: str, duration_s: float, cycle_time_s: float, priority: int | None) -> RoundTrip:
    """Cycle for a while against slaves on an interface and return the figures (those of the emulator are empty).

    Raises
    ------
    DeviceError : no slaves, or they do not reach OPERATIONAL.
    """
    master: Master = plugin(MASTERS, "soem")()
    try:
        master.open(interface)
    except ConnectionError as error:
        raise DeviceError(f"network interface {interface} cannot be opened: {error}; CAP_NET_RAW is needed") from error
    try:
        _bring_up(master, interface)
        return _cycle(master, round(duration_s / cycle_time_s), cycle_time_s, priority)
    finally:
        master.state = 0x01
        master.write_state()
        master.close()


def _bring_up(master: Master, interface: str) -> None:
    if master.config_init() < 1:
        raise DeviceError(f"no slave answers on {interface}; is an emulator or a bench at its other end?")
    master.config_map()
    master.config_dc()
    master.state_check(0x04, 5_000_000)
    master.state = _OPERATIONAL
    deadline = time.monotonic() + _SETTLING_S
    while time.monotonic() < deadline:
        master.send_processdata()
        master.receive_processdata(_TIMEOUT_US)
        if master.state_check(_OPERATIONAL, 2000) == _OPERATIONAL:
            return
        master.state = _OPERATIONAL  # reading the states has overwritten what was asked for
        master.write_state()
    raise DeviceError(f"the slaves on {interface} do not reach OPERATIONAL (state {master.read_state():#x})")


def _cycle(master: Master, cycles: int, cycle_time_s: float, priority: int | None) -> RoundTrip:
    pacing = plugin(DRIVERS, "absolute_deadlines")(cycle_time_s)
    times = np.zeros(cycles)
    counters = np.zeros(cycles, np.int32)
    slots = np.zeros(cycles, np.int64)
    expected = master.expected_wkc
    clock = time.perf_counter_ns
    steal = steal_s()
    with _undisturbed(priority):
        for i in range(cycles):
            slots[i], _ = pacing.next_slot()
            begin = clock()
            master.send_processdata()
            counters[i] = master.receive_processdata(_TIMEOUT_US)
            times[i] = clock() - begin
    steal = steal_s() - steal
    good = times[counters >= 0] / 1000.0
    if not good.size:
        raise DeviceError("not one frame came back")
    median, p99, p999, maximum = np.percentile(good, (50.0, 99.0, 99.9, 100.0)).tolist()
    return RoundTrip(
        cycles=cycles,
        cycle_time_s=cycle_time_s,
        lost=int(np.count_nonzero(counters < 0)),
        wrong=int(np.count_nonzero((counters != expected) & (counters >= 0))),
        missed=int(slots[-1] - slots[0] + 1 - cycles),
        median_us=median,
        p99_us=p99,
        p999_us=p999,
        maximum_us=maximum,
        steal_s=steal,
        emulator={},
    )


@contextmanager
def _undisturbed(priority: int | None) -> Iterator[None]:
    """Keep the garbage collector out, and other programs where a priority is given (needs CAP_SYS_NICE)."""
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    if priority is not None:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
        os.sched_setscheduler(0, *before)


def _ip(*arguments: str) -> None:
    try:
        subprocess.run(["ip", *arguments], check=True, capture_output=True, text=True)
    except FileNotFoundError as error:
        raise DeviceError(
            "the program ip is missing; name two interfaces instead of having a veth pair made"
        ) from error
    except subprocess.CalledProcessError as error:
        raise DeviceError(f"ip {' '.join(arguments)} failed: {error.stderr.strip()}; root rights are needed") from error
