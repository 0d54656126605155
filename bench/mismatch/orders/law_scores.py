"""Laws that amplitudes may follow, scored on the vectors of the revolutions: what each gains beside the polynomials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from bench.mismatch import criteria
from bench.mismatch.orders.between import is_between
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.revolutions import Complex, directions, passed, states
from bench.mismatch.orders.series import RELATIVE_NOISE, Series
from bench.simulation.frame import FloatArray
from bench.simulation.laws import EACH, MODES, RESONANCE, Law, Reference, value

PRIOR_REVOLUTIONS = 20.0
"""revolutions' worth of evidence that the noise is that of the spectra"""
RANK = 1e-3
"""singular values, over the largest, below which the revolutions do not tell two monomials apart"""
DAMPINGS = (0.03, 0.06, 0.12, 0.25)
PARTED = 1.0
"""orders apart from which a revolution tells two of them apart (Rayleigh's criterion)"""


def misfit(squares: FloatArray, revolutions: float) -> FloatArray:
    """Negative log-likelihood of the vectors of so many revolutions by the whitened ``squares`` that are left of them,
    noise of any size.
    """
    return np.asarray((revolutions + PRIOR_REVOLUTIONS) * np.log(squares + 2.0 * PRIOR_REVOLUTIONS))


@dataclass(frozen=True, slots=True)
class Amplitudes:
    """Vectors (revolutions, orders) of the series' orders in the training revolutions, noise of a component, states,
    times.
    """

    vectors: Complex
    sigma: FloatArray
    x: FloatArray
    direction: FloatArray
    time: FloatArray
    orders: tuple[float, ...]
    series: Series
    reference: Reference

    @property
    def regular(self) -> NDArray[np.bool_]:
        """Which orders (orders,) are whole ones into which no other kind leaks. Of an order between two whole ones,
        known to so many digits only, the phase moves with the distance run, and so with time and all that follows it.
        """
        orders = np.asarray(self.orders)
        between = orders[[is_between(f) for f in self.orders]]
        near = np.abs(orders[:, None] - between[None, :]) < PARTED
        return np.asarray(~near.any(axis=1))

    @property
    def frequency(self) -> FloatArray:
        """f·v of each order in each revolution, rad/s: below zero in negative direction."""
        return np.asarray(self.x[:, 1][:, None] * np.asarray(self.orders)[None, :])


def amplitudes(model: TransmissionModel) -> Amplitudes | None:
    """The amplitudes of a model's series but the load motor's ripple, before the laws it has; None where revolutions
    are too few.
    """
    if model.seen is None or model.periodic is None:
        return None
    series = model.periodic.series.less(model.given.notch)
    if not series.orders or len(model.training_revolutions) < 2 * criteria.FEWEST_TURNS:
        return None
    columns = [model.seen.orders.index(f) for f in series.orders]
    revolutions = model.training_revolutions
    vectors = model.seen.vectors[model.train][:, columns]
    sigma = model.seen.noise(series.orders)[model.train]
    sigma = np.sqrt(sigma**2 + (RELATIVE_NOISE * np.sqrt(np.mean(np.abs(vectors) ** 2, axis=0))) ** 2)
    x = states(revolutions)
    time = np.array([t.time for t in revolutions])
    by = passed(model.periodic.laws, revolutions, series.orders)
    vectors, sigma = vectors / by, sigma / np.abs(by)
    return Amplitudes(vectors, sigma, x, directions(revolutions), time, series.orders, series, Reference.of(x, time))


def stacked(values: Complex) -> FloatArray:
    """Real parts, then imaginary ones."""
    return np.concatenate([values.real, values.imag])


def tangent(data: Amplitudes, k: int) -> tuple[FloatArray, Complex]:
    """Columns (2*revolutions, 40) by which order k's vectors may move, scaled by their spread; and the series' vectors
    with the coefficients but the constants at zero in the linear sense (revolutions,).
    """
    blocks = []
    begin = data.series.vectors(data.x, data.direction)[:, k].astype(np.complex128)
    centre = begin.copy()
    for side in data.series.amplitude:
        on_side = data.direction * side > 0
        basis = np.where(on_side[:, None], data.series.scaling[side].monomials(data.x), 0.0)
        phase, amplitude = data.series.phase[side][k], data.series.amplitude[side][k]
        rotation = np.exp(1j * (basis @ phase))
        size = float(np.sqrt(np.mean(np.abs(begin[on_side]) ** 2))) if on_side.any() else 1.0
        prior = data.series.prior[k]
        spread = np.concatenate([prior[:9] * size, [10.0 * size], prior[9:], [10.0]])
        columns = np.hstack([rotation[:, None] * basis, (1j * (basis @ amplitude) * rotation)[:, None] * basis])
        columns[~on_side] = 0.0
        centre -= columns @ np.concatenate([amplitude, phase])
        blocks.append(np.vstack([columns.real, columns.imag]) * spread)
    return np.hstack(blocks), centre


def whitened(data: Amplitudes, wide: float = 1.0) -> tuple[list[FloatArray], FloatArray]:
    """Cholesky factor of each order's covariance, polynomials' freedom in it, so many times ``wide`` as the orders have
    shown; its residual, whitened (orders, 2*revolutions).
    """
    lowers, flat = [], []
    for k in range(len(data.orders)):
        columns, centre = tangent(data, k)
        sigma = np.concatenate([data.sigma[:, k]] * 2)
        lower = np.linalg.cholesky(wide**2 * columns @ columns.T + np.diag(sigma**2))
        lowers.append(np.asarray(lower))
        flat.append(np.asarray(solve_triangular(lower, stacked(data.vectors[:, k] - centre), lower=True)))
    return lowers, np.array(flat)


def _law(effect: str, form: str, point: tuple[float, ...], variables: tuple[str, ...], data: Amplitudes) -> Law:
    ones = np.ones(len(data.orders), dtype=np.complex128)
    return Law(effect, form, point, 0.0, data.orders, ones, variables, data.reference, data.orders)


def resonances(data: Amplitudes, forms: Sequence[str] = tuple(MODES)) -> list[Law]:
    """Modes that are tried: natural frequencies the orders pass, dampings, and what moves the mass."""
    frequency = np.abs(data.frequency)
    low, high = max(float(np.percentile(frequency, 10)), 0.05), 1.5 * float(frequency.max())
    naturals = np.geomspace(low, high, 40)
    return [
        _law(RESONANCE, form, (float(w), z, 1.0), ("speed",), data)
        for form in forms
        for w in naturals
        for z in DAMPINGS
    ]


def course(law: Law, data: Amplitudes) -> Complex:
    """Factor of the strength of each order in the revolutions (revolutions, orders) by a law of the form 1 + e*g."""
    if law.form in EACH:
        return EACH[law.form](data.frequency, *law.point[:2])
    g = value(law.effect, law.form, law.point, data.x, data.time, law.reference)
    return np.repeat(g[:, None], len(data.orders), axis=1).astype(np.complex128)


def factors(data: Amplitudes) -> list[Law]:
    """Laws of the form 1 + e*g that are tried, each with its points."""
    speed, load, heat = np.abs(data.x[:, 1]), data.x[:, 0], data.x[:, 2]
    span, coldest = max(float(np.ptp(heat)), 1.0), float(heat.min())
    tried: list[tuple[str, str, str, Sequence[tuple[float, ...]]]] = [
        (f"te.{name}_nonlinear", form, name, points)
        for name, form, points in (
            ("velocity", "exponential", [(float(v),) for v in np.geomspace(0.08, 0.8, 7) * speed.max()]),
            ("velocity", "rational", [(float(v),) for v in np.geomspace(0.08, 0.8, 7) * speed.max()]),
            ("temperature", "exponential", [(float(s * span),) for s in (0.08, 0.15, 0.3, 0.6)]),
            (
                "temperature",
                "transition",
                [(float(coldest + s * span), w * span) for s in (0.2, 0.35, 0.5, 0.65, 0.8) for w in (0.05, 0.12, 0.3)],
            ),
        )
    ]
    tried += [
        ("te.drift_time", "linear", "time", [()]),
        ("te.drift_time", "creep", "time", [(0.05,), (0.15,), (0.4,)]),
        ("unknown", "amplitude over load", "torque", [()]),
        ("unknown", "amplitude about zero load", "torque", [(0.05,), (0.15,), (0.3,)]),
    ]
    # a swelling in a band of speed or temperature is a function of that quantity: these names are defined so
    for effect, form, name, values in (
        ("unknown", "amplitude in a band of load", "torque", load),
        ("te.velocity_nonlinear", "band", "speed", speed),
        ("te.temperature_nonlinear", "band", "temperature", heat),
    ):
        width = float(np.ptp(values))
        if width > RANK * float(np.abs(values).max()):
            centres = float(values.min()) + np.linspace(0.0, 1.0, 13) * width
            tried.append((effect, form, name, [(float(c), w * width) for c in centres for w in (0.06, 0.12)]))
    names = {"velocity": "speed"}
    laws = [
        _law(effect, form, point, (names.get(name, name),), data)
        for effect, form, name, points in tried
        for point in points
    ]
    courses = (value(law.effect, law.form, law.point, data.x, data.time, law.reference) for law in laws)
    return [law for law, g in zip(laws, courses, strict=True) if is_beyond_polynomials(g, data)]


def is_beyond_polynomials(g: FloatArray, data: Amplitudes) -> bool:
    """Whether a course ``g`` (revolutions,) varies over the revolutions of a direction in a way that no polynomial of
    the series can say, but for :data:`criteria.LAW_BEYOND` of it.

    With two speeds every function of speed is a straight line: what such a law gains, it gains from the polynomials'
    prior and not from the recordings. So it does where the quantity stays as it is, but for rounding.
    """
    left, whole = 0.0, 0.0
    for side, scaling in data.series.scaling.items():
        on_side = data.direction * side > 0
        basis = scaling.monomials(data.x[on_side])
        left += float(np.sum((g[on_side] - basis @ np.linalg.lstsq(basis, g[on_side], rcond=RANK)[0]) ** 2))
        whole += float(np.sum((g[on_side] - g[on_side].mean()) ** 2))
    return whole > RANK**2 * float(np.sum(g**2)) and left > criteria.LAW_BEYOND * whole


def changes_of(data: Amplitudes, white: Sequence[FloatArray], laws: Sequence[Law]) -> list[FloatArray]:
    """What each law's strength does to the orders' whitened vectors (orders, 2*revolutions, k): one column of all for a
    resonance, else two of each.

    Orthonormal for the latter.
    """
    smooth = data.series.vectors(data.x, data.direction)
    moved = [_moved(data, smooth, law) for law in laws]
    columns = np.concatenate(moved, axis=2)
    whole = np.stack([np.asarray(solve_triangular(lower, columns[:, k], lower=True)) for k, lower in enumerate(white)])
    out = []
    for change in np.split(whole, np.cumsum([m.shape[2] for m in moved])[:-1], axis=2):
        if change.shape[2] == 1:
            out.append(np.ascontiguousarray(change))
            continue
        # with a weak prior: a law changes an amplitude by less than ten times itself
        prior = np.broadcast_to(0.1 * np.eye(2), (len(change), 2, 2))
        out.append(np.linalg.qr(np.concatenate([change, prior], axis=1))[0][:, :-2])
    for law, change in zip(laws, out, strict=True):
        if law.form not in MODES:
            change[~data.regular] = 0.0
    return out


def _moved(data: Amplitudes, smooth: Complex, law: Law) -> FloatArray:
    """What a law's strength does to the vectors ``smooth`` (revolutions, orders), before whitening: (2*revolutions,
    orders, k).
    """
    if law.form in MODES:
        return stacked(MODES[law.form](data.frequency, law.point[0], law.point[1]) * smooth)[:, :, None]
    begin = course(law, data) * smooth
    return np.stack([stacked(begin), stacked(1j * begin)], axis=2)


@dataclass(frozen=True, slots=True)
class Scores:
    """Gains of a law on some draws of the orders' residuals, net of its numbers' price: in ``total`` (draws,) and of
    ``each`` order (draws, orders); a resonance's ``participation`` (draws,).
    """

    total: FloatArray
    each: FloatArray
    participation: FloatArray


def scores(law: Law, changes: FloatArray, flat: FloatArray) -> Scores:
    """Score a law whose ``changes`` (orders, 2*revolutions, k) of the whitened vectors are given on draws of the
    orders' residuals ``flat`` (draws, orders, 2*revolutions).
    """
    revolutions = 0.5 * flat.shape[2]
    prior = 2.0 * PRIOR_REVOLUTIONS
    before = np.sum(flat**2, axis=2)
    price = float(np.log(2.0 * revolutions))
    # (orders, k, draws) -> (draws, orders, k)
    product = np.moveaxis(np.swapaxes(changes, 1, 2) @ np.transpose(flat, (1, 2, 0)), 2, 0)

    def gained(after: FloatArray) -> FloatArray:
        return np.asarray(
            (revolutions + PRIOR_REVOLUTIONS) * np.log((before + prior) / (np.maximum(after, 0.0) + prior))
        )

    if law.form in MODES:
        energy, product = np.sum(changes[:, :, 0] ** 2, axis=1), product[:, :, 0]
        p = np.minimum(product.sum(axis=1) / max(float(energy.sum()) + 0.01, 1e-300), 1.5)
        each = gained(before - 2.0 * p[:, None] * product + p[:, None] ** 2 * energy)
        # three numbers (BIC), of which the place is searched
        total = each.sum(axis=1) - 1.5 * price - unusual(law.point[1])
        held = p > 0.0
        return Scores(np.where(held, total, -np.inf), np.where(held[:, None], each, 0.0), np.where(held, p, 0.0))
    # two numbers an order (BIC), where it takes part
    each = np.maximum(gained(before - np.sum(product**2, axis=2)) - price, 0.0)
    return Scores(each.sum(axis=1), each, np.zeros(len(flat)))


def unusual(damping: float) -> float:
    """How unusual a resonance's damping is (log-likelihood): where no speed meets the mode, nothing else tells it."""
    return float(0.5 * (np.log(damping / criteria.USUAL_DAMPING) / criteria.DAMPING_SPREAD) ** 2)
