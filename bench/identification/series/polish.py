"""From harmonics of many recordings to polynomials of amplitude and phase.

Each recording gives one complex value z_r = A·exp(iφ) an order, with the variance its noise implies. The polynomials of
A and φ are fitted to all z_r at once (:mod:`.polar`), beginning with a phase whose linear part a search has found. What
scatters between recordings beyond their own noise (torque sensor, temperature reading, controller) is a second
variance, one along and one across z, estimated from the residuals, so that standard deviations hold.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.identification.series.inputs import Design
from bench.identification.series.points import points_covariance
from bench.identification.series.polar import fit_polynomials

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

MIN_FREEDOM = 8
MIN_FACTOR = 0.01


@dataclass(frozen=True, slots=True)
class PolarFit:
    """Coefficients of the kept standardised monomials (P,), joint covariance (2P, 2P) of (amplitude, phase).

    ``along`` is the spread of amplitudes (rad²), ``across`` that of phases (rad²).
    """

    amplitude: FloatArray
    phase: FloatArray
    covariance: FloatArray
    along: Spread
    across: Spread


@dataclass(frozen=True, slots=True)
class Spread:
    """Variance of a recording's value: ``factor``·(its own noise) + ``scatter`` between recordings."""

    factor: float = 1.0
    scatter: float = 0.0

    def variance(self, within: FloatArray) -> FloatArray:
        """Variance (R,) for the noise variance ``within`` (R,)."""
        return self.factor * within + self.scatter


def estimate_spread(residual: FloatArray, within: FloatArray, parameters: int) -> Spread:
    """Make Σ residual²/variance = R − parameters.

    Where residuals exceed their own noise the rest is scatter between recordings (Paule and Mandel 1982). Where they
    fall short of it, what is seen beside an order overstates the noise at it (the error of an encoder's counts is no
    random noise), and the noise is scaled down instead, given at least eight degrees of freedom.
    """
    freedom = residual.size - parameters
    # a noise of exactly 0 would be divided by
    within = np.maximum(within, 1e-12 * float(np.mean(residual**2)) + 1e-300)

    def excess(s: float) -> float:
        return float((residual**2 / (within + s)).sum()) - max(freedom, 1)

    beyond = excess(0.0)
    if beyond <= 0.0:
        share = (beyond + freedom) / freedom if freedom >= MIN_FREEDOM else 1.0
        return Spread(max(share, MIN_FACTOR), 0.0)
    scatter = 0.0
    for _ in range(60):
        # falling and convex in the scatter: Newton's steps go up to the root and never beyond
        step = beyond / float((residual**2 / (within + scatter) ** 2).sum())
        scatter += step
        beyond = excess(scatter)
        if step <= 1e-9 * scatter:
            break
    return Spread(1.0, scatter)


def fit_linear(regressors: FloatArray, values: FloatArray, within: FloatArray) -> tuple[FloatArray, FloatArray, Spread]:
    """Weighted least squares with scatter between recordings: coefficients (P,), covariance (P, P), spread."""
    spread = Spread()
    for _ in range(12):
        weight = 1.0 / spread.variance(within)
        covariance = np.asarray(np.linalg.pinv((regressors.T * weight) @ regressors), dtype=np.float64)
        coefficients = covariance @ (regressors.T @ (weight * values))
        update = estimate_spread(values - regressors @ coefficients, within, regressors.shape[1])
        done = np.allclose(update.variance(within), spread.variance(within), rtol=1e-3, atol=0.0)
        spread = update
        if done:
            break
    return coefficients, covariance, spread


def _phase_gradient(z: ComplexArray, inputs: FloatArray) -> FloatArray:
    """Slope (3,) of a phase linear in the standardised inputs for which the rotated z add up best."""
    grid = np.linspace(-4.0, 4.0, 9)
    varies = [grid if np.ptp(inputs[:, j]) > 0 else np.zeros(1) for j in range(3)]
    best = np.zeros(3)
    weighted = z * np.abs(z)
    for step in (0.8, 0.2, 0.05):
        axes = [best[j] + step * varies[j] for j in range(3)]
        steps = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        best = steps[np.argmax(np.abs(np.exp(-1j * (steps @ inputs.T)) @ weighted))]
    return np.asarray(best)


def _start(z: ComplexArray, design: Design) -> tuple[FloatArray, FloatArray]:
    columns = design.regressors
    scaled = (design.inputs - design.standardisation.mean) / design.standardisation.std
    gradient = _phase_gradient(z, scaled * (np.ptp(design.inputs, axis=0) > 0))
    rotated = z * np.exp(-1j * (scaled @ gradient))
    centre = np.angle((rotated * np.abs(rotated)).sum())
    rest = rotated * np.exp(-1j * centre)
    total = scaled @ gradient + centre + np.angle(rest)
    weight = np.abs(z)
    phase = np.linalg.lstsq(columns * weight[:, None], total * weight, rcond=None)[0]
    amplitude = np.linalg.lstsq(columns, (z * np.exp(-1j * (columns @ phase))).real, rcond=None)[0]
    return amplitude, phase


def fit_polar(
    z: ComplexArray, within: FloatArray, design: Design, near: PolarFit | None = None, points: bool = False
) -> PolarFit:
    """Fit amplitude and phase polynomials to z (R,) with variance ``within`` (R,) a component.

    ``near`` is an earlier fit to start from. The amplitude comes out positive and the phase within (−π, π] at the
    mean of the inputs. With ``points`` the covariance has what recordings of a speed and torque share.
    """
    columns = design.regressors
    size = columns.shape[1]
    p = np.concatenate(_start(z, design) if near is None else (near.amplitude, near.phase))
    radial = tangential = np.maximum(within, 1e-6 * float((np.abs(z) ** 2).mean()) + 1e-300)
    along = across = Spread()
    for _ in range(8):
        found = fit_polynomials(columns, z, radial, tangential, [p], columns @ p[size:])
        p = np.concatenate([found.amplitude, found.phase])
        level = columns @ found.amplitude
        off = z * np.exp(-1j * (columns @ found.phase)) - level
        along = estimate_spread(off.real, within, size)
        # Scatter of the phase turns into a deviation across z in proportion to the amplitude.
        square = np.maximum(np.abs(level), 1e-3 * float(np.abs(level).max()) + 1e-300) ** 2
        across = estimate_spread(off.imag / np.sqrt(square), within / square, size)
        new_radial, new_tangential = along.variance(within), across.variance(within / square) * square
        done = np.allclose(new_radial, radial, rtol=1e-3, atol=0.0) and np.allclose(
            new_tangential, tangential, rtol=1e-3, atol=0.0
        )
        radial, tangential = new_radial, new_tangential
        if done:
            break
    amplitude, phase, covariance = found.amplitude, found.phase, found.covariance
    if points:
        first, second = covariance[:size, :size], covariance[size:, size:]
        covariance[:size, :size] = first + points_covariance(design, first, off.real, radial)
        squares = tangential / square
        covariance[size:, size:] = second + points_covariance(design, second, off.imag / np.sqrt(square), squares)
    centre = design.columns(design.inputs.mean(axis=0))
    constant = int(np.argmax(design.kept == 9))
    if float(centre @ amplitude) < 0:
        amplitude, phase[constant] = -amplitude, phase[constant] + np.pi
        flip = np.concatenate([-np.ones(size), np.ones(size)])
        covariance = covariance * np.outer(flip, flip)
    mean_phase = float(centre @ phase)
    phase[constant] -= 2.0 * np.pi * np.ceil((mean_phase - np.pi) / (2.0 * np.pi))
    return PolarFit(amplitude, phase, covariance, along, across)
