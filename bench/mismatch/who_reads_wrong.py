"""Whether the torque sensor or the load motor is wrong where the two differ: the motor torque tells.

The load torque is compared with what the load motor reports. What is found between them may be an error of either. The
input motor drives the real load: with an error of the sensor its torque is explained better once that is taken off the
torque that was read, with an error of the load motor's report once it is not. What has no name may as well be a load,
such as a hose that is dragged along: where the load is kept at a level, and taken as its mean, the motor torque shows
it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import ChannelOutcome, Discovery
from bench.mismatch.given import ACTS_ON, LOAD_MOTOR, REPORTED_BY, SENSOR, SHAFT, Given, Known
from bench.mismatch.prediction import corrected
from bench.mismatch.problems import problem_of
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.regression.folds import DRAWS, predictive, weights
from bench.mismatch.regression.model import plain_residual
from bench.mismatch.regression.prior import calibrated_alone
from bench.mismatch.regression.problem import BaseTerm, ChannelProblem, starts_and_folds
from bench.mismatch.regression.regressors import UNKNOWN
from bench.mismatch.regression.search import searched
from bench.simulation.frame import FloatArray
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE


def of_load_motor(
    data: Dataset, given: Given, found: Sequence[Known], seed: int = 0, banned: Sequence[str] = ()
) -> float | None:
    """Probability that the motor torque is explained better with the load torque as it was read than less the errors of
    its sensor among what was ``found`` beside the simulation ``given``, had the points left out been drawn again; None
    where that may be chance, or cannot be asked.

    It is asked of the simulation alone, and then beside what each idea finds in the motor torque: where something else
    is missing there, an error of the sensor may make up for some of it. ``banned`` effects are not looked for.
    """
    if not any(k.misread for k in found):
        return None
    first = _better(data, given, as_reported(found), found)
    searching = partial(_searched, seed=seed)
    return None if first is None else _better(data, given, as_reported(found), found, searching, banned)


def of_shaft(data: Dataset, given: Given, found: Sequence[Known], nameless: Sequence[Known]) -> float | None:
    """Probability that the motor torque is explained better with a ``nameless`` function of the load torque as a load
    than without it, beside what was ``found`` there; None where that may be chance, or cannot be asked. Only where the
    load is kept at a level, and taken as its mean, do the two differ: elsewhere the sensor has read such a load.
    """
    return _better(data, given, [*found, *on_shaft(nameless)], found)


Effects = Callable[[ChannelProblem], "tuple[Sequence[BaseTerm], float]"]
"""what is fitted in a motor torque beside its simulation, and what saying it costs, in log density"""


def _none(_problem: ChannelProblem) -> tuple[Sequence[BaseTerm], float]:
    return (), 0.0


def _searched(problem: ChannelProblem, seed: int) -> tuple[Sequence[BaseTerm], float]:
    """What a search finds, at the price of each effect."""
    search = searched(problem, seed)
    model = search.model
    found = [BaseTerm(b.regressor, tuple(b.precision)) for chosen in model.chosen for b in chosen.blocks]
    search.close()
    return found, model.price * len(model.chosen)


def _better(
    data: Dataset,
    given: Given,
    first: Sequence[Known],
    second: Sequence[Known],
    effects: Effects = _none,
    banned: Sequence[str] = (),
) -> float | None:
    """Probability that the motor torque is explained better with the ``first`` of two ideas of the load torque than
    with the ``second``, beside the simulation ``given`` and ``effects``, had the points left out been drawn again; None
    where that may be chance, or cannot be asked.
    """
    rows = data.rows.get(MOTOR_TORQUE)
    if rows is None or MOTOR_TORQUE in data.simulated or data.folder.manner.free:
        return None
    before = given.known.get(LOAD_TORQUE, ())
    frames = [corrected(rows.frame, [*before, *idea]) for idea in (first, second)]
    problems = [problem_of(data, given, MOTOR_TORQUE, replace(rows, frame=frame), banned) for frame in frames]
    beside = [effects(problem) for problem in problems]
    problems = [replace(p, base=(*p.base, *terms)) for p, (terms, _) in zip(problems, beside, strict=True)]
    residual = plain_residual(problems[0])
    densities: list[FloatArray] = []
    for problem, (_, cost) in zip(problems, beside, strict=True):
        bank, blocks, fit = calibrated_alone(problem, residual)
        folds = starts_and_folds(problem.rows.take(problem.train).frame, problem.folds)[1]
        density = predictive(bank, blocks, folds, fit.variance)
        densities.append(density - cost / density.size)
    probability = float(weights(np.array(densities), 0)[0])
    return probability if probability >= 1.0 - criteria.ERROR_RATE else None


def on_shaft(nameless: Sequence[Known]) -> list[Known]:
    """What has no name in the load torque as a load that turns the shaft."""
    return [replace(k, on_shaft=True) for k in nameless]


def as_reported(found: Sequence[Known]) -> list[Known]:
    """What was ``found`` in the load torque with the errors in it as those of the load motor's report."""
    return [replace(k, of_load_motor=True) if k.misread else k for k in found]


def mark(outcome: ChannelOutcome, probability: float) -> None:
    """Say in an outcome of the load torque, and in the rows of its simulation, that the load motor's report is off."""
    outcome.notes.append(
        "the torque sensor reads right and the torque that the load motor reports is off: the motor torque of points "
        f"left out is predicted better with the load torque as read (probability {_likely(probability)})"
    )
    _say(outcome, lambda found: found.effect.startswith(SENSOR), {REPORTED_BY: LOAD_MOTOR})


def _likely(probability: float) -> str:
    """A probability in words, no closer to 1 than draws can tell."""
    highest = 1.0 - 1.0 / DRAWS
    return f"{probability:.3f}" if probability < highest else f"above {highest:.4g}"


def mark_load(outcome: ChannelOutcome, words: str, probability: float) -> None:
    """Say in an outcome of the load torque, and in the rows of its simulation, that a function without a name, called
    ``words``, is a load.
    """
    outcome.notes.append(
        f"{words} in the load torque is a load that turns the shaft: the motor torque of points left out is predicted"
        f" better with it as a load (probability {_likely(probability)})"
    )
    _say(outcome, lambda found: found.effect == UNKNOWN and found.words == words, {ACTS_ON: SHAFT})


def _say(outcome: ChannelOutcome, of: Callable[[Discovery], bool], key: dict[str, str]) -> None:
    """Put a ``key`` to the rows of the simulation that some discoveries of an outcome have."""
    for number, found in enumerate(outcome.discoveries):
        if of(found):
            rows = tuple(dict(row) | key for row in found.simulation_rows)
            outcome.discoveries[number] = replace(found, simulation_rows=rows)
