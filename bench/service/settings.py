"""How the service is set up: what it serves, where it keeps things, whom it lets in. Refuses what would be unsafe."""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass
from pathlib import Path

from bench.errors import ConfigurationError

STATE_FOLDER = ".service"
"""Folder beside the recordings for the service's own files."""


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of one service.

    Attributes
    ----------
    bench, interface : bench file (or shipped name), and the network interface it is on instead of the file's.
    folder : where campaigns go, each in a folder of its own.
    campaigns : folder of campaign files offered beside the shipped ones.
    host, port : address it is bound to.
    token : secret that browsers and scripts have to show; needed beyond loopback.
    certificate, key : PEM files for TLS; needed beyond loopback.
    names : further names or ``name:port`` under which browsers may reach it.
    model : simulation file drawn over the order spectrum.
    notify : apprise URLs alarms are sent to.
    stop_port : port on 127.0.0.1 of the runs' own stop listener; 0 for any that is free.
    conceal : seed of a plant drawn with concealed physics, for an emulated bench.
    watch : read a bench behind a network interface, without torque, also while nothing runs; its bus is locked then.
    """

    bench: str = "rh380n"
    interface: str | None = None
    folder: Path = Path("recordings")
    campaigns: Path | None = None
    host: str = "127.0.0.1"
    port: int = 8080
    token: str | None = None
    certificate: Path | None = None
    key: Path | None = None
    names: tuple[str, ...] = ()
    model: Path | None = None
    notify: tuple[str, ...] = ()
    stop_port: int = 0
    conceal: int | None = None
    watch: bool = False

    def __post_init__(self) -> None:
        """Refuse an address others can reach without TLS and a token."""
        if (self.certificate is None) != (self.key is None):
            raise ConfigurationError("TLS needs both --tls-certificate and --tls-key, only one of them is given")
        if self.is_loopback:
            return
        missing = [
            name
            for name, value in (
                ("--tls-certificate and --tls-key", self.certificate),
                ("--token-file", self.token),
                ("--name", self.names or not _is_wildcard(self.host) or None),
            )
            if value is None
        ]
        if missing:
            raise ConfigurationError(
                f"{self.host} can be reached from other computers, so the service needs {' and '.join(missing)};"
                " without them it serves 127.0.0.1 only"
            )
        if self.token is not None and len(self.token) < 16:
            raise ConfigurationError("the token is shorter than 16 characters, which can be guessed; make a longer one")

    @property
    def is_loopback(self) -> bool:
        """Whether only this computer can reach the address."""
        if self.host == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False

    @property
    def scheme(self) -> str:
        """``https`` with a certificate, else ``http``."""
        return "https" if self.certificate is not None else "http"

    @property
    def url(self) -> str:
        """Address of the page: by the first further name, where there is one."""
        if self.names:
            return f"{self.scheme}://{self._with_port(self.names[0])}"
        return f"{self.scheme}://{self._with_port(self.host)}"

    @property
    def state(self) -> Path:
        """Folder of the service's own files: log, queue, sockets."""
        return self.folder / STATE_FOLDER

    @property
    def hosts(self) -> frozenset[str]:
        """Values of the Host header that are answered."""
        local_names = {self.host, "localhost", "127.0.0.1", "::1"} if self.is_loopback else {self.host}
        answered = {self._with_port(name) for name in local_names | set(self.names)}
        if {443: "https", 80: "http"}.get(self.port) == self.scheme:
            # a browser leaves the usual port out
            answered |= {name.removesuffix(f":{self.port}") for name in answered}
        return frozenset(name.lower() for name in answered)

    def _with_port(self, name: str) -> str:
        if name.count(":") > 1 and not name.startswith("["):
            return f"[{name}]:{self.port}"
        has_port = ":" in name.rpartition("]")[2]
        return name if has_port else f"{name}:{self.port}"


def _is_wildcard(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_unspecified
    except ValueError:
        return False
