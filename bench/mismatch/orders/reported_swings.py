"""Orders of a joint that never turns its output round, as discoveries."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import AMBIGUOUS, NAMED, UNKNOWN, UNNAMED, Discovery, RefittedAlternative
from bench.mismatch.orders.misread import ENCODER, HARMONIC
from bench.mismatch.orders.periodicity import MOST_WAVES, equation
from bench.mismatch.orders.reported import OF_MOTOR, WAVE, parameter, probability
from bench.mismatch.orders.shaft import PHASES, RIPPLE
from bench.mismatch.orders.swings import SwingOrder, evaluated
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.strength import active_size
from bench.simulation.frame import FloatArray
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE, TRANSMISSION_ERROR


def discoveries(
    found: Sequence[SwingOrder], rows: Rows, compared: FloatArray, floor: float, banned: Sequence[str]
) -> list[Discovery]:
    """Orders as discoveries: multiples of the motor shaft's, which its encoder or the gearbox may make, and all others.
    None of what is weak: ``compared`` samples of the rows (n,), noise ``floor`` of a sample, rad.
    """
    out = []
    for of_shaft in (True, False):
        some = [order for order in found if order.of_shaft == of_shaft]
        values = evaluated(some, rows)
        if not some or active_size(values, compared) < criteria.LEAST_STRENGTH * floor:
            continue
        names = [name for name in ((HARMONIC, ENCODER) if of_shaft else (HARMONIC,)) if name not in banned]
        if names:
            out.append(_discovery(some, values, names))
    return out


def of_torque(found: Sequence[SwingOrder], rows: Rows, compared: FloatArray, floor: float) -> list[Discovery]:
    """Orders of the motor torque as discoveries: ripple, which stands at multiples of six times the shaft's turns, and
    what has no name. None of what is weak, as in :func:`discoveries`; N·m.
    """
    ratio = rows.frame.ratio

    def is_ripple(order: SwingOrder) -> bool:
        turns = round(order.wave.order / ratio)
        return (order.of_shaft or ratio == 1.0) and turns % PHASES == 0

    out = []
    for effect in (RIPPLE, UNNAMED):
        some = [order for order in found if is_ripple(order) == (effect == RIPPLE)]
        values = evaluated(some, rows)
        least = criteria.LEAST_STRENGTH * (1.0 if effect == RIPPLE else criteria.NAMELESS)
        if some and active_size(values, compared) >= least * floor:
            out.append(_of_torque(effect, some, values, ratio))
    return out


def _of_torque(effect: str, found: Sequence[SwingOrder], values: FloatArray, ratio: float) -> Discovery:
    orders = sorted(found, key=lambda order: -np.hypot(order.wave.cosine, order.wave.sine))
    by_size = [order.wave for order in orders]
    first, p_value = by_size[0], max(order.p_value for order in found)
    size, std = float(np.hypot(first.cosine, first.sine)), first.cosine_std
    over, form = ("q", {}) if ratio == 1.0 else ("theta", {"form": "ripple"})
    named = "tau_m += a_rc*cos(n*u*theta) + a_rs*sin(n*u*theta), a_r = sqrt(a_rc**2 + a_rs**2)"
    return Discovery(
        effect=effect,
        status=NAMED if effect == RIPPLE else UNKNOWN,
        confidence=probability(p_value),
        channel=MOTOR_TORQUE,
        words=LIBRARY[RIPPLE].name if effect == RIPPLE else f"order {first.order:g} of the output",
        equation=named if effect == RIPPLE else equation(by_size[:MOST_WAVES], over),
        variables=("angle",),
        parameters=(
            parameter("a_r", size, "N*m", std),
            parameter("a_rc", first.cosine, "N*m", std),
            parameter("a_rs", first.sine, "N*m", std),
            parameter("n", first.order / ratio, "1", orders[0].std / ratio),
        ),
        added=values,
        gain=float(sum(order.gain for order in found)),
        p_value=p_value,
        simulation_rows=(
            {"effect": effect, **form, "channels": [MOTOR_TORQUE], "waves": [w.to_json() for w in by_size]},
        ),
        orders=tuple(w.order for w in by_size),
        numbers=2 * len(by_size),
    )


def _discovery(found: Sequence[SwingOrder], values: FloatArray, names: Sequence[str]) -> Discovery:
    by_size = sorted(found, key=lambda order: -np.hypot(order.wave.cosine, order.wave.sine))
    effect, *others = names
    of_shaft = by_size[0].of_shaft
    # the same waves: nothing that was recorded differs between them
    alternatives = tuple(
        RefittedAlternative(name, LIBRARY[name].name, np.inf, np.inf, np.nan, True, of_fitted=True) for name in others
    )
    table = tuple(
        {
            "order": order.wave.order,
            "amplitude": float(np.hypot(order.wave.cosine, order.wave.sine)),
            "unit": "rad",
            "std": order.wave.cosine_std,
            "part": "motor shaft" if of_shaft else "output",
            "depends_on": "nothing",
        }
        for order in by_size
    )
    first, p_value = by_size[0].wave, max(order.p_value for order in found)
    return Discovery(
        effect=effect,
        status=AMBIGUOUS if others else NAMED,
        confidence=probability(p_value),
        channel=TRANSMISSION_ERROR,
        words=LIBRARY[effect].name,
        equation=f"{WAVE}{OF_MOTOR if of_shaft else ''}, a = sqrt(c**2 + s**2)",
        variables=("angle",),
        parameters=(
            parameter("f", first.order, "1", by_size[0].std),
            parameter("a", float(np.hypot(first.cosine, first.sine)), "rad", first.cosine_std),
            parameter("c", first.cosine, "rad", first.cosine_std),
            parameter("s", first.sine, "rad", first.sine_std),
        ),
        added=values,
        gain=float(sum(order.gain for order in found)),
        p_value=p_value,
        simulation_rows=(
            {"effect": effect, "channels": [TRANSMISSION_ERROR], "waves": [o.wave.to_json() for o in by_size]},
        ),
        alternatives=alternatives,
        orders=tuple(o.wave.order for o in by_size),
        table=table,
        numbers=2 * len(by_size),
    )
