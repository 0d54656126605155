"""Feedforward of the identified model on a bench, with and without, at points that it was not fitted to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.campaigns.planning.facts import facts
from bench.configuration import BenchFile
from bench.cycle.channels import Scaling
from bench.cycle.end import EndKind
from bench.cycle.rig import Rig
from bench.errors import ConfigurationError, DeviceError
from bench.identification.compensation.feedforward import Left, Loop, Series, ripple_free, steady_phases
from bench.protocols import Phase, Segment
from bench.simulation import Simulation

FloatArray = NDArray[np.float64]

MARGIN = 0.02
"""Part of a revolution recorded beyond the one that is scored."""
GAINS: dict[str, float] = {"without": 0.0, "with": 1.0, "added": -1.0}
"""Feedforward of each run; ``added`` is the sign of the paper's figure."""


@dataclass(frozen=True, slots=True)
class OperatingPoint:
    """Load torque N·m and velocity rad/s at the load side."""

    load_torque: float
    velocity: float


@dataclass(frozen=True, slots=True)
class Outcome:
    """What each run leaves at one point, the lubricant temperature there in °C and the counting of the motor's encoder.

    ``counting`` is the RMS in rad, at the load side, of reading whole counts: no feedforward is held to less.
    """

    point: OperatingPoint
    temperature: float
    left: dict[str, Left]
    counting: float


class _AngleSink:
    """Keeps the two angles of the steady segment and where the motor last stood."""

    def __init__(self, scaling: Scaling, ratio: float) -> None:
        self._scaling, self._ratio = scaling, ratio
        self._steady = False
        self._parts: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        self.theta = float("nan")

    def segment(self, segment: Segment | None) -> None:
        self._steady = segment is Segment.STEADY

    def rows(self, raw: dict[str, NDArray[Any]]) -> None:
        if raw["cycle"].size == 0:
            return
        motor, load, time = (
            raw[name] * self._scaling.scale(name) + self._scaling.offset(name)
            for name in ("motor_angle", "load_angle", "time")
        )
        self.theta = float(motor[-1]) / self._ratio
        if self._steady:
            self._parts.append((time, motor / self._ratio, load))

    def event(self, level: str, text: str) -> None:
        """Events are reported at the end of the run."""

    def steady(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Time, θ and q of the steady motion, one whole revolution from its end backwards."""
        time, theta, load = (np.concatenate([part[i] for part in self._parts]) for i in range(3))
        inside = np.abs(theta[-1] - theta) < 2.0 * np.pi
        return time[inside], theta[inside], load[inside]


def _run_phases(rig: Rig, phases: Sequence[Phase], sink: _AngleSink) -> None:
    end = rig.run(phases, sink, lambda: False)
    if end.kind is not EndKind.FINISHED:
        raise DeviceError(f"the compensation run was stopped: {end.text}")


def _measure_residual(
    rig: Rig,
    file: BenchFile,
    point: OperatingPoint,
    series: Series,
    gain: float,
    extra: Series | None,
    notch: Sequence[int],
) -> Left:
    """Ramp up, find the angle reached, run one revolution with the feedforward, ramp down; what is left."""
    bench = facts(file.configuration)
    sink = _AngleSink(rig.scaling, bench.ratio)
    v, tau = point.velocity, point.load_torque
    up = (
        Phase(Segment.RAMP_UP, bench.velocity_ramp_s(0.0, v), v, 0.0),
        Phase(Segment.RAMP_UP, bench.torque_ramp_s(0.0, tau), v, tau),
        Phase(Segment.RAMP_UP, bench.settling_s, v, tau),
    )
    _run_phases(rig, up, sink)
    duration = (1.0 + MARGIN) * 2.0 * np.pi / abs(v)
    _run_phases(rig, steady_phases(series, sink.theta, v, duration, tau, gain, extra), sink)
    time, theta, load = sink.steady()
    down = (
        Phase(Segment.RAMP_DOWN, bench.torque_ramp_s(tau, 0.0), v, 0.0),
        Phase(Segment.RAMP_DOWN, bench.velocity_ramp_s(v, 0.0), 0.0, 0.0),
    )
    _run_phases(rig, down, sink)
    return ripple_free(time, theta, load, v, notch, series.orders)


def compensate(
    file: BenchFile,
    simulation: Simulation,
    points: Sequence[OperatingPoint],
    *,
    seed: int = 0,
    runs: Sequence[str] = ("without", "with"),
    notch_orders: Sequence[int] = (150, 300),
    loop: tuple[float, float] | None = None,
    progress: Callable[[str], None] | None = None,
) -> list[Outcome]:
    """Run every point with each feedforward of ``runs`` on an emulated bench; names of runs as in :data:`GAINS`.

    ``loop`` is the input drive's velocity loop, if it is to be allowed for: proportional gain in N·m·s/rad at the motor
    shaft and integral time in s. Inertia and viscous friction are the model's.

    Raises
    ------
    ConfigurationError
        The model has no transmission error for a direction, or the bench is not an emulated one.
    DeviceError
        The bench stopped.
    """
    model = simulation.transmission_error()
    if model is None:
        raise ConfigurationError("the model holds no transmission error; identify it first with 'bench identify'")
    if not file.configuration.bus.in_process:
        raise ConfigurationError(f"bench {file.configuration.name} is no emulated one; it is tried there only")
    friction = simulation.value("load.bearing_friction", "f_b") or 0.0
    shaft = None
    if loop is not None:
        inertia, viscous = simulation.value("motor.inertia", "J"), simulation.value("friction.viscous", "f_v")
        shaft = Loop(*loop, inertia or 0.0, viscous or 0.0, facts(file.configuration).ratio)
    outcomes = []
    with Rig(file, seed=seed) as rig:
        rig.enable()
        counting = abs(rig.scaling.scale("motor_angle")) / facts(file.configuration).ratio / np.sqrt(12.0)
        for point in points:
            fourier = model.direction(np.sign(point.velocity))
            if fourier is None:
                raise ConfigurationError(f"the model has no series for the direction of {point.velocity:.4g} rad/s")
            # The load motor is commanded open loop; bearing friction adds to it at the gearbox.
            torque = point.load_torque + friction * float(np.sign(point.velocity))
            temperature = rig.temperature
            series = Series.at(fourier, torque, point.velocity, temperature)
            left = {}
            for name in runs:
                if progress:
                    progress(f"{point.load_torque:.0f} N·m, {np.degrees(point.velocity):.1f} deg/s, {name}")
                extra = None
                if shaft is not None and GAINS[name] != 0.0:
                    extra = shaft.extra(series, GAINS[name], torque, point.velocity)
                left[name] = _measure_residual(rig, file, point, series, GAINS[name], extra, notch_orders)
            outcomes.append(Outcome(point, temperature, left, counting))
    return outcomes
