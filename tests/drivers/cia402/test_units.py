import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.cia402.units import read_units
from drivers.errors import DriverError
from drivers.ethercat import SdoClient
from tests.drivers.ethercat.scripted import ScriptedSlave

RPM, MILLI_RPM, MICRO_RPM, DEGREES_A_SECOND = 0x00B44700, 0xFDB44700, 0xFAB44700, 0x00410300


def drive(**objects: tuple[str, int]) -> SdoClient:
    slave = ScriptedSlave(1, 2, 3, "drive")
    defaults = {"6092:1": ("u4", 8192), "6092:2": ("u4", 1), "6076:0": ("u4", 17_500), "60A9:0": ("u4", RPM)}
    for name, (type_, value) in (defaults | objects).items():
        index, sub = name.split(":")
        if type_ != "none":
            slave.put(int(index, 16), int(sub), type_, value)
    return SdoClient(slave, "input_drive")


def test_the_plain_case() -> None:
    units = read_units(drive(**{"6075:0": ("u4", 8_600)}))
    assert units.counts_per_turn == 8192
    assert units.position_rad == pytest.approx(2 * math.pi / 8192)
    assert units.velocity_rad_s == pytest.approx(2 * math.pi / 60)
    assert units.torque_nm == pytest.approx(0.0175)
    assert units.rated_current_a == pytest.approx(8.6)


@pytest.mark.parametrize(
    ("unit", "rad_s"),
    [
        (RPM, 2 * math.pi / 60),
        (0xFFB44700, 2 * math.pi / 600),
        (MILLI_RPM, 2 * math.pi / 60e3),
        (MICRO_RPM, 2 * math.pi / 60e6),
        (DEGREES_A_SECOND, math.pi / 180),
        (0xFD100300, 1e-3),
        (0x00B40300, 2 * math.pi),
    ],
)
def test_velocity_units_of_60a9(unit: int, rad_s: float) -> None:
    assert read_units(drive(**{"60A9:0": ("u4", unit)})).velocity_rad_s == pytest.approx(rad_s)


def test_gear_ratio_counts_for_positions_and_velocities() -> None:
    units = read_units(drive(**{"6091:1": ("u4", 5), "6091:2": ("u4", 2)}))
    assert units.counts_per_turn == pytest.approx(8192 / 2.5)
    assert units.velocity_rad_s == pytest.approx(2.5 * 2 * math.pi / 60)


def test_encoder_resolution_where_there_is_no_feed_constant_or_positions_are_increments() -> None:
    encoder = {"608F:1": ("u4", 1 << 25), "608F:2": ("u4", 1)}
    without = read_units(drive(**encoder, **{"6092:1": ("none", 0), "6092:2": ("none", 0)}))
    assert without.counts_per_turn == 1 << 25
    assert read_units(drive(**encoder, **{"60A8:0": ("u4", 0x00B50000)})).counts_per_turn == 1 << 25


@given(numerator=st.integers(1, 10_000), divisor=st.integers(1, 10_000))
def test_velocity_factor_scales_position_units_a_second(numerator: int, divisor: int) -> None:
    factor = {"6096:1": ("u4", numerator), "6096:2": ("u4", divisor), "60A9:0": ("none", 0)}
    units = read_units(drive(**factor))
    # One turn a second is 8192 position units a second; the factor makes counts of it.
    counts = 8192 * numerator / divisor
    assert counts * units.velocity_rad_s == pytest.approx(2 * math.pi)


def test_a_velocity_unit_that_is_no_rotation_asks_for_configuration() -> None:
    with pytest.raises(DriverError, match=r"60A9:00 is 0x00010300, .* should stand in the configuration"):
        read_units(drive(**{"60A9:0": ("u4", 0x00010300)}))
    assert read_units(drive(**{"60A9:0": ("u4", 0x00010300)}), velocity_rad_s=0.1).velocity_rad_s == 0.1


def test_scales_of_nothing_are_refused() -> None:
    with pytest.raises(DriverError, match="6092 is 8192/0"):
        read_units(drive(**{"6092:2": ("u4", 0)}))
    with pytest.raises(DriverError, match="rated torque 6076:00 is 0"):
        read_units(drive(**{"6076:0": ("u4", 0)}))
