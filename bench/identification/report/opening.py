"""What the report begins with: a verdict in three lines, and the equations that were identified."""

from __future__ import annotations

import html
from collections.abc import Sequence

import numpy as np

from bench.identification.balances.slow_equations import FRICTION_MEANING
from bench.identification.identify import Identification
from bench.identification.summary import doubtful, parameters, verdict
from bench.simulation import basis
from bench.typeset import engineering, mathml, symbol

LARGEST = 3
EQUATIONS: tuple[tuple[str, str], ...] = (
    (
        "Transmission error",
        "TE = sum_k A_k(tau, dtheta, T)*sin(f_k*theta + phi_k(tau, dtheta, T)) + a0(tau, dtheta, T)",
    ),
    (
        "Torque at the motor",
        "tau_m = tau/u + d*f_c + f_v*w_m + f_vT*w_m*(T - 25 degC) + d*f_l*abs(tau)/u + J*dw_m/dt + tau_0",
    ),
    ("Heat", "C*dT/dt = abs(tau_m*w_m - tau*dq/dt) - (T - T_amb)/R"),
    ("Torque sensor", "tau_s = tau_L + d*f_b + J_L*d2q/dt2 + z_0"),
)
MEANING: dict[str, str] = {
    **FRICTION_MEANING,
    "C": "heat capacity",
    "R": "heat resistance to the room",
    "T_amb": "temperature of the room",
    "f_b": "bearing friction of the load side",
    "J_L": "inertia of the load side",
    "z_0": "zero of the torque sensor",
}
"""What each identified parameter is."""
QUANTITIES: dict[str, str] = {
    "TE": "transmission error, q − θ",
    "theta": "angle of the motor divided by the ratio",
    "dtheta": "its speed",
    "q": "angle of the load side",
    "tau": "load torque",
    "tau_m": "torque of the motor",
    "tau_s": "reading of the torque sensor",
    "tau_L": "torque of the load motor",
    "T": "temperature of the lubricant",
    "w_m": "speed of the motor",
    "u": "ratio of the gearbox",
    "d": "direction of motion, +1 or −1",
    "f_k": "order, per revolution of the load side",
    "A_k": "amplitude of an order, a polynomial of its three inputs",
    "phi_k": "phase of an order, as well",
    "a0": "mean error, as well",
}
"""What the symbols of the equations are, besides the parameters."""


def three_lines(found: Identification) -> tuple[str, str, str]:
    """How good the model is, what this gearbox is like, and what is not known of it; one sentence each."""
    return verdict(found), _gearbox(found), _unknown_sentence(found)


def opening(found: Identification, since_last: Sequence[str] = ()) -> str:
    """The verdict as HTML; ``since_last`` is what changed since the last campaign of the same gearbox."""
    lines = "".join(f"<p>{html.escape(text)}</p>" for text in three_lines(found))
    more = "".join(f"<p>{html.escape(text)}</p>" for text in since_last)
    changed = f"<h2>Against the last campaign of this gearbox</h2><div class=verdict>{more}</div>" if more else ""
    return f"<div class=verdict>{lines}</div>{changed}"


def equations() -> str:
    """The equations with their symbols explained, as HTML."""
    rows = "".join(f"<p class=equation>{html.escape(name)}: {mathml(text)}</p>" for name, text in EQUATIONS)
    meanings = "".join(f"<dt>{symbol(name)}</dt><dd>{html.escape(what)}</dd>" for name, what in QUANTITIES.items())
    return f"{rows}<details><summary>What the symbols are</summary><dl>{meanings}</dl></details>"


def _gearbox(found: Identification) -> str:
    parts, unit = [], "µm" if found.linear else "µrad"
    for name, mark in (("positive", "+"), ("negative", "−")):
        result = found.refined.get(name)
        if result is None:
            continue
        centre = np.nan_to_num(result.design.inputs.mean(axis=0))
        size = np.abs(result.fourier.amplitude @ basis(centre[0], centre[1], centre[2]))
        largest = np.argsort(-size)[:LARGEST]
        listed = ", ".join(f"{result.fourier.orders[k]:g} with {1e6 * size[k]:.1f} {unit}" for k in largest)
        parts.append(f"largest orders {mark}: {listed}")
    known = parameters(found)
    for key in ("f_c", "f_v", "R"):
        if key in known:
            value, std, of = engineering(known[key].value, known[key].std, known[key].unit)
            doubt = "" if std == "–" else f" ± {std}"
            parts.append(f"{MEANING[key]} {value}{doubt} {of}")
    return f"This gearbox: {'; '.join(parts)}." if parts else "Nothing of this gearbox could be identified."


def _unknown_sentence(found: Identification) -> str:
    bad = list(doubtful(found))
    parts = [f"values that cannot be: {', '.join(bad)}"] if bad else []
    missing = [key for key in MEANING if key not in parameters(found)]
    parts += [f"not determined: {', '.join(missing)}"] if missing else []
    parts += [f"{len(found.skipped)} recordings left out or cut"] if found.skipped else []
    return f"What is not known: {'; '.join(parts)}." if parts else "Every parameter is determined by these recordings."
