"""Orders whose vectors follow a state that is not recorded: a shaft that bows while it warms, a load remembered.

Such a part is a vector of each order times the state, the same at every load, speed and temperature: a law of the
amplitudes multiplies an order by a function of what is recorded now, and says nothing of it. The polynomials'
coefficients are free beside it, as they are beside a law, so nothing counts that a calibration could absorb. What the
best of all states gains in noise is measured on draws of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import minimize_scalar

from bench.mismatch import criteria
from bench.mismatch.discovery import UNKNOWN, UNNAMED, Discovery
from bench.mismatch.orders.law_scores import amplitudes, misfit, stacked, whitened
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.reported import probability, strong
from bench.mismatch.orders.revolutions import Complex, Revolution, passed
from bench.mismatch.regression.maxima import tail, tail_rate
from bench.mismatch.unnamed.formula_regressor import Equation
from bench.mismatch.unnamed.formula_units import product
from bench.simulation.formulas import Formula
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.laws import MODES, Law
from bench.simulation.quantities import OF_KIND, QUANTITIES, label, quantity, range_of, state_named, state_of
from bench.simulation.terms import CHANNEL_UNITS, TRANSMISSION_ERROR

KINDS = ("risen", "recent_loss", "recent_speed", "recent_load", "recent_torque")
"""kinds of states that the orders are asked to follow"""
ANGLE = "input_angle"
"""the quantity that a formula has the waves over"""
SURROGATES = 60
STEP = 2.6
"""factor about a time constant of the table within which it is refined: that of the table's next one"""
FINE = 0.02
"""of the logarithm of a time constant"""


@dataclass(frozen=True, slots=True)
class Remembered:
    """Orders that follow a ``state``: its name, their vectors b + j*a (orders,), rad for each unit of the state, with
    the standard deviation of a component (orders,); gain of log-likelihood and p-value.
    """

    state: str
    orders: tuple[float, ...]
    vectors: Complex
    std: FloatArray
    gain: float
    p_value: float

    @property
    def coefficients(self) -> FloatArray:
        """Of cosine and sine of each order in turn."""
        return np.column_stack([self.vectors.imag, self.vectors.real]).ravel()

    def equation(self, frame: Frame) -> Equation:
        """A formula of angle and state, the latter within what the rows of ``frame`` have of it."""
        values = quantity(self.state, frame)
        angles = ("x1" if f == 1.0 else f"{f:g}*x1" for f in self.orders)
        parts = tuple(("1", f"x2*{wave}({angle})") for angle in angles for wave in ("cos", "sin"))
        within = ((0.0, 2.0 * np.pi), (float(values.min()), float(values.max())))
        unit = product([(CHANNEL_UNITS[TRANSMISSION_ERROR], 1), (QUANTITIES[self.state].unit, -1)])
        return Equation(TRANSMISSION_ERROR, Formula((ANGLE, self.state), within, parts), (unit,) * len(parts))

    def evaluate(self, frame: Frame) -> FloatArray:
        """What the orders have of it at the rows of a frame (n,), rad."""
        return np.asarray(self.equation(frame).columns(frame) @ self.coefficients)


def search(model: TransmissionModel, seed: int) -> Remembered | None:
    """The state that orders follow, if any gains more than the best of all does in noise, and than the laws of the
    amplitudes do that were found without it.
    """
    sight = _Sight.of(model)
    if sight is None:
        return None
    frame, longest = model.rows.frame, max(t.duration for t in sight.revolutions)
    names = [name for kind in KINDS for name in OF_KIND[kind] if _scale(name) > longest]
    states = {name: sight.over_revolutions(name, frame) for name in names}
    states = {name: values for name, values in states.items() if np.ptp(values) > 0.0}
    if not states:
        return None
    columns = {name: sight.columns(values) for name, values in states.items()}
    gains = {name: float(sight.gains(z, sight.left).sum()) for name, z in columns.items()}
    best = max(gains, key=lambda name: gains[name])
    rng = np.random.default_rng([seed, 11])
    nulls = np.array(
        [max(float(sight.gains(z, drawn).sum()) for z in columns.values()) for drawn in sight.noise(rng, SURROGATES)]
    )
    least = max(tail(nulls, criteria.ERROR_RATE_OF_A_CHANNEL), sight.of_laws + criteria.RICHER)
    if gains[best] < least:
        return None
    best = _refined(sight, frame, best)
    found = sight.estimated(sight.over_revolutions(best, frame))
    if not found:
        return None
    gain = sum(one.gain for one in found)
    return Remembered(
        best,
        tuple(one.order for one in found),
        np.array([one.vector for one in found]),
        np.array([one.std for one in found]),
        gain,
        tail_rate(nulls, gain),
    )


def as_discovery(model: TransmissionModel, found: Remembered, excess: FloatArray) -> Discovery | None:
    """Orders that follow a state as a discovery; ``excess`` (n,): what no calibration says of them. None where they are
    weak.
    """
    equation, coefficients = found.equation(model.rows.frame), found.coefficients
    added, std = found.evaluate(model.rows.frame), np.repeat(found.std, 2)
    if not strong(model, added):
        return None
    some = f"order{'s' if len(found.orders) > 1 else ''} {', '.join(f'{f:g}' for f in found.orders[:6])}"
    return Discovery(
        effect=UNNAMED,
        status=UNKNOWN,
        confidence=probability(found.p_value),
        channel=TRANSMISSION_ERROR,
        words=f"{some} with the {label(found.state)}",
        equation=equation.equation,
        variables=(found.state,),
        parameters=tuple(equation.parameters(coefficients, std)),
        added=added,
        gain=found.gain,
        p_value=found.p_value,
        simulation_rows=({"effect": UNNAMED} | equation.row(coefficients, std),),
        orders=found.orders,
        numbers=2 * len(found.orders) + 1,
        excess=excess,
    )


def _scale(name: str) -> float:
    state = state_of(name)
    assert state is not None
    return state[1]


def _refined(sight: _Sight, frame: Frame, name: str) -> str:
    """The state with the time constant, in whole seconds, with which it gains most about that of the table."""
    state = state_of(name)
    assert state is not None
    kind, begin = state

    def loss(logarithm: float) -> float:
        values = sight.over_revolutions(state_named(kind, float(np.exp(logarithm))), frame)
        return -float(sight.gains(sight.columns(values), sight.left).sum())

    low, high = np.log(np.clip([begin / STEP, begin * STEP], *range_of(kind)))
    best = minimize_scalar(loss, bounds=(low, high), method="bounded", options={"xatol": FINE})
    return state_named(kind, float(np.exp(best.x))) if best.fun < loss(float(np.log(begin))) else name


@dataclass(frozen=True, slots=True)
class _Following:
    """An order that follows a state: its vector b + j*a for each unit of that, standard deviation of a component,
    gain of log-likelihood less what its numbers cost.
    """

    order: float
    vector: complex
    std: float
    gain: float


@dataclass(frozen=True, slots=True)
class _Sight:
    """What the polynomials leave of ``orders`` of the series in the training ``revolutions``: ``left`` (orders,
    2*revolutions), whitened by Cholesky factors ``lowers`` of their freedom and the noise, behind the ``response``
    (revolutions, orders) of modes. ``of_laws``: what other laws gain, without which all this is seen.
    """

    revolutions: tuple[Revolution, ...]
    orders: tuple[float, ...]
    left: FloatArray
    lowers: tuple[FloatArray, ...]
    response: Complex
    of_laws: float

    @classmethod
    def of(cls, model: TransmissionModel) -> _Sight | None:
        """The orders of a model into which no others leak; None where there are none, or too few revolutions."""
        if model.periodic is None:
            return None
        kept = tuple(law for law in model.periodic.laws if law in model.given.laws or law.form in MODES)
        less: Sequence[Law] = [law for law in model.periodic.laws if law not in kept]
        data = amplitudes(replace(model, periodic=replace(model.periodic, laws=kept)))
        if data is None or not data.regular.any():
            return None
        lowers, left = whitened(data)
        chosen = np.flatnonzero(data.regular)
        response = passed(kept, model.training_revolutions, data.orders)
        return cls(
            tuple(model.training_revolutions),
            tuple(data.orders[k] for k in chosen),
            left[chosen],
            tuple(lowers[k] for k in chosen),
            response[:, chosen],
            sum(law.gain for law in less),
        )

    def over_revolutions(self, name: str, frame: Frame) -> FloatArray:
        """Means of a quantity over the revolutions (revolutions,)."""
        values = quantity(name, frame)
        return np.array([values[t.rows].mean() for t in self.revolutions])

    def columns(self, values: FloatArray) -> FloatArray:
        """What a vector times a state's ``values`` (revolutions,) does to each order, whitened (orders, 2*revolutions,
        2).
        """
        moved = values[:, None] / self.response
        out = [
            solve_triangular(lower, np.column_stack([stacked(one), stacked(1j * one)]), lower=True)
            for lower, one in zip(self.lowers, moved.T, strict=True)
        ]
        return np.array(out)

    def noise(self, rng: np.random.Generator, number: int) -> FloatArray:
        """Draws (number, orders, 2*revolutions) of noise as large as what is left, or as it should be."""
        usual = np.sqrt(np.maximum(np.mean(self.left**2, axis=1), 1.0))
        return np.asarray(rng.normal(size=(number, *self.left.shape)) * usual[None, :, None])

    def gains(self, columns: FloatArray, left: FloatArray) -> FloatArray:
        """Gain of log-likelihood (orders,) by a state's whitened ``columns``, 0 where it does not pay for its numbers;
        ``left`` (orders, 2*revolutions) is what they are fitted to.
        """
        number = len(self.revolutions)
        product = np.einsum("orc,or->oc", columns, left)
        gram = np.einsum("orc,ord->ocd", columns, columns)
        before = np.sum(left**2, axis=1)
        after = before - np.einsum("oc,oc->o", product, np.linalg.solve(gram, product[:, :, None])[:, :, 0])
        # two numbers an order (BIC), and any of the orders
        price = float(np.log(2.0 * number) + np.log(len(self.orders)))
        gained = misfit(before, number) - misfit(np.maximum(after, 0.0), number) - price
        return np.asarray(np.maximum(gained, 0.0))

    def estimated(self, values: FloatArray) -> list[_Following]:
        """The orders that gain by a state with ``values`` (revolutions,)."""
        columns = self.columns(values)
        gains, out = self.gains(columns, self.left), []
        for k in np.flatnonzero(gains > 0.0).tolist():
            z, r = columns[k], self.left[k]
            inverse = np.linalg.inv(z.T @ z)
            found = inverse @ (z.T @ r)
            noise = max(float(np.mean((r - z @ found) ** 2)), 1.0)
            std = float(np.sqrt(0.5 * noise * np.trace(inverse)))
            out.append(_Following(self.orders[k], complex(found[0], found[1]), std, float(gains[k])))
        return out
