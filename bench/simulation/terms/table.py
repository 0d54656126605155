"""The table of all terms: to add one, write its file and put it here."""

from __future__ import annotations

from bench.simulation.terms.base import Term
from bench.simulation.terms.friction import (
    directional,
    position_dependent,
    presliding,
    run_in,
    stribeck,
    viscous_quadratic,
    viscous_temperature,
)
from bench.simulation.terms.load import unbalance
from bench.simulation.terms.motor import torque_constant, torque_ripple
from bench.simulation.terms.nominal import friction as nominal_friction
from bench.simulation.terms.nominal import load as nominal_load
from bench.simulation.terms.nominal import motor as nominal_motor
from bench.simulation.terms.nominal import thermal as nominal_thermal
from bench.simulation.terms.nominal import transmission_error as nominal_te
from bench.simulation.terms.sensor import (
    motor_encoder,
    timing_skew,
    torque_gain,
    torque_hysteresis,
    torque_nonlinearity,
    torque_zero_temperature,
)
from bench.simulation.terms.te import (
    drift_time,
    harmonic,
    hysteresis,
    local_defect,
    lost_motion,
    resonance,
    sideband,
    stiffness_nonlinear,
    temperature_nonlinear,
    velocity_nonlinear,
)
from bench.simulation.terms.thermal import ambient_drift, convection_speed, second_mass, sensor_lag

_MODULES = (
    harmonic,
    sideband,
    local_defect,
    resonance,
    lost_motion,
    stiffness_nonlinear,
    hysteresis,
    drift_time,
    velocity_nonlinear,
    temperature_nonlinear,
    motor_encoder,
    timing_skew,
    stribeck,
    viscous_temperature,
    viscous_quadratic,
    directional,
    position_dependent,
    run_in,
    presliding,
    torque_ripple,
    torque_constant,
    unbalance,
    sensor_lag,
    second_mass,
    ambient_drift,
    convection_speed,
    torque_zero_temperature,
    torque_gain,
    torque_nonlinearity,
    torque_hysteresis,
)
_NOMINAL = (
    *nominal_te.TERMS,
    *nominal_friction.TERMS,
    *nominal_motor.TERMS,
    *nominal_thermal.TERMS,
    *nominal_load.TERMS,
)

LIBRARY: dict[str, Term] = {term.effect: term for term in (*_NOMINAL, *(module.TERM for module in _MODULES))}


def for_channel(channel: str) -> tuple[Term, ...]:
    """Terms beyond the nominal simulation that show in a channel."""
    return tuple(term for term in LIBRARY.values() if channel in term.forms and not term.nominal)


def nominal_for(channel: str) -> tuple[Term, ...]:
    """Terms of the nominal simulation that show in a channel."""
    return tuple(term for term in LIBRARY.values() if channel in term.forms and term.nominal)
