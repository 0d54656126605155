"""How strong an effect is beside a model, over the noise of a sample."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch import criteria
from bench.mismatch.regression.excess import levelled
from bench.mismatch.regression.model import ChannelModel, Chosen, fit_blocks
from bench.mismatch.regression.regressors import of_reading
from bench.simulation.frame import FloatArray, IntArray
from bench.simulation.heat_rates import HEATING
from bench.simulation.memory import integral
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE


@dataclass(frozen=True, slots=True)
class Strength:
    """Size of what an effect adds beyond the recalibrated simulation, over the noise of a sample: where it ``acts``
    (the smallest set of samples that holds nearly all of its energy, a fiftieth of all at least), and over ``all``
    samples.
    """

    acts: float
    overall: float
    trusted: float = 0.0
    """what no transducer of the channel is trusted with, over the noise of a sample"""

    @property
    def enough(self) -> bool:
        """Whether it is strong enough to be reported."""
        least = max(criteria.LEAST_STRENGTH, self.trusted)
        return self.acts >= least and self.overall >= criteria.LEAST_OVERALL


def strength(model: ChannelModel, candidate: Chosen) -> Strength:
    """How strong an effect is beside the model."""
    problem = model.problem
    train = problem.train
    fitted = fit_blocks(model.bank, model.blocks([*model.chosen, candidate]), model.variances)
    course = model.contribution(candidate, problem.rows.frame, fitted)[train]
    beyond = model.calibration.beyond(course)
    if not of_reading(candidate.main.regressor):
        return size_of(model, beyond)
    # a recording's temperature begins at a level of its own: only how the reading shifts within it is seen
    size = size_of(model, levelled(beyond, problem.rows.frame.take(train), problem.rows.number[train]))
    return replace(size, trusted=max(size.trusted, criteria.SELF_HEATING_K / max(model.floor, 1e-300)))


def added(model: ChannelModel, candidate: Chosen) -> Strength:
    """How much what the model says changes by an effect, the others fitted again: nothing where one of them says the
    same already.
    """
    both = [*model.chosen, candidate]
    frame, train = model.problem.rows.frame, model.problem.train
    change = model.predict(frame, both, model.refitted(both)) - model.predict(
        frame, model.chosen, model.refitted(model.chosen)
    )
    return size_of(model, np.asarray(change[train]))


def size_of(model: ChannelModel, beyond: FloatArray) -> Strength:
    """Strength of what an effect adds to the rows of the fit (n,)."""
    number = model.problem.rows.number[model.problem.train]
    floor = max(model.floor, 1e-300)
    overall = float(np.sqrt(np.sum(beyond**2 * number) / max(float(number.sum()), 1.0)))
    return Strength(active_size(beyond, number) / floor, overall / floor, trusted(model) / floor)


def trusted(model: ChannelModel) -> float:
    """What no transducer of a torque is trusted with in these recordings: N·m in a torque, in the temperature the K by
    which such a torque at the output would warm the gearbox, beyond what the recalibrated simulation makes of it; 0 in
    the transmission error. Nor is more said of the load torque than the rounding of the load motor's torque lets it.
    """
    problem = model.problem
    frame = problem.rows.frame
    if problem.channel == TEMPERATURE:
        heating = next((block for block in model.base if block.regressor.effect == HEATING), None)
        if heating is None:
            return 0.0
        capacity = 1.0 / max(float(model.fit.of(heating.indices)[0][0]), 1e-300)
        rate = criteria.TRANSDUCER * _largest(frame.torque, problem.usable) * np.abs(frame.velocity) / capacity
        course = integral(rate, frame)[problem.train]
        return active_size(model.calibration.beyond(course), problem.rows.number[problem.train])
    values = {LOAD_TORQUE: frame.torque, MOTOR_TORQUE: frame.motor_torque}.get(problem.channel)
    if values is None:
        return 0.0
    return max(criteria.TRANSDUCER * _largest(values, problem.usable), problem.unresolved)


def _largest(values: FloatArray, usable: NDArray[np.bool_]) -> float:
    return float(np.max(np.abs(values[usable]), initial=0.0))


def active_size(values: FloatArray, number: FloatArray) -> float:
    """Root mean square of ``values`` (n,), of ``number`` samples each, over the samples where they act,
    ``criteria.LEAST_ACTIVE`` of all samples at least.
    """
    acts = active(values, number)
    energy = float(number[acts] @ values[acts] ** 2)
    if energy <= 0.0:
        return 0.0
    samples = max(float(number[acts].sum()), criteria.LEAST_ACTIVE * float(number.sum()))
    return float(np.sqrt(energy / samples))


def active(values: FloatArray, number: FloatArray) -> IntArray:
    """Where ``values`` (n,), of ``number`` samples each, act: the fewest samples that hold
    ``criteria.ACTIVE_ENERGY`` of their energy. Their places (k,), the largest first; none where all are zero.
    """
    order = np.argsort(-(values**2))
    energy = np.cumsum(values[order] ** 2 * number[order])
    if energy.size == 0 or energy[-1] <= 0.0:
        return order[:0]
    return order[: min(int(np.searchsorted(energy, criteria.ACTIVE_ENERGY * energy[-1])), energy.size - 1) + 1]
