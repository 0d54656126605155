"""What a channel has without a name, less what the recalibrated simulation may say of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.mismatch.regression.course import best_coefficients, less
from bench.mismatch.regression.model import ChannelModel
from bench.mismatch.regression.regressors import Regressor
from bench.simulation.frame import FloatArray, Frame


@dataclass(frozen=True, slots=True)
class NamelessCourse:
    """Sum of a model's effects without a name, less the part that the simulation's ``base`` says with ``coefficients``
    (k,).

    Nothing tells such a part from the base: a table says nothing of it, but a formula may with any coefficient. In
    another channel it would stand for what the simulation has there, however much of it.
    """

    model: ChannelModel
    base: tuple[Regressor, ...]
    coefficients: FloatArray

    @classmethod
    def of(cls, model: ChannelModel) -> NamelessCourse:
        """The course of a model; the base's part by the rows it was fitted to, each sample counted alike."""
        problem = model.problem
        frame = problem.rows.frame
        base = model.calibrated
        number = np.where(problem.train, problem.rows.number, 0.0)
        course = model.sum_of(model.nameless, frame)
        return cls(model, base, best_coefficients(course, base, frame, number))

    def at(self, frame: Frame) -> FloatArray:
        """The course at the rows of a frame (n,)."""
        return less(self.model.sum_of(self.model.nameless, frame), self.base, frame, self.coefficients)
