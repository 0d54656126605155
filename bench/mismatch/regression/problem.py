"""What there is to explain: one channel's rows, what the simulation says of them, who may be fitted."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.recordings.beginning import at_start
from bench.mismatch.recordings.comparable import INPUTS
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.excess import levelled
from bench.mismatch.regression.noise import Mixture
from bench.mismatch.regression.regressors import Named, Regressor
from bench.simulation.frame import FloatArray, Frame, IntArray, recording_starts
from bench.simulation.heat_rates import HEATING
from bench.simulation.memory import integral
from bench.simulation.terms import LIBRARY, LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR

TORQUE_ZERO = 0.01
"""N·m at the motor: how far the zero of a torque may differ from recording to recording, by data sheets; further where
the motor torque's own recordings show it
"""
STRETCH_S = 100.0
"""over which the slow noise of the motor torque is taken to be one zero at most: a recording of many minutes sums it up
to a random walk of the predicted temperature
"""
SHORTEST_STRETCH_S = 18.0
"""the same at least: what bends within so short a time is noise of the temperature's rows
(:data:`bench.mismatch.regression.slow_noise.WINDOW`)
"""
BRIDGE = 4.0
"""variance of a random walk at the end of a stretch, over what the straight line of one zero misses of it in the middle
(Brownian bridge)
"""
CAPACITY = 2.0e4
"""J/K, to turn that into a rate of the temperature where the recordings do not tell the heat capacity"""
SURE_OF_HEATING = 3.0
"""standard errors by which the rate of heating per watt is above 0, from which the recordings tell the heat capacity"""


@dataclass(frozen=True, slots=True)
class ChannelSpec:
    """A compared channel: channels it is made of, those its simulation needs where the campaign has them, what is taken
    off it before anything is fitted (an id), whether its regressors are integrals over each recording.
    """

    name: str
    made_of: tuple[str, ...]
    inputs: tuple[str, ...]
    fixed: str = ""
    integral: bool = False


NUISANCE = "nuisance"
"""effect of the blocks that stand for zeros of sensors"""
CHANNELS: dict[str, ChannelSpec] = {
    LOAD_TORQUE: ChannelSpec(LOAD_TORQUE, *INPUTS[LOAD_TORQUE], "load.reaction"),
    TRANSMISSION_ERROR: ChannelSpec(TRANSMISSION_ERROR, *INPUTS[TRANSMISSION_ERROR]),
    MOTOR_TORQUE: ChannelSpec(MOTOR_TORQUE, *INPUTS[MOTOR_TORQUE], "motor.load_reaction"),
    TEMPERATURE: ChannelSpec(TEMPERATURE, *INPUTS[TEMPERATURE], integral=True),
}
"""in the order in which they are analysed: what is found of the torque sensor changes what the others are compared
with, the load's reaction in the motor torque passes the transmission error, and the heat is the torques'
"""


@dataclass(frozen=True, slots=True)
class BaseTerm:
    """A part of the simulation that is calibrated: regressors with the prior precision (k,) of their coefficients."""

    regressor: Regressor
    precision: tuple[float, ...] = ()

    def precisions(self, size: int) -> FloatArray:
        """Prior precision of each of ``size`` coefficients."""
        return np.asarray(self.precision) if self.precision else np.zeros(size)


@dataclass(frozen=True, slots=True)
class ChannelProblem:
    """One channel to explain.

    ``rows``: all rows of all recordings (memories run through every one of them), ``y`` less what is fixed; ``usable``
    rows that may be compared; ``folds`` fold of each recording by its index, -1 where it is held out; ``base`` what the
    simulation has; ``noise`` of its samples, where spectra tell it; ``doubt``
    variance of each row by what was taken off it; ``switched_off`` nominal terms it lacks; ``banned`` effects that
    are not looked for; ``unsettled`` effects in force whose form and numbers are the recordings' to say.
    """

    channel: str
    rows: Rows
    usable: NDArray[np.bool_]
    folds: IntArray
    base: tuple[BaseTerm, ...]
    noise: Mixture | None = None
    doubt: FloatArray | None = None
    switched_off: tuple[str, ...] = ()
    banned: tuple[str, ...] = ()
    unsettled: tuple[str, ...] = ()
    lacking: tuple[str, ...] = ()
    """nominal terms that the simulation is known to lack, where they are asked before their changes: one from elsewhere
    may have them
    """
    angles: tuple[str, ...] | None = None
    """auxiliary quantities that are angles; None where nothing tells"""
    free: bool = False
    """whether the motion follows no set speeds: operating points are none that were run apart"""
    cut: bool = False
    """whether recordings of such a motion are pieces of a few longer ones, which share the sensors' zeros"""
    states: bool = False
    """whether functions of states that are not recorded are candidates"""
    swings: bool = False
    """whether the output never turns round, so that functions of its angle are candidates where orders are elsewhere"""
    unresolved: float = 0.0
    """what rounding leaves of the level of the quantity that the channel is compared with, in its unit"""

    @property
    def spec(self) -> ChannelSpec:
        """The channel's row of the table."""
        return CHANNELS[self.channel]

    @property
    def train(self) -> NDArray[np.bool_]:
        """Rows that may be fitted."""
        return np.asarray(self.usable & (self.folds[self.rows.frame.recording] >= 0) & (self.rows.number > 0))

    @property
    def held_out(self) -> NDArray[np.bool_]:
        """Rows that are scored and never fitted."""
        return np.asarray(self.usable & (self.folds[self.rows.frame.recording] < 0) & (self.rows.number > 0))


def starts_and_folds(frame: Frame, folds: IntArray) -> tuple[IntArray, IntArray]:
    """First rows of the recordings in a frame (recordings + 1,), and the fold of each, numbered from 0 without gaps."""
    starts = recording_starts(frame)
    fold = folds[frame.recording[starts[:-1]]]
    return starts, np.unique(fold, return_inverse=True)[1].astype(np.int64)


def nominal_base(channel: str, switched_off: Sequence[str]) -> list[BaseTerm]:
    """Nominal terms with free parameters that the simulation has in a channel."""
    out = []
    for term in LIBRARY.values():
        if not term.nominal or channel not in term.forms or term.effect in switched_off or term.effect == "te.fourier":
            continue
        if term.effect == CHANNELS[channel].fixed:
            continue
        out.append(BaseTerm(Named(term, channel, term.forms[channel][0])))
    return out


def fixed_part(channel: str, frame: Frame, switched_off: Sequence[str]) -> FloatArray:
    """What geometry says of a channel (n,): taken off before anything is fitted."""
    effect = CHANNELS[channel].fixed
    if not effect or effect in switched_off:
        return np.zeros(frame.size)
    return np.asarray(LIBRARY[effect].forms[channel][0].columns(frame, ())[:, 0])


class Untold:
    """A regressor that stands for what sensors may be wrong by: no finding, and no part of any simulation file."""

    effect = NUISANCE
    variables: tuple[str, ...] = ()
    numbers = 0

    def parameters(self, coefficients: FloatArray, std: FloatArray) -> list[dict[str, object]]:
        """None: it is told to nobody."""
        del coefficients, std
        return []

    def row(self, coefficients: FloatArray, std: FloatArray) -> dict[str, object]:
        """Empty: it stands in no file."""
        del coefficients, std
        return {}


@dataclass(frozen=True, slots=True)
class WanderingZero(Untold):
    """Heat that never was: the zero of the motor's torque, integrated over the speed, is a recording's own.

    One regressor for each recording, and one for each stretch of a long one: zeros of another day are others. None is
    common to all: beside heating runs at one torque it could not be separated from the heat capacity, and what no file
    holds is missing from every prediction (a constant zero is asked for in :mod:`bench.mismatch.power_zeros`).

    ``squared_speed_time``: mean square of the motor's speed times the length of a stretch, (rad/s)²·s, up to which one
    zero stands for the walk: the faster a recording, the shorter are its stretches (:func:`squared_speed_time`).
    """

    squared_speed_time: float = math.inf
    words: str = "zero of the motor torque in the heat balance"
    equation: str = "dT/dt += z_r*w_m/C"

    def columns(self, frame: Frame) -> FloatArray:
        """Integral of the motor's speed over each recording alone (zero elsewhere); then over each stretch of the
        recordings that have several.
        """
        recordings = _recordings(frame)
        parts = [(rows, np.ones(rows.stop - rows.start, dtype=bool)) for rows in recordings]
        parts += [(rows, stretch) for rows, stretch, _ in _stretches(frame, self.squared_speed_time)]
        omega = frame.omega
        out = np.zeros((frame.size, len(parts)), order="F")
        for k, (rows, stretch) in enumerate(parts):
            out[rows, k] = integral(np.where(stretch, omega[rows], 0.0), frame.take(rows))
        return out

    def told(self, frame: Frame, precision: FloatArray, left: FloatArray, noise: FloatArray) -> FloatArray:
        """Most likely heat of the zeros (n,) within the residual ``left`` (n,) of a temperature, counted from the level
        of each recording's first readings.

        ``precision`` of the coefficients of :meth:`columns`; ``noise`` (n,): variance of a row, infinite for one that
        says nothing.
        """
        recordings = _recordings(frame)
        out, stretch = np.zeros(frame.size), len(recordings)
        for k, rows in enumerate(recordings):
            part = frame.take(rows)
            z = np.column_stack([c - at_start(part, c) for c in self.columns(part).T])
            own = np.array([k, *range(stretch, stretch + z.shape[1] - 1)])
            stretch += z.shape[1] - 1
            weighted = (z / noise[rows, None]).T
            out[rows] = z @ np.linalg.solve(weighted @ z + np.diag(precision[own]), weighted @ left[rows])
        return out


def _recordings(frame: Frame) -> list[slice]:
    """Rows of each recording."""
    return [slice(int(a), int(b)) for a, b in itertools.pairwise(recording_starts(frame))]


def _stretches(frame: Frame, most: float) -> list[tuple[slice, NDArray[np.bool_], float]]:
    """Each stretch of the recordings that have several: rows of the recording, which of them, how long it is (s)."""
    out = []
    for rows in _recordings(frame):
        elapsed = frame.elapsed[rows]
        fast = float(np.mean(frame.omega[rows] ** 2))
        length = min(STRETCH_S, max(most / max(fast, 1e-12), SHORTEST_STRETCH_S))
        number = np.floor((elapsed - elapsed.min()) / length)
        if number.max() >= 1.0:
            out += [(rows, number == k, length) for k in np.unique(number)]
    return out


def squared_speed_time(torque: Mixture | None, row: float | None, capacity: float) -> float:
    """:attr:`WanderingZero.squared_speed_time`: the walk that the noise of the ``torque`` adds up to bends away from
    the straight line of one zero by no more than the noise of a ``row`` of the temperature, K, for any function of the
    heat would follow a bend that is seen. ``capacity``: heat capacity, J/K. Infinite where no spectra tell the torque's
    noise, or no rows that of the temperature.
    """
    if torque is None or row is None:
        return math.inf
    density = STRETCH_S * _of_stretches(torque, np.array([STRETCH_S]))[0]
    return float(BRIDGE * (row * capacity) ** 2 / max(density, 1e-300))


def _of_stretches(torque: Mixture, length: FloatArray) -> FloatArray:
    """Variance of the mean of a torque's noise over stretches of some ``length`` (n,), s."""
    return torque.of_means(torque.rate * length, length)


def heat_capacity(rows: Rows, base: Sequence[BaseTerm], fitted: NDArray[np.bool_]) -> float:
    """Heat capacity (J/K) that the ``fitted`` rows (n,) of the temperature show: the nominal balance by least squares,
    the level of each recording free; :data:`CAPACITY` where they do not tell it.
    """
    terms = [t for t in base if t.regressor.effect != NUISANCE]
    number = next((k for k, t in enumerate(terms) if t.regressor.effect == HEATING), None)
    if number is None or not fitted.any():
        return CAPACITY
    each = [t.regressor.columns(rows.frame)[fitted] for t in terms]
    columns, first = np.hstack(each), sum(part.shape[1] for part in each[:number])
    columns = np.where(np.isfinite(columns), columns, 0.0)
    frame, alike = rows.frame.take(np.flatnonzero(fitted)), np.ones(len(columns))
    x, y = levelled(columns, frame, alike), levelled(rows.y[fitted], frame, alike)
    scale = np.maximum(np.sqrt(np.mean(x**2, axis=0)), 1e-300)
    x /= scale
    beta, _, rank, _ = np.linalg.lstsq(x, y, rcond=1e-9)
    if rank < scale.size:
        return CAPACITY
    # rows of one recording are no independent readings
    recordings = recording_starts(frame).size - 1
    error = np.sqrt(np.linalg.inv(x.T @ x)[first, first] * float(np.sum((y - x @ beta) ** 2)) / recordings)
    return float(scale[first] / beta[first]) if beta[first] > SURE_OF_HEATING * error else CAPACITY


def zero_precisions(
    frame: Frame,
    torque: Mixture | None,
    zero: float = TORQUE_ZERO,
    capacity: float = CAPACITY,
    most: float = math.inf,
) -> tuple[float, ...]:
    """Prior precisions of the wandering zero's coefficients: of each recording, then of each stretch.

    ``zero``: how far it differs from recording to recording, N·m; ``torque``: noise of a sample of the motor torque;
    its mean over a stretch is heat that never was. None: not known, and a stretch is taken to be as wrong as a data
    sheet lets a recording be. ``capacity``: heat capacity, J/K; ``most``: squared speed
    times time of a stretch.
    """
    length = np.array([of_stretch for _, _, of_stretch in _stretches(frame, most)])
    squared = np.full(length.size, zero**2) if torque is None else _of_stretches(torque, length)
    each = capacity**2 / np.maximum(squared, 1e-12)
    return (*([(capacity / zero) ** 2] * len(_recordings(frame))), *(float(p) for p in each))
