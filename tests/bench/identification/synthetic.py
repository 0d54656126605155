"""A quick bench for tests: recordings made from the nominal equations, with quantised encoders and sensor noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.recording import ChannelSpec, Gearbox, RecordingHeader, Segment, Setpoint, write_recording
from bench.simulation import FourierSet, Standardisation, TransmissionErrorModel
from bench.simulation.terms.nominal.transmission_error import PAPER_ORDERS

FloatArray = NDArray[np.float64]

RATIO = 185.0
STIFFNESS = 3.2e6
COUNT = 2.0 * np.pi / 8192


def true_model(orders: Sequence[float] = PAPER_ORDERS, seed: int = 5) -> TransmissionErrorModel:
    """A plausible transmission error: some 25 µrad and below, phases that move by some tenths of a radian."""
    rng = np.random.default_rng(seed)
    scale = Standardisation(np.array([0.0, 0.0, 35.0]), np.array([1000.0, np.deg2rad(10.0), 15.0]))
    sets = []
    for _ in range(2):
        size = len(orders)
        level = 3e-5 / (1.0 + np.arange(size) ** 0.7)
        amplitude = rng.normal(size=(size, 10)) * 0.06 * level[:, None]
        amplitude[:, 9] = level
        phase = rng.normal(size=(size, 10)) * 0.08
        phase[:, 9] = rng.uniform(-3, 3, size)
        offset = rng.normal(size=10) * 3e-6
        offset[3] -= 1000.0 / STIFFNESS
        sets.append(
            FourierSet(
                np.asarray(orders, dtype=np.float64), scale.to_raw(amplitude), scale.to_raw(phase), scale.to_raw(offset)
            )
        )
    return TransmissionErrorModel(sets[0], sets[1])


@dataclass
class Bench:
    """Parameters of the synthetic bench; ``write`` makes one recording."""

    folder: Path
    model: TransmissionErrorModel = field(default_factory=true_model)
    rate: float = 500.0
    seed: int = 1
    weak: tuple[tuple[int, float], ...] = ()
    zero: float = 2.0
    friction: tuple[float, float, float, float] = (0.5, 0.006, -1e-4, 0.04)
    clock: datetime = datetime(2026, 1, 5, 8, 0, tzinfo=UTC)
    number: int = 0
    serial: str | None = None

    def write(
        self,
        torque: float,
        velocity: float,
        temperature: float,
        kind: str = "constant_velocity",
        revolutions: float = 1.02,
    ) -> Path:
        """Record a ramp, ``revolutions`` of steady motion and a ramp; N·m, rad/s at the load side, °C."""
        rng = np.random.default_rng((self.seed, self.number))
        ramp = 0.5
        steady = revolutions * 2.0 * np.pi / abs(velocity)
        n = int((2 * ramp + steady) * self.rate)
        t = np.arange(n) / self.rate
        speed = velocity * np.clip(np.minimum(t / ramp, (t[-1] - t) / ramp), 0.0, 1.0)
        theta = 0.7 + np.cumsum(speed) / self.rate
        heat = temperature + 0.004 * t
        ripple = 5.0 * np.sin(150 * theta + 0.7)
        d = np.sign(velocity)
        tau = torque + 8.0 * d + ripple + 3.0 * self._acceleration(speed)
        te = self.model.evaluate(theta, tau, np.full(n, velocity), heat, np.full(n, d))
        for order, amplitude in self.weak:
            te = te + amplitude * np.sin(order * theta + order)
        f_c, f_v, f_vt, f_l = self.friction
        omega = speed * RATIO
        motor = tau / RATIO + np.sign(omega) * (f_c + f_l * np.abs(tau) / RATIO) + f_v * omega
        motor = motor + f_vt * omega * (heat - 25.0) + 0.0029 * self._acceleration(omega) + 0.04
        motor_counts = np.rint(theta * RATIO / COUNT + rng.normal(size=n) * 0.3).astype(np.int64)
        load_scale = 2.0 * np.pi / 2**25
        first, last = int(ramp * self.rate), n - int(ramp * self.rate)
        self.number += 1
        name = f"r{self.number:03d}"
        self.clock += timedelta(seconds=t[-1] + 20.0)

        def angle(name: str, counts: NDArray[np.int64], scale: float) -> tuple[NDArray[np.int64], ChannelSpec]:
            return counts, ChannelSpec.of(name, scale=scale)

        def analogue(name: str, values: FloatArray, scale: float) -> tuple[NDArray[np.int16], ChannelSpec]:
            return np.rint(values / scale).astype(np.int16), ChannelSpec.of(name, scale=scale)

        path = self.folder / f"{name}.h5"
        write_recording(
            path,
            RecordingHeader(
                name, "synthetic", kind, self.clock, self.rate, "emulator",
                Setpoint(torque, velocity, temperature), Gearbox(RATIO, 24, 96, 45, 46),
                gearbox_serial=self.serial,
            ),
            {
                "time": (np.arange(n, dtype=np.int64), ChannelSpec.of("time", scale=1.0 / self.rate)),
                "motor_angle": angle("motor_angle", motor_counts, COUNT),
                "load_angle": angle("load_angle", np.rint((theta + te) / load_scale).astype(np.int64), load_scale),
                "motor_torque": analogue("motor_torque", motor + rng.normal(size=n) * 0.02, 0.0064),
                "load_torque": analogue("load_torque", tau + self.zero + rng.normal(size=n) * 0.4, 0.305),
                "load_motor_torque": analogue("load_motor_torque", torque + ripple + rng.normal(size=n) * 0.8, 0.4),
                "temperature": analogue("temperature", heat + rng.normal(size=n) * 0.02, 0.1),
                "cycle": (np.arange(n, dtype=np.int64), ChannelSpec.of("cycle")),
            },
            [Segment("ramp_up", 0, first), Segment("steady", first, last), Segment("ramp_down", last, n)],
            accepted=True,
        )  # fmt: skip
        return path

    def _acceleration(self, speed: FloatArray) -> FloatArray:
        return np.asarray(np.gradient(speed) * self.rate)


def campaign(folder: Path, *, rate: float = 250.0, weak: bool = False) -> Bench:
    """A small campaign: torques × velocities (deg/s, both ways) × temperatures, and four validation points."""
    bench = Bench(folder, rate=rate, weak=((2, 4e-6), (5, 3e-6), (37, 3e-6), (110, 4e-6)) if weak else ())
    for temperature in (22.0, 35.0, 49.0):
        for torque in (-1000.0, -350.0, 350.0, 1000.0):
            for velocity in (6.0, 8.0, 10.0):
                for d in (1, -1):
                    bench.write(torque, float(d * np.deg2rad(velocity)), temperature)
    for torque, velocity, temperature in ((-750.0, 7.0, 26.0), (300.0, 9.0, 44.0), (650.0, -8.5, 31.0)):
        bench.write(torque, float(np.deg2rad(velocity)), temperature, kind="validation")
    return bench
