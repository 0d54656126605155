"""The torque sensor's own hysteresis."""

from __future__ import annotations

from bench.simulation.terms.base import LOAD_TORQUE, Symbol, Term
from bench.simulation.terms.loops import STACK, WIDEST, Loops

LOOPS = Loops(
    level=lambda frame: frame.load_motor_level,
    torque="load_motor_torque",
    output="load_torque",
    size=Symbol("h_s", "N*m", "half width of the loop"),
    width=Symbol("w_h", "N*m", "torque over which the loop turns", 0.0),
    rate=Symbol("r", "1/s", "rate at which the loop forgets, for the load wavers to and fro", 0.0),
    in_motion=Symbol(
        "k", "1/rad", "rate at which the loop forgets in motion, for the load wavers with the angle (dither)", 0.0
    ),
    relaxing="dahl",
    # the simulation has a compliance, which is what the widest play of a stack looks like, but no gain of the sensor
    widest_stack=WIDEST / max(STACK),
)

TERM = Term(
    effect="sensor.torque_hysteresis",
    name="hysteresis of the torque sensor",
    equation="load_torque += h_s*z, dz = (1 - z*sgn(dx))*dx/w_h (or play of half width w_h), x = load_motor_torque",
    reference="Krasnosel'skii and Pokrovskii, Systems with Hysteresis, Springer 1989; VDI/VDE 2646",
    where="load_torque, by whether the load rises or falls",
    forms={LOAD_TORQUE: LOOPS.forms()},
    variables=("torque_path",),
)
