"""What is periodic in the transmission error and not in its simulation, as discoveries.

Plain orders come first. Then hypotheses that say the same with less, or more with a structure of their own: pulses at
fixed angles, laws that the amplitudes follow, errors of the motor's encoder, sidebands. What none of them explains
stays one list of orders, ``te.harmonic``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import UNNAMED, Discovery
from bench.mismatch.orders import defects, laws, modulation
from bench.mismatch.orders.borne_out import borne_out
from bench.mismatch.orders.calibrating import with_parts
from bench.mismatch.orders.misread import ENCODER, Misread
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.of_motor import of_motor
from bench.mismatch.orders.periodic import Periodic
from bench.mismatch.orders.reported import (
    AMPLITUDE,
    MOVES_NOTHING,
    modulation_parameters,
    of_encoder,
    of_orders,
    of_pulses,
    order_p_value,
    probability,
)
from bench.mismatch.orders.reported_law import further, of_law
from bench.mismatch.orders.sight import Sight, rebuilt
from bench.mismatch.orders.under_mode import PassedMode, beside, hides, under
from bench.simulation import Gearbox
from bench.simulation.laws import MODES, RESONANCE
from bench.simulation.terms import LIBRARY, TRANSMISSION_ERROR

PAIR = ", ".join(
    [
        LIBRARY["te.sideband"].forms[TRANSMISSION_ERROR][0].equation,
        *(AMPLITUDE.format(side) for side in ("_lower", "_upper")),
    ]
)
OF_AN_ORDER = (UNNAMED, "te.temperature_nonlinear", "te.velocity_nonlinear")
"""laws that say how amplitudes change with the state: of an order that the simulation has not, that is no effect of its
own
"""
ANGLES = 8192
"""of a revolution, at which the sum of orders is looked at"""
MOST_LAWS = 2
"""of one effect"""


class Teeth(Protocol):
    """A gearbox as headers have it."""

    @property
    def ratio(self) -> float | None:
        """Gear ratio u."""
        ...

    @property
    def z1(self) -> int | None:
        """Teeth of the input gear."""
        ...

    @property
    def z2(self) -> int | None:
        """Teeth of the planets' spur gears."""
        ...

    @property
    def z3(self) -> int | None:
        """Lobes of the cycloid discs."""
        ...

    @property
    def z4(self) -> int | None:
        """Pins."""
        ...


def discoveries(model: TransmissionModel, gearbox: Teeth, seed: int) -> list[Discovery]:
    """Everything periodic in the transmission error beyond the simulation; ``model.periodic`` then holds it.

    ``model`` has been through :func:`bench.mismatch.orders.turns.analyse`.
    """
    if Sight.of(model) is None:
        return []
    teeth = Gearbox(float(gearbox.ratio or 1.0), gearbox.z1, gearbox.z2, gearbox.z3, gearbox.z4)
    out: list[Discovery | None] = []
    before = replace(model)
    mode = _mode(model, seed)
    found_defects, pulses, law = _under(model, mode, seed)
    if mode is not None and law is None:
        # too weak to be told: nothing else is told beside it
        model.restore(before)
        found_defects, pulses, law = _under(model, None, seed)
    sight = Sight.of(model)
    assert sight is not None
    law = _law(model, seed, law)
    parts = _encoders_parts(model, sight)
    shaft = of_motor(model, sight, teeth.ratio)
    encoder = _encoder(model, sight, shaft, teeth)
    rest = [f for f in sight.found if encoder is None or f not in shaft]
    encoder = _borne_out(model, encoder)
    pair = modulation.search(model, sight, (*shaft, *(m.order for m in parts)), seed)
    if pair is not None:
        first = pair.pairs[0]
        extra = {
            "words": f"order {first.carrier:g} modulated {first.modulation:g} times a revolution",
            "parameters": modulation_parameters(model, sight, pair),
            "equation": PAIR,
        }
        confidence = probability(pair.p_value)
        sidebands = of_orders(model, sight, "te.sideband", pair.orders, teeth, pair.p_value, confidence, extra)
        if sidebands is not None:
            rest = [f for f in rest if f not in pair.orders]
        out.append(_borne_out(model, sidebands))
    plain = _plain(model, sight, rest, teeth)
    if parts and plain is None:
        # what the gearbox has beside them is too weak to be told
        model.torque_check = replace(
            model.torque_check, found=tuple(replace(m, beside=False) for m in model.torque_check.found)
        )
        encoder = _borne_out(model, _encoder(model, sight, of_motor(model, sight, teeth.ratio), teeth))
    elif parts:
        encoder = _with_its_parts(model, encoder, parts)
    if law is not None and plain is not None and _of_new_orders(law, plain):
        # how an order that the simulation has not changes with the state is a property of that order
        plain = replace(
            plain, simulation_rows=plain.simulation_rows + law.simulation_rows, numbers=plain.numbers + law.numbers
        )
        law = None
    if pulses is not None and plain is not None and _of_pulses(sight, found_defects, plain.orders):
        pulses = replace(
            pulses,
            words=f"{pulses.words}, whose form {len(plain.orders)} orders complete",
            added=pulses.added + plain.added,
            simulation_rows=pulses.simulation_rows + plain.simulation_rows,
            numbers=pulses.numbers + plain.numbers,
        )
        plain = None
    return [d for d in (law, pulses, encoder, *out, plain) if d is not None]


def _under(
    model: TransmissionModel, mode: PassedMode | None, seed: int
) -> tuple[list[defects.Defect], Discovery | None, Discovery | None]:
    """Damaged places that stand in the revolutions, those that are told as a discovery, and the ``mode`` as another."""
    sight = Sight.of(model)
    assert sight is not None
    pulses = None
    found_defects = defects.search(sight, seed)
    if found_defects:
        pulses, mode = _pulses(model, found_defects, mode)
    return found_defects, pulses, None if mode is None else of_law(model, *mode)


def _pulses(
    model: TransmissionModel, found_defects: Sequence[defects.Defect], mode: PassedMode | None
) -> tuple[Discovery | None, PassedMode | None]:
    """Defects as a discovery, the model calibrated with them, and a ``mode`` as it is beside them; None, and the model
    as it was, where they are weak or recordings held out contradict them.
    """
    if mode is not None:
        return _pulses_beside(model, found_defects, mode)
    before = replace(model)
    rebuilt(model, defects.all_pulses(found_defects))
    found = _told(model, found_defects)
    if found is None:
        # orders that the pulses had drawn are there again, as they were found
        model.restore(before)
    return found, None


def _pulses_beside(
    model: TransmissionModel, found_defects: Sequence[defects.Defect], mode: PassedMode
) -> tuple[Discovery | None, PassedMode]:
    """The same beside a mode."""
    before = replace(model)
    with_them = beside(model, mode[0], defects.all_pulses(found_defects))
    found = None if with_them is None else _told(model, found_defects)
    if found is None or with_them is None:
        model.restore(before)
        return None, mode
    return found, with_them


def _told(model: TransmissionModel, found_defects: Sequence[defects.Defect]) -> Discovery | None:
    """Defects of a model that has their pulses, as a discovery; None where they are weak or recordings held out
    contradict them.
    """
    found = of_pulses(model, found_defects)
    assert model.periodic is not None
    # against nothing in their place: orders that draw them predict as well
    return found if found is not None and _holds(model, found, replace(model.periodic, pulses=())) else None


def _of_pulses(sight: Sight, found_defects: Sequence[defects.Defect], orders: Sequence[float]) -> bool:
    """Whether orders are what the form of pulses leaves of nature's: of the energy of their sum, less what would lie
    there by chance, most lies at the places of the pulses, within half their width of these. Orders of a gearbox act
    over all of the revolution.
    """
    whole = [round(f) for f in orders if f == round(f)]
    if len(whole) < len(orders):
        return False
    table = np.zeros(ANGLES // 2 + 1, dtype=np.complex128)
    table[whole] = sight.mean[whole].imag - 1j * sight.mean[whole].real
    course = np.fft.irfft(table, ANGLES)
    inside = defects.near_defects(found_defects, np.arange(ANGLES, dtype=np.float64) * (2.0 * np.pi / ANGLES), 1.0)
    share, chance = float(np.sum(course[inside] ** 2) / np.sum(course**2)), float(np.mean(inside))
    return share - chance > 0.5 * (1.0 - chance)


def _of_new_orders(law: Discovery, plain: Discovery) -> bool:
    """Whether a law only says how orders change that the simulation has not."""
    return law.effect in OF_AN_ORDER and set(law.orders) <= set(plain.orders)


def _mode(model: TransmissionModel, seed: int) -> PassedMode | None:
    """A mode that orders pass which the simulation has not: they are looked for under it, before anything else is; the
    model then holds both.
    """
    found = laws.search(model, seed)
    if found is None or found.law.form not in MODES or not _sure(found) or not hides(model, found):
        return None
    before = model.periodic
    assert before is not None
    joined = laws.joined(before.series, found.series)
    plain = with_parts(model, replace(before, series=joined, laws=(*before.laws, found.law)))
    return under(model, found, plain)


def _law(model: TransmissionModel, seed: int, first: Discovery | None) -> Discovery | None:
    """A law that the amplitudes follow, the series calibrated under it; and a second of the same effect, where what is
    left follows one: a frame has more than one mode, and no function of speed need be one of the library. ``first``:
    a mode that the model has already.
    """
    out = first
    for number in range(0 if first is None else 1, MOST_LAWS):
        found = laws.search(model, seed + number)
        if found is None or not _sure(found) or (out is not None and found.law.effect != out.effect):
            break
        before = model.periodic
        assert before is not None
        joined = laws.joined(before.series, found.series)
        model.periodic = with_parts(model, replace(before, series=joined, laws=(*before.laws, found.law)))
        # a mode may be the leakage of a tone or of orders, and a law without a name claims nothing but that it predicts
        doubtful = found.law.effect in (UNNAMED, RESONANCE)
        described = of_law(model, found, before) if borne_out(model, before, model.periodic, doubtful) else None
        if described is None:
            model.periodic = before
            break
        out = described if out is None else further(model, out, described)
    return out


def _sure(found: laws.FoundLaw) -> bool:
    """Whether some order's strength stands above its own uncertainty; of a resonance, whether its natural frequency is
    told from nothing: orders that change in whatever way are no resonance.
    """
    size = np.abs(found.law.strength)
    measured = found.strength_std > 0.0
    if found.law.form in MODES and found.std:
        return found.law.point[0] > criteria.TOLD * found.std[0]
    if found.law.form in MODES or not measured.any():
        return True
    return bool(np.max(size[measured] / found.strength_std[measured]) > criteria.SURE)


def _encoder(model: TransmissionModel, sight: Sight, shaft: Sequence[float], teeth: Gearbox) -> Discovery | None:
    """Orders that are the motor encoder's as a whole."""
    if not shaft:
        return None
    words = {"words": "the motor's encoder: multiples of the ratio, the same at every load, speed and temperature"}
    by_reaction = [m for m in model.torque_check.found if m.order in shaft]
    if by_reaction:
        p_value: float | None = min(m.p_value for m in by_reaction)
        words = {"words": MOVES_NOTHING}
    else:
        p_value = order_p_value(model, max(sight.gains(sight.at(model, f), f)[0] for f in shaft))
    return of_orders(model, sight, ENCODER, shaft, teeth, p_value, probability(p_value), words)


def _encoders_parts(model: TransmissionModel, sight: Sight) -> list[Misread]:
    """The encoder's parts of orders that the gearbox has as well, if they are strong enough to be told; the model then
    has no others. An order that a pulse or a law has taken since is no order any more.
    """
    parts = [m for m in model.torque_check.found if m.beside and m.order in sight.found]
    if of_encoder(model, parts, MOVES_NOTHING) is None:
        parts = []
    model.torque_check = replace(
        model.torque_check, found=tuple(m for m in model.torque_check.found if not m.beside or m in parts)
    )
    return parts


def _with_its_parts(model: TransmissionModel, encoder: Discovery | None, parts: Sequence[Misread]) -> Discovery | None:
    """The encoder's error with its parts of orders that the gearbox has as well."""
    found = of_encoder(model, parts, MOVES_NOTHING)
    if encoder is None or found is None:
        return encoder or found
    first, other = (encoder, found) if encoder.gain >= found.gain else (found, encoder)
    return replace(
        first,
        added=first.added + other.added,
        gain=first.gain + other.gain,
        simulation_rows=first.simulation_rows + other.simulation_rows,
        orders=first.orders + other.orders,
        table=first.table + other.table,
        numbers=first.numbers + other.numbers,
    )


def _plain(model: TransmissionModel, sight: Sight, orders: list[float], teeth: Gearbox) -> Discovery | None:
    if not orders:
        return None
    gain = max(sight.gains(sight.at(model, f), f)[0] for f in orders)
    p_value = order_p_value(model, gain)
    # with a model of noise that holds, the best of many orders at such a gain is real; an alternative is another name
    words = f"{len(orders)} orders that the simulation does not have" if len(orders) > 1 else ""
    extra = {"words": words} if words else {}
    return _borne_out(
        model, of_orders(model, sight, "te.harmonic", orders, teeth, p_value, probability(p_value), extra)
    )


def _borne_out(model: TransmissionModel, found: Discovery | None) -> Discovery | None:
    """A discovery of orders, if recordings held out bear it out; else None, and the model is without the orders: a
    tone, or whatever else has no order, is followed by some in the fitted recordings alone.
    """
    if found is None or model.periodic is None:
        return found
    without = model.periodic.less(found.orders)
    if _holds(model, found, without):
        return found
    model.periodic = without
    return None


def _holds(model: TransmissionModel, found: Discovery, before: Periodic | None) -> bool:
    """Whether recordings held out bear out a discovery, predicted ``before`` it and with it; a note if they do not."""
    if before is None or model.periodic is None or borne_out(model, before, model.periodic, False):
        return True
    model.notes.append(
        f"{found.words} gained in the fit, but recordings held out are predicted worse with it: it is not reported"
    )
    return False
