"""From a law that the amplitudes of the orders follow to a discovery: what it adds, its words, its parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import AMBIGUOUS, NAMED, UNKNOWN, Discovery, RefittedAlternative
from bench.mismatch.equations import renamed
from bench.mismatch.orders.laws import FoundLaw
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.periodic import Periodic
from bench.mismatch.orders.reported import Row, parameter, probability, strong
from bench.mismatch.regression.windows import strongest
from bench.simulation.frame import FloatArray, IntArray
from bench.simulation.laws import EACH, MODES, RESONANCE, Law
from bench.simulation.terms import LIBRARY, TRANSMISSION_ERROR

RESONANT = {
    "second_order": "A_f -> A_f*(1 + p*(H(f*dtheta) - 1)), H(w) = 1/(1 - (w/w_0)**2 + 2j*zeta*w/w_0)",
    "second_order_of_base_each": "A_f -> A_f*(1 + e_f*r**2*H(r)), H(r) = 1/(1 - r**2 + 2j*zeta*r), r = f*dtheta/w_0",
    "second_order_unsigned": "A_f -> A_f*(1 + p*(H(f*abs(dtheta)) - 1)), the same phase in both directions, "
    "H(w) = 1/(1 - (w/w_0)**2 + 2j*zeta*w/w_0)",
    "second_order_of_base": "A_f -> A_f*(1 + p*r**2*H(r)), H(r) = 1/(1 - r**2 + 2j*zeta*r), r = f*dtheta/w_0",
}
OF_A_MODE: Sequence[tuple[str, str]] = (("w_0", "rad/s"), ("zeta", "1"))
"""symbols and units of a mode's numbers"""
FACTOR = "order f: A_f -> A_f*(1 + e_f*g), g = {}"
_UNITS = {"speed": "rad/s", "temperature": "degC", "torque": "N*m"}


def of_one_recording(energy: FloatArray, recording: IntArray) -> bool:
    """Whether the ``energy`` (n,) of a law is that of one recording, which no other bears out."""
    each = np.bincount(recording, energy)
    return bool(each.max() > criteria.CANNOT_BE_SPARED * each.sum())


def of_law(model: TransmissionModel, found: FoundLaw, before: Periodic) -> Discovery | None:
    """A law that the amplitudes follow; ``before``: what is periodic without it, calibrated."""
    assert model.periodic is not None
    frame, law = model.rows.frame, found.law
    values = np.asarray(model.periodic.evaluate(frame) - before.evaluate(frame))
    if not strong(model, values):
        return None
    excess, everywhere = _beyond(model, law)
    if of_one_recording(model.compared * excess**2, frame.recording):
        return None
    quantity = law.variables[0]
    alternatives = tuple(
        RefittedAlternative.of_revolutions(other.effect, _law_words(other), loss, error, share)
        for other, loss, error, share in found.alternatives
    )
    real = probability(found.p_value)
    status, share = status_of(law.effect, found.share, alternatives)
    touched = _moved(model, before, law.orders)
    return Discovery(
        effect=law.effect,
        status=status,
        confidence=None if real is None else real * share,
        channel=TRANSMISSION_ERROR,
        words=_law_words(law, touched),
        equation=RESONANT[law.form] if law.effect == RESONANCE else FACTOR.format(law.equation()),
        variables=(quantity,),
        parameters=tuple(_law_parameters(found)),
        added=values,
        gain=law.gain,
        p_value=found.p_value,
        simulation_rows=({"effect": law.effect, "channels": [TRANSMISSION_ERROR], "law": law.to_json()},),
        alternatives=alternatives,
        orders=touched,
        numbers=len(law.point) + (0 if law.form in MODES else 2 * len(law.orders)),
        excess=excess,
        everywhere=everywhere,
    )


def status_of(effect: str, share: float, alternatives: Sequence[RefittedAlternative]) -> tuple[str, float]:
    """Status of an effect that has a ``share`` of the likelihood among its alternatives, and the share that its status
    rests on: of an ambiguous one those of the names that are not told apart from it with it.
    """
    if effect not in LIBRARY:
        return UNKNOWN, share
    names = [other.weight for other in alternatives if other.as_good and other.effect in LIBRARY]
    return (AMBIGUOUS, share + sum(names)) if names else (NAMED, share)


def _beyond(model: TransmissionModel, law: Law) -> tuple[FloatArray, FloatArray]:
    """What a law adds at the model's rows (n,) beyond the simulation recalibrated: on the samples that are compared,
    and on all that are recorded.
    """
    assert model.periodic is not None
    frame = model.rows.frame
    numbers = [model.compared, model.recorded]
    excess, everywhere = model.periodic.beyond_series(law, frame, numbers, model.given.orders)
    if law.effect != RESONANCE:
        return excess, everywhere
    swinging = model.periodic.swinging(frame)
    return excess + swinging, everywhere + swinging


def further(model: TransmissionModel, first: Discovery, second: Discovery) -> Discovery:
    """A law and a second one of the same effect, the model's last two, as one discovery."""
    assert model.periodic is not None
    before, last = model.periodic.laws[-2:]
    # orders that a pulse has drawn are none any more
    remaining = [f for f in dict.fromkeys((*before.orders, *last.orders)) if f in model.periodic.series.orders]
    both = replace(last, orders=tuple(remaining))
    excess, everywhere = _beyond(model, both)
    names = {str(row["symbol"]): f"{row['symbol']}_2" for row in second.parameters}
    parameters = tuple({**row, "symbol": names[str(row["symbol"])]} for row in second.parameters)
    return replace(
        first,
        added=first.added + second.added,
        excess=excess,
        everywhere=everywhere,
        gain=first.gain + second.gain,
        equation=f"{first.equation}; {renamed(second.equation, names)}",
        parameters=first.parameters + parameters,
        simulation_rows=first.simulation_rows + second.simulation_rows,
        orders=first.orders + tuple(f for f in second.orders if f not in first.orders),
        numbers=first.numbers + second.numbers,
    )


def _law_words(law: Law, orders: Sequence[float] = ()) -> str:
    if law.effect in LIBRARY:
        return LIBRARY[law.effect].name
    return f"{law.form}: orders {', '.join(f'{f:g}' for f in (orders or law.orders)[:6])}"


def _moved(model: TransmissionModel, before: Periodic, orders: Sequence[float]) -> tuple[float, ...]:
    """Orders that a law changes most: those with nine tenths of the squares, the most first."""
    assert model.periodic is not None
    now = model.periodic.at_revolutions(model.training_revolutions, orders)
    then = before.at_revolutions(model.training_revolutions, orders)
    return tuple(float(orders[k]) for k in strongest(np.sum(np.abs(now - then) ** 2, axis=0)))


def _law_parameters(found: FoundLaw) -> list[Row]:
    law = found.law
    if law.form in MODES:
        of_mode = (*OF_A_MODE, ("p", "1"))
        return [
            parameter(symbol, value, unit, std)
            for (symbol, unit), value, std in zip(of_mode, law.point, found.std, strict=True)
        ]
    unit = _UNITS.get(law.variables[0], "1")
    numbers = [(f"g_{k + 1}", unit) for k in range(len(law.point))]
    names = OF_A_MODE if law.form in EACH else numbers
    out = [parameter(symbol, value, of, None) for (symbol, of), value in zip(names, law.point, strict=True)]
    strongest = int(np.argmax(np.abs(law.strength)))
    std = float(found.strength_std[strongest])
    out.append(parameter("f", law.series[strongest], "1", None))
    return [*out, parameter("e_f", float(np.abs(law.strength[strongest])), "1", std)]
