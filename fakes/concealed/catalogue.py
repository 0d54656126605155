"""The cases of an exam: which effects, at which strength, in which design, with which nuisance."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

import fakes.concealed.effects.compliance
import fakes.concealed.effects.foreign
import fakes.concealed.effects.load_side
import fakes.concealed.effects.motor_side
import fakes.concealed.effects.physics
import fakes.concealed.effects.thermal
import fakes.concealed.effects.transmission  # noqa: F401
from fakes.concealed.design import Design
from fakes.concealed.effects.formula import FORMS, Form
from fakes.concealed.exam import CLEAR, COMPOUNDS, CONFUSIONS, FAINT, GROUPS, QUICK, QUICK_DESIGN, SWITCHABLE, TOO_CLOSE
from fakes.concealed.noise import NUISANCE_NAMES


@dataclass(frozen=True, slots=True)
class CaseSpec:
    """One case before it is made.

    Attributes:
        forms: the forms to conceal; strengths: their targets in units of the noise floor (same length).
        status: what an honest report says of each; also: indistinguishable alternatives of each.
        shape: numbers of the forms to be set rather than drawn.
        elsewhere: another laboratory's bench: other magnitudes and sensors, now and then a lost cycle.
        clutter: the gearbox has sixty to a hundred weak orders beside the nominal ones.
        least_overlap: share of the effect that those of ``also`` have to say on the bench that is drawn.
    """

    name: str
    group: str
    seed: int
    forms: tuple[Form, ...] = ()
    strengths: tuple[float, ...] = ()
    status: str = "named"
    also: tuple[str, ...] = ()
    design: Design = field(default_factory=Design)
    nuisance: str = "quiet"
    switched_off: tuple[str, ...] = ()
    truncate: bool = False
    shape: tuple[tuple[str, float], ...] = ()
    elsewhere: bool = False
    clutter: bool = False
    least_overlap: float = 0.0

    @property
    def alias(self) -> str:
        """The name of the folder and the campaign: it says nothing of what is in it."""
        return hashlib.sha256(f"{self.name} {self.seed} {self.clutter}".encode()).hexdigest()[:12]


def vocabulary() -> tuple[str, ...]:
    """Every effect id that has a form, ``unknown`` left out."""
    return tuple(dict.fromkeys(f.effect for f in FORMS if f.effect != "unknown"))


def cases(
    group: str, seed: int, count: int | None = None, held_back: bool = False, clutter: bool = False
) -> Iterator[CaseSpec]:
    """The cases of one group, or ``count`` of them drawn by the seed: the first ones would be of one kind.

    ``held_back`` draws from the forms that nobody tunes on as well. ``clutter`` gives every bench weak orders; cases
    are else the same.
    """
    makers = {
        "clear": lambda: _single("clear", CLEAR, seed, held_back),
        "faint": lambda: _single("faint", FAINT, seed, held_back),
        "null": lambda: _nulls(seed, count or 12, held_back),
        "null_small": lambda: _small_nulls(seed, count or 100, held_back),
        "compound": lambda: _compounds(seed, held_back),
        "unknown": lambda: _unknowns(seed, held_back),
        "ambiguous": lambda: _ambiguous(seed, held_back),
        "switched_off": lambda: _switched(seed),
        "quick": lambda: _quick(seed),
    }
    every = list(makers[group]())
    if count is not None and count < len(every):
        drawn = np.random.default_rng([seed, GROUPS.index(group), len(every)]).choice(len(every), count, replace=False)
        every = [every[k] for k in sorted(drawn)]
    for case in every:
        yield replace(case, clutter=clutter)


def _pick(effect: str, rng: np.random.Generator, held_back: bool) -> Form:
    """A form of an effect; of a held-back set the held-back one where there is one."""
    mine = [f for f in FORMS if f.effect == effect]
    chosen = [f for f in mine if f.held_back == held_back] or mine
    return chosen[int(rng.integers(len(chosen)))]


def _seeded(group: str, seed: int, number: int) -> tuple[int, np.random.Generator]:
    rng = np.random.default_rng([seed, GROUPS.index(group), number])
    return int(rng.integers(1, 2**31)), rng


def _uneven(rng: np.random.Generator, held_back: bool = False) -> Design:
    """The full design with some of its levels left out, as laboratories do; another laboratory's where held back."""
    if held_back:
        step = float(rng.choice([125.0, 200.0, 300.0]))
        half = [step * k for k in (0.25, 1.0, 2.0, 3.0, 4.0, 5.0) if step * k <= 1000.0]
        levels = int(rng.integers(3, 5))
        return Design(
            loads=(*(-x for x in reversed(half)), *((0.0,) if rng.random() < 0.6 else ()), *half),
            speeds=tuple(np.round(np.linspace(2.5, rng.uniform(9.0, 11.0), int(rng.integers(4, 7))), 2)),
            levels=levels,
            heat_time=1100.0 / levels,
            grid=int(rng.integers(26, 32)),
            validation=int(rng.integers(4, 9)),
            transients=(int(rng.integers(2, 5)), int(rng.integers(2, 5)), 2),
        )
    base = Design()
    loads = tuple(sorted(rng.choice(base.loads, size=int(rng.integers(6, 10)), replace=False)))
    loads = tuple(sorted({-1000.0, 0.0, 1000.0, *map(float, loads)}))
    return replace(base, loads=loads, validation=int(rng.integers(5, 9)), grid=int(rng.integers(27, 33)))


def _single(group: str, strengths: tuple[float, float], seed: int, held_back: bool) -> Iterator[CaseSpec]:
    for number, effect in enumerate(vocabulary()):
        case_seed, rng = _seeded(group, seed, number)
        form = _pick(effect, rng, held_back)
        yield CaseSpec(
            name=f"{group}-{number:03d}",
            group=group,
            seed=case_seed,
            forms=(form,),
            strengths=(float(rng.uniform(*strengths)),),
            design=_uneven(rng, held_back),
            truncate=bool(rng.random() < 0.15),
            nuisance=_nuisance(rng, held_back),
            elsewhere=held_back,
        )


def _nulls(seed: int, count: int, held_back: bool) -> Iterator[CaseSpec]:
    for number in range(count):
        case_seed, rng = _seeded("null", seed, number)
        nuisance = NUISANCE_NAMES[number % len(NUISANCE_NAMES)]
        yield CaseSpec(
            f"null-{number:03d}",
            "null",
            case_seed,
            design=_uneven(rng, held_back),
            nuisance=nuisance,
            truncate=bool(rng.random() < 0.15),
            elsewhere=held_back,
        )


def _small_nulls(seed: int, count: int, held_back: bool) -> Iterator[CaseSpec]:
    """Folders without effect of a few short recordings each: many can be asked, for a tight rate of false alarms."""
    for case in _nulls(seed, count, held_back):
        case_seed, _rng = _seeded("null_small", seed, int(case.name.rsplit("-", 1)[1]))
        name = case.name.replace("null", "null_small")
        yield replace(case, name=name, group="null_small", seed=case_seed, design=QUICK_DESIGN, truncate=False)


def _nuisance(rng: np.random.Generator, held_back: bool) -> str:
    """Nothing but ordinary noise; on a held-back bench a nuisance in every second folder."""
    return str(rng.choice(NUISANCE_NAMES)) if held_back and rng.random() < 0.5 else "quiet"


def _compounds(seed: int, held_back: bool) -> Iterator[CaseSpec]:
    for number, listed in enumerate(COMPOUNDS):
        case_seed, rng = _seeded("compound", seed, number)
        effects = _together(len(listed), rng) if held_back else listed
        forms = tuple(_pick(effect, rng, held_back) for effect in effects)
        targets = tuple(float(rng.uniform(0.6, 1.6)) for _ in effects)
        yield CaseSpec(
            name=f"compound-{number:03d}",
            group="compound",
            seed=case_seed,
            forms=forms,
            strengths=targets,
            design=_uneven(rng, held_back),
            elsewhere=held_back,
        )


def _together(count: int, rng: np.random.Generator) -> tuple[str, ...]:
    """Random effects, none too close to another."""
    while True:
        effects = tuple(str(e) for e in rng.choice(vocabulary(), count, replace=False))
        if not any(frozenset(pair) in TOO_CLOSE for pair in combinations(effects, 2)):
            return effects


def _unknowns(seed: int, held_back: bool) -> Iterator[CaseSpec]:
    forms = [f for f in FORMS if f.effect == "unknown" and f.held_back <= held_back]
    for number, form in enumerate(sorted(forms, key=lambda f: not f.held_back)):
        case_seed, rng = _seeded("unknown", seed, number)
        target = (float(rng.uniform(1.0, 2.0)),)
        yield CaseSpec(
            name=f"unknown-{number:03d}",
            group="unknown",
            seed=case_seed,
            forms=(form,),
            strengths=target,
            status="unknown",
            design=_uneven(rng, held_back),
            elsewhere=held_back,
        )


def _ambiguous(seed: int, held_back: bool) -> Iterator[CaseSpec]:
    for number, pair in enumerate(CONFUSIONS):
        case_seed, rng = _seeded("ambiguous", seed, number)
        form = next(f for f in FORMS if (f.effect, f.name) == (pair.effect, pair.form))
        yield CaseSpec(
            name=f"ambiguous-{number:03d}",
            group="ambiguous",
            seed=case_seed,
            forms=(form,),
            strengths=(float(rng.uniform(*pair.strength)),),
            status="ambiguous",
            also=pair.also,
            design=pair.design,
            shape=pair.shape,
            least_overlap=pair.least_overlap,
        )


def _quick(seed: int) -> Iterator[CaseSpec]:
    for number, effect in enumerate(QUICK):
        case_seed, rng = _seeded("quick", seed, number)
        forms = (_pick(effect, rng, False),) if effect else ()
        strengths = tuple(float(rng.uniform(*CLEAR)) for _ in forms)
        yield CaseSpec(f"quick-{number:03d}", "quick", case_seed, forms, strengths, design=QUICK_DESIGN)


def _switched(seed: int) -> Iterator[CaseSpec]:
    for number, term in enumerate(SWITCHABLE):
        case_seed, rng = _seeded("switched_off", seed, number)
        yield CaseSpec(
            f"switched_off-{number:03d}", "switched_off", case_seed, design=_uneven(rng), switched_off=(term,)
        )
