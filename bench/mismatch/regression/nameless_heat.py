"""Heat that may never have been: what a torque has without a name may be an error of its report."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.model import ChannelModel, Chosen
from bench.mismatch.regression.nameless import NamelessCourse
from bench.mismatch.regression.problem import BaseTerm, Untold, fixed_part
from bench.mismatch.regression.regressors import Regressor
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import integral
from bench.simulation.terms import MOTOR_TORQUE

REPORTED_GAIN = "motor.torque_constant"
"""effect that is an error of the reported motor torque"""


@dataclass(frozen=True, slots=True)
class NamelessHeat(Untold):
    """Power of what the motor torque has without a name, and of what its model leaves, integrated over each recording.

    A drive whose magnets weaken reports a torque that it does not give. Nothing tells it from friction, which heats, so
    an effect in the temperature is looked for beside either.
    """

    course: NamelessCourse
    words: str = "heat of what the motor torque has without a name"
    equation: str = "dT/dt += dtau_m*w_m/C"

    def columns(self, frame: Frame) -> FloatArray:
        """Integrals of both powers (n, 2)."""
        model = self.course.model
        fixed = fixed_part(MOTOR_TORQUE, frame, model.problem.switched_off)
        left = np.where(frame.direction != 0, frame.motor_torque - fixed - model.predict(frame), 0.0)
        return heat_of((self.course.at(frame), left), frame)


@dataclass(frozen=True, slots=True)
class GainHeat(Untold):
    """Power of what a gain error of the reported motor torque comes to, integrated over each recording.

    It is the small difference of two large powers, and neither its coefficients are known exactly nor need nature's
    form of the error be the library's: a saturation that is followed a little wrong is heat that never was.
    """

    model: ChannelModel
    gain: Chosen
    words: str = "heat of the gain error of the motor torque"
    equation: str = "dT/dt += dtau_m*w_m/C"

    def columns(self, frame: Frame) -> FloatArray:
        """Integrals of the powers (n, k + 1): of one standard deviation of the coefficients in each of k independent
        directions, and of as much as the form may be off.
        """
        return heat_of(_off_by(self.model, self.gain, frame), frame)


@dataclass(frozen=True, slots=True)
class SensorHeat(Untold):
    """Power of what an error of the torque sensor comes to beyond what was taken off its reading, integrated over each
    recording: its coefficients are not known exactly, and nature's form need not be the library's.
    """

    model: ChannelModel
    error: Chosen
    words: str = "heat of the error of the torque sensor"
    equation: str = "dT/dt += dtau*dq/C"

    def columns(self, frame: Frame) -> FloatArray:
        """Integrals of the powers (n, k + 1): of one standard deviation of the coefficients in each of k independent
        directions, and of as much as the form may be off.
        """
        return _load_heat_of(_off_by(self.model, self.error, frame), frame)


@dataclass(frozen=True, slots=True)
class NamelessLoadHeat(Untold):
    """Power of what the load torque has without a name, integrated over each recording: an error of the sensor is power
    that was never there.
    """

    course: NamelessCourse
    words: str = "heat of what the load torque has without a name"
    equation: str = "dT/dt += dtau*dq/C"

    def columns(self, frame: Frame) -> FloatArray:
        """Integral of the power (n, 1)."""
        return _load_heat_of([self.course.at(frame)], frame)


def deviations(covariance: FloatArray) -> FloatArray:
    """One standard deviation of coefficients of a ``covariance`` (k, k), in each of k independent directions a column
    (k, k).
    """
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return np.asarray(scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))


def heat_of(torques: Sequence[FloatArray], frame: Frame) -> FloatArray:
    """Integrals (n, k) over each recording of what ``torques`` (n,) of the motor add to the loss."""
    sign = np.sign(frame.motor_torque * frame.omega - frame.torque * frame.velocity)
    return np.column_stack([integral(sign * torque * frame.omega, frame) for torque in torques])


def _load_heat_of(torques: Sequence[FloatArray], frame: Frame) -> FloatArray:
    """Integrals (n, k) over each recording of the powers of ``torques`` (n,) of the load."""
    return np.column_stack([integral(torque * frame.velocity, frame) for torque in torques])


def _off_by(model: ChannelModel, error: Chosen, frame: Frame) -> list[FloatArray]:
    """What an effect of a torque may be off by at the rows of a frame (n,): one standard deviation of its coefficients
    in each of k independent directions, and as much as its form may be off.
    """
    main = error.main
    unsure = main.regressor.columns(frame) @ deviations(model.fit.of(main.indices)[1])
    return [*unsure.T, criteria.SHAPE * model.contribution(error, frame)]


def _given_and_found(model: ChannelModel) -> list[Chosen]:
    """Effects of a model that the simulation has, and those that were found beside it."""
    return [*(Chosen(block) for block in model.base), *model.chosen]


def _precision(error: Chosen, capacity: float) -> tuple[float, ...]:
    """Of the columns of what an effect may be off by, for a heat capacity (J/K)."""
    return (capacity**2,) * (len(error.main.indices) + 1)


def nameless_load_heat(model: ChannelModel, capacity: float) -> tuple[BaseTerm, ...]:
    """The base term of the temperature for a model of the load torque and a heat capacity (J/K); none where all that
    the torque has is named.
    """
    if not model.nameless:
        return ()
    return (BaseTerm(NamelessLoadHeat(NamelessCourse.of(model)), (capacity**2,)),)


def sensor_heat(model: ChannelModel, misread: Collection[Regressor], capacity: float) -> tuple[BaseTerm, ...]:
    """The base terms of the temperature for a model of the load torque and a heat capacity (J/K), one for each given or
    found error of the torque sensor, those that are ``misread`` and so taken off its reading.
    """
    errors = [one for one in _given_and_found(model) if one.main.regressor in misread]
    return tuple(BaseTerm(SensorHeat(model, e), _precision(e, capacity)) for e in errors)


def gain_heat(model: ChannelModel, capacity: float) -> tuple[BaseTerm, ...]:
    """The base terms of the temperature for a model of the motor torque and a heat capacity (J/K); none where no gain
    error was given or found. It may be off by what its coefficients are unsure by, and nature's form by a fifth.
    """
    gains = [one for one in _given_and_found(model) if one.effect == REPORTED_GAIN]
    return tuple(BaseTerm(GainHeat(model, g), _precision(g, capacity)) for g in gains)


def nameless_heat(model: ChannelModel, capacity: float) -> tuple[BaseTerm, ...]:
    """The base term of the temperature for a model of the motor torque and a heat capacity (J/K); none where all that
    the torque has is named.
    """
    if not model.nameless:
        return ()
    return (BaseTerm(NamelessHeat(NamelessCourse.of(model)), (capacity**2, capacity**2)),)
