"""How often 95 % intervals hold the truth: deviations of a model from the truth in standard normal units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm, t

from bench.identification.balances.instant import systematic_std
from bench.identification.statistics.freedom import parameter_freedom, series_freedom
from bench.simulation import FourierSet, Simulation
from bench.simulation._coefficients import DIRECTIONS, fourier_from_json

FloatArray = NDArray[np.float64]

LEVEL = 0.95
LIMIT = float(norm.isf(0.5 * (1.0 - LEVEL)))
_FURTHEST = 37.0
"""Normal deviates beyond this have no tail in double precision."""


def normal_deviate(difference: FloatArray, std: FloatArray, freedom: float) -> FloatArray:
    """Deviates (...,) that are standard normal where difference/std follows Student's t with ``freedom`` degrees.

    NaN where ``std`` is 0 or not known: such a coefficient is not claimed to be determined.
    """
    known = np.isfinite(std) & (std > 0.0)
    ratio = np.abs(difference) / np.where(known, std, 1.0)
    size = norm.isf(t.sf(ratio, freedom)) if np.isfinite(freedom) else ratio
    size = np.where(np.isfinite(size), size, _FURTHEST)
    return np.where(known, np.sign(difference) * size, np.nan)


def _series(found: FourierSet, true: FourierSet, freedom: float) -> dict[str, FloatArray]:
    """Deviates of amplitudes and phases (K·10,) of the orders found, of amplitudes of orders that are not there, of a₀.

    An order that the true series lacks has the amplitude 0 and no phase. Its amplitudes stand apart (``absent``).
    """
    position = {float(order): row for row, order in enumerate(true.orders)}
    there = np.array([float(order) in position for order in found.orders])
    at = [position[float(order)] for order in found.orders[there]]
    true_amplitude = np.zeros_like(found.amplitude)
    true_amplitude[there] = true.amplitude[at]
    phase = found.phase[there] - true.phase[at]
    # a phase is known up to whole revolutions, an amplitude's sign up to half of one
    phase[:, 9] = (phase[:, 9] + np.pi) % (2.0 * np.pi) - np.pi
    missing = np.full_like(found.amplitude, np.nan)

    def std(values: FloatArray | None, otherwise: FloatArray) -> FloatArray:
        return otherwise if values is None else values

    amplitude = normal_deviate(found.amplitude - true_amplitude, std(found.amplitude_std, missing), freedom)
    return {
        "A": amplitude[there].ravel(),
        "phi": normal_deviate(phase, std(found.phase_std, missing)[there], freedom).ravel(),
        "absent": amplitude[~there].ravel(),
        "a0": normal_deviate(found.offset - true.offset, std(found.offset_std, missing[0]), freedom),
    }


def _rounded(z: float) -> float | None:
    return round(float(z), 3) if np.isfinite(z) else None


def deviates(found: Simulation, truth: Mapping[str, Any]) -> dict[str, Any]:
    """Compare an identified model with the truth of its plant.

    ``truth`` has ``nominal`` (effect → symbol → value) and ``transmission_error`` (a simulation file's coefficients).
    Returns ``parameters``: symbol → value, std, freedom, truth, z; ``series``: direction → A, phi, absent, a0 → lists
    of z.
    Symbols that were not determined are absent, coefficients that were not are None.
    """
    parameters: dict[str, dict[str, float | None]] = {}
    for effect, values in truth["nominal"].items():
        for symbol, true in values.items():
            found_term = found.terms[effect]
            parameter = found_term.parameters.get(symbol)
            if parameter is None or parameter.std is None:
                continue
            freedom = parameter_freedom(found_term, symbol)
            shared = systematic_std(found_term, symbol)
            std = float(np.hypot(parameter.std, shared))
            # a known bound has no degrees of freedom to speak of; what is left of the others' share is Welch's
            freedom *= (std / parameter.std) ** 4 if parameter.std > 0.0 else 1.0
            off = np.array(parameter.value - true)
            z = float(normal_deviate(off, np.array(std), freedom))
            parameters[symbol] = {
                "value": parameter.value,
                "std": std,
                "repeat_std": parameter.std,
                "repeat_z": float(normal_deviate(off, np.array(parameter.std), parameter_freedom(found_term, symbol))),
                "freedom": freedom if np.isfinite(freedom) else None,
                "truth": true,
                "z": z,
            }
    series: dict[str, dict[str, list[float | None]]] = {}
    model, true_model = found.transmission_error(), fourier_from_json(truth["transmission_error"], None, None, "truth")
    for name, sign in zip(DIRECTIONS, (1.0, -1.0), strict=True):
        one, true_one = None if model is None else model.direction(sign), true_model.direction(sign)
        if one is not None and true_one is not None:
            rows = _series(one, true_one, series_freedom(found, name))
            series[name] = {key: [_rounded(z) for z in values] for key, values in rows.items()}
    return {"parameters": parameters, "series": series}
