"""What is still to come: time by point, the lubricant's planned way, and its way to the next temperature."""

from __future__ import annotations

import itertools

import pytest

from bench.campaigns import load_campaign, make_plan
from bench.campaigns.planning.facts import facts
from bench.campaigns.planning.outlook import costs, expected_way, planned_way
from bench.campaigns.planning.registry import build_sequence
from bench.configuration import load_bench
from bench.protocols import Point

BENCH = load_bench("rh380n").configuration


def test_the_costs_of_all_points_are_the_plan_but_for_the_last_tare() -> None:
    plan = make_plan(load_campaign("paper"), BENCH)
    each = costs(plan)
    assert len(each) == plan.points
    assert sum(each.values()) == pytest.approx(plan.duration_s - plan.tasks[-1].duration_s)
    way = planned_way(plan)
    assert way[0] == (0.0, plan.start_temperature)
    assert way[-1][0] == pytest.approx(plan.duration_s)
    assert all(before[0] <= after[0] for before, after in itertools.pairwise(way))


def test_the_way_of_a_heating_ends_where_it_is_to_end() -> None:
    point = Point("heating", temperature=40.0)
    phases = build_sequence("heating").phases(point, facts(BENCH))
    way, reached = expected_way(phases, BENCH, 25.0)
    assert reached
    assert way[0] == (0.0, 25.0)
    assert max(degrees for _, degrees in way) == pytest.approx(40.0 + BENCH.heating.hysteresis, abs=0.05)
    rising = [degrees for _, degrees in way[2:-3]]
    assert rising == sorted(rising)
    slower, _ = expected_way(phases, BENCH, 20.0)
    assert slower[-1][0] > way[-1][0]


def test_a_temperature_out_of_reach_is_said() -> None:
    phases = build_sequence("heating").phases(Point("heating", temperature=300.0), facts(BENCH))
    way, reached = expected_way(phases, BENCH, 25.0)
    assert not reached
    assert way[-1][0] > BENCH.heating.time_limit
