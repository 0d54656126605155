"""What a physics term is: an equation, its parameters, where it shows, and regressors it offers in each channel.

A term has one or more *forms* a channel: standard ways of writing the same effect (Gaussian or rational Stribeck, tanh
or piecewise lost motion). Whatever form nature took, the effect's name is the same. The linear parameters of a form are
the coefficients of its columns; its nonlinear parameters are searched on a grid that follows the data and then refined.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from bench.simulation.frame import FloatArray, Frame

Point = tuple[float, ...]
Shape = tuple[str, str]
"""quantity that a function is of, and the factor it is multiplied with (:mod:`bench.simulation.quantities`)"""
Columns = Callable[[Frame, Point], FloatArray]
Grid = Callable[[Frame], tuple[Point, ...]]

TRANSMISSION_ERROR = "transmission_error"
MOTOR_TORQUE = "motor_torque"
LOAD_TORQUE = "load_torque"
TEMPERATURE = "temperature"
CHANNEL_UNITS = {TRANSMISSION_ERROR: "rad", MOTOR_TORQUE: "N*m", LOAD_TORQUE: "N*m", TEMPERATURE: "degC"}


@dataclass(frozen=True, slots=True)
class Symbol:
    """A parameter: its symbol in the equation, SI unit, meaning, and physical bounds."""

    symbol: str
    unit: str
    meaning: str
    lower: float = -np.inf
    upper: float = np.inf


def _no_grid(_: Frame) -> tuple[Point, ...]:
    return ((),)


@dataclass(frozen=True, slots=True)
class Form:
    """One way of writing a term in one channel.

    ``columns(frame, point)`` returns (n, k) regressors for the nonlinear parameters ``point``; ``linear`` names the k
    coefficients; ``grid(frame)`` proposes points within the data's range. With ``one_sign`` the coefficients are
    parts of one thing and have one sign.
    """

    name: str
    columns: Columns
    linear: tuple[Symbol, ...]
    nonlinear: tuple[Symbol, ...] = ()
    grid: Grid = _no_grid
    one_sign: bool = False
    remembers: bool = False
    """whether its state goes on from one recording to the next"""
    jumps: bool = False
    """whether it jumps where the motion turns: between the rows of a campaign lies no straight line"""
    shape: tuple[Shape, ...] = ()
    """functions by which nature's form may differ from this one, where they are others than the term's"""
    equation: str = ""
    """this form's own equation, in its own symbols; empty where it is the term's"""
    ratio: tuple[float, float] | None = None
    """least and most of the second coefficient over the first, where the first is positive; None where it may be any"""
    shares: str = ""
    """nominal term whose first coefficient its own is; empty where it is free"""
    says: tuple[str, ...] = ()
    """other effects that this form says as well: one law in place of theirs and its own"""
    variables: tuple[str, ...] = ()
    """quantities it depends on, where it depends on more than the other forms of its term: all of them"""
    counts: bool = False
    """whether its nonlinear parameters are whole numbers, such as the orders of teeth: none lies between two points"""
    blur: float = 0.0
    """share of the first of ``nonlinear`` by which the form leaves it open, for it does not follow its input to that"""


@dataclass(frozen=True, slots=True)
class Term:
    """A physics term of the library; ``effect`` is its id in the vocabulary."""

    effect: str
    name: str
    equation: str
    reference: str
    where: str
    forms: Mapping[str, tuple[Form, ...]]
    nominal: bool = False
    variables: tuple[str, ...] = field(default=())
    """quantities of the frame the effect depends on, the most telling first; used to say where it shows"""
    shape: Mapping[str, tuple[Shape, ...]] = field(default_factory=dict)
    """in each channel, the functions by which nature's form may differ from those here"""
    any_function: bool = False
    """whether a free function of ``shape`` is the effect by definition, whatever it looks like"""
    one_way: bool = False
    """whether such a function goes one way, and what comes and goes is another effect"""
    modifies: tuple[str, ...] = ()
    """effects that it is a change of: without one of them it is no law of its own (marginality: Nelder, J. R. Stat.
    Soc. A 140 (1977) 48)
    """
    passing: Mapping[str, tuple[Shape, ...]] = field(default_factory=dict)
    """in each channel, the functions that follow from it because something else passes through it"""

    def shapes(self, channel: str) -> set[Shape]:
        """All functions of a channel by which nature's form may differ from one of the forms here."""
        per_form = (form.shape for form in self.forms.get(channel, ()))
        return {*self.shape.get(channel, ()), *(shape for shapes in per_form for shape in shapes)}

    def shape_of(self, channel: str, form: Form | None = None) -> tuple[Shape, ...]:
        """Those of one form; of the term where no form is named, or it has none of its own."""
        return form.shape if form is not None and form.shape else tuple(self.shape.get(channel, ()))

    def variables_of(self, form: Form) -> tuple[str, ...]:
        """Quantities that one of its forms depends on, the most telling first."""
        return form.variables or self.variables

    def equation_of(self, form: Form) -> str:
        """Equation of one of its forms."""
        return form.equation or self.equation

    def form(self, channel: str, name: str | None) -> Form | None:
        """Its form of a name in a channel; None where there is none."""
        return next((form for form in self.forms.get(channel, ()) if form.name == name), None)


def columns(*parts: FloatArray) -> FloatArray:
    """Stack one-dimensional regressors as columns."""
    return np.column_stack(parts)


def logarithmic(lower: float, upper: float, number: int) -> tuple[Point, ...]:
    """Points spread evenly in their logarithm."""
    return tuple((float(v),) for v in np.geomspace(max(lower, 1e-12), max(upper, lower * 1.001, 1e-12), number))


STANDSTILL = 0.3
"""rad/s at the motor: the crawl of a geared motor, below which nothing is told of its speed"""
SLOW = 0.02
"""of the fastest speed: what is slow for a machine that never moves ten times as fast as that crawl"""


def slow_speed(values: FloatArray) -> float:
    """Least speed that matters among speeds (n,) of the motor: the crawl of geared motors, or the machine's own."""
    fastest = top(values)
    return max(1e-3 * fastest, STANDSTILL) if fastest > 10.0 * STANDSTILL else SLOW * fastest


def top(values: FloatArray) -> float:
    """Largest magnitude that is no outlier (99th percentile); 1 where there is nothing."""
    if values.size == 0:
        return 1.0
    largest = float(np.percentile(np.abs(values), 99))
    return largest if largest > 0 else 1.0
