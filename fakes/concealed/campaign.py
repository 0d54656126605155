"""One concealed campaign: the bench runs its points one after another, with one history of heat, travel and time."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fakes.concealed import plant as nominal
from fakes.concealed.design import Point
from fakes.concealed.effects.base import Effect, Floats, Run, ThermalWorld
from fakes.concealed.effects.kernels import follow
from fakes.concealed.motion import Motion, move
from fakes.concealed.plant import RATIO, Plant

_COARSE_S = 0.5  # step of the heat balance; its time constants are minutes
_REST_S = 5.0
_MOST_ROUNDS = 8
_AGREED_K = 0.002
_BLOCK = 20_000  # samples whose orders are modulated at once


@dataclass(slots=True)
class Signals:
    """What ideal sensors would read (N,), and what the concealed effects alone add to each compared channel.

    Attributes:
        motor_shaft: reading of the motor encoder, rad of the shaft.
        load_angle: rad, not a number where the run was asked to leave it out.
        motor_torque, load_torque, load_motor_torque: N·m. probe: PT100 in °C. power: loss in W as the nominal equation
            has it.
        added: channel → (N,) contribution of all effects.
    """

    run: Run
    motion: Motion
    motor_shaft: Floats
    load_angle: Floats
    motor_torque: Floats
    load_torque: Floats
    probe: Floats
    power: Floats
    added: dict[str, Floats]


@dataclass(slots=True)
class _History:
    """State that outlives a recording."""

    clock: float = 0.0
    travel: float = 0.0
    theta: float = 0.0
    side: int = 1
    lubricant: float = 20.0
    house: float = 20.0
    probe: list[float] = field(default_factory=list)


@dataclass(slots=True)
class Campaign:
    """A bench, its concealed effects and the points it runs."""

    plant: Plant
    effects: Sequence[Effect]
    points: Sequence[Point]
    seed: int

    def run(self, rate_hz: float, angle: bool = True) -> Iterator[Signals]:
        """Run all points at a sample rate; recorded ones are yielded in order. The draws do not depend on the rate.

        Without ``angle`` the load angle is left out, which takes longest: for who asks what the effects add.
        """
        for effect in self.effects:
            effect.reset()
        duration = self._planned_duration()
        rng = np.random.default_rng([self.seed, 0])
        history = _History(theta=float(rng.uniform(0.0, 6.0)))
        history.lubricant = history.house = self.plant.ambient + float(rng.uniform(0.3, 1.5))
        history.probe = [history.lubricant] * sum(len(effect.probe_lags()) for effect in self.effects)
        for index, point in enumerate(self.points):
            self._rest(point.pause * float(np.random.default_rng([self.seed, 2, index]).uniform(0.8, 1.5)), history)
            if point.kind == "pause":
                continue
            recorded = point.kind != "unrecorded"
            signals = self._run_point(
                point, index, rate_hz if recorded else 10.0, history, duration, angle and recorded
            )
            if recorded:
                yield signals

    def _added(self, hook: str, run: Run) -> Floats:
        out = np.zeros(run.time.size)
        for effect in self.effects:
            part = effect.add(hook, run)
            if part is not None:
                out += part
        return out

    def _planned_duration(self) -> float:
        total = 0.0
        for index, point in enumerate(self.points):
            total += 1.15 * point.pause
            if point.kind != "pause":
                total += move(point, 5.0, 0.0, np.random.default_rng([self.seed, 1, index])).time[-1]
        return total

    def _world(self, count: int) -> ThermalWorld:
        return ThermalWorld(
            conductance=np.full(count, 1.0 / self.plant.heat_resistance),
            ambient=np.full(count, self.plant.ambient),
            extra_power=np.zeros(count),
        )

    def _warm(self, world: ThermalWorld, step: float, power: Floats, history: _History) -> Floats:
        course = nominal.heat_up(
            np.array([history.lubricant, history.house]),
            step,
            power + world.extra_power,
            world.conductance,
            world.ambient,
            self.plant.heat_capacity,
            world.house_capacity,
            world.house_link,
            np.array(world.capacity_bump),
        )
        history.lubricant, history.house = float(course[-1, 0]), float(course[-1, 1])
        return course[:, 0]

    def _rest(self, seconds: float, history: _History) -> None:
        count = max(int(np.ceil(seconds / _REST_S)), 1)
        step = seconds / count
        world = self._world(count)
        clock: Floats = history.clock + step * np.arange(count, dtype=np.float64)
        for effect in self.effects:
            effect.rest(world, clock)
        course = self._warm(world, step, np.zeros(count), history)
        # a thermometer that lags by seconds is followed as closely as in a recording
        close = np.linspace(0.0, seconds, max(int(np.ceil(seconds / _COARSE_S)), 1) + 1)
        course = np.interp(close, step * np.arange(count + 1), course)
        history.probe = self._lagged(course, float(close[1]), history.probe)[1]
        history.clock += seconds

    def _lagged(self, course: Floats, step: float, start: list[float]) -> tuple[Floats, list[float]]:
        """What the PT100 shows of a course of temperature, and the states of its lags at the end."""
        ends = []
        lags = [lag for effect in self.effects for lag in effect.probe_lags()]
        for lag, first in zip(lags, start, strict=True):
            course = follow(course, np.exp(-step / lag) if lag > 0.0 else 0.0, first)
            ends.append(float(course[-1]))
        return course, ends

    def _run_point(
        self, point: Point, index: int, rate_hz: float, history: _History, duration: float, angle: bool
    ) -> Signals:
        motion = move(point, rate_hz, history.theta, np.random.default_rng([self.seed, 1, index]))
        run = self._begin(point, index, rate_hz, motion, history, duration)
        memories = [copy.deepcopy(getattr(effect, "memory", None)) for effect in self.effects]
        start = (history.lubricant, history.house)
        torques = self._torques(run)
        # friction heats and heat changes friction: repeated until the temperature agrees with the torque it came from
        for _ in range(_MOST_ROUNDS):
            before = run.temperature
            self._heat(run, motion, history, torques[0])
            history.lubricant, history.house = start
            for effect, memory in zip(self.effects, memories, strict=True):
                if memory is not None:
                    effect.memory.clear()  # type: ignore[attr-defined]
                    effect.memory.update(copy.deepcopy(memory))  # type: ignore[attr-defined]
            torques = self._torques(run)
            if np.max(np.abs(run.temperature - before)) < _AGREED_K:
                break
        power, probe = self._heat(run, motion, history, torques[0], final=True)
        signals = self._read(run, motion, torques, power, probe, angle)
        history.clock = float(run.clock[-1]) + 1.0 / rate_hz
        history.travel = float(run.travel[-1])
        history.theta = float(motion.theta[-1])
        history.side = int(run.side[-1])
        return signals

    def _begin(
        self, point: Point, index: int, rate_hz: float, motion: Motion, history: _History, duration: float
    ) -> Run:
        p = self.plant
        ripple = sum(
            a * np.cos(k * motion.theta - phi)
            for k, a, phi in zip(nominal.LOAD_RIPPLE_ORDERS, p.ripple, p.ripple_phase, strict=True)
        )
        torque = motion.command + motion.sign * p.f_b + p.load_inertia * motion.acceleration + ripple
        return Run(
            point=point,
            index=index,
            rate_hz=rate_hz,
            time=motion.time,
            clock=history.clock + motion.time,
            theta=motion.theta,
            rate=motion.rate,
            acceleration=motion.acceleration,
            sign=motion.sign,
            side=_last_side(motion.sign, history.side),
            travel=history.travel + np.cumsum(np.abs(motion.rate)) / rate_hz,
            command=motion.command,
            torque=torque,
            temperature=np.full(motion.time.size, history.lubricant),
            motor_torque=np.zeros(motion.time.size),
            duration=duration,
        )

    def _torques(self, run: Run) -> tuple[Floats, Floats, Floats]:
        """Set the run's true torques; returns what the load side, the output and friction add (each (N,))."""
        base = run.torque
        behind = self._added("load_side", run)
        run.torque = base + behind
        before = self._added("output_torque", run)
        friction = self._added("friction", run)
        run.motor_torque = friction + nominal.nominal_motor_torque(
            self.plant, run.torque + before, run.motor_rate, RATIO * run.acceleration, run.temperature, run.sign
        )
        run.torque = base
        return behind, before, friction

    def _heat(
        self, run: Run, motion: Motion, history: _History, behind: Floats, final: bool = False
    ) -> tuple[Floats, Floats]:
        """Integrate the heat balance over the recording; sets the true temperature, returns power and probe (N,).

        ``behind`` (N,): what the load side adds behind the torque sensor; its work heats nothing.
        """
        power = np.abs(run.motor_torque * run.motor_rate - (run.torque + behind) * run.rate)
        block = max(int(_COARSE_S * run.rate_hz), 1)
        count = -(-run.time.size // block)
        edges = np.arange(count) * block
        mean = np.add.reduceat(power, edges) / np.diff(np.append(edges, run.time.size))
        world = self._world(count)
        for effect in self.effects:
            effect.heat(world, run, run.clock[edges], slice(0, None, block))
        step = block / run.rate_hz
        course = self._warm(world, step, mean, history)
        grid = step * np.arange(count + 1)
        run.temperature = np.interp(run.time, grid, course)
        lagged, ends = self._lagged(course, step, history.probe)
        if final:
            history.probe = ends
        return power, np.interp(run.time, grid, lagged)

    def _read(
        self,
        run: Run,
        motion: Motion,
        torques: tuple[Floats, Floats, Floats],
        power: Floats,
        probe: Floats,
        angle: bool,
    ) -> Signals:
        behind, before, friction = torques
        run.torque = run.torque + behind
        geared = run.torque + before
        # what the effects add depends on the series only where they modulate it
        first = slice(0, 1)
        if angle or any(e.modulation(run.theta[first], run.rate[first], self.plant.orders) for e in self.effects):
            plain = nominal.transmission_error(self.plant, run.theta, run.side, geared, run.rate, run.temperature)
        else:
            plain = np.zeros(run.time.size)
        whole = self._modulated(run, geared, plain)
        te = self._added("transmission", run)
        shaft = self._added("motor_encoder", run)
        motor_error = self._added("motor_reading", run)
        delay = sum(effect.sensor_delay() for effect in self.effects)
        late = np.interp(run.time - delay, run.time, run.torque) if delay > 0.0 else run.torque
        sensor_error = self._added("sensor_reading", run) + late - run.torque
        lean = self.plant.offset[run.side, 3] / 1000.0
        return Signals(
            run=run,
            motion=motion,
            motor_shaft=RATIO * run.theta + shaft,
            load_angle=run.theta + whole + te if angle else np.full(run.time.size, np.nan),
            motor_torque=run.motor_torque + motor_error,
            load_torque=run.torque + sensor_error + self.plant.load_zero,
            probe=probe,
            power=power,
            added={
                "transmission_error": whole - plain + te - shaft / RATIO - lean * sensor_error + lean * before,
                "motor_torque": friction + motor_error + (before - sensor_error) / RATIO,
                "load_torque": behind + sensor_error,
            },
        )

    def _modulated(self, run: Run, geared: Floats, plain: Floats) -> Floats:
        """The series (N,) with every order as the effects change it; in blocks, for many orders take room."""
        out = plain.copy()
        for start in range(0, plain.size, _BLOCK):
            part = slice(start, start + _BLOCK)
            changes = (effect.modulation(run.theta[part], run.rate[part], self.plant.orders) for effect in self.effects)
            modulations = [m for m in changes if m is not None]
            if not modulations:
                break
            gain = np.prod([1.0 + m[0] for m in modulations], axis=0) - 1.0
            shift = np.sum([m[1] for m in modulations], axis=0)
            out[part] = nominal.transmission_error(
                self.plant,
                run.theta[part],
                run.side[part],
                geared[part],
                run.rate[part],
                run.temperature[part],
                (gain, shift),
            )
        return out


def _last_side(sign: Floats, before: int) -> NDArray[np.int64]:
    """1 where the last motion was positive, 0 where negative."""
    index = np.where(sign != 0.0, np.arange(sign.size), -1)
    index = np.maximum.accumulate(index)
    return np.where(index < 0, before, (sign[np.maximum(index, 0)] > 0.0).astype(np.int64)).astype(np.int64)
