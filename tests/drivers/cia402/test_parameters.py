import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.cia402 import DriveLimits, DriveUnits, FaultReaction, Parameter, QuickStopOption
from drivers.cia402.parameters import apply, cycle_parameters, limit_parameters, verify
from drivers.errors import DriverError
from drivers.ethercat import SdoClient
from tests.drivers.ethercat.scripted import ScriptedSlave

UNITS = DriveUnits(8192.0, 2 * math.pi / 60e3, 17.5)


def by_index(parameters: tuple[Parameter, ...]) -> dict[int, int]:
    return {parameter.index: parameter.value for parameter in parameters}


@given(torque=st.floats(0.0, 1000.0), speed=st.floats(0.0, 1000.0), window=st.floats(0.0, 10.0))
def test_limits_never_round_up(torque: float, speed: float, window: float) -> None:
    values = by_index(limit_parameters(DriveLimits(torque, speed, following_error_rad=window), UNITS))
    slack = 1.0 + 1e-5
    assert values[0x6072] * UNITS.torque_nm <= torque * slack + 1e-6
    assert (values[0x6072] + 1) * UNITS.torque_nm > torque
    assert values[0x6080] * 2 * math.pi / 60 <= speed * slack + 1e-6
    assert values[0x6065] * UNITS.position_rad <= window * slack + 1e-6


def test_whole_values_stay_whole() -> None:
    limits = DriveLimits(35.0, 100 * math.pi, following_error_rad=math.pi / 2, following_error_time_s=0.01)
    values = by_index(limit_parameters(limits, UNITS))
    assert (values[0x6072], values[0x6080], values[0x6065], values[0x6066]) == (2000, 3000, 2048, 10)


def test_reactions_are_written() -> None:
    limits = DriveLimits(
        10.0, 100.0, quick_stop=QuickStopOption.CURRENT_LIMIT_AND_STAY, fault_reaction=FaultReaction.SLOW_DOWN
    )
    values = by_index(limit_parameters(limits, UNITS))
    assert (values[0x605A], values[0x605E]) == (7, 1)
    ramp = by_index(limit_parameters(DriveLimits(1.0, 1.0, quick_stop_deceleration_rad_s2=400.0), UNITS))
    assert ramp[0x6085] * UNITS.velocity_rad_s == pytest.approx(400.0, rel=1e-5)


@given(st.integers(1, 255), st.integers(-6, 0))
def test_interpolation_time_is_the_cycle_time(value: int, exponent: int) -> None:
    cycle = value * 10.0**exponent
    parameters = cycle_parameters(cycle)
    assert parameters[0].value * 10.0 ** parameters[1].value == pytest.approx(cycle)


def test_a_cycle_time_that_cannot_be_told() -> None:
    with pytest.raises(DriverError, match="cannot be written to a drive"):
        cycle_parameters(0.0003456789)


def test_parameters_are_compared_after_writing_and_later() -> None:
    slave = ScriptedSlave(1, 2, 3, "drive")
    sdo = SdoClient(slave, "load_drive")
    parameters = (
        Parameter(0x6072, 0, "u2", 900, "torque limit 1485 N·m"),
        Parameter(0x60C2, 1, "u1", 5, "interpolation time", optional=True),
    )
    apply(sdo, parameters)
    assert (0x60C2, 1) not in slave.objects  # optional, and the drive does not have it
    assert verify(sdo, parameters) == ()
    slave.put(0x6072, 0, "u2", 3000)  # the drive was restarted with its defaults
    assert verify(sdo, parameters) == ("load_drive: torque limit 1485 N·m (6072:00) should be 900 but is 3000",)


def test_a_limit_that_is_not_taken_is_named() -> None:
    slave = ScriptedSlave(1, 2, 3, "drive", keeps={(0x6072, 0): b"\x0a\x00"})
    with pytest.raises(DriverError, match=r"load_drive, torque limit 5 N·m \(6072:00\) was not taken: .* keeps 10"):
        apply(SdoClient(slave, "load_drive"), (Parameter(0x6072, 0, "u2", 900, "torque limit 5 N·m"),))
