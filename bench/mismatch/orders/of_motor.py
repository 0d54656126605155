"""Which orders are the motor encoder's: it misreads its disc alike in every revolution of the motor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import binom

from bench.mismatch import criteria
from bench.mismatch.orders.between import is_between
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.revolutions import Complex
from bench.mismatch.orders.sight import Sight
from bench.mismatch.orders.under_mode import passes
from bench.mismatch.recordings.late import lag_of

MOSTLY = 0.9
"""share of an order's energy that one vector holds, from which a further multiple of the ratio is the encoder's as
well: what a report calls a place holds as much
"""


def multiples(orders: Sequence[float], ratio: float) -> tuple[float, ...]:
    """Those of the orders that are multiples of the ratio: the motor turns so."""
    return tuple(f for f in orders if ratio > 1.0 and _multiple(f, ratio))


def of_motor(model: TransmissionModel, sight: Sight, ratio: float) -> tuple[float, ...]:
    """Found orders that are the motor encoder's and not the gearbox's.

    Where the motor's torque says whose they are, those of which it says so. Of the others the multiples of the ratio
    that have one vector whatever the direction, load, speed, temperature; and, where there is such an order, further
    multiples that are nearly so: a disc has several. A gearbox full of weak orders may have one there by chance; then
    nothing says that it is the encoder's, and a note says what it may be.
    """
    whole = [m.order for m in model.torque_check.found if not m.beside]
    left = [f for f in multiples(sight.found, ratio) if f not in model.torque_check.orders]
    if model.laws:
        left = [f for f in left if not passes(model, sight.stage, f)]
    constant = [f for f in left if _constant(model, sight, f)]
    if constant and not whole:
        by_chance = chance(model, sight, constant, ratio)
        if by_chance > criteria.ERROR_RATE:
            _note(model, constant, by_chance)
            constant = []
    further = [f for f in left if f in constant or (constant and _share_of_mean(model, sight, f) >= MOSTLY)]
    return tuple(f for f in sight.found if f in whole or f in further)


def chance(model: TransmissionModel, sight: Sight, orders: Sequence[float], ratio: float) -> float:
    """Chance that weak orders of the gearbox lie on as many multiples of the ratio as ``orders`` are and are as large,
    or on one and as large as the largest of them: by how densely the other constant orders lie, and how large they are.
    """
    whole = [f for f in sight.found if not is_between(f)]
    others = [f for f in whole if not _multiple(f, ratio) and _constant(model, sight, f)]
    highest = max(sight.found)
    known = [f for f in sight.known if f <= highest]
    places = int(highest) - len(known)
    asked, sizes = (np.array([_size(model, sight, f) for f in some]) for some in (orders, others))
    possible = int(highest / ratio) - len(multiples(known, ratio))

    def tail(number: int, least: float) -> float:
        larger = (1.0 + float(np.sum(sizes >= least))) / (1.0 + sizes.size)
        return float(binom.sf(number - 1, possible, min(sizes.size / places * larger, 1.0)))

    return min(tail(len(orders), float(asked.min())), tail(1, float(asked.max())))


def _note(model: TransmissionModel, orders: Sequence[float], by_chance: float) -> None:
    """Say in a model's notes that orders may be the encoder's; once."""
    several = "orders" if len(orders) > 1 else "order"
    named = " and ".join(f"{f:g}" for f in orders)
    note = (
        f"transmission_error: {several} {named} may be the motor encoder's; of so many weak orders the gearbox has one"
        f" there by chance, as large, with probability {by_chance:.2g}"
    )
    if note not in model.notes:
        model.notes.append(note)


def _multiple(order: float, ratio: float) -> bool:
    return round(order / ratio) >= 1 and not is_between(order / ratio)


def _constant(model: TransmissionModel, sight: Sight, order: float) -> bool:
    """Whether an order has one vector, whatever the state: the plainest model of it is the best, as it is or with its
    phase turned back by the speed. Moments at which two encoders are read differ a little.
    """
    vectors = sight.at(model, order)
    # a lag is looked for only where one is needed
    as_it_is = sight.gains(vectors, order)[1] == 0
    return as_it_is or sight.gains(_turned_back(vectors, sight, order), order)[1] == 0


def _turned_back(vectors: Complex, sight: Sight, order: float) -> Complex:
    """Vectors (revolutions,) of an order read so much later that they are nearest to one: a moment turns them by order
    times speed.
    """
    speed = np.array([r.velocity for r in sight.stage.revolutions])
    late = lag_of(vectors[:, None], 1.0 / sight.stage.scale, speed, [order])
    return np.asarray(vectors * np.exp(-1j * late * speed * order))


def _size(model: TransmissionModel, sight: Sight, order: float) -> float:
    """Size of the mean of an order's vectors over the training revolutions."""
    scale = sight.stage.scale
    return abs(complex(np.sum(sight.at(model, order) / scale) / np.sum(1.0 / scale**2)))


def _share_of_mean(model: TransmissionModel, sight: Sight, order: float) -> float:
    """Share of an order's energy over all revolutions, less that of noise, which one vector holds."""
    whole, of_mean = _energies(model, sight, order)
    return of_mean / whole if whole > 0.0 else 0.0


def _energies(model: TransmissionModel, sight: Sight, order: float) -> tuple[float, float]:
    """Energy of an order over all revolutions, and that which one vector holds, both less that of noise."""
    vectors, scale = sight.at(model, order), sight.stage.scale
    noise = 2.0 * sight.noise(order) ** 2
    whole = float(np.sum(np.abs(vectors) ** 2)) - noise * vectors.size
    return whole, _size(model, sight, order) ** 2 * float(np.sum(1.0 / scale**2)) - noise
