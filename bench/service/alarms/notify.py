"""Alarms for those who are not there: mail or chat through apprise, if it is installed (extra ``notify``)."""

from __future__ import annotations

import logging
import threading
from importlib import import_module
from typing import Any

from bench.errors import ConfigurationError
from bench.service.alarms.alarms import Alarm

_LOG = logging.getLogger(__name__)


class Notifier:
    """Sends alarms to apprise URLs, from a thread of its own: a mail server that is down holds up nothing.

    Raises
    ------
    ConfigurationError
        If URLs are given and apprise is not installed, or does not understand one.
    """

    def __init__(self, urls: tuple[str, ...]) -> None:
        self._sender: Any = None
        if not urls:
            return
        try:
            apprise = import_module("apprise")
        except ImportError as error:
            raise ConfigurationError(
                "--notify needs apprise; install it with pip install 'gearbench[notify]'"
            ) from error
        self._sender = apprise.Apprise()
        for url in urls:
            if not self._sender.add(url):
                scheme = url.split("://")[0]
                raise ConfigurationError(f"--notify {scheme}://… is not an address apprise understands")

    def send(self, alarm: Alarm, bench: str) -> threading.Thread | None:
        """Send an alarm; returns at once."""
        if self._sender is None:
            return None
        thread = threading.Thread(target=self._send, args=(alarm, bench), name="notify", daemon=True)
        thread.start()
        return thread

    def _send(self, alarm: Alarm, bench: str) -> None:
        title = f"Bench {bench}: {alarm.cause.replace('_', ' ').lower()}"
        if not self._sender.notify(
            title=title,
            body=f"{alarm.text}\n\n{alarm.what_to_do}\n\n{alarm.point + chr(10) if alarm.point else ''}{alarm.at}",
        ):
            _LOG.warning("an alarm could not be sent to every address of --notify: %s", alarm.text)
