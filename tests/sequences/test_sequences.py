import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.protocols import BenchFacts, Phase, Point, Request, Segment, Sequence, Until
from sequences.constant_velocity import ConstantVelocity
from sequences.thermal import Cooling, Dwell, Heating
from sequences.transients import Reversal, RunIn, TorqueRamp, VelocityRamp
from sequences.validation import Validation

FACTS = BenchFacts(185.0, 40.0, 500.0, 2.0, 200.0, 7200.0, 1.0, 20.0, 21.0)
ALL: tuple[Sequence, ...] = (
    ConstantVelocity(),
    Validation(),
    Heating(),
    Cooling(),
    Dwell(),
    Reversal(),
    TorqueRamp(),
    VelocityRamp(),
    RunIn(),
)

speeds = st.floats(math.radians(0.5), math.radians(20))
points = st.builds(
    Point,
    st.just("any"),
    st.floats(-1000, 1000),
    st.builds(math.copysign, speeds, st.sampled_from([-1.0, 1.0])),
    st.floats(20, 60),
)


def named(phases: tuple[Phase, ...], segment: Segment) -> list[Phase]:
    return [phase for phase in phases if phase.segment is segment]


@pytest.mark.parametrize("sequence", ALL, ids=lambda s: type(s).__name__)
@given(point=points)
def test_every_sequence_ends_at_rest_without_load(sequence: Sequence, point: Point) -> None:
    phases = sequence.phases(point, FACTS)
    assert phases
    assert (phases[-1].velocity, phases[-1].load_torque) == (0.0, 0.0)
    assert all(phase.duration_s >= 0.0 and math.isfinite(phase.duration_s) for phase in phases)


@pytest.mark.parametrize("sequence", ALL, ids=lambda s: type(s).__name__)
@given(point=points)
def test_no_phase_asks_for_more_than_the_ramps_of_the_bench(sequence: Sequence, point: Point) -> None:
    velocity = torque = 0.0
    for phase in sequence.phases(point, FACTS):
        assert abs(phase.velocity - velocity) * FACTS.ratio <= FACTS.motor_acceleration * phase.duration_s * (1 + 1e-9)
        assert abs(phase.load_torque - torque) <= FACTS.torque_rate * phase.duration_s * (1 + 1e-9) + 1e-9
        velocity, torque = phase.velocity, phase.load_torque


@given(point=points)
def test_steady_is_a_full_revolution_at_the_set_point(point: Point) -> None:
    steady = named(ConstantVelocity().phases(point, FACTS), Segment.STEADY)
    assert len(steady) == 1
    assert steady[0].duration_s * abs(point.velocity) >= 2 * math.pi
    assert (steady[0].velocity, steady[0].load_torque) == (point.velocity, point.load_torque)


@given(point=points)
def test_load_goes_on_after_the_speed_and_off_before_it(point: Point) -> None:
    velocity = 0.0
    for phase in ConstantVelocity().phases(point, FACTS):
        changes_speed = phase.velocity != velocity
        assert not (changes_speed and phase.load_torque != 0.0)
        velocity = phase.velocity


def test_standstill_is_refused_where_it_makes_no_sense() -> None:
    for sequence in (ConstantVelocity(), Reversal(), RunIn()):
        with pytest.raises(ValueError, match="velocity"):
            sequence.phases(Point("any"), FACTS)


def test_heating_waits_for_the_temperature_within_its_limit() -> None:
    phases = Heating().phases(Point("heating", temperature=40.0), FACTS)
    (heat,) = named(phases, Segment.HEAT)
    assert heat.until is Until.WARMER
    assert heat.temperature == 41.0
    assert heat.duration_s == FACTS.heating_time_limit_s
    assert heat.velocity * FACTS.ratio == pytest.approx(200.0)
    with pytest.raises(ValueError, match="temperature"):
        Heating().phases(Point("heating"), FACTS)


def test_reversal_alternates_over_its_amplitude() -> None:
    phases = Reversal(amplitude=0.1, cycles=3).phases(Point("reversal", 100.0, 0.05), FACTS)
    steady = named(phases, Segment.STEADY)
    assert [math.copysign(1, phase.velocity) for phase in steady] == [1, -1] * 3
    assert all(phase.duration_s * abs(phase.velocity) == pytest.approx(0.1) for phase in steady)


def test_torque_ramp_is_one_staircase_through_both_signs() -> None:
    phases = named(TorqueRamp(steps=2, hold=1.0).phases(Point("torque_ramp", 600.0), FACTS), Segment.STEADY)
    holds = [phase.load_torque for phase in phases if phase.duration_s == 1.0]
    assert holds == pytest.approx([0, 300, 600, 300, 0, -300, -600, -300, 0])


def test_velocity_ramp_has_only_ramps() -> None:
    phases = VelocityRamp().phases(Point("velocity_ramp", 0.0, 0.3), FACTS)
    assert {phase.segment for phase in phases} == {Segment.RAMP_UP, Segment.RAMP_DOWN}


def request(**values: object) -> Request:
    return Request(
        "validation",
        (-1000.0, 0.0, 1000.0),
        (math.radians(2.5), math.radians(-10.0)),
        (None, 50.0),
        start_temperature=21.0,
        **values,  # type: ignore[arg-type]
    )


@given(st.integers(1, 70), st.integers(0, 2**31))
def test_sobol_points_stay_within_the_grid(count: int, seed: int) -> None:
    found = Validation(count, seed).points(request())
    assert len(found) == count
    for point in found:
        assert -1000 <= point.load_torque <= 1000
        assert math.radians(2.5) - 1e-12 <= abs(point.velocity) <= math.radians(10) + 1e-12
        assert point.temperature is not None
        assert 21 <= point.temperature <= 50


def test_sobol_points_are_reproducible_and_two_sided() -> None:
    points = Validation(19, 7).points(request())
    assert points == Validation(19, 7).points(request())
    assert points != Validation(19, 8).points(request())
    assert 5 <= sum(point.velocity > 0 for point in points) <= 14


def test_grid_repeats_lie_apart() -> None:
    points = ConstantVelocity().points(Request("constant_velocity", (0.0, 1.0), (0.1,), (None,), repeats=2))
    assert [(point.load_torque, point.repeat) for point in points] == [(0.0, 1), (1.0, 1), (0.0, 2), (1.0, 2)]
