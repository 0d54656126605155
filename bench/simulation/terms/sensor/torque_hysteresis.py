"""The torque sensor's own hysteresis."""

from __future__ import annotations

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import FORGETS, NOISE_SHARE, RATES, begins, play, relaxing
from bench.simulation.terms.base import LOAD_TORQUE, Form, Point, Symbol, Term, columns, logarithmic, top

WIDEST = 0.4
"""of the largest torque: a loop that is wider is hardly turned, and looks like a gain"""


def _widths(frame: Frame) -> tuple[Point, ...]:
    largest = top(frame.load_motor_torque)
    return logarithmic(0.06 * largest, WIDEST * largest, 8)


def _play(frame: Frame, point: Point) -> FloatArray:
    x = frame.load_motor_level
    return columns((x - play(x, frame, point[0])) / point[0])


def _play_kept(frame: Frame, point: Point) -> FloatArray:
    x = frame.load_motor_level
    return columns((x - play(x, frame, point[0], "kept")) / point[0])


def _dahl(frame: Frame, point: Point) -> FloatArray:
    return columns(relaxing(_quiet(frame, point[0]), frame, point[0]))


def _dahl_kept(frame: Frame, point: Point) -> FloatArray:
    return columns(relaxing(_quiet(frame, point[0]), frame, point[0], "kept"))


def _forgetting(frame: Frame, point: Point) -> FloatArray:
    return columns(relaxing(_quiet(frame, point[0]), frame, point[0], "fresh", point[1]))


def _forgetting_points(frame: Frame) -> tuple[Point, ...]:
    largest = top(frame.load_motor_torque)
    widths = logarithmic(0.06 * largest, WIDEST * largest, 4)
    return tuple((w, rate) for (w,) in widths for rate in RATES)


def _quiet(frame: Frame, width: float) -> FloatArray:
    """Load torque without the noise that would turn the relaxing state to and fro."""
    return play(frame.load_motor_level, frame, NOISE_SHARE * width)


H_S = Symbol("h_s", "N*m", "half width of the loop")
RATE = Symbol("r", "1/s", "rate at which the loop forgets, for the load wavers to and fro", 0.0)
W_H = Symbol("w_h", "N*m", "torque over which the loop turns", 0.0)

_PLAY = "load_torque += h_s*(x - y)/w_h, y = max(x - w_h, min(x + w_h, y)), x = load_motor_torque"
_DAHL, _FORGETTING = (
    f"load_torque += h_s*z, dz = (1 - z*sgn(dx))*dx/w_h{forgets}, "
    f"x = max(l - {NOISE_SHARE:g}*w_h, min(l + {NOISE_SHARE:g}*w_h, x)), l = load_motor_torque"
    for forgets in ("", FORGETS)
)

TERM = Term(
    effect="sensor.torque_hysteresis",
    name="hysteresis of the torque sensor",
    equation="load_torque += h_s*z, dz = (1 - z*sgn(dx))*dx/w_h (or play of half width w_h), x = load_motor_torque",
    reference="Krasnosel'skii and Pokrovskii, Systems with Hysteresis, Springer 1989; VDI/VDE 2646",
    where="load_torque, by whether the load rises or falls",
    forms={
        LOAD_TORQUE: (
            Form("play", _play, (H_S,), (W_H,), _widths, equation=f"{_PLAY}, {begins('y', 'fresh')}"),
            Form(
                "play_kept",
                _play_kept,
                (H_S,),
                (W_H,),
                _widths,
                remembers=True,
                equation=f"{_PLAY}, {begins('y', 'kept')}",
            ),
            Form("dahl", _dahl, (H_S,), (W_H,), _widths, equation=f"{_DAHL}, {begins('z', 'fresh')}", blur=NOISE_SHARE),
            Form(
                "dahl_kept",
                _dahl_kept,
                (H_S,),
                (W_H,),
                _widths,
                remembers=True,
                equation=f"{_DAHL}, {begins('z', 'kept')}",
                blur=NOISE_SHARE,
            ),
            Form(
                "forgetting",
                _forgetting,
                (H_S,),
                (W_H, RATE),
                _forgetting_points,
                equation=f"{_FORGETTING}, {begins('z', 'fresh')}",
                blur=NOISE_SHARE,
            ),
        )
    },
    variables=("torque_path",),
)
