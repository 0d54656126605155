"""What a comparison finds of changes that are there: known ones put into one of two models of the same plant."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from bench.identification.comparison.compare import compare
from bench.simulation import FourierSet, Simulation, TransmissionErrorModel

SHARES = (0.01, 0.02, 0.05)
_Set = Callable[[FourierSet], FourierSet]


def _series(simulation: Simulation, change: _Set) -> Simulation:
    model = simulation.transmission_error()
    if model is None:
        return simulation
    sets = (None if one is None else change(one) for one in (model.positive, model.negative))
    return simulation.with_transmission_error(TransmissionErrorModel(*sets))


def _order(order: float) -> Callable[[Simulation, float], Simulation]:
    def change(simulation: Simulation, share: float) -> Simulation:
        def stronger(one: FourierSet) -> FourierSet:
            amplitude = one.amplitude.copy()
            amplitude[one.orders == order] *= 1.0 + share
            return replace(one, amplitude=amplitude)

        return _series(simulation, stronger)

    return change


def _stiffness(simulation: Simulation, share: float) -> Simulation:
    def stiffer(one: FourierSet) -> FourierSet:
        offset = one.offset.copy()
        offset[3] /= 1.0 + share
        return replace(one, offset=offset)

    return _series(simulation, stiffer)


def _coulomb(simulation: Simulation, share: float) -> Simulation:
    term = simulation.terms["friction.coulomb"]
    found = term.parameters.get("f_c")
    if found is None:
        return simulation
    parameters = {**term.parameters, "f_c": replace(found, value=found.value * (1.0 + share))}
    return simulation.with_term(replace(term, parameters=parameters))


CHANGES: Mapping[str, tuple[str, Callable[[Simulation, float], Simulation]]] = {
    "order 1": ("order 1,", _order(1.0)),
    "order 46": ("order 46,", _order(46.0)),
    "order 276": ("order 276,", _order(276.0)),
    "Coulomb friction": ("friction.coulomb f_c", _coulomb),
    "stiffness": ("compliance,", _stiffness),
}
"""What is changed: how the comparison's row for it begins, and the change by a share of itself."""


def power(before: Simulation, after: Simulation) -> dict[str, list[bool] | None]:
    """Whether each change of 1, 2 and 5 % is found as such when ``after`` has it on top; None if it is not compared."""
    compared = [row.what for row in compare(before, after)]
    out: dict[str, list[bool] | None] = {}
    for name, (begins, change) in CHANGES.items():
        if not any(what.startswith(begins) for what in compared):
            out[name] = None
            continue
        out[name] = [
            any(row.changed and row.what.startswith(begins) for row in compare(before, change(after, share)))
            for share in SHARES
        ]
    return out
