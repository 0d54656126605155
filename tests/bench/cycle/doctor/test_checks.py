"""Each check of the doctor on machines that are made up."""

from __future__ import annotations

import os
import shutil
from importlib import metadata
from pathlib import Path

import pytest

from bench.configuration import load_bench
from bench.cycle.doctor import disk, interface, machine, packages, rights
from bench.cycle.doctor.examine import examine
from bench.cycle.doctor.finding import Finding, State

ALL, NONE = (1 << 41) - 1, 0


def states(findings: list[Finding]) -> dict[str, State]:
    return {finding.check: finding.state for finding in findings}


def write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def proc(root: Path, capabilities: int, throttle: int = 950_000) -> Path:
    write(root / "self/status", f"Name:\tpython\nCapEff:\t{capabilities:016x}\n")
    write(root / "sys/kernel/sched_rt_runtime_us", str(throttle))
    write(root / "sys/kernel/sched_rt_period_us", "1000000")
    return root


def test_what_is_not_granted_is_bad_only_where_nothing_goes_without_it(tmp_path: Path) -> None:
    assert set(states(rights.capabilities(proc(tmp_path, ALL))).values()) == {State.GOOD}
    refused = states(rights.capabilities(proc(tmp_path, NONE)))
    assert refused == {
        "CAP_NET_RAW": State.BAD,
        "CAP_NET_ADMIN": State.BAD,
        "CAP_SYS_NICE": State.ADVICE,
        "CAP_IPC_LOCK": State.ADVICE,
    }
    assert states(rights.capabilities(proc(tmp_path, 1 << 13)))["CAP_NET_RAW"] is State.GOOD


@pytest.mark.parametrize(("throttle", "state"), [(-1, State.GOOD), (950_000, State.GOOD), (200_000, State.BAD)])
def test_the_throttle_is_looked_at(tmp_path: Path, throttle: int, state: State) -> None:
    assert states(rights.scheduling(10, proc(tmp_path, ALL, throttle)))["real-time throttle"] is state


def test_scheduling_that_is_refused_is_advice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    found = rights.scheduling(80, tmp_path)[0]
    assert (found.state, "rtprio 80" in found.change) == (State.ADVICE, True)


def test_scheduling_is_left_as_it_was(tmp_path: Path) -> None:
    before = os.sched_getscheduler(0)
    rights.scheduling(10, tmp_path)
    machine.wake_up(10)
    assert os.sched_getscheduler(0) == before


@pytest.mark.parametrize(
    ("limit", "capabilities", "state"),
    [(64 << 10, NONE, State.ADVICE), (64 << 10, ALL, State.GOOD), (-1, NONE, State.GOOD), (1 << 30, NONE, State.GOOD)],
)
def test_the_limit_of_locked_memory_counts_without_the_capability(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limit: int, capabilities: int, state: State
) -> None:
    monkeypatch.setattr(rights.resource, "getrlimit", lambda _: (limit, limit))
    assert rights.locked_memory(proc(tmp_path, capabilities))[0].state is state


def test_processors(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path / "isolated", "\n")
    write(tmp_path / "cpu0/cpufreq/scaling_governor", "powersave\n")
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0})
    assert set(states(machine.processors(tmp_path)).values()) == {State.ADVICE}
    write(tmp_path / "isolated", "3\n")
    write(tmp_path / "cpu0/cpufreq/scaling_governor", "performance\n")
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
    assert set(states(machine.processors(tmp_path)).values()) == {State.GOOD}


def test_kernel_and_clock(tmp_path: Path) -> None:
    assert machine.kernel(tmp_path)[0].state is State.ADVICE
    write(tmp_path / "realtime", "1\n")
    assert machine.kernel(tmp_path)[0].state is State.GOOD
    write(tmp_path / "current_clocksource", "hpet\n")
    assert machine.clock(tmp_path)[0].state is State.BAD
    write(tmp_path / "current_clocksource", "tsc\n")
    assert machine.clock(tmp_path)[0].state is State.GOOD


def port(root: Path, flags: int = 0x1003, carrier: str = "1") -> Path:
    for name, text in (("type", "1"), ("flags", hex(flags)), ("carrier", carrier), ("speed", "100")):
        write(root / "net/eth1" / name, text)
    return root / "net"


def test_an_interface_that_is_not_there_is_said_with_those_that_are(tmp_path: Path) -> None:
    found = interface.interface("eth7", port(tmp_path), tmp_path)[0]
    assert found.state is State.BAD
    assert "eth1" in found.found


@pytest.mark.parametrize(
    ("flags", "carrier", "state"), [(0x1003, "1", State.GOOD), (0x1002, "0", State.BAD), (0x1003, "0", State.BAD)]
)
def test_a_link_must_be_up_and_connected(tmp_path: Path, flags: int, carrier: str, state: State) -> None:
    found = states(interface.interface("eth1", port(tmp_path, flags, carrier), tmp_path))
    assert found["interface eth1: link"] is state


def test_an_interface_of_others_is_not_for_the_bus(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda _: None)
    write(tmp_path / "net/route", "Iface\tDestination\neth1\t00000000\n")
    write(tmp_path / "sys/net/ipv6/conf/eth1/disable_ipv6", "0\n")
    found = states(interface.interface("eth1", port(tmp_path / "sysfs"), tmp_path))
    assert found["interface eth1: use"] is State.BAD
    assert found["interface eth1: IPv6"] is State.ADVICE
    assert found["interface eth1: coalescing"] is State.ADVICE


def test_coalescing_is_read_from_ethtool(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tool = write(tmp_path / "ethtool", "#!/bin/sh\nprintf 'Adaptive RX: off\\nrx-usecs: 3\\ntx-usecs: 0\\n'\n")
    tool.chmod(0o755)
    monkeypatch.setattr(interface.shutil, "which", lambda _: str(tool))
    found = interface.interface("eth1", port(tmp_path), tmp_path)[-1]
    assert (found.state, found.change) == (State.ADVICE, "ethtool -C eth1 rx-usecs 0")


@pytest.mark.parametrize(
    ("script", "says"),
    [("echo 'netlink error: Operation not supported' >&2; exit 95", "not supported"), ("echo Coalesce", "no delay")],
)
def test_what_ethtool_does_not_say_is_not_called_good(
    script: str, says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tool = write(tmp_path / "ethtool", f"#!/bin/sh\n{script}\n")
    tool.chmod(0o755)
    monkeypatch.setattr(interface.shutil, "which", lambda _: str(tool))
    found = interface.interface("eth1", port(tmp_path), tmp_path)[-1]
    assert found.state is State.ADVICE
    assert "not seen" in found.found
    assert says in found.found


def test_disk(tmp_path: Path) -> None:
    found = disk.disk(tmp_path / "not" / "yet", 0.0)
    assert found[0].state is State.GOOD
    assert [path for path in tmp_path.iterdir()] == []
    assert disk.disk(tmp_path, 1e18)[0].state is State.BAD


def test_packages_are_those_required() -> None:
    def version(name: str) -> str:
        if name == "absent":
            raise metadata.PackageNotFoundError(name)
        return "1.5"

    assert packages.packages(["present>=1.0"], version)[0].state is State.GOOD
    wanted = ["present>=1.0", "absent", "old>=2.0", 'other>=9; extra == "test"']
    assert states(packages.packages(wanted, version)) == {"package absent": State.BAD, "package old": State.BAD}
    assert packages.packages()[0].state is State.GOOD
    assert packages.python()[0].state is State.GOOD


def test_the_bus_is_looked_at_where_there_is_one(tmp_path: Path) -> None:
    emulated = states(examine(load_bench("rh380n").configuration, None, tmp_path))
    assert not any(check.startswith("interface") for check in emulated)
    wired = states(examine(load_bench("rh380n").configuration, "no-such-port", tmp_path))
    assert wired["interface no-such-port"] is State.BAD
    # "host" stands there only where the hypervisor took time away during the look.
    assert set(emulated) - {"host"} < set(wired)
