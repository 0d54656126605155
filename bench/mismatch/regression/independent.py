"""Whether what is left without an explanation may be what a name stands for: not if it depends on other quantities."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.bank import Fit
from bench.mismatch.regression.heredity import without
from bench.mismatch.regression.model import ChannelModel, Chosen, unrefined
from bench.mismatch.regression.regressors import Regressor, kinds
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import ABOUT_ZERO, ANGLE, REMEMBERED, made_of

KINDS: dict[str, frozenset[str]] = {
    "load": frozenset({"torque", "load", "load_motor_torque", "torque_rate", "torque_path"}),
    "speed": frozenset({"speed", "velocity", "speeding_up", "acceleration", "order_frequency"}),
    "angle": frozenset({ANGLE, ABOUT_ZERO}),
    "course": frozenset(
        {
            "temperature",
            "time",
            "travel",
            "seconds",
            "elapsed",
            "since_reversal",
            "distance_since_start",
            "transient",
            *REMEMBERED,
        }
    ),
}
"""quantities that go together in a campaign: what depends on one may pass for a function of another of its kind"""
MOST_SUBSTITUTES = 2
"""functions of other kinds of quantities that a name has to hold its gain beside"""


def beyond_noise(model: ChannelModel, chosen: Sequence[Chosen], fitted: Fit) -> float:
    """Mean square that some effects leave of the whitened rows, beyond that of noise, which is 1. In an integral the
    level at which each recording begins is free, and counts as nothing left.
    """
    bank = model.bank
    left = bank.residual([i for b in model.blocks(chosen) for i in b.indices], fitted.coefficients)
    if model.problem.spec.integral:
        left = bank.about_levels(left)
    return max(float(np.mean(left**2)) - 1.0, 0.0)


def much_is_left(model: ChannelModel) -> bool:
    """Whether a model leaves more of its rows than noise usually is."""
    return beyond_noise(model, model.chosen, model.fit) > criteria.MORE_THAN_NOISE**2 - 1.0


def beyond_floor(model: ChannelModel, left: FloatArray, number: FloatArray) -> bool:
    """Whether what is ``left`` of rows (n,) of ``number`` samples each is more than noise usually is, by what is known
    of the noise of a sample.
    """
    return (
        model.floor > 0.0
        and float(np.average(left**2, weights=number)) > (criteria.MORE_THAN_NOISE**2 - 1.0) * model.floor**2
    )


def independent(search: Search, chosen: Sequence[Chosen], one: Chosen) -> bool:
    """Whether what is left does not depend on what a name depends on: beside the name nothing else of its quantities
    gains what another form of it would, and beside functions of other quantities the name gains most of what it does
    without them. An unbalanced mass over the angle is no part of oil that flows back in time.
    """
    model = search.model
    kinds = kinds_of(one.main.regressor)
    if not kinds:
        return False
    others = without(chosen, one, model.problem.lacking)
    gain = float(search.density(chosen).sum() - search.to_be_beaten(others).sum())
    beside = search.scan(chosen, model.refitted(chosen)).gain
    others_alike = [b.regressor.effect != one.effect and bool(kinds & kinds_of(b.regressor)) for b in search.blocks]
    alike = beside[np.array(others_alike, dtype=bool)]
    if alike.max(initial=0.0) > criteria.SHAPE**2 * gain:
        return False
    instead = search.scan(others, model.refitted(others))
    substitutes = [
        unrefined(search.bank, search.blocks[k])
        for k in np.argsort(-instead.gain)
        if instead.gain[k] > instead.price and not kinds & kinds_of(search.blocks[k].regressor)
    ]
    for other in substitutes[:MOST_SUBSTITUTES]:
        held = float(search.density([*others, other, one]).sum() - search.to_be_beaten([*others, other]).sum())
        if held < criteria.EITHER * gain:
            return False
    return True


def kinds_of(regressor: Regressor) -> set[str]:
    """Which kinds of quantities (:data:`KINDS`) a regressor depends on."""
    parts = {part for name in kinds(regressor) for part in made_of(name)}
    return {kind for kind, members in KINDS.items() if members & parts}
