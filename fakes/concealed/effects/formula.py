"""Effects given by one law, and the register of all forms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fakes.concealed.effects.base import Effect, Floats, Run
from fakes.concealed.truth import Parameter

Law = Callable[[Run, dict[str, float], dict[str, Any]], Floats]
Factory = Callable[[np.random.Generator], Effect]


def _none(run: Run, shape: dict[str, float], memory: dict[str, Any]) -> Floats:
    return np.zeros(run.time.size)


@dataclass(slots=True)
class Formula(Effect):
    """``amplitude · law(run, shape, memory)`` through one hook.

    Attributes:
        hook: one of :data:`fakes.concealed.effects.base.HOOKS`.
        law: unit-amplitude law; ``memory`` carries its state from recording to recording.
        natural: (symbol, unit) of the amplitude where it is the vocabulary's own parameter, with further shape
            entries as (symbol, shape key, unit).
    """

    hook: str = "transmission"
    law: Law = _none
    natural: tuple[tuple[str, str, str], ...] = ()
    memory: dict[str, Any] = field(default_factory=dict)

    def reset(self) -> None:
        """Forget the state."""
        self.memory.clear()

    def add(self, hook: str, run: Run) -> Floats | None:
        """The law through its own hook, nothing through any other."""
        return self.amplitude * self.law(run, self.shape, self.memory) if hook == self.hook else None

    def parameters(self) -> tuple[Parameter, ...]:
        """The natural parameters' true values."""
        values = {"": self.amplitude, **self.shape}
        return tuple(Parameter(symbol, float(values[key]), unit) for symbol, key, unit in self.natural)


@dataclass(frozen=True, slots=True)
class Form:
    """One registered form of one effect."""

    effect: str
    name: str
    held_back: bool
    make: Factory


#: Every form, in order of registration.
FORMS: list[Form] = []


def form(effect: str, name: str, *, held_back: bool = False) -> Callable[[Factory], Factory]:
    """Register a factory under a vocabulary id; ``held_back`` forms appear only in sets nobody tunes on."""

    def register(make: Factory) -> Factory:
        FORMS.append(Form(effect, name, held_back, make))
        return make

    return register
