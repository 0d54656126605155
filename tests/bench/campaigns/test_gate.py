import math
from dataclasses import replace

import pytest

from bench.campaigns.gate import judge
from bench.campaigns.recorder import SteadyFigures
from bench.configuration import BenchConfiguration, load_bench
from bench.protocols import Point

POINT = Point("constant_velocity", 500.0, math.radians(-5), 30.0)


@pytest.fixture(scope="module")
def bench() -> BenchConfiguration:
    return load_bench("rh380n").configuration


def good() -> SteadyFigures:
    return SteadyFigures(
        samples=1000,
        travel=6.3,
        velocity_sum=math.radians(-5) * 1000,
        torque_sum=505.0 * 1000,
        temperature_low=29.5,
        temperature_high=30.5,
    )


def test_a_good_recording_passes(bench: BenchConfiguration) -> None:
    gate = judge(POINT, "constant_velocity", good(), bench)
    assert gate.passed
    assert gate.failures == ""
    assert set(gate.as_dict()) >= {"travel", "velocity", "load_torque", "lost_cycles", "saturated_samples"}


@pytest.mark.parametrize(
    ("change", "check"),
    [
        ({"travel": 6.2}, "travel"),
        ({"velocity_sum": math.radians(-4.9) * 1000}, "velocity"),
        ({"velocity_sum": math.radians(5) * 1000}, "velocity"),
        ({"torque_sum": 540.0 * 1000}, "load_torque"),
        ({"torque_sum": -500.0 * 1000}, "load_torque"),
        ({"temperature_low": 27.0}, "temperature_low"),
        ({"temperature_high": 33.0}, "temperature_high"),
        ({"lost_cycles": 1}, "lost_cycles"),
        ({"saturated": 1}, "saturated_samples"),
    ],
)
def test_what_is_wrong_is_named(bench: BenchConfiguration, change: dict[str, float], check: str) -> None:
    gate = judge(POINT, "constant_velocity", replace(good(), **change), bench)  # type: ignore[arg-type]
    assert [c.name for c in gate.checks if not c.passed] == [check]
    assert check in gate.failures


def test_a_recording_without_steady_motion_fails(bench: BenchConfiguration) -> None:
    gate = judge(POINT, "constant_velocity", SteadyFigures(), bench)
    assert {c.name for c in gate.checks if not c.passed} >= {"travel", "velocity", "load_torque"}


def test_as_found_has_no_temperature_band_and_other_kinds_no_revolution(bench: BenchConfiguration) -> None:
    found = judge(replace(POINT, temperature=None), "constant_velocity", good(), bench)
    assert not any(check.name.startswith("temperature") for check in found.checks)
    heating = judge(Point("heating", temperature=30.0), "heating", SteadyFigures(), bench)
    assert heating.passed
