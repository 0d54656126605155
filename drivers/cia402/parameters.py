"""Parameters of a drive: its own limits and reactions, written, read back and compared before anything is enabled."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

from drivers.cia402.units import DriveUnits
from drivers.entries import entry_name
from drivers.errors import DriverError
from drivers.ethercat.sdo import SdoClient


class QuickStopOption(IntEnum):
    """Quick stop option code (0x605A). 1–3 end in "switch on disabled", 5–7 stay in "quick stop active"."""

    DISABLE = 0
    SLOW_DOWN = 1
    QUICK_STOP_RAMP = 2
    CURRENT_LIMIT = 3
    SLOW_DOWN_AND_STAY = 5
    QUICK_STOP_RAMP_AND_STAY = 6
    CURRENT_LIMIT_AND_STAY = 7


class FaultReaction(IntEnum):
    """Fault reaction option code (0x605E)."""

    DISABLE = 0
    SLOW_DOWN = 1
    QUICK_STOP_RAMP = 2
    CURRENT_LIMIT = 3


@dataclass(frozen=True, slots=True)
class Parameter:
    """One object to be set to one value.

    Attributes
    ----------
    index, subindex, type : the object and its type (:data:`drivers.entries.TYPES`).
    value : what the device should keep, in its own unit.
    why : what it limits, with its unit, for errors.
    optional : leave it out where the drive does not have the object.
    """

    index: int
    subindex: int
    type: str
    value: int
    why: str
    optional: bool = False


@dataclass(frozen=True, slots=True)
class DriveLimits:
    """The drive's own limits and reactions, at the motor shaft.

    They act without the master. Without them a stalled input motor makes its full torque times the gear ratio at the
    output, and an uncoupled load motor runs away within the watchdog's time.

    Attributes
    ----------
    torque_nm : maximum torque (0x6072), N·m.
    speed_rad_s : maximum motor speed (0x6080), rad/s.
    following_error_rad : window of the following error (0x6065), rad; None leaves the drive's.
    following_error_time_s : time outside it until the drive reacts (0x6066), s; None leaves the drive's.
    quick_stop : what a quick stop does (0x605A).
    quick_stop_deceleration_rad_s2 : its ramp (0x6085), rad/s²; None leaves the drive's.
    fault_reaction : what a fault does (0x605E).
    """

    torque_nm: float
    speed_rad_s: float
    following_error_rad: float | None = None
    following_error_time_s: float | None = None
    quick_stop: QuickStopOption = QuickStopOption.QUICK_STOP_RAMP
    quick_stop_deceleration_rad_s2: float | None = None
    fault_reaction: FaultReaction = FaultReaction.QUICK_STOP_RAMP


def limit_parameters(limits: DriveLimits, units: DriveUnits) -> tuple[Parameter, ...]:
    """Return the objects that hold the limits, in the drive's units; every limit is rounded towards the safer side."""
    rpm = limits.speed_rad_s * 60.0 / (2.0 * math.pi)
    parameters = [
        Parameter(
            0x6072, 0, "u2", _floor(limits.torque_nm / units.torque_nm), f"torque limit {limits.torque_nm:g} N·m"
        ),
        Parameter(0x6080, 0, "u4", _floor(rpm), f"speed limit {limits.speed_rad_s:g} rad/s"),
        Parameter(0x605A, 0, "i2", limits.quick_stop, "quick stop option"),
        Parameter(0x605E, 0, "i2", limits.fault_reaction, "fault reaction option"),
    ]
    if limits.following_error_rad is not None:
        window = limits.following_error_rad
        counts = _floor(window / units.position_rad)
        parameters.append(Parameter(0x6065, 0, "u4", counts, f"following error window {window:g} rad"))
    if limits.following_error_time_s is not None:
        time = limits.following_error_time_s
        parameters.append(Parameter(0x6066, 0, "u2", _floor(time * 1e3), f"following error time {time:g} s"))
    if limits.quick_stop_deceleration_rad_s2 is not None:
        ramp = limits.quick_stop_deceleration_rad_s2
        raw = math.ceil(ramp / units.velocity_rad_s)
        parameters.append(Parameter(0x6085, 0, "u4", raw, f"quick stop deceleration {ramp:g} rad/s²"))
    return tuple(parameters)


def cycle_parameters(cycle_time_s: float) -> tuple[Parameter, ...]:
    """Return the interpolation time (0x60C2: value · 10^exponent s) where a drive has it.

    Raises
    ------
    DriverError
        If the cycle time cannot be written as 1 … 255 times a power of ten.
    """
    for exponent in range(-6, 1):
        value = cycle_time_s / 10.0**exponent
        if 1 <= round(value) <= 255 and math.isclose(value, round(value), rel_tol=1e-9):
            return (
                Parameter(0x60C2, 1, "u1", round(value), "interpolation time", optional=True),
                Parameter(0x60C2, 2, "i1", exponent, "interpolation time exponent", optional=True),
            )
    raise DriverError(
        f"a cycle time of {cycle_time_s:g} s cannot be written to a drive (60C2); "
        "1 to 255 times a power of ten can, as 0.0005"
    )


def apply(sdo: SdoClient, parameters: tuple[Parameter, ...]) -> None:
    """Write every parameter, read it back and compare.

    Raises
    ------
    DriverError
        Naming the parameter with what it limits, where the drive refuses it or keeps another value.
    """
    for parameter in parameters:
        if parameter.optional and not sdo.exists(parameter.index, parameter.subindex):
            continue
        try:
            sdo.write_checked(parameter.index, parameter.subindex, parameter.type, parameter.value)
        except DriverError as error:
            where = f"{sdo.name}, {parameter.why} ({entry_name(parameter.index, parameter.subindex)})"
            raise DriverError(f"{where} was not taken: {error}") from error


def verify(sdo: SdoClient, parameters: tuple[Parameter, ...]) -> tuple[str, ...]:
    """Read every parameter again; one sentence for each that the drive no longer keeps."""
    found = []
    for parameter in parameters:
        if parameter.optional and not sdo.exists(parameter.index, parameter.subindex):
            continue
        kept = sdo.read(parameter.index, parameter.subindex, parameter.type)
        if kept != parameter.value:
            name = entry_name(parameter.index, parameter.subindex)
            found.append(f"{sdo.name}: {parameter.why} ({name}) should be {parameter.value} but is {kept}")
    return tuple(found)


def _floor(value: float) -> int:
    """Round down, but let a value that is whole up to rounding errors be whole."""
    return math.floor(value + 1e-6)
