"""Loops over a torque: path dependence that a transmission and a torque sensor have alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import FORGETS, NOISE_SHARE, RATES, Between, begins, play, relaxing
from bench.simulation.terms.base import Columns, Form, Point, Symbol, columns, logarithmic, top

BETWEEN: tuple[Between, ...] = ("fresh", "kept", "released")
SUFFIX = {"fresh": "", "kept": "_kept", "released": "_released"}
NARROWEST = 0.06
"""of the largest torque"""
WIDEST = 0.4
"""of the largest torque: a loop that is wider is hardly turned, and looks like a gain or a compliance"""
NARROWEST_STACK = 0.08
"""of the largest torque, the middle of a stack's plays"""
STACK = (0.4, 1.0, 2.2)
"""widths of a stack of plays, in units of its parameter"""


@dataclass(frozen=True, slots=True)
class Loops:
    """What loops are over: ``level(frame)`` the torque without slow noise (n,), called ``torque`` in equations.

    What they add to (``output``); the ``size`` of a loop, its ``width`` and the ``rate`` at which it forgets;
    ``relaxing``: name of the form that relaxes; ``widest_stack``: of the largest torque, the middle of a stack's plays.
    """

    level: Callable[[Frame], FloatArray]
    torque: str
    output: str
    size: Symbol
    width: Symbol
    rate: Symbol
    relaxing: str
    widest_stack: float = WIDEST

    def forms(self) -> tuple[Form, ...]:
        """Play, a state that relaxes (Dahl), and a stack of plays, each with what it does between recordings; and a
        state that forgets.
        """
        h, w, torque, out = self.size.symbol, self.width.symbol, self.torque, self.output
        play_text = f"{out} += {h}*({torque} - y)/{w}, y = max({torque} - {w}, min({torque} + {w}, y))"
        relaxing_text, forgetting_text = (
            f"{out} += {h}*z, dz = (1 - z*sgn(dx))*dx/{w}{forgets}, "
            f"x = max({torque} - {NOISE_SHARE:g}*{w}, min({torque} + {NOISE_SHARE:g}*{w}, x))"
            for forgets in ("", FORGETS)
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
        kinds = (
            ("play", self._play, (self.size,), self.widths, play_text, "y", 0.0),
            (self.relaxing, self._relaxing, (self.size,), self.widths, relaxing_text, "z", NOISE_SHARE),
            ("stack", self._stack, sizes, self.widths_of_a_stack, stack_text, "y_k", 0.0),
        )
        return (
            *(
                Form(
                    f"{name}{SUFFIX[between]}",
                    make(between),
                    linear,
                    (self.width,),
                    grid,
                    one_sign=len(linear) > 1,
                    remembers=between != "fresh",
                    equation=f"{text}, {begins(state, between)}",
                    blur=blur,
                )
                for name, make, linear, grid, text, state, blur in kinds
                for between in BETWEEN
            ),
            Form(
                "forgetting",
                self._forgetting,
                (self.size,),
                (self.width, self.rate),
                self._forgetting_points,
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

    def _play(self, between: Between) -> Columns:
        def regressors(frame: Frame, point: Point) -> FloatArray:
            x = self.level(frame)
            return columns((x - play(x, frame, point[0], between)) / point[0])

        return regressors

    def _stack(self, between: Between) -> Columns:
        def regressors(frame: Frame, point: Point) -> FloatArray:
            x = self.level(frame)
            widths = [share * point[0] for share in STACK]
            return columns(*((x - play(x, frame, w, between)) / w for w in widths))

        return regressors

    def _relaxing(self, between: Between) -> Columns:
        def regressors(frame: Frame, point: Point) -> FloatArray:
            return columns(relaxing(self._quiet(frame, point[0]), frame, point[0], between))

        return regressors

    def _forgetting(self, frame: Frame, point: Point) -> FloatArray:
        return columns(relaxing(self._quiet(frame, point[0]), frame, point[0], "fresh", point[1]))

    def _forgetting_points(self, frame: Frame) -> tuple[Point, ...]:
        return tuple((w, rate) for (w,) in self.widths_of_a_stack(frame) for rate in RATES)

    def _quiet(self, frame: Frame, width: float) -> FloatArray:
        """The torque without the sensor's noise, which would turn the loop by itself."""
        return play(self.level(frame), frame, NOISE_SHARE * width)
