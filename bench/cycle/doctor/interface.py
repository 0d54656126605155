"""The network interface of the bus."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

from bench.cycle.doctor.finding import Finding, advice, bad, good

_SYS, _PROC = Path("/sys/class/net"), Path("/proc")
_UP = 0x1


def interfaces(root: Path = _SYS) -> list[str]:
    """Names of the Ethernet interfaces of this machine."""
    if not root.is_dir():
        return []
    return sorted(path.name for path in root.iterdir() if _text(path / "type") == "1")


def interface(name: str, root: Path = _SYS, proc: Path = _PROC) -> list[Finding]:
    """Look whether an interface is there, connected, quiet and undelayed."""
    check = f"interface {name}"
    if not (root / name).exists():
        known = ", ".join(interfaces(root)) or "none"
        return [bad(check, f"there is none of this name; there are {known}", "its name in the bench file, or --bus")]
    return [
        _link(check, root / name),
        _addresses(check, name, proc),
        _ipv6(check, name, proc),
        *_coalescing(check, name),
    ]


def _link(check: str, folder: Path) -> Finding:
    name = f"{check}: link"
    if not int(_text(folder / "flags") or "0", 16) & _UP:
        return bad(name, "it is down", f"ip link set {folder.name} up")
    if _text(folder / "carrier") != "1":
        return bad(name, "no carrier", "cable, and power of the first device")
    speed = _text(folder / "speed")
    return good(name, f"connected, {speed} Mbit/s" if speed not in ("", "-1") else "connected")


def _addresses(check: str, name: str, proc: Path) -> Finding:
    routes = _text(proc / "net/route").splitlines()[1:]
    if any(line.split()[0] == name for line in routes if line):
        return bad(
            f"{check}: use",
            "it carries IP traffic, which delays frames",
            f"a port of its own for the bus: ip address flush dev {name}, and no network manager on it",
        )
    return good(f"{check}: use", "no IP routes over it")


def _ipv6(check: str, name: str, proc: Path) -> Finding:
    if _text(proc / f"sys/net/ipv6/conf/{name}/disable_ipv6") == "0":
        return advice(
            f"{check}: IPv6", "on: the system sends frames of its own", f"sysctl net.ipv6.conf.{name}.disable_ipv6=1"
        )
    return good(f"{check}: IPv6", "off")


def _coalescing(check: str, name: str) -> list[Finding]:
    """Delays the card puts between frames and interrupts, where ethtool reports them."""
    tool = shutil.which("ethtool")
    if tool is None:
        return [advice(f"{check}: coalescing", "not seen: ethtool is not installed", "install ethtool")]
    done = subprocess.run([tool, "-c", name], capture_output=True, text=True, check=False)
    waits = {key: int(value) for key, value in re.findall(r"^([rt]x-usecs): (\d+)$", done.stdout, re.MULTILINE)}
    late = {key: value for key, value in waits.items() if value > 0}
    if done.returncode != 0 or not waits:
        why = (done.stderr.strip().splitlines() or ["it names no delay"])[-1]
        return [advice(f"{check}: coalescing", f"not seen: ethtool says {why}", f"ethtool -c {name}")]
    if not late:
        return [good(f"{check}: coalescing", "none")]
    text = ", ".join(f"{key} {value} µs" for key, value in late.items())
    return [advice(f"{check}: coalescing", text, f"ethtool -C {name} " + " ".join(f"{key} 0" for key in late))]


def _text(path: Path) -> str:
    try:
        return path.read_text().strip()
    except OSError:
        return ""
