"""The transmission error's model: what it holds, and how it begins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.orders import offset_rows as slow
from bench.mismatch.orders.bounds import Bounds
from bench.mismatch.orders.misread import TorqueCheck
from bench.mismatch.orders.periodic import Periodic
from bench.mismatch.orders.revolutions import LEAST_PART, SHORTEST_REVOLUTION, Revolution, Seen, found_in
from bench.mismatch.orders.series import Series
from bench.mismatch.orders.swings import SwingOrder, evaluated
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.noise import Mixture, usual_rate
from bench.mismatch.regression.problem import BaseTerm
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray, IntArray
from bench.simulation.laws import Law


@dataclass(frozen=True, slots=True)
class GivenOrders:
    """What the given simulation has of the transmission error: orders of its series, the ripple's, laws of the
    series.
    """

    orders: tuple[float, ...]
    notch: tuple[float, ...] = ()
    laws: tuple[Law, ...] = ()


@dataclass(frozen=True, slots=True)
class KnownOffset:
    """The offset of the rows as an earlier search has it: its ``values`` (n,), rad, whether functions of ``states``
    that are not recorded were candidates, and by what energy inside revolutions it ``moved`` from what was taken off
    before, in squares of the samples' noise.
    """

    values: FloatArray
    states: bool
    moved: float


@dataclass(frozen=True, slots=True)
class Swings:
    """Of a joint that never turns its output round: whether its motion is ``free`` and its recordings are pieces that
    were ``cut``, as in :class:`bench.mismatch.regression.problem.ChannelProblem`; the ``orders`` that were found.
    """

    free: bool
    cut: bool
    orders: tuple[SwingOrder, ...] = ()


@dataclass(slots=True)
class TransmissionModel:
    """The transmission error's model on the rows over the angle."""

    rows: Rows
    inside: NDArray[np.bool_]
    revolutions: list[Revolution]
    train: NDArray[np.bool_]
    """which revolutions may be fitted"""
    given: GivenOrders
    folds: IntArray
    base: tuple[BaseTerm, ...]
    switched_off: tuple[str, ...] = ()
    banned: tuple[str, ...] = ()
    """effects that are no candidates for the offset"""
    periodic: Periodic | None = None
    plain: Series | None = None
    """the given orders alone"""
    seen: Seen | None = None
    noise: Mixture | None = None
    price: float | None = None
    """gain that an order reaches in noise"""
    nulls: FloatArray | None = field(default=None, repr=False)
    """what the best of all orders gains in surrogates"""
    offset: Search | None = None
    quiet: FloatArray | None = field(default=None, repr=False)
    """the rows without their offset (n,): what the orders were found in"""
    tone: FloatArray | None = field(default=None, repr=False)
    """a disturbance of one frequency on the rows (n,), rad, that is no order"""
    known: KnownOffset | None = field(default=None, repr=False)
    """the offset as an earlier search has it; None: as the simulation alone has it"""
    parts: tuple[Revolution, ...] = ()
    """steady parts of less than a revolution that may be fitted"""
    notes: list[str] = field(default_factory=list)
    laws: tuple[Law, ...] = ()
    """found strong, so that everything else is calibrated under them"""
    torque_check: TorqueCheck = field(default_factory=TorqueCheck)
    """whose the multiples of the ratio are, by the load's reaction"""
    swings: Swings | None = None
    """how the rows are read where no steady part covers a revolution; None where one does"""

    @property
    def training_revolutions(self) -> list[Revolution]:
        """Turns that may be fitted."""
        return [t for t, chosen in zip(self.revolutions, self.train, strict=True) if chosen]

    def restore(self, before: TransmissionModel) -> None:
        """Hold again what a copy holds that was made ``before``."""
        for item in fields(self):
            setattr(self, item.name, getattr(before, item.name))

    @property
    def periodic_at_rows(self) -> FloatArray:
        """What of the model is periodic in the angle, at the rows (n,)."""
        if self.swings is not None:
            return evaluated(self.swings.orders, self.rows)
        return np.zeros(self.rows.size) if self.periodic is None else self.periodic.evaluate(self.rows.frame)

    @property
    def without_offset(self) -> FloatArray:
        """The rows (n,) less their offset and a tone, as far as these are known: what orders are found in."""
        return self.toneless if self.quiet is None else self.quiet

    @property
    def toneless(self) -> FloatArray:
        """The rows (n,) less a tone, if there is one."""
        return self.rows.y if self.tone is None else self.rows.y - self.tone

    @property
    def given_orders(self) -> FloatArray:
        """What the orders of the simulation add at the rows (n,), as calibrated."""
        if self.plain is None:
            return np.zeros(self.rows.size)
        return Periodic(self.plain, laws=self.given.laws).evaluate(self.rows.frame)

    @property
    def compared(self) -> FloatArray:
        """Samples of each row (n,) that are compared."""
        return np.where(self.inside, self.rows.number, 0.0)

    @property
    def recorded(self) -> FloatArray:
        """Samples of each row (n,), those that are not compared with them: at rest the shafts have a transmission error
        as well. None of a recording in which nothing is compared, such as one that never turns.
        """
        number, recording = self.rows.number, self.rows.frame.recording
        compared = np.bincount(recording, self.compared) > 0.0
        return np.where(compared[recording], number, 0.0)


def begun(
    rows: Rows,
    folds: IntArray,
    given: GivenOrders,
    base: Sequence[BaseTerm],
    switched_off: Sequence[str] = (),
    banned: Sequence[str] = (),
) -> TransmissionModel:
    """A model with nothing calibrated yet."""
    revolutions = found_in(rows.frame)
    inside = (rows.number > 0) & (rows.frame.direction != 0)
    bounds = Bounds.of([t.velocity for t in revolutions])
    if bounds is not None:
        inside &= bounds.inside(rows.frame)
    train = np.array([folds[t.recording] >= 0 for t in revolutions], dtype=bool)
    parts = tuple(
        p
        for p in found_in(rows.frame, LEAST_PART, SHORTEST_REVOLUTION)
        if folds[p.recording] >= 0 and bool(inside[p.rows].all()) and bool((rows.number[p.rows] > 0).all())
    )
    return TransmissionModel(
        rows, inside, revolutions, train, given, folds, tuple(base), tuple(switched_off), tuple(banned), parts=parts
    )


def steady_rows(model: TransmissionModel) -> NDArray[np.bool_]:
    """Rows inside the bounds, in steady motion."""
    return np.asarray(model.inside & (model.rows.frame.steady > 0.5))


def floor_of(model: TransmissionModel) -> float:
    """Noise of a sample of a model's rows, rad."""
    assert model.noise is not None
    return float(np.sqrt(model.noise.variance))


def with_noise(model: TransmissionModel, now: Seen) -> None:
    """Tell a model's noise from what its revolutions show and its rows scatter."""
    assert model.periodic is not None
    slope = model.periodic.slope(model.rows.frame.take(steady_rows(model)))
    steady = model.rows.take(steady_rows(model))
    inner = np.maximum(steady.within - 2.0 * slope * steady.lean + slope**2 * steady.sweep, 0.0)
    model.noise = slow.mixture(now, model.revolutions, steady, inner, usual_rate(model.rows.frame))
