"""A client of the service: ``bench run`` joins the queue of a service that has the bus, instead of fighting for it."""

from __future__ import annotations

import getpass
import http.client
import json
import re
import secrets
import ssl
import urllib.error
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.campaigns import shipped_campaigns
from bench.errors import BenchError, DeviceError

Message = dict[str, Any]
_TIMEOUT_S = 30.0
_NOT_IN_NAMES = re.compile(r"[^\w .@'\-]")


class Refused(BenchError):
    """The service refused; the sentence is its own."""


@dataclass(frozen=True, slots=True)
class Client:
    """A service by its address, as :func:`bench.locks.service_for` gives it."""

    url: str
    token: str | None = None
    certificate: str | None = None
    folder: str = ""

    @classmethod
    def at(cls, address: dict[str, Any]) -> Client:
        """Return the client of a service."""
        return cls(*(address.get(key, default) for key, default in _ADDRESS))

    @property
    def person(self) -> str:
        """The name acts of this client are recorded with."""
        return (_NOT_IN_NAMES.sub("", f"{getpass.getuser()} (bench run)".replace("(", "").replace(")", "")))[:40]

    def get(self, path: str) -> Any:
        """Return what the service answers."""
        with self._open(urllib.request.Request(f"{self.url}/api/{path}")) as answer:
            return json.load(answer)

    def post(self, path: str, body: Message) -> Any:
        """Ask for a change.

        Raises
        ------
        Refused
            With the service's own sentence.
        DeviceError
            If it cannot be reached.
        """
        request = urllib.request.Request(f"{self.url}/api/{path}", json.dumps(body).encode(), method="POST")
        request.add_header("Content-Type", "application/json")
        with self._open(request) as answer:
            return json.load(answer)

    def ask(
        self,
        campaign: str,
        out: Path | None,
        real_time: bool,
        seed: int,
        twin: Path | None = None,
        twin_pause: bool = False,
    ) -> Message:
        """Put a campaign into the queue, with the controls if nobody else holds them; return the run.

        Raises
        ------
        Refused
            If the campaign or the folder is refused.
        """
        body: Message = {"name": self.person, "real_time": real_time, "seed": seed, **_campaign(campaign)}
        if twin is not None:
            body |= {"twin": _analysis(twin), "twin_pause": twin_pause}
        if out is not None:
            body["folder"] = self._folder_name(out)
        secret = self._controls()
        try:
            asked: Message = self.post("runs", _new({**body, "secret": secret} if secret else body))
        finally:
            if secret:
                self.post("controls/release", _new({"secret": secret}))
        return asked

    def events(self) -> Iterator[Message]:
        """Yield what happens until the service ends.

        Raises
        ------
        DeviceError
            If it cannot be reached, or says nothing for half a minute.
        """
        with self._open(urllib.request.Request(f"{self.url}/api/events")) as stream:
            try:
                for line in stream:
                    if line.startswith(b"data: {") and (message := json.loads(line[6:])):
                        yield message
            except (OSError, http.client.HTTPException) as error:
                raise DeviceError(
                    f"the service at {self.url} does not answer any more ({error}); a run goes on without it"
                ) from error

    def _controls(self) -> str | None:
        holder = next(message for message in self.get("state") if message["type"] == "state")["holder"]
        if holder is not None:
            return None
        return str(self.post("controls/take", _new({"name": self.person}))["secret"])

    def _folder_name(self, out: Path) -> str:
        if out.parent == Path() or out.absolute().parent == Path(self.folder):
            return out.name
        raise Refused(
            f"the service keeps recordings in {self.folder}, --out {out} lies elsewhere; give a name without folder"
        )

    def _open(self, request: urllib.request.Request) -> Any:
        if self.token is not None:
            request.add_header("Authorization", f"Bearer {self.token}")
        context = None if self.certificate is None else ssl.create_default_context(cafile=self.certificate)
        try:
            return urllib.request.urlopen(request, timeout=_TIMEOUT_S, context=context)
        except urllib.error.HTTPError as error:
            with error:
                try:
                    why = str(json.load(error)["problem"])
                except (ValueError, KeyError, TypeError):
                    why = f"the service at {self.url} answered {error.code}"
            raise Refused(why) from error
        except (OSError, urllib.error.URLError) as error:
            raise DeviceError(f"the service at {self.url} has this bus and does not answer: {error}") from error


_ADDRESS: tuple[tuple[str, Any], ...] = (("url", ""), ("token", None), ("certificate", None), ("folder", ""))


def _new(body: Message) -> Message:
    return {"request_id": secrets.token_hex(16), **body}


def _analysis(model: Path) -> str:
    """The analysis of the service that a model is of."""
    folder = model.absolute().parent
    if folder.parent.name != "analyses" or model.name != "model.json":
        raise Refused(
            f"{model} is no model of the service that has this bench; identify on its page and give"
            " FOLDER/.service/analyses/ID/model.json, or choose it there"
        )
    return folder.name


def _campaign(campaign: str) -> Message:
    path = Path(campaign)
    if campaign in shipped_campaigns():
        return {"campaign": campaign}
    if path.suffix == ".py":
        raise Refused(
            f"{path} is a program, which a service takes from its own campaigns folder only; put it there or write TOML"
        )
    return {"text": path.read_text("utf-8")}
