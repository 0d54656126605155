"""What is concealed in a plant, in words and numbers."""

from __future__ import annotations

from typing import Any

from fakes.plant.hidden.kinds import Hidden
from fakes.plant.spec import plant_of


def concealed_in(plant: str) -> dict[str, Any]:
    """Return what a plant's name (``rh380n?conceal=77``) conceals, JSON-ready.

    Raises:
        PlantError: the name is wrong.
    """
    truth = plant_of(plant)
    series = truth.transmission_error
    return {
        "format": "bench-concealed",
        "base": plant.partition("?")[0],
        "concealed": [_entry(one) for one in truth.hidden],
        "weak_orders": [float(order) for order in series.orders[series.weak]],
        "nominal": truth.nominal_parameters(),
    }


def _entry(one: Hidden) -> dict[str, Any]:
    kind = one.definition
    return {
        "effect": kind.effect,
        "form": kind.text,
        "channel": kind.channel,
        "in_library": kind.in_library,
        "parameters": dict(zip(kind.parameters, one.parameters, strict=True)),
    }


def nominal_truth(plant: str) -> dict[str, Any]:
    """Return the true nominal parameters of a plant and its whole series, JSON-ready, as a simulation file has them.

    Raises:
        PlantError: the name is wrong.
    """
    truth = plant_of(plant)
    return {"nominal": truth.nominal_parameters(), "transmission_error": truth.te_coefficients()}
