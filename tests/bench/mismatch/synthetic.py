"""Small data sets made of the simulation's own equations, in memory: what is concealed is known to the last number."""

from __future__ import annotations

import itertools
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from bench.mismatch.candidates import Candidate, Range, frame_of
from bench.mismatch.dataset import Dataset, Member
from bench.mismatch.rows import Rows
from bench.simulation.frame import Frame, concatenate
from bench.simulation.terms import LIBRARY

RATIO = 185.0
COVERED = Range(1000.0, 0.03, 0.17, 22.0, 40.0, 0.0, 0.0)
CHANNELS = ("time", "motor_angle", "load_angle", "motor_torque", "load_torque", "load_motor_torque", "temperature")
SIGMA = {"motor_torque": 0.02, "load_torque": 1.5, "temperature": 0.01}


def effect(
    name: str, channel: str, form: str, frame: Frame, linear: tuple[float, ...], point: tuple[float, ...]
) -> Any:
    """What a term of the library adds at the rows of a frame."""
    chosen = next(f for f in LIBRARY[name].forms[channel] if f.name == form)
    return chosen.columns(frame, point) @ np.asarray(linear)


def frames(speeds: tuple[float, ...] = (0.02, 0.06, 0.1, 0.17), reversals: int = 4) -> list[tuple[str, Frame]]:
    """Ideal motions of a campaign, one after another: kind and rows of each recording."""
    points: list[tuple[str, Candidate]] = []
    torques = (-1000.0, -300.0, 0.0, 400.0, 1000.0)
    for k, (torque, speed) in enumerate(itertools.product(torques, speeds)):
        points.append(("constant_velocity", Candidate("constant_velocity", torque, speed * (-1.0) ** k)))
        if k % 3 == 0:
            points.append(("constant_velocity", Candidate("constant_velocity", torque, -speed * (-1.0) ** k)))
    points += [("validation", Candidate("constant_velocity", t, v)) for t, v in ((250.0, 0.05), (-700.0, -0.12))]
    points += [("validation", Candidate("constant_velocity", t, v)) for t, v in ((700.0, 0.14), (-250.0, -0.03))]
    for k in range(reversals):
        told = (("amplitude", '"10 deg"'),)
        points.append(("reversal", Candidate("reversal", 400.0 * (k % 2), 0.05, None, told)))
    order = np.random.default_rng(2).permutation(len(points))
    out: list[tuple[str, Frame]] = []
    time, travel = 0.0, 0.0
    for number, k in enumerate(order):
        kind, point = points[k]
        frame = frame_of(point, COVERED, RATIO)
        n = min(frame.size, 70)
        frame = frame.take(np.arange(n))
        temperature = np.full(n, 22.0 + 18.0 * ((number * 7) % len(points)) / len(points))
        out.append(
            (
                kind,
                replace(
                    frame,
                    recording=np.full(n, number, dtype=np.int64),
                    time=frame.elapsed + time,
                    temperature=temperature,
                    travel=frame.travel + travel,
                ),
            )
        )
        time += float(frame.elapsed[-1]) + 60.0
        travel = float(out[-1][1].travel[-1])
    return out


def dataset(parts: list[tuple[str, Frame]], **channels: Rows) -> Dataset:
    """A data set of recordings of these kinds; the validation points are held out."""
    members = []
    for number, (kind, frame) in enumerate(parts):
        setpoint = SimpleNamespace(
            load_torque=float(np.median(frame.torque)),
            velocity=float(np.median(frame.velocity)),
            temperature=float(np.median(frame.temperature)),
        )
        recording: Any = SimpleNamespace(
            recording_id=f"{number:03d}",
            kind=kind,
            channels=CHANNELS,
            specs={},
            setpoint=setpoint,
            gearbox=SimpleNamespace(ratio=RATIO),
        )
        point = (kind, setpoint.load_torque, round(setpoint.velocity, 4), 0.0)
        held = kind == "validation"
        members.append(Member(number, recording, point, held, -1 if held else number, "zero", f"{number:03d}"))
    data = Dataset(members, [])
    data.heat, data.angle = channels.pop("heat", None), channels.pop("angle", None)
    data.slow = channels
    return data


def rows(frame: Frame, y: Any, sigma: float, seed: int) -> Rows:
    """Rows of 100 samples each with white noise of ``sigma`` a sample."""
    noise = np.random.default_rng(seed).normal(0.0, sigma / 10.0, frame.size)
    return Rows(frame, y + noise, np.full(frame.size, 100.0), np.full(frame.size, sigma**2))


def motor_torque(frame: Frame) -> Any:
    """The nominal input torque balance."""
    f, u = frame, frame.ratio
    w = f.omega
    own = 0.5 * f.direction + 0.006 * w - 1e-4 * w * (f.temperature - 25.0) + 0.04 * f.direction * np.abs(f.torque) / u
    return f.torque / u + own + 0.003 * f.acceleration + 0.05


def torques(
    extra_motor: Any = None, extra_load: Any = None, speeds: tuple[float, ...] = (0.02, 0.06, 0.1, 0.17)
) -> Dataset:
    """Motor torque and load torque; ``extra_*`` take the frame and return what is concealed in the channel.

    What the torque sensor reads wrong is not what acts on the gearbox.
    """
    parts = frames(speeds)
    frame = concatenate([f for _, f in parts])
    error = np.zeros(frame.size) if extra_load is None else extra_load(frame)
    motor = motor_torque(frame) + (0.0 if extra_motor is None else extra_motor(frame))
    load = frame.load_motor_torque + 8.0 * frame.direction + 4.0 + error
    seen = replace(frame, torque=frame.torque + error)
    return dataset(
        parts,
        motor_torque=rows(seen, motor, SIGMA["motor_torque"], 1),
        load_torque=rows(seen, load, SIGMA["load_torque"], 2),
    )


def transmission(
    vectors: Any = None, extra: Any = None, turns: int = 26, step: float = 2.4e-3, sigma: float = 3e-6
) -> Dataset:
    """Transmission error over one revolution each: orders 1, 46 and 92 of the series; ``vectors(f, speed)`` a factor on
    them, ``extra(frame)`` what is added.
    """
    rng = np.random.default_rng(5)
    parts: list[tuple[str, Frame]] = []
    time = 0.0
    for number in range(turns):
        speed = float(rng.choice([0.05, 0.08, 0.11, 0.14, 0.17])) * (-1.0) ** number
        torque, temperature = float(rng.choice([-800.0, 0.0, 800.0])), float(rng.uniform(22.0, 40.0))
        n = int(2.02 * np.pi / step)
        theta = step * np.arange(n) * np.sign(speed) + float(rng.uniform(0.0, 6.0))
        one = frame_of(Candidate("constant_velocity", torque, speed), COVERED, RATIO).take(np.zeros(n, dtype=np.int64))
        elapsed = step * np.arange(n) / abs(speed)
        frame = replace(
            one,
            recording=np.full(n, number, dtype=np.int64),
            count=np.full(n, 6.0),
            theta=theta,
            q=theta,
            elapsed=elapsed,
            time=time + elapsed,
            temperature=np.full(n, temperature),
            travel=number * 6.3 + step * np.arange(n),
            reversal_travel=1.0 + step * np.arange(n),
            reversal_time=5.0 + elapsed,
            step=np.where(np.arange(n) > 0, step / abs(speed), 0.0),
        )
        parts.append(("validation" if number % 6 == 4 else "constant_velocity", frame))
        time += float(elapsed[-1]) + 60.0
    frame = concatenate([f for _, f in parts])
    y = -frame.torque / 4e6
    for order, size in ((1, 2e-5), (46, 3e-5), (92, 1e-5)):
        vector = size * (1.0 + 0.1 * frame.torque / 1000.0) * np.exp(0.3j * order)
        factor = 1.0 if vectors is None else vectors(order, np.abs(frame.velocity))
        y = y + (vector * factor * np.exp(1j * order * frame.theta)).imag
    if extra is not None:
        y = y + extra(frame)
    noise = np.random.default_rng(6).normal(0.0, sigma / np.sqrt(6.0), frame.size)
    angle = Rows(frame, y + noise, np.full(frame.size, 6.0), np.full(frame.size, sigma**2))
    return dataset(parts, angle=angle)


def temperatures(lag: float = 0.0, sigma: float = 0.01) -> Dataset:
    """Heating runs and rests of the nominal heat balance, the thermometer lagging by ``lag`` s."""
    parts: list[tuple[str, Frame]] = []
    courses = []
    start, time = 22.0, 0.0
    step, n = 2.0, 150
    for number in range(14):
        heated = number % 2 == 0
        speed = 1.0 if heated else 0.05
        driven = (np.arange(n) >= 20) & (np.arange(n) < 100)
        power = np.where(driven, (320.0 if heated else 40.0) + 20.0 * (number % 3), 0.0)
        one = frame_of(Candidate("constant_velocity", 0.0, speed), COVERED, RATIO).take(np.zeros(n, dtype=np.int64))
        true = np.empty(n)
        level = start
        for i in range(n):
            true[i] = level
            level += step * (power[i] / 2.0e4 - (level - 21.0) / (0.25 * 2.5e4))
        seen = np.empty(n)
        shown = true[0]
        for i in range(n):
            shown = true[i] + (shown - true[i]) * (np.exp(-step / lag) if lag > 0 else 0.0)
            seen[i] = shown
        elapsed = step * np.arange(n)
        frame = replace(
            one,
            recording=np.full(n, number, dtype=np.int64),
            elapsed=elapsed,
            time=time + elapsed,
            temperature=seen,
            power=power,
            velocity=np.where(power > 0, speed, 0.0),
            step=np.where(np.arange(n) > 0, step, 0.0),
        )
        parts.append(("validation" if number in (5, 8) else "heating" if heated else "constant_velocity", frame))
        courses.append(seen)
        start, time = float(true[-1]) - 3.0, time + float(elapsed[-1]) + 300.0
    frame = concatenate([f for _, f in parts])
    return dataset(parts, heat=rows(frame, np.concatenate(courses), sigma, 9))
