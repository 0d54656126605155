"""Whether the torque sensor or the load motor is wrong where the two differ: the motor torque tells.

The load torque is compared with what the load motor reports. What is found between them may be an error of either. The
input motor drives the real load: with an error of the sensor its torque is explained better once that is taken off the
torque that was read, with an error of the load motor's report once it is not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from bench.mismatch import criteria
from bench.mismatch.discovery import ChannelOutcome
from bench.mismatch.given import LOAD_MOTOR, REPORTED_BY, SENSOR, Given, Known
from bench.mismatch.prediction import corrected
from bench.mismatch.problems import problem_of
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.regression.folds import apart, predictive
from bench.mismatch.regression.model import plain_residual
from bench.mismatch.regression.prior import calibrated_alone
from bench.mismatch.regression.problem import starts_and_folds
from bench.simulation.frame import FloatArray
from bench.simulation.terms import MOTOR_TORQUE


def of_load_motor(data: Dataset, given: Given, known: Sequence[Known]) -> tuple[float, float] | None:
    """By how much log density of points left out the motor torque is explained better with the load torque as it was
    read than less the errors of its sensor among what is ``known``, and the standard error of that; None where that is
    no more than chance, or cannot be asked.
    """
    rows = data.rows.get(MOTOR_TORQUE)
    if rows is None or MOTOR_TORQUE in data.simulated or data.folder.manner.free:
        return None
    if not any(k.regressor.effect.startswith(SENSOR) for k in known):
        return None
    reads_right = [k for k in known if not k.regressor.effect.startswith(SENSOR)]
    frames = (corrected(rows.frame, reads_right), corrected(rows.frame, known))
    problems = [problem_of(data, given, MOTOR_TORQUE, replace(rows, frame=frame), ()) for frame in frames]
    residual = plain_residual(problems[0])
    densities: list[FloatArray] = []
    for problem in problems:
        bank, blocks, fit = calibrated_alone(problem, residual)
        folds = starts_and_folds(problem.rows.take(problem.train).frame, problem.folds)[1]
        densities.append(predictive(bank, blocks, folds, fit.variance))
    gain, error = apart(*densities)
    return (gain, error) if gain > criteria.ONE_ERROR * error else None


def as_reported(known: Sequence[Known]) -> list[Known]:
    """What is ``known`` of the load torque with the errors in it as those of the load motor's report."""
    return [replace(k, of_load_motor=True) if k.regressor.effect.startswith(SENSOR) else k for k in known]


def mark(outcome: ChannelOutcome, gain: float, error: float) -> None:
    """Say in an outcome of the load torque, and in the rows of its simulation, that the load motor's report is off."""
    outcome.notes.append(
        "the torque sensor reads right and the torque that the load motor reports is off: with the load torque as read"
        f" the motor torque of points left out has {gain:.1f} ± {error:.1f} more log density"
    )
    for number, found in enumerate(outcome.discoveries):
        if found.effect.startswith(SENSOR):
            rows = tuple(dict(row) | {REPORTED_BY: LOAD_MOTOR} for row in found.simulation_rows)
            outcome.discoveries[number] = replace(found, simulation_rows=rows)
