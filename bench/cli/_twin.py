"""The twin beside ``bench run``: what it says, and a campaign that comes to rest when the model no longer holds."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from bench.cli._plain import escaped

if TYPE_CHECKING:
    from rich.console import Console

    from bench.campaigns.operator.directions import Directions

LAST_LOOKS_S = 600.0
"""how long is waited for the last recordings to be looked at, after the campaign"""


@dataclass(slots=True)
class TwinMessages:
    """What the twin has said of this run."""

    alarm: dict[str, Any] | None = None
    looked: dict[str, Any] | None = None
    why: str = ""
    longest_s: float = 0.0
    unread: dict[str, str] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """For the summary as JSON."""
        return {
            "no_longer_holds": self.alarm,
            "tested": 0 if self.looked is None else self.looked["tested"],
            "evidence": None if self.looked is None else self.looked["evidence"],
            "longest_look_s": self.longest_s,
            "ended": self.why,
            "unread": self.unread,
        }


@contextmanager
def watched_by(
    model: Path | None, folder: Path, directions: Directions | None, console: Console, keeps_pace: bool = False
) -> Iterator[TwinMessages | None]:
    """Run the twin beside what is done inside, and let it look at the last recordings afterwards.

    ``directions``: of the run, to bring it to rest when the model no longer holds; None to let it go on.
    ``keeps_pace``: whether the bench keeps the clock's pace. Raises ConfigurationError for a wrong model, before
    anything is done.
    """
    if model is None:
        yield None
        return
    from bench.twin.companion import Companion
    from bench.twin.job import BESIDE_EMULATED, LOWEST

    heard, nice = TwinMessages(), LOWEST if keeps_pace else BESIDE_EMULATED

    def hear(message: dict[str, Any]) -> None:
        if message["type"] == "looked":
            heard.looked = message
            heard.longest_s = max(heard.longest_s, message["took_s"])
        elif message["type"] == "no_longer_holds":
            heard.alarm = message
            console.print(f"[bold yellow]twin[/]: {escaped(message['text'])}", soft_wrap=True)
            if directions is not None:
                directions.stop()
        elif message["type"] == "ended":
            heard.why = message["why"]
            heard.unread = message.get("unread", {})

    with TemporaryDirectory() as place:
        companion = Companion(model, folder, Path(place) / "twin.json", hear, nice)
        try:
            yield heard
            companion.finish()
            if not companion.wait(LAST_LOOKS_S):
                heard.why = f"the twin had not looked at everything {LAST_LOOKS_S:.0f} s after the campaign"
        finally:
            companion.kill()


def say_seen(heard: TwinMessages | None, console: Console) -> None:
    """What the twin saw, in a sentence."""
    if heard is None:
        return
    if heard.why:
        console.print(f"[yellow]twin[/]: {escaped(heard.why)}", soft_wrap=True)
    for recording, why in heard.unread.items():
        console.print(f"twin: {escaped(recording)} was not looked at: {escaped(why)}", soft_wrap=True)
    looked = heard.looked
    if looked is None or looked["tested"] == 0:
        points = 0 if looked is None else looked["points"]
        console.print(f"twin: {points} recordings at one point each are too few to watch anything", soft_wrap=True)
        return
    for channel, why in looked["not_watched"].items():
        console.print(f"twin: {channel.replace('_', ' ')} is not watched: {escaped(why)}", soft_wrap=True)
    if heard.alarm is None:
        console.print(f"twin: the model holds in all {looked['tested']} recordings that were tested", soft_wrap=True)
