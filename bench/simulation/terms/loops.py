"""Loops over a torque: path dependence that a transmission and a torque sensor have alike."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import NOISE_SHARE, RATES, RATES_IN_MOTION, Between, begins, play, relaxing
from bench.simulation.terms.base import Columns, Form, Point, Symbol, columns, logarithmic, top

BETWEEN: tuple[Between, ...] = ("fresh", "followed", "released")
"""what loops do between recordings: they begin anew, or the load goes from one to the next, with or without a rest at
zero
"""
OF_A_PLAY: tuple[Between, ...] = ("fresh", "kept", "released")
"""the same of a play: one that stays is where the load's next value takes it"""
SUFFIX = {"fresh": "", "kept": "_kept", "followed": "_followed", "released": "_released"}
NARROWEST = 0.06
"""of the largest torque"""
WIDEST = 0.4
"""of the largest torque: a loop that is wider is hardly turned, and looks like a gain or a compliance"""
NARROWEST_STACK = 0.08
"""of the largest torque, the middle of a stack's plays"""
NARROWEST_PAIR = 0.12
"""of the largest torque, the wider of two plays"""
STACK = (0.4, 1.0, 2.2)
"""widths of a stack of plays, in units of its parameter"""
RATIOS = (2.5, 8.0)
"""of the widths of two plays that are tried"""


@dataclass(frozen=True, slots=True)
class Loops:
    """What loops are over: ``level(frame)`` the torque without slow noise (n,), called ``torque`` in equations.

    What they add to (``output``); the ``size`` of a loop, its ``width``, the ``rate`` at which it forgets in time and
    that ``in_motion``; ``relaxing``: name of the form that relaxes; ``widest_stack``: of the largest torque, the middle
    of a stack's plays.
    """

    level: Callable[[Frame], FloatArray]
    torque: str
    output: str
    size: Symbol
    width: Symbol
    rate: Symbol
    in_motion: Symbol
    relaxing: str
    widest_stack: float = WIDEST

    def forms(self) -> tuple[Form, ...]:
        """Play, a state that relaxes (Dahl), a stack of plays, two plays, and a state that forgets in motion, each with
        what it does between recordings; and one that forgets in time.
        """
        h, w, torque, out = self.size.symbol, self.width.symbol, self.torque, self.output
        play_text = f"{out} += {h}*({torque} - y)/{w}, y = max({torque} - {w}, min({torque} + {w}, y))"
        relaxing_text, forgetting_text, dither_text = (
            f"{out} += {h}*z, dz = (1 - z*sgn(dx))*dx/{w}{forgets}, "
            f"x = max({torque} - {NOISE_SHARE:g}*{w}, min({torque} + {NOISE_SHARE:g}*{w}, x))"
            for forgets in ("", f" - {self.rate.symbol}*z*dt", f" - {self.in_motion.symbol}*z*abs(dtheta)")
        )
        parts = range(1, len(STACK) + 1)
        sizes = tuple(
            Symbol(f"{h}_{k}", self.size.unit, f"half width of the loop of the play of {share:g}*{w}")
            for k, share in zip(parts, STACK, strict=True)
        )
        stack_text = "{} += {}, y_k = max({} - w_k, min({} + w_k, y_k)), {}".format(
            out,
            " + ".join(f"{h}_{k}*({torque} - y_{k})/w_{k}" for k in parts),
            torque,
            torque,
            ", ".join(
                f"w_{k} = {f'{share:g}*' if share != 1.0 else ''}{w}" for k, share in zip(parts, STACK, strict=True)
            ),
        )
        two = (
            Symbol(f"{h}_a", self.size.unit, "half width of the narrower loop"),
            Symbol(f"{h}_b", self.size.unit, "half width of the wider loop"),
        )
        two_widths = (
            Symbol(f"{w}_b", self.width.unit, "torque over which the wider loop turns", 0.0),
            Symbol("rho", "1", "width of the wider loop over that of the narrower", 1.0),
        )
        pair_text = "{} += {}, y_k = max({} - {}_k, min({} + {}_k, y_k)), {}_a = {}_b/rho".format(
            out, " + ".join(f"{h}_{k}*({torque} - y_{k})/{w}_{k}" for k in "ab"), torque, w, torque, w, w, w
        )
        one, width, width_and_rate = (self.size,), (self.width,), (self.width, self.in_motion)
        noise = NOISE_SHARE
        kinds = (
            ("play", self._play, one, width, self.widths, play_text, "y", OF_A_PLAY, 0.0),
            (self.relaxing, self._relaxing, one, width, self.widths, relaxing_text, "z", BETWEEN, noise),
            ("stack", self._stack, sizes, width, self.widths_of_a_stack, stack_text, "y_k", OF_A_PLAY, 0.0),
            ("pair", self._pair, two, two_widths, self._pair_points, pair_text, "y_k", OF_A_PLAY, 0.0),
            (
                "dithered",
                self._dithered,
                one,
                width_and_rate,
                self._with_rates(RATES_IN_MOTION),
                dither_text,
                "z",
                BETWEEN,
                noise,
            ),
        )
        return (
            *(
                Form(
                    f"{name}{SUFFIX[between]}",
                    make(between),
                    linear,
                    nonlinear,
                    grid if between in ways else _not_looked_for,
                    one_sign=len(linear) > 1,
                    remembers=between != "fresh",
                    equation=f"{text}, {begins(state, between)}",
                    blur=blur,
                )
                for name, make, linear, nonlinear, grid, text, state, ways, blur in kinds
                # files from before have relaxing states that stay
                for between in dict.fromkeys((*ways, "kept"))
            ),
            Form(
                "forgetting",
                self._forgetting,
                (self.size,),
                (self.width, self.rate),
                self._with_rates(RATES),
                equation=f"{forgetting_text}, {begins('z', 'fresh')}",
                blur=NOISE_SHARE,
            ),
        )

    def widths(self, frame: Frame) -> tuple[Point, ...]:
        """Widths of a loop to try."""
        largest = top(self.level(frame))
        return logarithmic(NARROWEST * largest, WIDEST * largest, 8)

    def widths_of_a_stack(self, frame: Frame) -> tuple[Point, ...]:
        """Widths of a stack's middle play to try."""
        largest = top(self.level(frame))
        return logarithmic(NARROWEST_STACK * largest, self.widest_stack * largest, 4)

    def _plays(self, frame: Frame, widths: Iterable[float], between: Between) -> FloatArray:
        x = self.level(frame)
        return columns(*((x - play(x, frame, w, between)) / w for w in widths))

    def _play(self, between: Between) -> Columns:
        return lambda frame, point: self._plays(frame, point, between)

    def _stack(self, between: Between) -> Columns:
        return lambda frame, point: self._plays(frame, (share * point[0] for share in STACK), between)

    def _pair(self, between: Between) -> Columns:
        return lambda frame, point: self._plays(frame, (point[0] / point[1], point[0]), between)

    def _pair_points(self, frame: Frame) -> tuple[Point, ...]:
        largest = top(self.level(frame))
        wider = logarithmic(NARROWEST_PAIR * largest, WIDEST * largest, 3)
        return tuple((w, ratio) for (w,) in wider for ratio in RATIOS)

    def _state(self, frame: Frame, width: float, between: Between, rate: float | FloatArray = 0.0) -> FloatArray:
        return columns(relaxing(self._quiet(frame, width, between), frame, width, between, rate))

    def _relaxing(self, between: Between) -> Columns:
        return lambda frame, point: self._state(frame, point[0], between)

    def _forgetting(self, frame: Frame, point: Point) -> FloatArray:
        return self._state(frame, point[0], "fresh", point[1])

    def _dithered(self, between: Between) -> Columns:
        return lambda frame, point: self._state(frame, point[0], between, point[1] * np.abs(frame.velocity))

    def _with_rates(self, rates: Sequence[float]) -> Callable[[Frame], tuple[Point, ...]]:
        return lambda frame: tuple((w, rate) for (w,) in self.widths_of_a_stack(frame) for rate in rates)

    def _quiet(self, frame: Frame, width: float, between: Between) -> FloatArray:
        """The torque without the sensor's noise, which would turn the loop by itself. Beside a state that stays it
        begins anew: so files from before were made.
        """
        return play(self.level(frame), frame, NOISE_SHARE * width, "fresh" if between == "kept" else between)


def _not_looked_for(_: Frame) -> tuple[Point, ...]:
    """No points: a form that a file may have, and that is no candidate."""
    return ()
