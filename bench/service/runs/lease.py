"""Who holds the controls: one browser or script at a time; handed over, taken, let go; each stands in the book.

The lease is a token, not a name: two browsers in which the same name was given are two.
"""

from __future__ import annotations

import hmac
import secrets
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any

from bench.errors import BenchError
from bench.service.files.book import Book

LOST_S = 300.0
"""A holder whose page has not been heard of for so long no longer holds the controls."""
SILENT_S = 60.0
"""A holder not heard of for so long is shown as away."""


class NotHeld(BenchError):
    """The caller does not hold the controls."""


@dataclass(frozen=True, slots=True)
class Holder:
    """Who holds the controls; ``id`` may be known to everybody, ``secret`` to the holder only.

    Times in s of the monotonic clock given to :class:`Lease`.
    """

    id: str
    name: str
    secret: str
    since: datetime
    heard: float
    offered_to: str | None = None


class Lease:
    """The lease of the controls; ``now`` of each call is a monotonic time in s."""

    def __init__(self, book: Book) -> None:
        self._book = book
        self._holder: Holder | None = None

    def holder(self, now: float) -> Holder | None:
        """Who holds the controls, None if nobody does."""
        holder = self._holder
        if holder is not None and now - holder.heard > LOST_S:
            self._book.write("controls", holder.name, f"no message from {holder.name} for {LOST_S / 60:.0f} min")
            self._holder = None
        return self._holder

    def take(self, name: str, from_: str | None, now: float) -> Holder:
        """Give the controls to ``name`` and return who holds them now, with the secret that proves it.

        Raises
        ------
        NotHeld
            If somebody else holds them and the caller does not say from whom they are taken.
        """
        holder = self.holder(now)
        if holder is not None and from_ != holder.name and holder.offered_to != name:
            raise NotHeld(f"{holder.name} holds the controls; take them from {holder.name} by saying so")
        if holder is None:
            text = f"{name} took the controls"
        elif holder.offered_to == name:
            text = f"{holder.name} handed the controls over to {name}"
        else:
            text = f"{name} took the controls from {holder.name}"
            text += " in another browser" if name == holder.name else ""
        self._book.write("controls", name, text)
        self._holder = Holder(secrets.token_hex(8), name, secrets.token_urlsafe(24), datetime.now(UTC), now)
        return self._holder

    def check(self, secret: str | None, now: float) -> Holder:
        """Return the holder if ``secret`` is theirs.

        Raises
        ------
        NotHeld
            If it is not.
        """
        holder = self.holder(now)
        if holder is None:
            raise NotHeld("nobody holds the controls; take them first")
        if secret is None or not hmac.compare_digest(secret.encode(), holder.secret.encode()):
            raise NotHeld(f"{holder.name} holds the controls in another browser or script; take them first")
        self._holder = replace(holder, heard=now)
        return self._holder

    def offer(self, secret: str | None, to: str, now: float) -> None:
        """Offer the controls to someone by name, who then takes them."""
        holder = self.check(secret, now)
        self._book.write("controls", holder.name, f"{holder.name} offers the controls to {to}")
        self._holder = replace(holder, offered_to=to)

    def release(self, secret: str | None, now: float) -> None:
        """Let go of the controls."""
        holder = self.check(secret, now)
        self._book.write("controls", holder.name, f"{holder.name} let go of the controls")
        self._holder = None

    def as_dict(self, now: float) -> dict[str, Any] | None:
        """For the page, without the secret."""
        holder = self.holder(now)
        if holder is None:
            return None
        return {
            "id": holder.id,
            "name": holder.name,
            "since": holder.since.isoformat(),
            "away": now - holder.heard > SILENT_S,
            "offered_to": holder.offered_to,
        }
