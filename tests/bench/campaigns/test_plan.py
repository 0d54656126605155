import math
from pathlib import Path

import pytest

from bench.campaigns import Block, Campaign, Stage, load_campaign, make_plan, parse_campaign, shipped_campaigns
from bench.campaigns.planning.definition import Order
from bench.campaigns.planning.estimate import Estimator, ThermalState
from bench.campaigns.planning.registry import build_sequence, sequence_names
from bench.campaigns.planning.schedule import schedule
from bench.configuration import BenchConfiguration, load_bench
from bench.errors import ConfigurationError, LimitError
from bench.protocols import Phase, Point, Segment, Sequence, Until


@pytest.fixture(scope="module")
def bench() -> BenchConfiguration:
    return load_bench("rh380n").configuration


def test_shipped_campaigns_fit_the_bench(bench: BenchConfiguration) -> None:
    assert shipped_campaigns() == ("distinguish", "paper", "quick", "short")
    for name in shipped_campaigns():
        assert make_plan(load_campaign(name), bench).points > 0


def test_paper_is_the_papers_campaign(bench: BenchConfiguration) -> None:
    plan = make_plan(load_campaign("paper"), bench)
    points = [task.point for task in plan.tasks if not task.is_preparation]
    grid = [point for point in points if point.sequence == "constant_velocity"]
    validation = [point for point in points if point.sequence == "validation"]
    assert (len(grid), len(validation)) == (224, 19)
    assert {point.load_torque for point in grid} == {0, 333, -333, 500, -500, 1000, -1000}
    assert {point.temperature for point in grid} == {None, 30, 40, 50}
    assert {round(math.degrees(point.velocity), 6) for point in grid} == {
        s * v for s in (-1, 1) for v in (2.5, 5, 7.5, 10)
    }
    steady = sum(2 * math.pi / abs(point.velocity) for point in points)
    assert 4.6 < steady / 3600 < 5.2
    assert 6 < plan.duration_s / 3600 < 9


def test_paper_is_measured_at_ascending_temperature(bench: BenchConfiguration) -> None:
    plan = make_plan(load_campaign("paper"), bench)
    wanted = [t.point.temperature for t in plan.tasks if not t.is_preparation and t.point.temperature is not None]
    assert wanted == sorted(wanted)
    for task in plan.tasks:
        if task.point.temperature is not None and not task.is_preparation:
            assert task.start_temperature >= task.point.temperature - bench.heating.band - 1e-9
            assert task.start_temperature <= task.point.temperature + bench.heating.band + 1e-9


def one(bench: BenchConfiguration, block: Block) -> None:
    make_plan(Campaign("mine", "", (Stage("s", (block,)),)), bench)


@pytest.mark.parametrize(
    ("block", "parts"),
    [
        (Block("constant_velocity", (2000.0,), (0.1,)), ["load torque", "limits.load_torque = 1300", "point 1"]),
        (Block("constant_velocity", (0.0,), (1.5,)), ["motor speed", "limits.motor_speed = 220"]),
        (Block("constant_velocity", (0.0,), (0.1,), (80.0,)), ["temperature", "limits.temperature"]),
        (Block("cooling", temperatures=(10.0,)), ["is not reached", "cooling"]),
    ],
)
def test_a_plan_that_breaks_a_limit_is_refused(bench: BenchConfiguration, block: Block, parts: list[str]) -> None:
    with pytest.raises(LimitError) as caught:
        one(bench, block)
    for part in parts:
        assert part in str(caught.value)


def test_heating_beyond_what_the_bench_can_is_refused(bench: BenchConfiguration) -> None:
    weak = bench.model_copy(update={"heating": bench.heating.model_copy(update={"motor_speed": 20.0})})
    with pytest.raises(LimitError, match="not reached"):
        one(weak, Block("constant_velocity", (0.0,), (0.1,), (50.0,)))


def test_the_second_bench_refuses_what_the_first_can(bench: BenchConfiguration) -> None:
    with pytest.raises(LimitError, match=r"limits\.load_torque = 400"):
        make_plan(load_campaign("paper"), load_bench("rv80n").configuration)


def test_standstill_as_a_constant_velocity_is_a_sentence(bench: BenchConfiguration) -> None:
    with pytest.raises(ConfigurationError, match="velocity other than zero"):
        one(bench, Block("constant_velocity", (0.0,), (0.0,)))


def test_heating_time_follows_the_heat_balance(bench: BenchConfiguration) -> None:
    nominal = bench.nominal
    estimator = Estimator(bench)
    heat = Phase(Segment.HEAT, 1e5, bench.heating.motor_speed / bench.gearbox.ratio, 0.0, Until.WARMER, 40.0)
    ramp = Phase(Segment.RAMP_UP, 0.0, heat.velocity, 0.0)
    state, _ = estimator.run([ramp, heat], ThermalState(nominal.ambient_temperature))
    # an independent integration with a tenth of a second
    temperature, time = nominal.ambient_temperature, 0.0
    while temperature < 40.0:
        speed = bench.heating.motor_speed
        viscous = nominal.friction_viscous + nominal.friction_viscous_temperature * (temperature - 25.0)
        loss = (nominal.friction_coulomb + viscous * speed) * speed
        out = (temperature - nominal.ambient_temperature) / nominal.thermal_resistance
        temperature += 0.1 * (loss - out) / nominal.heat_capacity
        time += 0.1
    assert state.time_s == pytest.approx(time, rel=0.02)


def test_points_as_found_give_way_when_the_lubricant_warms_up() -> None:
    points = [Point("constant_velocity", float(i), 0.1) for i in range(3)]
    points.append(Point("validation", 0.0, 0.1, temperature=22.0))
    temperatures = iter([21.0, 21.0, 22.5, 22.5, 22.5, 22.5, 22.5, 22.5])
    seen = [task.point.sequence for task in schedule(points, Order.TEMPERATURE, 1.0, lambda: next(temperatures))]
    assert seen == ["constant_velocity", "constant_velocity", "validation", "constant_velocity"]


def test_topping_up_comes_before_a_point_that_got_too_cold() -> None:
    points = [Point("constant_velocity", 0.0, 0.1, 40.0), Point("constant_velocity", 1.0, 0.1, 40.0)]
    now = [39.5]
    seen = []
    for task in schedule(points, Order.LISTED, 1.0, lambda: now[0]):
        seen.append(task.is_preparation)
        now[0] = 41.0 if task.is_preparation else 38.0
    assert seen == [False, True, False]


def test_listed_order_is_kept() -> None:
    points = [Point("dwell", 0.0, 0.0, t) for t in (40.0, 20.0, 30.0)]
    seen = [task.point.temperature for task in schedule(points, Order.LISTED, 1.0, lambda: 60.0)]
    assert seen == [40.0, 20.0, 30.0]


TEXT = """
format = "bench-campaign"
format_version = "1.0"
name = "mine"
title = "t"
[[stages]]
name = "s"
[[stages.points]]
sequence = "reversal"
velocities = ["5 deg/s"]
options = { amplitude = "10 deg", cycles = 2 }
"""


def test_options_have_units() -> None:
    (block,) = parse_campaign(TEXT, "mine.toml").stages[0].blocks
    assert dict(block.options) == {"amplitude": pytest.approx(math.radians(10)), "cycles": 2}


@pytest.mark.parametrize(
    ("old", "new", "part"),
    [
        ('"reversal"', '"revearsal"', "installed are"),
        ('amplitude = "10 deg"', 'amplitude = "10 N*m"', "angle"),
        ('amplitude = "10 deg"', "amplitude = 10", "unit"),
        ("cycles = 2", "cycles = 2.5", "whole number"),
        ("cycles = 2", "cicles = 2", 'no option "cicles"'),
        ('"5 deg/s"', '"5 deg"', "unit of speed"),
        ('name = "s"', 'name = "s"\norder = "random"', "stages[1].order"),
        ("velocities", "velocites", "velocites"),
        ('["5 deg/s"]', "[]", "velocities"),
    ],
)
def test_wrong_campaign_files_get_a_sentence(old: str, new: str, part: str) -> None:
    assert old in TEXT
    with pytest.raises(ConfigurationError) as caught:
        parse_campaign(TEXT.replace(old, new), "mine.toml")
    assert part in str(caught.value)
    assert "mine.toml" in str(caught.value)


def test_the_same_point_twice_is_refused(bench: BenchConfiguration) -> None:
    campaign = Campaign("c", "", (Stage("s", (Block("dwell"), Block("dwell"))),))
    with pytest.raises(ConfigurationError, match="twice"):
        make_plan(campaign, bench)


def test_a_campaign_may_be_a_python_file(tmp_path: Path, bench: BenchConfiguration) -> None:
    path = tmp_path / "mine.py"
    path.write_text(
        "from bench.campaigns import Block, Campaign, Stage\n"
        "block = Block('constant_velocity', velocities=(0.1, -0.1))\n"
        "campaign = Campaign('py', 'from Python', (Stage('s', (block,)),))\n"
    )
    assert make_plan(load_campaign(path), bench).points == 2
    path.write_text("campaign = 3\n")
    with pytest.raises(ConfigurationError, match="variable campaign"):
        load_campaign(path)


def test_all_sequences_are_found_and_are_sequences() -> None:
    assert set(sequence_names()) >= {"constant_velocity", "validation", "heating", "reversal", "tare"}
    for name in sequence_names():
        assert isinstance(build_sequence(name), Sequence)
