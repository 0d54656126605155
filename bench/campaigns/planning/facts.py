"""From a bench configuration to the facts a sequence may know."""

from __future__ import annotations

from bench.configuration import BenchConfiguration
from bench.protocols import BenchFacts


def facts(bench: BenchConfiguration) -> BenchFacts:
    """Return ratio, ramps and heating of a bench."""
    return BenchFacts(
        ratio=bench.gearbox.ratio,
        motor_acceleration=bench.motion.motor_acceleration,
        torque_rate=bench.motion.torque_rate,
        settling_s=bench.motion.settling,
        heating_motor_speed=bench.heating.motor_speed,
        heating_time_limit_s=bench.heating.time_limit,
        heating_hysteresis=bench.heating.hysteresis,
        heating_soak_s=bench.heating.soak,
        ambient_temperature=bench.nominal.ambient_temperature,
    )
