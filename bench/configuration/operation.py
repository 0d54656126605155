"""How a bench is run: its limits, its ramps, its tuning, and what is known of its friction and heat for estimates."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from bench.configuration.parts import Section
from bench.configuration.quantities import (
    Acceleration,
    Angle,
    HeatCapacity,
    Power,
    Ratio,
    Size,
    Speed,
    Temperature,
    TemperatureDifference,
    ThermalResistance,
    Time,
    Torque,
    TorqueRate,
    Viscous,
    ViscousChange,
)

PositiveTime = Annotated[Time, Field(gt=0)]


class Limits(Section):
    """What must not be exceeded; crossing any of these stops the bench. They protect equipment, not people."""

    motor_speed: Annotated[Speed, Field(gt=0)]
    load_speed: Annotated[Speed, Field(gt=0)] | None = None
    """Load side, by its own encoder's drive; absent: 1.2 · motor_speed / ratio."""
    motor_acceleration: Annotated[Acceleration, Field(gt=0)] | None = None
    """Greatest change of the motor's speed, both ways, while it follows set values; absent: not watched."""
    motor_torque: Annotated[Torque, Field(gt=0)]
    load_torque: Annotated[Torque, Field(gt=0)]
    load_motor_torque: Annotated[Torque, Field(gt=0)]
    load_torque_rate: Annotated[TorqueRate, Field(gt=0)] | None = None
    """Greatest change of the torque sensor's reading (smoothed over 50 ms); absent: not watched."""
    temperature: Temperature
    temperature_minimum: Temperature
    temperature_rate: Annotated[TemperatureDifference, Field(gt=0)]
    """Greatest believable change within one second; more is a sensor that lies."""
    load_position: Annotated[Angle, Field(gt=0)] | None = None
    """Greatest load-side angle either side of zero; absent where the load side turns freely."""
    velocity_error: Annotated[Speed, Field(gt=0)]
    """Greatest following error of the input motor's (filtered) velocity."""
    following_error: Annotated[Angle, Field(gt=0)] | None = None
    """Motor angle lost against the set velocity within about a second; also the drive's own window (0x6065)."""
    torque_error: Annotated[Torque, Field(gt=0)] | None = None
    """Greatest difference of the load motor's torque and its set value, both filtered."""
    torque_disagreement: Annotated[Torque, Field(gt=0)]
    """Greatest difference of torque sensor and load motor torque, both filtered."""
    torque_drift: Annotated[Torque, Field(gt=0)] | None = None
    """Greatest change of that difference's slow mean (one minute) against its first; absent: not watched."""
    friction_torque: Annotated[Torque, Field(gt=0)] | None = None
    """Greatest motor torque beyond what the torque sensor's reading asks of the motor (load_torque / ratio)."""
    encoder_disagreement: Annotated[Angle, Field(gt=0)]
    """Greatest change of load_angle − motor_angle/ratio against its value at the start."""
    slow_reading_age: PositiveTime
    frozen_signal: PositiveTime
    """How long a signal that must move (encoders under speed, noisy analogue values) may stay exactly the same."""
    frozen_temperature: PositiveTime | None = None
    """How long the temperature may read exactly the same; absent: for ever."""
    lost_cycles: Annotated[int, Field(ge=1)]
    """Cycles in a row without a right working counter."""
    lost_share: Annotated[float, Field(gt=0, le=1)] = 0.2
    """Greatest share of such cycles within about a second, in a row or not; 1 is never exceeded."""


class Motion(Section):
    """Ramps and waits of every sequence."""

    motor_acceleration: Annotated[Acceleration, Field(gt=0)]
    torque_rate: Annotated[TorqueRate, Field(gt=0)]
    settling: PositiveTime
    quick_stop_deceleration: Annotated[Acceleration, Field(gt=0)]
    standstill: Annotated[Speed, Field(gt=0)]
    """Motor speed below which the shaft counts as standing (on a filtered velocity)."""


class Stopping(Section):
    """Deadlines of the stop ladder; a step that does not end in time is followed by the next, harder one."""

    controlled_ramp: PositiveTime
    quick_stop: PositiveTime
    disable_voltage: PositiveTime


class Heating(Section):
    """How the lubricant is brought to a temperature, and when it counts as there."""

    motor_speed: Annotated[Speed, Field(gt=0)]
    time_limit: PositiveTime
    band: Annotated[TemperatureDifference, Field(gt=0)]
    """A point is measured within ± band of its temperature; below it the lubricant is topped up."""
    hysteresis: Annotated[TemperatureDifference, Field(ge=0)]
    """Heating goes this far above the point's temperature, so that cooling does not start a top-up at once."""
    soak: Annotated[Time, Field(ge=0)]
    """Wait after heating, for the temperature to even out."""

    @model_validator(mode="after")
    def _hysteresis_within_band(self) -> Heating:
        if self.hysteresis >= self.band:
            raise ValueError("hysteresis must be smaller than band, or heating would end outside the band")
        return self


class Nominal(Section):
    """What is known of friction and heat, for estimates of duration and energy (bench-physics.md, equations 2–4)."""

    friction_coulomb: Torque
    friction_viscous: Viscous
    friction_viscous_temperature: ViscousChange
    friction_load: Ratio
    load_friction: Torque
    heat_capacity: Annotated[HeatCapacity, Field(gt=0)]
    thermal_resistance: Annotated[ThermalResistance, Field(gt=0)]
    ambient_temperature: Temperature
    idle_power: Annotated[Power, Field(ge=0)]
    """Electrical power of drives and controls while the bench is on."""


class VelocityTuning(Section):
    """Velocity controller of the input drive, as it is set there."""

    proportional_gain: Annotated[Viscous, Field(gt=0)]
    integral_time: PositiveTime


class TorqueTuning(Section):
    """Torque loop of the load drive, as it is set there."""

    time_constant: PositiveTime


class Tuning(Section):
    """Controllers of both drives: provenance, the bench does not write them."""

    input_drive: VelocityTuning
    load_drive: TorqueTuning


class Unattended(Section):
    """What may be done without a person at a terminal; by default nothing."""

    may: tuple[Literal["acknowledge", "reset", "resume", "experiment"], ...] = ()
    """Acts after a stop that a script may do for the operator; and experiments that ``bench investigate`` begins."""


class Commissioning(Section):
    """How the bench is tried out before it may run: slowly, and with little torque."""

    motor_speed: Annotated[Speed, Field(gt=0)] = 20.0
    load_torque: Annotated[Torque, Field(gt=0)] | None = None
    """Load put on for the polarity check; absent: a tenth of limits.load_torque."""
    torque_share: Annotated[Ratio, Field(gt=0, le=1)] = 0.25
    """Share of the limits of torque and speed the drives are given meanwhile."""
    zero_spread: Annotated[Angle, Field(gt=0)] = 2e-4
    """Greatest difference of two reference approaches, load side."""
    largest_tare: Annotated[Torque, Field(gt=0)] | None = None
    """Greatest reading of the unloaded torque sensor; absent: 1 % of its rated torque."""
    marker: Annotated[str, Field(pattern="^[0-9A-F]{4}:[0-9A-F]{2}$")] = "6067:00"
    """Object of both drives that forgets at power-off and has no use in the cyclic modes (32 bit)."""


class Storage(Section):
    """Where recordings go and what disk space must be free before a point starts."""

    minimum_free: Annotated[Size, Field(ge=0)]
