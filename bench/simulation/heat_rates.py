"""The heat balance of an identified model in the form that predictions and calibrations ask for.

Identification reports C, R and T_amb, of the loss less what the constant τ_0 makes; the nominal terms are linear in
1/C, 1/(R·C) and (T_amb − 25 °C)/(R·C), and say in a key of their own what is taken off the loss.
"""

from __future__ import annotations

from dataclasses import replace

from bench.simulation.model import Parameter, Simulation

REFERENCE_CELSIUS = 25.0
"""temperature to which the cooling is referred (bench-physics, "Nominal simulation")"""
LESS = "less"
"""key of the term of the loss that names what is taken off it"""
LOAD_ZERO, MOTOR_ZERO = "load zero", "motor zero"
"""the constants z_0 and tau_0 as zeros of their sensors"""
OF_RECORDINGS = "zeros of recordings"
"""what the torque models leave of each recording's mean"""
OF_RECORDINGS_LOAD = "load zeros of recordings"
"""the same of the load torque alone"""
MOTOR_GAIN = "gain of the motor torque"
"""what ``motor.torque_constant`` says of the reported motor torque"""
MOTOR_UNNAMED = "unknown in the motor torque"
"""what functions without a name say of the motor torque, if that is an error of its report and no torque"""
LEFT_OF_MOTOR = "rest of the motor torque"
"""what the motor torque's model leaves of it at every moment: zeros of recordings, and the slow noise of its report"""
KINETIC = "kinetic energy"
"""what ``motor.inertia`` stores while the motor speeds up, and gives back"""
LIFTED = "unbalance"
"""what ``load.unbalance`` stores while its mass is lifted, and gives back"""
TAKEN_OFF = (
    LOAD_ZERO,
    MOTOR_ZERO,
    OF_RECORDINGS,
    OF_RECORDINGS_LOAD,
    LEFT_OF_MOTOR,
    KINETIC,
    MOTOR_GAIN,
    MOTOR_UNNAMED,
    LIFTED,
)
"""all that may be taken off the loss"""
HEATING, CONVECTION = "thermal.loss_heating", "thermal.convection"


def with_rates(simulation: Simulation) -> Simulation:
    """The simulation with the rates in place of its C, R and T_amb; unchanged where it has not all three, positive."""
    values = {
        symbol: p.value for e in (HEATING, CONVECTION) if e in simulation.terms for symbol, p in _of(simulation, e)
    }
    if not {"C", "R", "T_amb"} <= set(values) or min(values["C"], values["R"]) <= 0.0:
        return simulation
    slow = 1.0 / (values["C"] * values["R"])
    rates = {
        HEATING: {"1/C": Parameter(1.0 / values["C"], "K/J")},
        CONVECTION: {
            "1/(R*C)": Parameter(slow, "1/s"),
            "(T_amb-25)/(R*C)": Parameter((values["T_amb"] - REFERENCE_CELSIUS) * slow, "K/s"),
        },
    }
    for effect, parameters in rates.items():
        term = simulation.terms[effect]
        kept = {symbol: p for symbol, p in term.parameters.items() if symbol not in ("C", "R", "T_amb")}
        simulation = simulation.with_term(replace(term, parameters={**parameters, **kept}))
    heating = simulation.terms[HEATING]
    return simulation.with_term(replace(heating, extra={LESS: [MOTOR_ZERO], **heating.extra}))


def _of(simulation: Simulation, effect: str) -> list[tuple[str, Parameter]]:
    return list(simulation.terms[effect].parameters.items())
