"""All regressors of a channel side by side: simulation, terms at every grid point, free-form rivals; and where each
stands.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.rivals import rivals
from bench.simulation.frame import FloatArray, Frame, recording_starts
from bench.simulation.terms import (
    LIBRARY,
    LOAD_TORQUE,
    MOTOR_TORQUE,
    TEMPERATURE,
    Form,
    Point,
    Term,
    for_channel,
)
from bench.simulation.terms.memory import integral

FREE_PRIOR = 1e-4
OFFSET_PRIOR = 1e-6
ZERO_TORQUE = 0.01
"""N·m at the motor: how far the zero of a torque may be off, by data sheets"""
HEAT_CAPACITY = 2.0e4
"""J/K, only to turn that into a temperature's rate"""
REPEATABILITY = 0.02
"""of the friction at high speed from one warm-up to the next"""
RIPPLE_ORDERS = (150.0, 300.0)
FIXED_BY_GEOMETRY = ("motor.load_reaction", "load.reaction")
"""terms without a free parameter: they are taken off the measured channel"""
HARMONIC_TERMS = ("te.harmonic", "te.sideband", "te.local_defect", "te.resonance", "sensor.motor_encoder", "te.fourier")
"""terms periodic in the angle: looked for in the order spectrum, not among the slow rows"""
SPECTRAL_TERMS = ("motor.torque_ripple",)


@dataclass(frozen=True, slots=True)
class Entry:
    """Columns of one candidate: an effect in one form at one point, or a free-form rival (``effect`` is "unknown")."""

    effect: str
    form: str
    point: Point
    index: tuple[int, ...]
    variables: tuple[str, ...] = ()
    deviation: tuple[float, ...] = ()
    """standard deviations of the point's parameters, once they are refined"""
    common: bool = True
    """whether a free form belongs to the flexible model that tells the noise (one of many frequencies does not)"""
    bounds: tuple[tuple[float, float], ...] = ()
    """physical bounds of its coefficients; none for a free form"""
    one_sign: bool = False
    """whether its coefficients are parts of one thing, and of one sign"""

    @property
    def numbers(self) -> int:
        """Parameters it has to follow the data with."""
        return len(self.index) + len(self.point)


@dataclass(frozen=True, slots=True)
class Layout:
    """The columns of a channel (n, p), their prior precisions (p,), and what each block is."""

    columns: FloatArray
    prior: FloatArray
    precision: FloatArray
    base: tuple[int, ...]
    base_effects: tuple[tuple[str, str, tuple[int, ...]], ...]
    """(effect, form, columns) of the simulation's own terms"""
    named: tuple[Entry, ...]
    free: tuple[Entry, ...]
    slots: tuple[int, ...] = ()
    """columns of nothing yet: for free functions whose place is looked for"""

    def of_the_simulation(self) -> Layout:
        """The same with the values of the simulation's own columns only (which come first)."""
        return replace(self, columns=self.columns[:, : len(self.base)].copy(order="F"))


def _ripple(frame: Frame) -> FloatArray:
    parts = [f(order * frame.q) for order in RIPPLE_ORDERS for f in (np.cos, np.sin)]
    return np.column_stack([*parts, *(part * frame.load_motor_torque / 1000.0 for part in parts)])


def _own_integrals(frame: Frame) -> FloatArray:
    """Integral of the motor's speed, a column for each recording in which it is large enough to matter."""
    turned = integral(frame.omega, frame)
    starts = recording_starts(frame)
    most = np.maximum.reduceat(np.abs(turned), starts[:-1])
    chosen = np.flatnonzero(most > 0.05 * most.max())
    out = np.zeros((frame.size, chosen.size))
    for column, r in enumerate(chosen):
        out[starts[r] : starts[r + 1], column] = turned[starts[r] : starts[r + 1]]
    return out


def _fast_recordings(frame: Frame) -> tuple[FloatArray, float]:
    """Motor speed in each recording driven far faster than the others, a column each; how well its friction repeats."""
    starts = recording_starts(frame)
    speed = np.abs(frame.omega)
    typical = np.add.reduceat(speed, starts[:-1]) / np.maximum(np.diff(starts), 1)
    chosen = np.flatnonzero(typical > 2.5 * np.median(typical))
    out = np.zeros((frame.size, chosen.size))
    ratios: list[float] = []
    for column, r in enumerate(chosen):
        rows = slice(starts[r], starts[r + 1])
        out[rows, column] = frame.omega[rows]
        driven = speed[rows] > 0.5 * speed[rows].max()
        ratios.append(float(np.median(np.abs(frame.motor_torque[rows][driven]) / speed[rows][driven])))
    return out, max(REPEATABILITY * float(np.median(ratios)), 1e-9) if ratios else 1.0


def simulated_terms(channel: str, switched_off: Sequence[str]) -> list[tuple[Term, Form]]:
    """Nominal terms with free parameters that the simulation has in a channel."""
    return [
        (term, term.forms[channel][0])
        for term in LIBRARY.values()
        if term.nominal
        and channel in term.forms
        and term.effect not in switched_off
        and term.effect not in FIXED_BY_GEOMETRY
        and term.effect not in HARMONIC_TERMS
    ]


def layout(
    channel: str,
    frame: Frame,
    switched_off: Sequence[str] = (),
    known: Sequence[tuple[Term, Form, Point]] = (),
    with_free: bool = True,
    reference: Frame | None = None,
    with_named: bool = True,
    used: NDArray[np.bool_] | None = None,
    slots: int = 0,
) -> Layout:
    """Evaluate every regressor of ``channel`` on the rows of ``frame``; the simulation's alone without ``with_free``
    and ``with_named``.

    ``reference``: rows whose quantities place the rivals' knots. ``switched_off``: nominal terms the given simulation
    lacks (they become candidates); ``known``: further terms it has; ``used``: the rows whose regressors are kept
    (memories run through all of them); ``slots``: columns to keep free.
    """
    parts: list[FloatArray] = []
    priors: list[float] = []
    width = 0
    precision: dict[int, float] = {}

    def add(block: FloatArray, prior: float) -> tuple[int, ...]:
        nonlocal width
        own = block if used is None else block[used]
        parts.append(np.where(np.isfinite(own), own, 0.0))
        priors.extend([prior] * block.shape[1])
        place = tuple(range(width, width + block.shape[1]))
        width += block.shape[1]
        return place

    base_effects: list[tuple[str, str, tuple[int, ...]]] = []
    for term, form in simulated_terms(channel, switched_off):
        prior = OFFSET_PRIOR if term.effect == "te.offset" else 0.0
        base_effects.append((term.effect, form.name, add(form.columns(frame, ()), prior)))
    for term, form, point in known:
        base_effects.append((term.effect, form.name, add(form.columns(frame, point), 0.0)))
    if channel == LOAD_TORQUE:
        base_effects.append(("notch", "ripple", add(_ripple(frame), OFFSET_PRIOR)))
    if channel == TEMPERATURE:
        # the zero of the motor torque wanders from recording to recording and turns into heat that never was
        # (and a part that all recordings share: the zero of the torque sensor, tau_0 and z_0 of the nominal simulation)
        common = add(integral(frame.omega, frame)[:, None], 0.0)
        precision[common[0]] = (HEAT_CAPACITY / (10.0 * ZERO_TORQUE)) ** 2
        base_effects.append(("zero", "common", common))
        heat = _own_integrals(frame)
        place = add(heat, 0.0)
        precision.update({column: (HEAT_CAPACITY / ZERO_TORQUE) ** 2 for column in place})
        base_effects.append(("zero", "torques", place))
    if channel == MOTOR_TORQUE:
        # a warm-up repeats within some per cent only: its level is one datum, not as many as it has rows
        fast, spread = _fast_recordings(frame)
        if fast.shape[1]:
            place = add(fast, 0.0)
            precision.update({column: 1.0 / spread**2 for column in place})
            base_effects.append(("level", "fast recordings", place))
    base = tuple(range(width))
    named: list[Entry] = []
    for term in _candidates(channel, switched_off) if with_named else ():
        for form in term.forms[channel]:
            bounds = tuple((symbol.lower, symbol.upper) for symbol in form.linear)
            for point in form.grid(frame):
                index = add(form.columns(frame, point), 0.0)
                named.append(
                    Entry(term.effect, form.name, point, index, term.variables, bounds=bounds, one_sign=form.one_sign)
                )
    free: list[Entry] = []
    if with_free:
        for rival in rivals(channel, frame, reference):
            free.append(
                Entry("unknown", rival.name, (), add(rival.columns, FREE_PRIOR), rival.variables, (), rival.common)
            )
    empty = add(np.zeros((frame.size, slots)), FREE_PRIOR)
    own = np.zeros(width)
    for place_of, value in precision.items():
        own[place_of] = value
    columns = _side_by_side(parts, frame.size if used is None else int(used.sum()))
    return Layout(columns, np.asarray(priors), own, base, tuple(base_effects), tuple(named), tuple(free), empty)


def _side_by_side(parts: list[FloatArray], rows: int) -> FloatArray:
    """Blocks of columns as one array, column after column in memory; each is let go once it has been copied."""
    out = np.empty((rows, sum(part.shape[1] for part in parts)), order="F")
    parts.reverse()
    at = 0
    while parts:
        part = parts.pop()
        out[:, at : at + part.shape[1]] = part
        at += part.shape[1]
    return out


def _candidates(channel: str, switched_off: Sequence[str]) -> list[Term]:
    beyond = [t for t in for_channel(channel) if t.effect not in HARMONIC_TERMS + SPECTRAL_TERMS]
    missing = [LIBRARY[e] for e in switched_off if channel in LIBRARY[e].forms and e not in HARMONIC_TERMS]
    return [*beyond, *missing]


def is_integral(channel: str) -> bool:
    """Whether a channel's regressors are integrals over each recording (its offset is then free)."""
    return channel == TEMPERATURE
