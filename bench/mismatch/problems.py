"""What is to be explained in each channel: its rows less what the simulation has of them, beside its nominal terms."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.given import Given
from bench.mismatch.orders.periodicity import Periodicity, on_rows
from bench.mismatch.orders.reaction import Reaction
from bench.mismatch.orders.shaft import OF_A_SPECTRUM, factors
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.recordings.output_orders import OutputSpectrum
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.recordings.vibration import ShaftSpectrum
from bench.mismatch.regression import noise
from bench.mismatch.regression.problem import (
    BaseTerm,
    ChannelProblem,
    WanderingZero,
    fixed_part,
    heat_capacity,
    nominal_base,
    squared_speed_time,
    zero_precisions,
)
from bench.mismatch.regression.sensitivity import sensitivities
from bench.mismatch.regression.state import Search
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE
from bench.simulation.waves import Wave

ANGLES = ("rad", "")
"""units of auxiliary quantities that may be angles: radians, into which angles are imported, and no unit at all"""


def usable(channel: str, rows: Rows) -> NDArray[np.bool_]:
    """Rows that can be compared: those with samples, in motion where friction is in the channel."""
    moving = np.ones(rows.size, dtype=bool) if channel == TEMPERATURE else rows.frame.direction != 0
    return np.asarray(moving & (rows.number > 0))


def base_of(given: Given, channel: str, rows: Rows) -> list[BaseTerm]:
    """Terms that are fitted in every model of a channel: nominal ones, free parameters, effects that are known."""
    base = nominal_base(channel, given.switched_off)
    base += [BaseTerm(sensitivity) for sensitivity in sensitivities(given.base, channel, tuple(rows.frame.aux))]
    apart = {id(known) for known in given.over_input_angle()}  # no offset: they stay as they are
    return base + [BaseTerm(known.regressor) for known in given.known.get(channel, ()) if id(known) not in apart]


def capacity_of(data: Dataset, given: Given, rows: Rows) -> float:
    """Heat capacity (J/K) that the fitted rows of the temperature show."""
    fitted = usable(TEMPERATURE, rows) & (np.asarray(data.folds())[rows.frame.recording] >= 0)
    return heat_capacity(rows, base_of(given, TEMPERATURE, rows), fitted)


def wandering_zero(data: Dataset, rows: Rows, zero: float, capacity: float, row: float | None) -> BaseTerm:
    """The zeros of the motor torque in the heat balance.

    ``zero``: how far they differ from recording to recording, N·m; ``capacity``: heat capacity, J/K; ``row``: noise of
    a row of the temperature, K, None where nothing tells it.
    """
    torque = noise.mixture(data.density.get(MOTOR_TORQUE, []))
    most = squared_speed_time(torque, row, capacity)
    return BaseTerm(WanderingZero(most), zero_precisions(rows.frame, torque, zero, capacity, most))


def less_fixed(given: Given, channel: str, rows: Rows) -> Rows:
    """Rows less what the simulation says of a channel that is not calibrated: geometry, given waves and ripple."""
    taken = fixed_part(channel, rows.frame, given.switched_off)
    given_waves = given.waves.get(channel, ())
    if given_waves:
        taken = taken + on_rows(given_waves, rows)
    if channel == MOTOR_TORQUE and given.ripples:
        taken = taken + on_rows(given.ripples, rows, rows.frame.theta)
    return replace(rows, y=rows.y - taken)


def problem_of(
    data: Dataset,
    given: Given,
    channel: str,
    rows: Rows,
    banned: Sequence[str],
    nuisances: Sequence[BaseTerm] = (),
) -> ChannelProblem:
    """Return what the regression of a channel is given; effects that are ``banned`` are no candidates, ``nuisances``
    stand beside the simulation.
    """
    base = [*base_of(given, channel, rows), *nuisances]
    rows = less_fixed(given, channel, rows)
    mixture = noise.mixture(data.density.get(channel, []))
    return ChannelProblem(
        channel,
        rows,
        usable(channel, rows),
        data.folds(),
        tuple(base),
        mixture,
        None,
        given.switched_off,
        tuple(banned),
        given.unsettled.get(channel, ()),
        given.switched_off if data.folder.manner.free and channel not in data.simulated else (),
        tuple(name for name, unit in data.auxiliary_units.items() if unit in ANGLES),
        data.folder.manner.free,
        data.folder.manner.free and data.cut,
        unresolved=data.unresolved if channel == LOAD_TORQUE else 0.0,
    )


def periodicity_of(
    data: Dataset, given: Given, search: Search, reaction: Reaction | None, misread: Collection[float] = ()
) -> Periodicity:
    """Spectra and rows of a torque, for what is periodic in it and too quick for its rows: less the waves that the
    simulation has and the ``reaction``, which it is known to hold; what the inertia asks for is still in them.
    ``misread``: orders of the motor encoder's error.
    """
    problem = search.model.problem
    channel = problem.channel
    output, shaft = data.output.get(channel, []), data.shaft if channel == MOTOR_TORQUE else []
    # of a direct drive the shaft's orders are the output's
    ripples = (*given.ripples, *(given.waves.get(channel, ()) if data.ratio == 1.0 else ()))
    if reaction is not None:
        output, shaft = [reaction.less_output(s) for s in output], [reaction.less_shaft(s) for s in shaft]
    return Periodicity(
        channel,
        [_less(s, given.waves.get(channel, ())) for s in output],
        [_less_ripple(s, ripples, data.ratio) for s in shaft],
        problem.rows,
        problem.folds,
        data.ratio,
        search.model.floor,
        frozenset(round(f / data.ratio) for f in misread),
    )


def _less(seen: OutputSpectrum, known: Sequence[Wave]) -> OutputSpectrum:
    """A spectrum over the output angle less waves that the simulation has."""
    if not known:
        return seen
    amplitude = seen.amplitude.copy()
    load = seen.torque / 1000.0
    size = {"1": 1.0, "d": seen.direction, "tau": load, "d*abs_tau": seen.direction * abs(load)}
    for wave in known:
        order = round(wave.order)
        if order < amplitude.size and wave.times in size:
            amplitude[order] -= complex(wave.cosine, wave.sine) * size[wave.times]
    return replace(seen, amplitude=amplitude)


def _less_ripple(seen: ShaftSpectrum, known: Sequence[Wave], ratio: float) -> ShaftSpectrum:
    """A spectrum over the motor's angle less ripple that the simulation has."""
    if not known:
        return seen
    amplitude = seen.amplitude.copy()
    for wave in known:
        order = round(wave.order / ratio)
        if order < amplitude.size and OF_A_SPECTRUM.keys() >= set(wave.times.split("*")):
            amplitude[order] -= complex(wave.cosine, wave.sine) * float(factors([seen], [wave.times])[wave.times][0])
    return replace(seen, amplitude=amplitude)
