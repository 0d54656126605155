import math
from dataclasses import replace

import pytest

from bench.campaigns.execution.gate import judge
from bench.campaigns.records.recorder import SteadyFigures
from bench.configuration import BenchConfiguration, load_bench
from bench.protocols import Point

POINT = Point("constant_velocity", 500.0, math.radians(-5), 30.0)


@pytest.fixture(scope="module")
def bench() -> BenchConfiguration:
    return load_bench("rh380n").configuration


def good() -> SteadyFigures:
    return SteadyFigures(
        rows=1500,
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
    assert [c.name for c in gate.checks if c.passed is False] == [check]
    assert check in gate.failures


def test_a_recording_without_steady_motion_fails(bench: BenchConfiguration) -> None:
    gate = judge(POINT, "constant_velocity", SteadyFigures(), bench)
    assert {c.name for c in gate.checks if c.passed is False} >= {"travel", "velocity", "load_torque"}


UNSEEN = {"passed": None, "value": None, "low": None, "high": None}


def test_what_nobody_looked_at_is_not_said_to_have_passed(bench: BenchConfiguration) -> None:
    found = judge(replace(POINT, temperature=None), "constant_velocity", good(), bench)
    assert found.passed
    unseen = {name for name, check in found.as_dict().items() if check == UNSEEN}
    assert unseen == {"temperature_low", "temperature_high"}
    heating = judge(Point("heating", temperature=30.0), "heating", SteadyFigures(rows=1000), bench)
    assert heating.passed
    made = {name for name, check in heating.as_dict().items() if check["passed"]}
    assert made == {"lost_cycles", "saturated_samples"}
    assert all(check == UNSEEN for name, check in heating.as_dict().items() if name not in made)


def test_a_recording_without_rows_does_not_pass(bench: BenchConfiguration) -> None:
    assert not judge(Point("dwell"), "dwell", SteadyFigures(), bench).passed
