"""Text of files on a terminal: what would steer the terminal, or be read as markup, is shown instead of obeyed."""

from __future__ import annotations

import re
from collections.abc import Iterable

import typer
from rich.console import Console, ConsoleOptions, RenderableType
from rich.markup import escape
from rich.segment import Segment

# C0 but tab and line feed, DEL, C1, and marks that reorder text or break lines (Unicode 3.5, Bidi_Control).
_STEERING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")


def plain(text: object) -> str:
    """Give a text in which characters that steer a terminal are written out as JSON has them: ``\\u001b``."""
    return _STEERING.sub(lambda found: f"\\u{ord(found[0]):04x}", str(text))


def line(text: object) -> str:
    """Give a text as a single line, so that a value in a file cannot look like a sentence of this program."""
    return plain(text).replace("\n", "\\n")


def escaped(text: object) -> str:
    """Give a text for the inside of rich's markup; brackets in it stay brackets."""
    return escape(line(text))


def say(text: object, *, err: bool = False, nl: bool = True) -> None:
    """Print a text, to stderr if ``err``."""
    typer.echo(plain(text), err=err, nl=nl)


class PlainConsole(Console):
    """A console on which only its own styles steer the terminal, whatever stands in the texts."""

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Render, with what would steer the terminal written out."""
        for segment in super().render(renderable, options):
            harmless = segment.control or not _STEERING.search(segment.text)
            yield segment if harmless else Segment(plain(segment.text), segment.style)
