"""Units as laboratories and simulation tools write them."""

from __future__ import annotations

import math

import pytest

from bench.errors import ConfigurationError
from bench.importing.headings import split_heading
from bench.importing.units import is_unit, split_unit, unit_of


@pytest.mark.parametrize(
    ("written", "si", "factor"),
    [
        ("Nm", "N·m", 1.0),
        ("Ncm", "N·m", 0.01),
        ("mNm", "N·m", 1e-3),
        ("Nmm", "N·m", 1e-3),
        ("daNm", "N·m", 10.0),
        ("N.m", "N·m", 1.0),
        ("rad/s2", "rad/s²", 1.0),
        ("rad.s-1", "rad/s", 1.0),
        ("kg.m2", "kg·m²", 1.0),
        ("m3/s", "m³/s", 1.0),
        ("N.m.s/rad", "N·m·s/rad", 1.0),
        ("Nms/rad", "N·m·s/rad", 1.0),
        ("min-1", "rad/s", 0.10471975511965977),
        ("Grad", "rad", math.pi / 180.0),
        ("grad", "rad", math.pi / 180.0),
        ("Grad/s", "rad/s", math.pi / 180.0),
        ("Umdr./min", "rad/s", math.pi / 30.0),
        ("Umdrehungen pro Minute", "rad/s", math.pi / 30.0),
        ("Inkremente", "1", 1.0),
        ("Millisekunden", "s", 1e-3),
    ],
)
def test_spellings_of_loggers_modelica_and_fmi(written: str, si: str, factor: float) -> None:
    unit = unit_of(written, "a.csv")
    assert (unit.si, unit.offset) == (si, 0.0)
    assert unit.factor == pytest.approx(factor)


@pytest.mark.parametrize("written", ["foo", "x2", "run.3", "Achse3"])
def test_names_are_no_units(written: str) -> None:
    assert not is_unit(written)
    with pytest.raises(ConfigurationError, match=f"a.csv: unit '{written}' is not known"):
        unit_of(written, "a.csv")


def test_a_speed_that_was_written_as_a_product_is_said_to_be_one() -> None:
    with pytest.raises(
        ConfigurationError, match=r"unit 'rad\.s' should be one that becomes 'rad/s'; did you mean 'rad/s'\?"
    ):
        unit_of("rad.s", "x", "rad/s")
    with pytest.raises(ConfigurationError, match=r"becomes 'rad/s'\.$"):
        unit_of("N*m", "x", "rad/s")


@pytest.mark.parametrize(
    ("heading", "name", "unit"),
    [
        ("motor_velocity_turns_s", "motor_velocity", "rev/s"),
        ("J2_vel_degs", "J2_vel", "deg/s"),
        ("J2_vel_deg/s", "J2_vel", "deg/s"),
        ("vel_rad_per_sec", "vel", "rad/s"),
        ("vel_counts_s", "vel", "counts/s"),
        ("feed_mm_min", "feed", "mm/min"),
        ("Motor_Inkremente", "Motor", "counts"),
        ("Abtrieb_Grad", "Abtrieb", "deg"),
        ("Drehzahl_U_min", "Drehzahl", "rpm"),
        ("Motor_Umdrehungen", "Motor", "rev"),
        ("Winkel_Grad_pro_Sekunde", "Winkel", "deg/s"),
        ("Zeit_Sek", "Zeit", "s"),
        ("POS_DEG", "POS", "deg"),
        ("force_N", "force", "N"),
        ("torque_n", "torque_n", ""),
        ("gradient", "gradient", ""),
    ],
)
def test_a_unit_at_the_end_of_a_name(heading: str, name: str, unit: str) -> None:
    assert split_unit(heading) == (name, unit)


@pytest.mark.parametrize(
    ("heading", "name", "unit"),
    [
        ("time/s", "time", "s"),
        ("cam_angle/deg", "cam_angle", "deg"),
        ("torque/V", "torque", "V"),
        ("torque/N m", "torque", "N m"),
        ("opening/%", "opening", "%"),
        ("t/ms", "t", "ms"),
        ("F/N", "F", "N"),
        ("M/Nm", "M", "Nm"),
        ("s/mm", "s", "mm"),
        ("alpha/deg", "alpha", "deg"),
        ("v/m/s", "v", "m/s"),
        ("v/(m/s)", "v", "m/s"),
        ("n/1/min", "n", "1/min"),
        ("omega/rad/s", "omega", "rad/s"),
        # a ratio is one unit
        ("m/s", "m/s", ""),
        ("m/s²", "m/s²", ""),
        ("deg/s", "deg/s", ""),
        ("U/min", "U/min", ""),
        ("Nm/rad", "Nm/rad", ""),
        ("vel m/s", "vel", "m/s"),
        ("force_N/s", "force", "N/s"),
        ("speed [m/s]", "speed", "m/s"),
        # names with a mark between
        ("on/off", "on/off", ""),
        ("min/max", "min/max", ""),
        ("Log/t", "Log/t", ""),
    ],
)
def test_a_heading_may_have_its_unit_after_a_mark_alone(heading: str, name: str, unit: str) -> None:
    assert split_heading(heading) == (name, unit)


def test_in_groups_the_mark_divides_names() -> None:
    assert split_unit("log/A") == ("log/A", "")
