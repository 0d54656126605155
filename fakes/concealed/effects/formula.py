"""Effects given by one law, and the register of all forms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fakes.concealed.effects.base import Effect, Floats, Run
from fakes.concealed.truth import Parameter

Law = Callable[[Run, dict[str, float], dict[str, Any]], Floats]
Derived = Callable[[float, dict[str, float]], dict[str, tuple[float, str]]]
Factory = Callable[[np.random.Generator], Effect]


def _none(run: Run, shape: dict[str, float], memory: dict[str, Any]) -> Floats:
    return np.zeros(run.time.size)


@dataclass(slots=True)
class Formula(Effect):
    """``amplitude · law(run, shape, memory)`` through one hook.

    Attributes:
        hook: one of :data:`fakes.concealed.effects.base.HOOKS`.
        law: unit-amplitude law; ``memory`` carries its state from recording to recording.
        natural: parameters that are the amplitude (key "") or an entry of the shape: (symbol, key, unit).
        derived: more of them, computed from amplitude and shape: symbol → (value, unit). Symbols and signs are the
            vocabulary's own, as ``model.json`` has them.
    """

    hook: str = "transmission"
    law: Law = _none
    natural: tuple[tuple[str, str, str], ...] = ()
    derived: Derived | None = None
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
        plain = [Parameter(symbol, float(values[key]), unit) for symbol, key, unit in self.natural]
        more = self.derived(self.amplitude, self.shape) if self.derived is not None else {}
        return (*plain, *(Parameter(symbol, float(value), unit) for symbol, (value, unit) in more.items()))


@dataclass(frozen=True, slots=True)
class Form:
    """One registered form of one effect.

    Attributes:
        in_library: the analyser's library has this very form (of an unknown kind: a free function of one recorded
            quantity, or a tone, draws it), as its public description says. The proof's table keeps the two apart.
    """

    effect: str
    name: str
    held_back: bool
    in_library: bool
    make: Factory


#: Every form, in order of registration.
FORMS: list[Form] = []


def form(effect: str, name: str, *, held_back: bool = False, in_library: bool = False) -> Callable[[Factory], Factory]:
    """Register a factory under a vocabulary id; ``held_back`` forms appear only in sets nobody tunes on."""

    def register(make: Factory) -> Factory:
        FORMS.append(Form(effect, name, held_back, in_library, make))
        return make

    return register
