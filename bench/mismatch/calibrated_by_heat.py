"""The calibration of the motor torque as the heat tells it.

Where the zero of a recording is taken off the loss, or all that the calibrated torque leaves, its calibration is in
the loss (:mod:`bench.mismatch.power_zeros`). What the calibration is off by in a mean is then power that is missing,
or that never was: 5 mN·m at 170 rad/s change the end of a heating run by several times the noise of its thermometer.
So the temperature tells the coefficients of the motor torque more exactly than noise that is slow lets the torque
itself tell them. Both are put together: the covariance of the coefficients is the prior in the heat balance, and its
posterior mean is what they are moved to (a Kalman update, of which the heat balance is the second measurement).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.power_zeros import Zeros, goes_on, left_out, measured
from bench.mismatch.regression.excess import levelled
from bench.mismatch.regression.folds import apart
from bench.mismatch.regression.model import Block, ChannelModel
from bench.mismatch.regression.nameless_heat import deviations, heat_of
from bench.mismatch.regression.problem import NUISANCE, BaseTerm, ChannelProblem, Untold
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.heat_rates import HEATING


@dataclass(frozen=True, slots=True)
class CalibrationHeat(Untold):
    """Power of what the calibrated motor torque is unsure by, in the mean of each recording or at every moment,
    integrated over the recording.
    """

    model: ChannelModel
    words: str = "heat of what the calibration of the motor torque is unsure by"
    equation: str = "dT/dt += dtau_m*w_m/C"
    whole: bool = False
    """whether all that the model leaves is taken off the loss, and no mean of a recording alone"""
    less: tuple[str, ...] = ()
    """effects of the model that are taken off the loss themselves: how unsure they are is in no heat"""

    @property
    def indices(self) -> list[int]:
        """Columns of the motor torque's bank that a simulation file tells."""
        return [i for block in self._told() for i in block.indices]

    def deviations(self) -> FloatArray:
        """One standard deviation of their coefficients (k, k), in each of k independent directions a column."""
        return deviations(self.model.covariance(self.indices))

    def columns(self, frame: Frame) -> FloatArray:
        """Integrals of the powers of one standard deviation in each direction (n, k)."""
        columns = np.hstack([np.zeros((frame.size, 0)), *(b.regressor.columns(frame) for b in self._told())])
        unsure = columns @ self.deviations()
        if self.whole:
            return heat_of(list(np.where(goes_on(frame), unsure.T, 0.0)), frame)
        means = unsure - levelled(unsure, frame, np.where(frame.direction != 0, frame.count, 0.0))
        return heat_of(list(means.T), frame)

    def term(self, capacity: float) -> BaseTerm:
        """The base term of the temperature for a heat capacity (J/K)."""
        return BaseTerm(self, (capacity**2,) * len(self.indices))

    def _told(self) -> list[Block]:
        return [block for block in self.model.blocks() if block.regressor.effect not in (NUISANCE, *self.less)]


def calibrated(
    heat: ChannelModel, problem: ChannelProblem, zeros: Zeros, models: Mapping[str, ChannelModel]
) -> Zeros | None:
    """Move the calibration of the motor torque to where the heat says that it is: the zeros as it leaves them. None,
    and nothing is moved, where no loss depends on it, or where the temperatures of the training recordings, each
    predicted by a heat balance that is calibrated on the others, are not met better by more than the standard error.

    ``heat``: model of the temperature; ``problem``: that of the temperature with the whole loss; ``models`` of the
    torque channels, of which that of the motor torque is changed.
    """
    block = next((b for b in heat.base if isinstance(b.regressor, CalibrationHeat)), None)
    heating = next((b for b in heat.base if b.regressor.effect == HEATING), None)
    per_capacity = 0.0 if heating is None else float(heat.fit.of(heating.indices)[0][0])
    if block is None or per_capacity <= 0.0:
        return None
    asked = block.regressor
    assert isinstance(asked, CalibrationHeat)
    moves = asked.deviations() @ heat.fit.of(block.indices)[0] / per_capacity
    torque = asked.model
    found = [b for c in heat.chosen for b in c.blocks]
    without = left_out(problem, zeros, found)
    before = torque.moved, torque.fit
    torque.moved = {i: torque.moved.get(i, 0.0) + float(m) for i, m in zip(asked.indices, moves, strict=True)}
    torque.fit = torque.refitted(torque.chosen)
    moved = replace(measured(models), which=zeros.which)
    better, error = apart(without, left_out(problem, moved, found))
    if better > criteria.ONE_ERROR * error:
        return moved
    torque.moved, torque.fit = before
    return None
