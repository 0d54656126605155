"""Who leads through a commissioning: a person at a terminal, or nobody where the bench is emulated."""

from __future__ import annotations

from typing import Protocol


class Guide(Protocol):
    """Receives every step, and is asked for what only eyes and hands can do."""

    @property
    def has_hands(self) -> bool:
        """Whether somebody can press the emergency stop and see the output turn."""
        ...

    def step(self, number: int, count: int, title: str, what: str) -> None:
        """Announce a step."""
        ...

    def ask(self, question: str) -> bool:
        """Return whether the answer is yes."""
        ...

    def show(self, text: str) -> None:
        """Show a text."""
        ...


class Nobody:
    """Answers yes to everything; for emulated plants, which have no fingers to hurt and nothing to see."""

    has_hands = False

    def __init__(self) -> None:
        self.said: list[str] = []

    def step(self, number: int, count: int, title: str, what: str) -> None:
        """Keep the title."""
        self.said.append(title)

    def ask(self, question: str) -> bool:
        """Say yes."""
        return True

    def show(self, text: str) -> None:
        """Keep the text."""
        self.said.append(text)
