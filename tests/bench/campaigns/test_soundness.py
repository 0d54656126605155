"""What is no motion is refused by the plan, in one sentence with its place, before anything is made of it."""

from __future__ import annotations

import math
import time
from typing import Any

import pytest

from bench.campaigns import Block, Campaign, Stage, make_plan, parse_campaign
from bench.campaigns.planning.facts import facts
from bench.campaigns.planning.soundness import LONGEST_S, MOST_PHASES, check_phases
from bench.configuration import BenchConfiguration, load_bench
from bench.errors import BenchError, ConfigurationError, LimitError
from bench.protocols import BenchFacts, Phase, Point, Until
from sequences.thermal import Dwell

NAN, INF = math.nan, math.inf


@pytest.fixture(scope="module")
def bench() -> BenchConfiguration:
    return load_bench("rh380n").configuration


def plan(bench: BenchConfiguration, *blocks: Block) -> None:
    make_plan(Campaign("mine", "", (Stage("s", blocks),)), bench)


def refusal(bench: BenchConfiguration, block: Block) -> str:
    began = time.monotonic()
    with pytest.raises(BenchError) as caught:
        plan(bench, block)
    # before anything is generated of it
    assert time.monotonic() - began < 20.0
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("block", "said"),
    [
        (Block("dwell", (0.0, NAN)), 'stage "s", dwell: load_torques[2] is nan, it must be a finite number'),
        (Block("constant_velocity", velocities=(INF,)), "velocities[1] is inf"),
        (Block("dwell", temperatures=(NAN,)), "temperatures[1] is nan"),
        (Block("dwell", ("ten",)), "load_torques[1] is 'ten'"),  # type: ignore[arg-type]
        (Block("dwell", repeats=10**9), "repeats = 1000000000, it must be a whole number from 1 to 10000"),
        (Block("dwell", repeats=0), "repeats = 0"),
        (Block("dwell", tuple(map(float, range(300))), repeats=100), "30000 points, 20000 are the most"),
        (Block("dwell", options=(("duration", NAN),)), "option duration is nan"),
        (Block("dwell", options=(("duration", 1e9),)), "duration is 1e+09 s, it must lie between 0 and 172800 s"),
        (Block("constant_velocity", (0.0,), (0.1,), options=(("revolutions", INF),)), "option revolutions is inf"),
        (Block("constant_velocity", (0.0,), (0.1,), options=(("revolutions", 1e9),)), "revolutions is 1e+09"),
        (Block("constant_velocity", (0.0,), (1e-300,)), "48 h are the most; choose another speed or time"),
        (Block("reversal", (0.0,), (0.1,), options=(("cycles", 10**9),)), "cycles is 1000000000"),
        (Block("reversal", (0.0,), (0.1,), options=(("cycles", 2.0),)), "cycles is 2.0, it must be a whole number"),
        (Block("torque_ramp", (9.0,), (0.1,), options=(("steps", 10**9),)), "steps is 1000000000"),
        (Block("torque_ramp", (9.0,), (0.1,), options=(("hold", -1.0),)), "hold is -1 s"),
        (Block("validation", (0.0, 9.0), (0.1, 0.2), options=(("count", 10**9),)), "count is 1000000000"),
        (Block("heating", temperatures=(30.0,), options=(("direction", 5),)), "direction is 5, it must be 1 or -1"),
    ],
)
def test_what_is_no_motion_is_refused_with_its_place(bench: BenchConfiguration, block: Block, said: str) -> None:
    assert said in refusal(bench, block)


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("options = {}", "options = { revolutions = inf }", "this must be a finite number"),
        ("options = {}", "options = { revolutions = nan }", "this must be a finite number"),
        ("repeats = 1", "repeats = 1000000000", "stages[1].points[1].repeats = 1000000000"),
    ],
)
def test_a_file_is_refused_as_well(before: str, after: str, said: str) -> None:
    text = """
format = "bench-campaign"
format_version = "1.0"
name = "n"
title = "t"
[[stages]]
name = "s"
[[stages.points]]
sequence = "constant_velocity"
velocities = ["10 deg/s"]
repeats = 1
options = {}
"""
    parse_campaign(text, "c.toml")
    with pytest.raises(ConfigurationError, match=r"c\.toml") as caught:
        parse_campaign(text.replace(before, after), "c.toml")
    assert said in str(caught.value)


# -- sequences of others -----------------------------------------------------------------------------------------------

REST = Phase(None, 1.0, 0.0, 0.0)


@pytest.mark.parametrize("name", ["duration_s", "velocity", "load_torque"])
@pytest.mark.parametrize("value", [NAN, INF, -INF, None, "1"])
def test_a_phase_of_no_number_is_refused(bench: BenchConfiguration, name: str, value: Any) -> None:
    fields: dict[str, Any] = {"duration_s": 1.0, "velocity": 0.0, "load_torque": 0.0, name: value}
    with pytest.raises(ConfigurationError, match=f"here, phase 2: {name} is .*, it must be a finite number"):
        check_phases((REST, Phase(None, **fields)), bench, "here")


@pytest.mark.parametrize(
    ("phases", "error", "said"),
    [
        ((Phase(None, -1.0, 0.0, 0.0),), ConfigurationError, "a time is not negative"),
        ((Phase(None, LONGEST_S + 1, 0.0, 0.0),), ConfigurationError, "48 h are the most"),
        ((Phase(None, 1.0, 0.0, 0.0, Until.WARMER),), ConfigurationError, "temperature is nan"),
        ((Phase(None, 99.0, 0.0, 9.0, Until.WARMER, 30.0),), ConfigurationError, "it must keep speed and load"),
        ((REST,) * (MOST_PHASES + 1), ConfigurationError, "more than 100000 phases"),
        ((7,), ConfigurationError, "phase 1 is int, no bench.protocols.Phase"),
        ((Phase(None, 0.0, math.radians(20.0), 0.0),), LimitError, "from 0 to 20 °/s in no time"),
        ((Phase(None, 0.01, math.radians(20.0), 0.0),), LimitError, "in 0.01 s; motion.motor_acceleration asks for"),
        ((Phase(None, 0.0, 0.0, 200.0),), LimitError, "the load goes from 0 to 200 N·m in no time; motion.torque_rate"),
        ((Phase(None, 60.0, 0.0, 200.0),), LimitError, "every point ends at rest"),
    ],
)
def test_a_motion_the_bench_cannot_make_is_refused(
    bench: BenchConfiguration, phases: Any, error: type[Exception], said: str
) -> None:
    with pytest.raises(error) as caught:
        check_phases(phases, bench, "here")
    assert said in str(caught.value)


def test_the_ramps_of_the_bench_itself_pass(bench: BenchConfiguration) -> None:
    ramps = facts(bench)
    up = Phase(None, ramps.velocity_ramp_s(0.0, 0.3), 0.3, 0.0)
    on = Phase(None, ramps.torque_ramp_s(0.0, 300.0), 0.3, 300.0)
    off = Phase(None, ramps.torque_ramp_s(300.0, 0.0), 0.3, 0.0)
    down = Phase(None, ramps.velocity_ramp_s(0.3, 0.0), 0.0, 0.0)
    phases = (up, on, Phase(None, 0.0, 0.3, 300.0), off, down)
    assert check_phases(iter(phases), bench, "here") == phases


def test_a_sequence_is_asked_for_finite_motion_in_the_plan(
    bench: BenchConfiguration, monkeypatch: pytest.MonkeyPatch
) -> None:
    def phases(self: Dwell, point: Point, bench: BenchFacts) -> tuple[Phase, ...]:
        return (Phase(None, 1.0, NAN, 0.0),)

    monkeypatch.setattr(Dwell, "phases", phases)
    assert "mine, point 1 (dwell 0 N·m, 0 °/s, as found), phase 1: velocity is nan" in refusal(bench, Block("dwell"))
