"""The heat balance of an identified model in the form that predictions ask for.

Identification tells C, R and T_amb; the nominal terms are linear in 1/C, 1/(R·C) and (T_amb − 25 °C)/(R·C).
"""

from __future__ import annotations

from dataclasses import replace

from bench.mismatch import criteria
from bench.simulation.model import Parameter, Simulation

HEATING, CONVECTION = "thermal.loss_heating", "thermal.convection"


def with_rates(simulation: Simulation) -> Simulation:
    """The simulation with the rates its C, R and T_amb stand for; unchanged where it has none, or has the rates."""
    own = {symbol: p.value for e in (HEATING, CONVECTION) if e in simulation.terms for symbol, p in _of(simulation, e)}
    if not {"C", "R", "T_amb"} <= set(own) or min(own["C"], own["R"]) <= 0.0:
        return simulation
    slow = 1.0 / (own["C"] * own["R"])
    rates = {
        HEATING: {"1/C": Parameter(1.0 / own["C"], "K/J")},
        CONVECTION: {
            "1/(R*C)": Parameter(slow, "1/s"),
            "(T_amb-25)/(R*C)": Parameter((own["T_amb"] - criteria.REFERENCE_CELSIUS) * slow, "K/s"),
        },
    }
    for effect, parameters in rates.items():
        term = simulation.terms[effect]
        simulation = simulation.with_term(replace(term, parameters={**parameters, **term.parameters}))
    return simulation


def _of(simulation: Simulation, effect: str) -> list[tuple[str, Parameter]]:
    return list(simulation.terms[effect].parameters.items())
