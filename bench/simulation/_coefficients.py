"""How the coefficients of ``te.fourier`` and ``te.offset`` stand in a simulation file."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import ConfigurationError
from bench.simulation.fourier import FourierSet, TransmissionErrorModel
from bench.simulation.polynomial import TERM_COUNT

FloatArray = NDArray[np.float64]

DIRECTIONS = ("positive", "negative")


def _numbers(values: Any, shape: tuple[int, ...], where: str) -> FloatArray:
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ConfigurationError(f"{where} should be an array of numbers of shape {shape}.") from error
    if array.shape != shape or not np.isfinite(array).all():
        raise ConfigurationError(f"{where} should hold finite numbers of shape {shape}.")
    return array


def order_key(order: float) -> str:
    """An order as a key: without a point where it is whole, else with all its digits (turns multiply it)."""
    return str(int(order)) if order.is_integer() else repr(order)


def _order(key: str, where: str) -> float:
    try:
        return float(key)
    except ValueError as error:
        raise ConfigurationError(f"{where}: '{key}' should be a harmonic order or 'a0'.") from error


def _pairs(rows: dict[str, Any], keys: list[str], where: str) -> tuple[FloatArray, FloatArray]:
    amplitude, phase = np.zeros((len(keys), TERM_COUNT)), np.zeros((len(keys), TERM_COUNT))
    for i, key in enumerate(keys):
        row = rows.get(key)
        if not isinstance(row, dict):
            raise ConfigurationError(f"{where}.{key} should be an object with 'A' and 'phi'.")
        amplitude[i] = _numbers(row.get("A"), (TERM_COUNT,), f"{where}.{key}.A")
        phase[i] = _numbers(row.get("phi"), (TERM_COUNT,), f"{where}.{key}.phi")
    return amplitude, phase


def _section(data: Any, direction: str, where: str) -> dict[str, Any] | None:
    if data is None:
        return None
    if not isinstance(data, dict) or not isinstance(data.get(direction, {}), dict):
        raise ConfigurationError(f"{where} should be an object with '{direction}'.")
    section: dict[str, Any] | None = data.get(direction)
    return section


def fourier_from_json(parameters: Any, std: Any, covariance: Any, where: str) -> TransmissionErrorModel:
    """Read both directions; ``std`` and ``covariance`` may be None. Raises ConfigurationError."""
    sets: list[FourierSet | None] = []
    for direction in DIRECTIONS:
        rows = _section(parameters, direction, f"{where}.parameters")
        if rows is None:
            sets.append(None)
            continue
        path = f"{where}.parameters.{direction}"
        keys = sorted((key for key in rows if key != "a0"), key=lambda key: _order(key, path))
        amplitude, phase = _pairs(rows, keys, path)
        offset = _numbers(rows.get("a0", [0.0] * TERM_COUNT), (TERM_COUNT,), f"{path}.a0")
        spread = _section(std, direction, f"{where}.std")
        amplitude_std = phase_std = offset_std = None
        if spread is not None:
            if keys and all(key in spread for key in keys):
                amplitude_std, phase_std = _pairs(spread, keys, f"{where}.std.{direction}")
            if "a0" in spread:
                offset_std = _numbers(spread["a0"], (TERM_COUNT,), f"{where}.std.{direction}.a0")
        joint = _section(covariance, direction, f"{where}.covariance")
        matrices = offset_matrix = None
        if joint is not None:
            path = f"{where}.covariance.{direction}"
            if keys and all(key in joint for key in keys):
                size = (2 * TERM_COUNT, 2 * TERM_COUNT)
                matrices = np.stack([_numbers(joint[key], size, f"{path}.{key}") for key in keys])
            if "a0" in joint:
                offset_matrix = _numbers(joint["a0"], (TERM_COUNT, TERM_COUNT), f"{path}.a0")
        sets.append(
            FourierSet(
                np.asarray([float(key) for key in keys]),
                amplitude,
                phase,
                offset,
                amplitude_std,
                phase_std,
                offset_std,
                matrices,
                offset_matrix,
            )
        )
    return TransmissionErrorModel(sets[0], sets[1])


def fourier_to_json(model: TransmissionErrorModel, *, series: bool) -> dict[str, Any]:
    """Return ``parameters`` (and ``std``, ``covariance``): the orders if ``series``, else a₀ alone."""
    sections: dict[str, dict[str, dict[str, Any]]] = {"parameters": {}, "std": {}, "covariance": {}}
    for direction in DIRECTIONS:
        fourier: FourierSet | None = getattr(model, direction)
        if fourier is None:
            continue
        values: dict[str, Any] = {}
        spread: dict[str, Any] = {}
        joint: dict[str, Any] = {}
        if series:
            for i, order in enumerate(fourier.orders):
                key = order_key(float(order))
                values[key] = {"A": fourier.amplitude[i].tolist(), "phi": fourier.phase[i].tolist()}
                if fourier.amplitude_std is not None and fourier.phase_std is not None:
                    spread[key] = {"A": fourier.amplitude_std[i].tolist(), "phi": fourier.phase_std[i].tolist()}
                if fourier.covariance is not None:
                    joint[key] = fourier.covariance[i].tolist()
        else:
            values["a0"] = fourier.offset.tolist()
            if fourier.offset_std is not None:
                spread["a0"] = fourier.offset_std.tolist()
            if fourier.offset_covariance is not None:
                joint["a0"] = fourier.offset_covariance.tolist()
        for name, section in (("parameters", values), ("std", spread), ("covariance", joint)):
            if section:
                sections[name][direction] = section
    return {name: section for name, section in sections.items() if section}
