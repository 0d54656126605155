"""Campaign designs an examiner would think of: which points are run, in which order, with which repeats."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import qmc

DEG = np.pi / 180.0


@dataclass(frozen=True, slots=True)
class Point:
    """One recording to be made.

    Attributes:
        kind: a kind of the recording format.
        torque: N·m, in the torque sensor's sign.
        rate: rad/s at the load side, signed.
        temperature: °C aimed at.
        span: reversal amplitude in rad, or duration in s of heating, cooling and dwell.
        flying: the recording starts and ends at speed: no ramps in the file.
        pause: standstill before the recording in s, unrecorded.
    """

    kind: str
    torque: float
    rate: float
    temperature: float
    span: float = 0.0
    flying: bool = False
    pause: float = 8.0


@dataclass(frozen=True, slots=True)
class Design:
    """What a folder's points are drawn from.

    Attributes:
        loads, speeds: grid levels (N·m, deg/s, absolute speed).
        warm_ups: how many times the bench warms up from ambient.
        levels: temperature levels of a warm-up (°C above ambient reached by heating runs).
        directions: +1, −1 or both.
        grid, validation, anchors: number of grid points, Sobol points and repeats of each of two anchor points.
        transients: counts of reversal, torque_ramp and velocity_ramp recordings.
        flying: constant-velocity recordings without ramps.
        heating: heating and cooling runs are recorded.
        heat_time, heat_speed: about how long (s) and how fast (rad/s at the motor) a heating run is.
        sobol_free: Sobol points lie anywhere within the bounds rather than on the grid's levels.
    """

    loads: tuple[float, ...] = (-1000.0, -500.0, -250.0, -100.0, 0.0, 100.0, 250.0, 500.0, 1000.0)
    speeds: tuple[float, ...] = (2.5, 5.0, 7.5, 10.0)
    warm_ups: int = 2
    levels: int = 3
    directions: tuple[int, ...] = (1, -1)
    grid: int = 30
    validation: int = 6
    anchors: int = 3
    transients: tuple[int, int, int] = (3, 3, 2)
    flying: bool = False
    heating: bool = True
    heat_time: float = 420.0
    heat_speed: tuple[float, float] = (150.0, 200.0)
    sobol_free: bool = True


def draw_points(design: Design, rng: np.random.Generator) -> list[Point]:
    """The points of one campaign in running order, 45 to 60 of them."""
    stages = [(cycle, level) for cycle in range(design.warm_ups) for level in range(design.levels)]
    cells = [(load, speed * sign) for load in design.loads for speed in design.speeds for sign in design.directions]
    grid = _spread(cells, design.grid, rng)
    anchors = [(design.loads[0], design.speeds[0]), (design.loads[-1], -design.speeds[-1])]
    if len(design.directions) == 1:
        anchors = [(load, abs(speed) * design.directions[0]) for load, speed in anchors]
    plan: list[list[Point]] = [[] for _ in stages]
    _deal(plan, [_steady("constant_velocity", *cell, design) for cell in grid], rng)
    _deal(plan, [_steady("constant_velocity", *anchor, design) for anchor in anchors * design.anchors], rng)
    _deal(plan, [_steady("validation", *cell, design) for cell in _sobol(design, rng)], rng)
    _deal(plan, _transients(design, rng), rng)
    points: list[Point] = []
    for (cycle, level), stage in zip(stages, plan, strict=True):
        if level == 0 and cycle > 0:
            points.extend(_cool_down(design, rng))
        elif level > 0:
            points.extend(_heat(design, rng))
        aim = 22.0 + 10.0 * level
        points.extend(replace(p, temperature=aim) for p in stage)
    return points


def _steady(kind: str, torque: float, speed: float, design: Design) -> Point:
    return Point(kind, torque, speed * DEG, 0.0, flying=design.flying)


def _spread(cells: list[tuple[float, float]], count: int, rng: np.random.Generator) -> list[tuple[float, float]]:
    """``count`` cells that cover the grid evenly: whole shuffled copies first, then a part of one."""
    out: list[tuple[float, float]] = []
    while len(out) < count:
        out.extend(cells[i] for i in rng.permutation(len(cells)))
    return out[:count]


def _sobol(design: Design, rng: np.random.Generator) -> list[tuple[float, float]]:
    if design.validation == 0:
        return []
    unit = qmc.Sobol(3, seed=rng).random(8 * (design.validation // 8 + 1))[: design.validation]
    low, high = min(design.loads), max(design.loads)
    out = []
    for a, b, c in unit:
        load = low + a * (high - low)
        speed = design.speeds[0] + b * (design.speeds[-1] - design.speeds[0])
        if not design.sobol_free:
            load = min(design.loads, key=lambda x: abs(x - load))
            speed = min(design.speeds, key=lambda x: abs(x - speed))
        out.append((float(load), float(speed) * design.directions[int(c * len(design.directions))]))
    return out


def _transients(design: Design, rng: np.random.Generator) -> list[Point]:
    reversals, torque_ramps, velocity_ramps = design.transients
    top = max(abs(load) for load in design.loads)
    out = []
    for i in range(reversals):
        load = (0.0, 0.4 * top, -0.4 * top)[i % 3]
        out.append(
            Point("reversal", load, float(rng.choice([1.0, 2.5, 5.0])) * DEG, 0.0, (12.0, 25.0, 40.0)[i % 3] * DEG)
        )
    for i in range(torque_ramps):
        speed = float(rng.choice([2.5, 5.0, 7.5])) * (1.0, -1.0)[i % 2]
        out.append(Point("torque_ramp", (top, -top)[(i // 2) % 2], speed * DEG, 0.0))
    for i in range(velocity_ramps):
        load = (0.0, 0.5 * top)[i % 2]
        out.append(Point("velocity_ramp", load, design.speeds[-1] * (1.0, -1.0)[i % 2] * DEG, 0.0))
    return out


def _heat(design: Design, rng: np.random.Generator) -> list[Point]:
    rate = float(rng.uniform(*design.heat_speed)) / 185.0
    time = design.heat_time * float(rng.uniform(0.8, 1.2))
    if design.heating:
        return [Point("heating", 0.0, rate * float(rng.choice([1.0, -1.0])), 0.0, span=time, pause=15.0)]
    return [Point("unrecorded", 0.0, rate, 0.0, span=time, pause=15.0)]


def _cool_down(design: Design, rng: np.random.Generator) -> list[Point]:
    away = float(rng.uniform(2.0, 4.0)) * 3600.0
    if not design.heating:
        return [Point("pause", 0.0, 0.0, 0.0, pause=away)]
    return [
        Point("cooling", 0.0, 0.0, 0.0, span=240.0, pause=20.0),
        Point("dwell", float(rng.choice([0.0, 250.0])), 0.0, 0.0, span=40.0, pause=away),
    ]


def _deal(plan: list[list[Point]], points: list[Point], rng: np.random.Generator) -> None:
    """Spread points over the stages in turn, at random places in each."""
    start = int(rng.integers(len(plan)))
    for i, point in enumerate(points):
        stage = plan[(start + i) % len(plan)]
        stage.insert(int(rng.integers(len(stage) + 1)), point)
