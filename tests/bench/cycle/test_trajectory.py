import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.cycle.trajectory import Trajectory
from bench.cycle.unwrap import Unwrapper
from bench.protocols import Phase, Segment, Until

DT = 5e-4
phases = st.lists(
    st.builds(
        Phase,
        st.sampled_from([None, *Segment]),
        st.floats(0, 0.5),
        st.floats(-1, 1),
        st.floats(-1000, 1000),
    ),
    max_size=6,
)


def run(trajectory: Trajectory, capacity: int) -> tuple[list[float], list[float], list[tuple[int, Segment | None]]]:
    velocity: list[float] = []
    torque: list[float] = []
    changes: list[tuple[int, Segment | None]] = []
    while not trajectory.finished:
        block = trajectory.block(capacity)
        changes += [(len(velocity) + change.offset, change.segment) for change in block.changes]
        velocity += block.velocity.tolist()
        torque += block.load_torque.tolist()
    return velocity, torque, changes


@given(phases, st.integers(1, 300))
def test_blocks_of_any_size_give_the_same_motion(parts: list[Phase], capacity: int) -> None:
    assert run(Trajectory(parts, DT), capacity) == run(Trajectory(parts, DT), 10_000)


@given(phases)
def test_every_phase_takes_its_time_and_ends_at_its_values(parts: list[Phase]) -> None:
    velocity, torque, _ = run(Trajectory(parts, DT), 1000)
    assert len(velocity) == sum(round(part.duration_s / DT) for part in parts)
    end = 0
    for part in parts:
        end += round(part.duration_s / DT)
        if round(part.duration_s / DT):
            assert velocity[end - 1] == pytest.approx(part.velocity)
            assert torque[end - 1] == pytest.approx(part.load_torque)


def test_equal_segments_are_one() -> None:
    parts = [Phase(Segment.RAMP_UP, 0.01, 1, 0), Phase(Segment.RAMP_UP, 0.01, 1, 5), Phase(Segment.STEADY, 0.01, 1, 5)]
    assert run(Trajectory(parts, DT), 7)[2] == [(0, Segment.RAMP_UP), (40, Segment.STEADY)]


def test_a_condition_ends_its_phase() -> None:
    heat = Phase(Segment.HEAT, 10.0, 0.0, 0.0, Until.WARMER, 40.0)
    trajectory = Trajectory([heat, Phase(None, DT, 0.0, 0.0)], DT)
    for temperature in (30.0, 39.9):
        assert trajectory.block(100).size == 100
        trajectory.observe(temperature)
    trajectory.block(100)
    trajectory.observe(40.0)
    assert trajectory.block(100).size == 1
    assert trajectory.finished
    assert trajectory.expired is None


def test_a_condition_that_never_comes_expires() -> None:
    cool = Phase(Segment.DWELL, 0.1, 0.0, 0.0, Until.COOLER, 20.0)
    trajectory = Trajectory([cool], DT)
    count = 0
    while not trajectory.finished:
        count += trajectory.block(64).size
        trajectory.observe(25.0)
    assert count == 200
    assert trajectory.expired is cool


@given(st.lists(st.integers(-(2**31) + 1, 2**31 - 1), min_size=1, max_size=50), st.integers(1, 10))
def test_unwrapping_follows_any_motion(steps: list[int], size: int) -> None:
    true = np.cumsum(np.array(steps, dtype=object))
    wrapped = np.array([(int(v) + 2**31) % 2**32 - 2**31 for v in true], dtype=np.int64).astype(np.int32)
    unwrap = Unwrapper()
    blocks = [unwrap(wrapped[i : i + size]) for i in range(0, len(wrapped), size)]
    found = np.concatenate(blocks)
    assert [int(v) for v in found - found[0]] == [int(v - true[0]) for v in true]


def test_unwrapping_can_go_back() -> None:
    unwrap = Unwrapper()
    unwrap(np.array([2**31 - 5], np.int32))
    state = unwrap.state()
    over = np.array([-(2**31) + 5], np.int32)
    assert unwrap(over)[0] == 2**31 + 5
    unwrap.restore(state)
    assert unwrap(over)[0] == 2**31 + 5
