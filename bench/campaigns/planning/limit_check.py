"""Whether a planned point keeps the limits of the bench: the temperature it asks for, what its motion demands."""

from __future__ import annotations

from bench.campaigns.planning.estimate import Demand
from bench.configuration import BenchConfiguration
from bench.errors import LimitError
from bench.protocols import Point


def check_temperature(point: Point, bench: BenchConfiguration, where: str) -> None:
    """Compare the temperature that a point asks for with the limit of the bench.

    Raises
    ------
    LimitError
        Naming the point and the limit.
    """
    limit = bench.limits.temperature
    if point.temperature is not None and point.temperature > limit:
        raise LimitError(
            f"{where} needs a lubricant temperature of {point.temperature:.4g} °C, above limits.temperature ="
            f" {limit:.4g} °C"
        )


def check_demand(demand: Demand, bench: BenchConfiguration, where: str) -> None:
    """Compare what a motion demands with the limits of the bench.

    Raises
    ------
    LimitError
        Naming the point, the quantity and the limit.
    """
    limits = bench.limits
    table = (
        ("motor speed", demand.motor_speed, "limits.motor_speed", limits.motor_speed, "rad/s"),
        ("load torque", demand.load_torque, "limits.load_torque", limits.load_torque, "N·m"),
        ("load motor torque", demand.load_motor_torque, "limits.load_motor_torque", limits.load_motor_torque, "N·m"),
        ("motor torque", demand.motor_torque, "limits.motor_torque", limits.motor_torque, "N·m"),
        ("lubricant temperature", demand.temperature, "limits.temperature", limits.temperature, "°C"),
    )
    for quantity, value, name, limit, unit in table:
        if not value <= limit:
            raise LimitError(f"{where} needs a {quantity} of {value:.4g} {unit}, above {name} = {limit:.4g} {unit}")
    travel = max(demand.position_high, -demand.position_low)
    if limits.load_position is not None and not travel <= limits.load_position:
        raise LimitError(
            f"{where} turns the load side by {travel:.4g} rad, above limits.load_position ="
            f" {limits.load_position:.4g} rad"
        )
