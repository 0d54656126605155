"""Terms of the physics library played on a plant.

Friction over speed and temperature becomes a table that the mechanics obey, with its heat. Everything else is added
where it shows, to the load encoder, the reported motor torque, the torque sensor or the thermometer, as the nominal
simulation's equations have it. What remembers its path goes on from block to block; there are no recordings here at
whose begin it could begin afresh. Friction so added heats the lubricant as well: the work that the motor does against
it is lost. A rate of the temperature adds up beside the plant's own balance of heat, which forgets it by its cooling
and does not feel it otherwise.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.simulation import waves
from bench.simulation.frame import ARRAYS, Frame
from bench.simulation.laws import factor as law_factor
from bench.simulation.states import Memory
from bench.simulation.terms.base import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR
from bench.simulation.terms.table import LIBRARY
from fakes.plant.drag_table import speeds, temperatures
from fakes.plant.errors import PlantError
from fakes.plant.parts import Effect
from fakes.plant.since import follow, thermometer_change
from fakes.plant.transmission import NEGATIVE, POSITIVE
from fakes.plant.truth import PlantTruth

DRAGS = ("friction.stribeck", "friction.viscous_temperature", "friction.viscous_quadratic")
_STANDSTILL = 0.5
"""rad/s at the motor below which the direction is 0"""
_CHANNELS = (TRANSMISSION_ERROR, MOTOR_TORQUE, LOAD_TORQUE, TEMPERATURE)
_TORQUE, _VELOCITY, _WAY, _HEAT = 0, 1, slice(2, 7), slice(7, 9)
"""places in what is remembered: torque and speed of the last cycle, and what :mod:`since` asks for"""


def value(effect: Effect, frame: Frame) -> NDArray[np.float64]:
    """Return what an effect adds to its channel on the rows of a frame."""
    if effect.grid is not None:
        return np.asarray(effect.grid.columns(frame) @ np.array(effect.linear))
    if effect.formula is not None:
        return np.asarray(effect.formula.columns(frame) @ np.array(effect.linear))
    if effect.waves:
        of_motor = effect.channel == TRANSMISSION_ERROR or effect.form == "ripple"
        return waves.evaluate(effect.waves, frame.theta if of_motor else frame.q, frame)
    form = LIBRARY[effect.effect].form(effect.channel, effect.form)
    if form is None:
        raise PlantError(f"{effect.effect} has no form {effect.form} in {effect.channel}")
    result: NDArray[np.float64] = form.columns(frame, effect.nonlinear) @ np.array(effect.linear)
    return result


def frame_of(size: int, ratio: float, values: dict[str, Any], memory: Memory | None = None) -> Frame:
    """Return a frame of ``size`` rows with the arrays given; the others are 0. ``memory``: states that go on."""
    arrays: dict[str, Any] = {}
    for name in ARRAYS:
        kind = np.int64 if name == "recording" else np.float64
        arrays[name] = np.ascontiguousarray(np.broadcast_to(np.asarray(values.get(name, 0), dtype=kind), (size,)))
    return Frame(ratio=ratio, memory=memory, **arrays)


def _is_friction(effect: Effect) -> bool:
    """Whether the work against what an effect adds to the motor torque turns to heat in the gearbox."""
    return effect.channel == MOTOR_TORQUE and effect.effect.startswith("friction.")


class Overlay:
    """The effects of a plant, ready to be added block by block."""

    def __init__(self, truth: PlantTruth, cycle_time_s: float) -> None:
        self._truth = truth
        self._cycle_time_s = cycle_time_s
        drags = [e for e in truth.effects if e.effect in DRAGS]
        self._added = [e for e in truth.effects if e.effect not in DRAGS]
        self.drag = self._table(drags) if drags else np.zeros((0, 0))
        """friction in N·m over speed and temperature (W, C), empty without any"""
        self._warms = any(effect.channel == TEMPERATURE or _is_friction(effect) for effect in self._added)
        self._memory = np.zeros(9)
        self._memory[[_TORQUE, _VELOCITY]] = np.nan
        self._states = Memory()
        # every term asks once, so that a snapshot knows how many states there are
        self._sums(replace(frame_of(1, truth.gearbox.ratio, {}), memory=self._states))
        self._states.states[:] = np.nan

    @property
    def changing(self) -> tuple[NDArray[np.float64], ...]:
        """What is remembered from cycle to cycle: part of a snapshot."""
        return self._memory, self._states.states

    def add(self, trace: NDArray[Any], cycle: int, measurements: NDArray[Any]) -> None:
        """Add the effects without table to a block's measurements (n,); ``trace`` (n,) begins at ``cycle``."""
        if not self._added and not self._truth.laws:
            return
        truth = self._truth
        frame = self._frame(trace, cycle, measurements)
        sums = {channel: values[1:] for channel, values in self._sums(frame).items()}
        if truth.laws:
            sums[TRANSMISSION_ERROR] = sums[TRANSMISSION_ERROR] + self._beyond_series(frame)[1:]
        counts = truth.load_drive.polarity * 2.0**truth.load_encoder.bits / (2 * math.pi)
        measurements["load_position"] += np.rint(counts * sums[TRANSMISSION_ERROR]).astype(np.int64)
        measurements["input_torque"] += truth.input_drive.polarity * sums[MOTOR_TORQUE]
        sensor = truth.torque_sensor
        adc = measurements["torque_adc"] + np.rint(
            sums[LOAD_TORQUE] * sensor.full_scale_counts / sensor.rated_torque
        ).astype(np.int32)
        measurements["torque_adc"] = np.clip(adc, -sensor.full_scale_counts, sensor.full_scale_counts - 1)
        if self._warms:
            measurements["lubricant_temperature"] += self._warmer(sums[TEMPERATURE], cycle)

    def _sums(self, frame: Frame) -> dict[str, NDArray[np.float64]]:
        """What the effects without table add to each channel on the rows of a frame; of the temperature, K/s."""
        sums = {channel: np.zeros(frame.size) for channel in _CHANNELS}
        self._states.begin()
        for effect in self._added:
            added = value(effect, frame)
            sums[effect.channel] += added
            if _is_friction(effect):
                sums[TEMPERATURE] += added * frame.omega / self._truth.heat.capacity
        return sums

    def _warmer(self, rate: NDArray[np.float64], cycle: int) -> NDArray[np.float64]:
        """K that the thermometer shows beyond the plant's own temperature, for a rate in K/s (n,) from a cycle on."""
        heat, out = self._truth.heat, np.empty(rate.size)
        cooling = 1.0 / (heat.resistance * heat.capacity)
        interval, step = self._truth.numerics.te_interval, self._cycle_time_s
        thermometer_change(np.ascontiguousarray(rate), cycle, interval, cooling, step, self._memory[_HEAT], out)
        return out

    def _beyond_series(self, frame: Frame) -> NDArray[np.float64]:
        """What the laws add to the series that the mechanics play: each order's vector times its factor less one."""
        series = self._truth.transmission_error
        box = series.box.array()
        x = np.clip(np.column_stack([frame.torque, frame.velocity, frame.temperature]), box[:, 0], box[:, 1])
        t, v, c = x.T
        basis = np.column_stack([t * t, v * v, c * c, t, v, c, t * v, t * c, v * c, np.ones_like(t)])
        factor = np.ones((frame.size, series.orders.size), dtype=np.complex128)
        for law in self._truth.laws:
            factor *= law_factor(law, x, frame.time, series.orders.tolist())
        out = np.zeros(frame.size)
        for direction, rows in ((POSITIVE, frame.last_direction > 0), (NEGATIVE, frame.last_direction <= 0)):
            phase = basis[rows] @ series.phase[direction].T + series.orders * frame.theta[rows, None]
            wave = (basis[rows] @ series.amplitude[direction].T) * np.exp(1j * phase)
            out[rows] = np.sum((wave * (factor[rows] - 1.0)).imag, axis=1)
        return out

    def _frame(self, trace: NDArray[Any], cycle: int, measurements: NDArray[Any]) -> Frame:
        """Return the block as a frame; its first row is the plant's start, from which terms count time and travel."""
        truth = self._truth
        ratio = truth.gearbox.ratio
        rows = np.concatenate([trace[:1], trace])
        rows["travel"][0] = 0.0
        rate, gained = self._rate(_TORQUE, trace["torque"]), self._rate(_VELOCITY, trace["te_velocity"])
        last = np.where(rows["weight"] >= 0, 1.0, -1.0)
        time = np.concatenate([[0.0], (cycle + 1 + np.arange(trace.size)) * self._cycle_time_s])
        direction = np.where(np.abs(rows["te_velocity"]) * ratio > _STANDSTILL, last, 0.0)
        since = np.zeros((3, rows.size))
        follow(direction[1:], rows["travel"][1:].copy(), time[1:], self._memory[_WAY], since[:, 1:])
        reported = np.concatenate([measurements["input_torque"][:1], measurements["input_torque"]])
        load = np.concatenate([measurements["load_torque"][:1], measurements["load_torque"]])
        return frame_of(
            rows.size,
            ratio,
            {
                "count": 1.0,
                "time": time,
                # a plant knows no recordings: one begins when the bench begins to move
                "elapsed": since[1],
                "theta": rows["motor_angle"] / ratio,
                "q": rows["load_angle"],
                "velocity": rows["te_velocity"],
                "acceleration": gained * ratio,
                "direction": direction,
                "last_direction": last,
                "torque": rows["torque"],
                "torque_level": rows["torque"],
                "torque_rate": rate,
                "temperature": rows["temperature"],
                "motor_torque": truth.input_drive.polarity * reported,
                "load_motor_torque": -truth.load_drive.polarity * load,
                "load_motor_level": -truth.load_drive.polarity * load,
                "travel": rows["travel"],
                "reversal_travel": since[0],
                "reversal_time": since[1],
                "reversed_before": since[2],
                "step": self._cycle_time_s,
            },
            self._states,
        )

    def _rate(self, place: int, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Change of a quantity (n,) a second, with a 0 before it; its last value is remembered at a ``place``, so that
        the rate does not depend on how cycles are cut into blocks.
        """
        rate = np.diff(np.concatenate([self._memory[place : place + 1], values]), prepend=0.0) / self._cycle_time_s
        rate[0] = 0.0
        if np.isnan(self._memory[place]):
            rate[1] = 0.0
        self._memory[place] = values[-1]
        return np.asarray(rate)

    def _table(self, drags: list[Effect]) -> NDArray[np.float64]:
        """Tabulate friction laws of speed and temperature."""
        speed, temperature = (g.ravel() for g in np.meshgrid(speeds(), temperatures(), indexing="ij"))
        ratio = self._truth.gearbox.ratio
        frame = frame_of(
            speed.size,
            ratio,
            {"velocity": speed / ratio, "direction": 1.0, "last_direction": 1.0, "temperature": temperature},
        )
        total = np.sum([value(effect, frame) for effect in drags], axis=0)
        return np.ascontiguousarray(total.reshape(speeds().size, temperatures().size))
