"""Memory of the compiled step: parameters and state as packed records.

Everything that changes while the plant runs stands in these records (and the arrays of the transmission error), so
that a snapshot is a copy of them and nothing is forgotten.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from fakes.plant.parts import Drive, Encoder, Motor
    from fakes.plant.truth import PlantTruth

INPUT, LOAD = 0, 1
"""rows of the drive records"""
MAXIMUM_RIPPLES = 8
_HEAT = (
    "ambient_rate",
    "ambient_curvature",
    "ambient_cosine",
    "ambient_sine",
    "ambient_period",
    "ambient_change",
    "ambient_begin",
    "ambient_settling",
    "speed_cooling",
    "speed_exponent",
    "housing_rate",
    "housing_time",
)
"""values of the heat balance that are taken over by name"""

PLANT_PARAMETERS = np.dtype(
    [
        ("cycle_time", "f8"),
        ("drive_ticks", "i8"),
        ("substeps", "i8"),
        ("te_interval", "i8"),
        ("te_share", "f8"),  # of a new value in the filter of torque and velocity, a cycle
        ("te_reversal_travel", "f8"),
        ("ratio", "f8"),
        ("stiffness", "f8"),  # gearbox and coupling in series
        ("damping", "f8"),
        ("coulomb", "f8"),
        ("viscous", "f8"),
        ("viscous_temperature", "f8"),
        ("load_dependent", "f8"),
        ("reference_temperature", "f8"),
        ("minimum_viscous", "f8"),
        ("bearing_friction", "f8"),
        ("heat_capacity", "f8"),
        ("heat_resistance", "f8"),
        ("ambient", "f8"),
        ("ambient_rate", "f8"),
        ("ambient_curvature", "f8"),
        ("ambient_cosine", "f8"),
        ("ambient_sine", "f8"),
        ("ambient_period", "f8"),
        ("ambient_change", "f8"),
        ("ambient_begin", "f8"),
        ("ambient_settling", "f8"),
        ("speed_cooling", "f8"),
        ("speed_exponent", "f8"),
        ("housing_rate", "f8"),
        ("housing_time", "f8"),
        ("ripples", "i8"),
        ("ripple_order", "f8", (MAXIMUM_RIPPLES,)),
        ("ripple_amplitude", "f8", (MAXIMUM_RIPPLES,)),
        ("ripple_phase", "f8", (MAXIMUM_RIPPLES,)),
        ("sensor_counts", "f8"),  # counts per N·m
        ("sensor_limit", "f8"),
        ("sensor_zero", "f8"),
        ("sensor_noise", "f8"),
        ("sensor_gain", "f8"),
        ("lubricant_noise", "f8"),
        ("lubricant_offset", "f8"),
        ("lubricant_share", "f8"),  # of a new value in the lag of the PT100, a cycle
        ("ambient_noise", "f8"),
        ("ambient_offset", "f8"),
    ]
)

DRIVE_PARAMETERS = np.dtype(
    [
        ("polarity", "f8"),
        ("inertia", "f8"),
        ("maximum_torque", "f8"),
        ("torque_offset", "f8"),
        ("torque_gain", "f8"),
        ("brake_torque", "f8"),
        ("brake_delay", "f8"),
        ("proportional", "f8"),
        ("integral_share", "f8"),  # proportional gain · tick / integral time
        ("velocity_share", "f8"),  # filters: share of a new value, a tick
        ("torque_share", "f8"),
        ("current_share", "f8"),
        ("deceleration", "f8"),
        ("torque_resolution", "f8"),
        ("torque_noise", "f8"),
        ("encoder_scale", "f8"),  # counts per rad
        ("encoder_zero", "f8"),
        ("encoder_noise", "f8"),
    ]
)

DRIVE_STATE = np.dtype(
    [
        ("velocity", "f8"),  # estimate, own frame
        ("counts", "i8"),  # last reading of the encoder
        ("integral", "f8"),
        ("filtered", "f8"),  # set torque behind its filter
        ("torque", "f8"),  # of the motor as its current gives it, own frame
        ("ramp", "f8"),  # set velocity of the quick stop
        ("stopping", "u1"),
        ("off_time", "f8"),  # since the power stage went off
    ]
)

PLANT_STATE = np.dtype(
    [
        ("cycle", "i8"),
        ("motor_angle", "f8"),
        ("motor_velocity", "f8"),
        ("load_angle", "f8"),
        ("load_velocity", "f8"),
        ("torque", "f8"),  # in the spring of gearbox and coupling, noise-free
        ("sensed_torque", "f8"),  # as the torque sensor has it, noise apart
        ("temperature", "f8"),
        ("housing", "f8"),
        ("surroundings", "f8"),
        ("cooling", "f8"),  # 1/s
        ("slip", "f8"),  # twist lost while uncoupled
        ("te_torque", "f8"),  # filtered, as the polynomials see it
        ("te_velocity", "f8"),
        ("te_weight", "f8"),  # 1: positive direction's series, −1: negative's
        ("te", "f8"),  # without its elastic part
        ("ripple", "f8"),
        ("sensed_temperature", "f8"),  # at the PT100
        ("travel", "f8"),  # rad run at the output
        ("torque_adc", "i4"),
        ("lubricant_reading", "f8"),
        ("ambient_reading", "f8"),
        ("work_motor", "f8"),  # J done by the input motor on its shaft
        ("work_load", "f8"),  # J done by the load motor and its ripple on the load side
        ("loss_gearbox", "f8"),  # J turned to heat in the gearbox
        ("loss_bearing", "f8"),
    ]
)

TRACE = np.dtype(
    [
        ("motor_angle", "f8"),
        ("motor_velocity", "f8"),
        ("te_velocity", "f8"),
        ("load_angle", "f8"),
        ("torque", "f8"),
        ("temperature", "f8"),
        ("weight", "f8"),
        ("travel", "f8"),
        ("load_velocity", "f8"),
    ]
)
"""true state after each cycle of a block, for effects that are played on top and for whoever looks"""

CONDITIONS = np.dtype(
    [
        ("start_theta", "f8"),  # at the begin of the cycle
        ("te_drift", "f8"),  # its rate there as torque, velocity and temperature change, rad/s
        ("te_value", "f8"),  # there, and its derivatives in theta
        ("te_first", "f8"),
        ("te_second", "f8"),
        ("coulomb", "f8"),
        ("load_dependent", "f8"),
        ("viscous", "f8"),
        ("load_friction", "f8"),
        ("stiffness", "f8"),
        ("damping", "f8"),
        ("ripple", "f8"),
        ("motor_torque", "f8"),  # at the shafts, bench frame
        ("load_torque", "f8"),
        ("before_sensor", "f8"),  # hidden torque between gearbox and torque sensor
        ("spring_torque", "f8"),  # of hidden springs against the motor, part of motor_torque; their work is heat
    ]
)
"""what holds within a cycle or tick; filled anew each time, no part of a snapshot"""


def _share(step: float, time_constant: float) -> float:
    """Return the share of a new value in a first-order lag stepped exactly."""
    return 1.0 if time_constant <= 0.0 else 1.0 - math.exp(-step / time_constant)


def plant_parameters(truth: PlantTruth, cycle_time: float) -> NDArray[Any]:
    """Return the (1,) record of everything but the drives."""
    record = np.zeros(1, PLANT_PARAMETERS)
    stiffness = truth.torsional_stiffness
    ripple = [*truth.ripple]
    values: dict[str, Any] = {
        "cycle_time": cycle_time,
        "drive_ticks": truth.numerics.drive_ticks,
        "substeps": truth.numerics.substeps,
        "te_interval": truth.numerics.te_interval,
        "te_share": _share(cycle_time, truth.numerics.te_time_constant),
        "te_reversal_travel": truth.numerics.te_reversal_travel,
        "ratio": truth.gearbox.ratio,
        "stiffness": stiffness,
        "damping": 2.0 * truth.gearbox.damping_ratio * math.sqrt(stiffness * truth.load_motor.inertia),
        "coulomb": truth.friction.coulomb,
        "viscous": truth.friction.viscous,
        "viscous_temperature": truth.friction.viscous_temperature,
        "load_dependent": truth.friction.load_dependent,
        "reference_temperature": truth.friction.reference_temperature,
        "minimum_viscous": truth.friction.minimum_viscous_share * truth.friction.viscous,
        "bearing_friction": truth.load_side.bearing_friction,
        "heat_capacity": truth.heat.capacity,
        "heat_resistance": truth.heat.resistance,
        "ambient": truth.heat.ambient,
        **{name: getattr(truth.heat, name) for name in _HEAT},
        "ripples": len(ripple),
        "sensor_counts": truth.torque_sensor.full_scale_counts / truth.torque_sensor.rated_torque,
        "sensor_limit": truth.torque_sensor.full_scale_counts - 1,
        "sensor_zero": truth.torque_sensor.zero,
        "sensor_noise": truth.torque_sensor.noise,
        "sensor_gain": truth.torque_sensor.gain,
        "lubricant_noise": truth.lubricant_sensor.noise,
        "lubricant_offset": truth.lubricant_sensor.offset,
        "lubricant_share": _share(cycle_time, truth.lubricant_sensor.lag),
        "ambient_noise": truth.ambient_sensor.noise,
        "ambient_offset": truth.ambient_sensor.offset,
    }
    for name, value in values.items():
        record[name] = value
    for i, part in enumerate(ripple):
        record["ripple_order"][0, i] = part.order
        record["ripple_amplitude"][0, i] = part.amplitude
        record["ripple_phase"][0, i] = part.phase
    return record


def drive_parameters(truth: PlantTruth, cycle_time: float) -> NDArray[Any]:
    """Return the (2,) records of input and load drive with their motors and encoders."""
    record = np.zeros(2, DRIVE_PARAMETERS)
    tick = cycle_time / truth.numerics.drive_ticks
    sides: tuple[tuple[Motor, Drive, Encoder], ...] = (
        (truth.input_motor, truth.input_drive, truth.input_encoder),
        (truth.load_motor, truth.load_drive, truth.load_encoder),
    )
    for row, (motor, drive, encoder) in zip(record, sides, strict=True):
        row["polarity"] = drive.polarity
        row["inertia"] = motor.inertia
        row["maximum_torque"] = motor.maximum_torque
        row["torque_offset"] = motor.torque_offset
        row["brake_torque"] = motor.brake_torque
        row["brake_delay"] = motor.brake_delay
        row["torque_gain"] = drive.torque_gain
        row["proportional"] = drive.proportional_gain
        row["integral_share"] = drive.proportional_gain * tick / drive.integral_time
        row["velocity_share"] = _share(tick, drive.velocity_filter)
        row["torque_share"] = _share(tick, drive.torque_filter)
        row["current_share"] = _share(tick, drive.current_lag)
        row["deceleration"] = drive.quick_stop_deceleration
        row["torque_resolution"] = drive.torque_resolution
        row["torque_noise"] = drive.torque_noise
        row["encoder_scale"] = 2.0**encoder.bits / (2.0 * math.pi)
        row["encoder_zero"] = encoder.zero
        row["encoder_noise"] = encoder.noise
    return record
