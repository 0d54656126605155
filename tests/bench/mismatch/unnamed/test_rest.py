"""What is left and nobody explains is told, where it is more than noise in the motion whose noise was measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.discovery import Structure
from bench.mismatch.score import _Sum
from bench.mismatch.unnamed.rest import averaged, unexplained
from tests.bench.mismatch.report import made

SIGMA = 0.02


@pytest.mark.parametrize(("steady", "told"), [(1.0, 0), (1.1, 0), (2.0, 1)])
def test_the_floor_is_compared_with_steady_motion(steady: float, told: int) -> None:
    own = made.outcome(made.campaign(), "motor_torque", [], SIGMA)
    # ramps and starts leave three times the noise, which says nothing
    own.rmse |= {"after": 3.0 * own.floor, "after_steady": steady * own.floor}
    unexplained(own)
    assert len(own.discoveries) == told


def test_without_steady_motion_all_samples_count() -> None:
    own = made.outcome(made.campaign(), "motor_torque", [], SIGMA)
    own.rmse |= {"after": 3.0 * own.floor, "after_steady": None}
    unexplained(own)
    assert [d.effect for d in own.discoveries] == ["unknown"]


@pytest.mark.parametrize(("size", "told"), [(1.5, 0), (1.8, 1)])
def test_slow_noise_of_a_thermometer_may_be_as_much_again_as_its_floor(size: float, told: int) -> None:
    own = made.outcome(made.campaign(), "temperature", [], SIGMA)
    own.rmse |= {"after": size * own.floor, "after_steady": size * own.floor}
    unexplained(own)
    assert len(own.discoveries) == told


@pytest.mark.parametrize(("p_value", "size", "told"), [(1e-4, 1.8, 1), (1e-4, 0.5, 0), (1.0, 1.8, 0)])
def test_warm_ups_that_were_all_fitted_are_a_witness_of_structure(p_value: float, size: float, told: int) -> None:
    """Nothing held out shows what only warm-ups do."""
    frame = made.campaign()
    own = made.outcome(frame, "temperature", [], SIGMA)
    own.structure = Structure(p_value, "test")
    own = replace(own, whole=own.rows.y - size * own.floor * np.sign(np.sin(frame.elapsed)))
    own.rmse |= {"after": own.floor, "after_steady": own.floor}
    unexplained(own)
    assert len(own.discoveries) == told


def test_one_loud_recording_is_not_the_usual_one() -> None:
    total = _Sum()
    for size in (1.0, 1.0, 1.0, 9.0):
        total.add(np.full(100, size))
    assert total.usual() == pytest.approx(1.0)
    assert total.rmse() == pytest.approx(np.sqrt((3.0 + 81.0) / 4.0))
    assert _Sum().usual() is None


@pytest.mark.parametrize(("p_value", "told"), [(1.0, 0), (1e-4, 1)])
def test_structure_and_a_few_recordings_far_off_are_two_witnesses(p_value: float, told: int) -> None:
    own = made.outcome(made.campaign(), "motor_torque", [], SIGMA)
    own.structure = Structure(p_value, "test")
    own.rmse |= {"after": 2.0 * own.floor, "after_steady": own.floor}
    unexplained(own)
    assert len(own.discoveries) == told


@pytest.mark.parametrize(("size", "told"), [(20.0, ["friction.stribeck"]), (4.0, ["friction.stribeck", "unknown"])])
def test_beside_a_finding_what_its_form_may_leave_is_not_told(size: float, told: list[str]) -> None:
    """A form may be off by a fifth of an effect: of 20 times the noise that is 4 times it, of 4 times less than it."""
    frame = made.campaign()
    added = size * SIGMA * np.sign(frame.velocity)
    found = made.discovery("motor_torque", "friction.stribeck", added, ("speed",))
    own = made.outcome(frame, "motor_torque", [found], SIGMA)
    own.structure = Structure(1e-4, "test")
    own.rmse |= {"after": 2.0 * own.floor, "after_steady": own.floor}
    unexplained(own)
    assert [d.effect for d in own.discoveries] == told


def test_a_small_name_that_depends_on_something_else_is_no_part_of_what_is_left() -> None:
    frame = made.campaign()
    found = made.discovery("motor_torque", "load.unbalance", 0.3 * SIGMA * np.sign(frame.velocity), ("angle",))
    own = made.outcome(frame, "motor_torque", [replace(found, independent=True)], SIGMA)
    own.rmse |= {"after": 3.0 * own.floor, "after_steady": 3.0 * own.floor}
    unexplained(own)
    assert [d.effect for d in own.discoveries] == ["load.unbalance", "unknown"]


@pytest.mark.parametrize(
    ("channel", "p_value", "told"), [("motor_torque", 1.0, 0), ("motor_torque", 1e-4, 1), ("temperature", 1e-4, 0)]
)
def test_where_structure_is_seen_less_is_enough(channel: str, p_value: float, told: int) -> None:
    """But not of the temperature: slow noise of the torques adds up in it, of which its floor says nothing."""
    own = made.outcome(made.campaign(), channel, [], SIGMA)
    own.structure = Structure(p_value, "test")
    own.rmse |= {"after": 1.18 * own.floor, "after_steady": 1.05 * own.floor}
    unexplained(own)
    assert len(own.discoveries) == told


@pytest.mark.parametrize(("size", "named"), [(0.3, False), (9.0, True)])
def test_a_name_smaller_than_what_is_left_is_a_part_of_that(size: float, named: bool) -> None:
    frame = made.campaign()
    added = size * SIGMA * np.sign(frame.velocity)
    found = made.discovery("motor_torque", "friction.stribeck", added, ("speed",))
    own = made.outcome(frame, "motor_torque", [found], SIGMA)
    own.rmse |= {"after": 3.0 * own.floor, "after_steady": 3.0 * own.floor}
    unexplained(own)
    assert [d.effect for d in own.discoveries] == (["friction.stribeck"] if named else []) + ["unknown"]
    assert own.discoveries[-1].simulation_rows == (() if named else found.simulation_rows)
    assert any("smaller than what is left" in note for note in own.notes) is not named


@pytest.mark.parametrize(("left", "named"), [(1.0, True), (6.0, False)])
def test_a_name_that_stands_above_what_is_left_where_it_acts_is_no_part_of_that(left: float, named: bool) -> None:
    """Friction after reversals: eight times the noise in one row of a hundred, beside ``left`` times it there."""
    frame = made.campaign()
    acts = np.arange(frame.size) % 100 == 0
    found = made.discovery("motor_torque", "friction.presliding", 8.0 * SIGMA * acts, ("reversal_travel",))
    own = made.outcome(frame, "motor_torque", [found], SIGMA)
    own = replace(own, rows=replace(own.rows, y=own.whole + np.where(acts, left, 3.0) * SIGMA))
    own.rmse |= {"after": 3.0 * own.floor, "after_steady": 3.0 * own.floor}
    unexplained(own)
    assert [d.effect for d in own.discoveries] == (["friction.presliding"] if named else []) + ["unknown"]


@pytest.mark.parametrize(("beyond", "named"), [(8.0, True), (2.0, False)])
def test_of_a_name_counts_what_the_simulation_does_not_have(beyond: float, named: bool) -> None:
    """Friction that a reversal builds up is Coulomb friction in steady motion: that says nothing for the name."""
    frame = made.campaign()
    acts = np.arange(frame.size) % 100 == 0
    found = made.discovery("motor_torque", "friction.presliding", 20.0 * SIGMA * frame.direction, ("reversal_travel",))
    own = made.outcome(frame, "motor_torque", [replace(found, excess=beyond * SIGMA * acts)], SIGMA)
    own = replace(own, rows=replace(own.rows, y=own.whole + 3.0 * SIGMA))
    own.rmse |= {"after": 3.0 * own.floor, "after_steady": 3.0 * own.floor}
    unexplained(own)
    assert [d.effect for d in own.discoveries] == (["friction.presliding"] if named else []) + ["unknown"]


@pytest.mark.parametrize(
    ("size", "left", "channel", "named"),
    [
        (0.3, 2.0, "transmission_error", False),
        (9.0, 2.0, "transmission_error", True),
        # what is left is noise
        (0.3, 1.1, "transmission_error", True),
        # slow noise adds up in an integral
        (0.3, 2.0, "temperature", True),
    ],
)
def test_beside_a_function_without_a_name_a_small_name_is_a_part_of_what_is_left(
    size: float, left: float, channel: str, named: bool
) -> None:
    frame = made.campaign()
    effect = "te.stiffness_nonlinear" if channel == "transmission_error" else "thermal.convection_speed"
    small = made.discovery(channel, effect, size * SIGMA * np.sign(frame.velocity), ("torque",))
    free = made.discovery(channel, "unknown", np.full(frame.size, 0.1), ("time",))
    own = made.outcome(frame, channel, [free, small], SIGMA)
    own.rmse |= {"after": left * own.floor, "after_steady": own.floor}
    unexplained(own)
    assert [d.effect for d in own.discoveries] == ["unknown"] + ([effect] if named else [])
    taken = () if named else small.simulation_rows
    assert own.discoveries[0].simulation_rows == (*free.simulation_rows, *taken)
    assert np.allclose(own.discoveries[0].added, free.added + (0.0 if named else small.added))


def test_orders_are_told_beside_whatever_is_left() -> None:
    frame = made.campaign()
    found = made.discovery("transmission_error", "te.harmonic", 1e-9 * np.cos(frame.theta), ("angle",))
    own = made.outcome(frame, "transmission_error", [found], 1e-6)
    own.rmse |= {"after": 3.0 * own.floor, "after_steady": 3.0 * own.floor}
    unexplained(own)
    assert [d.effect for d in own.discoveries] == ["te.harmonic", "unknown"]


@pytest.mark.parametrize(
    ("p_value", "after", "rows", "told"),
    [
        (1e-4, 1.0, 1, True),
        (1.0, 2.0, 1, True),
        (1.0, 1.0, 1, False),
        # blocks that scatter have no row of a simulation: the structure is theirs
        (1e-4, 1.0, 0, False),
        (1e-4, 2.0, 0, True),
    ],
)
@pytest.mark.parametrize("everywhere", [True, False])
def test_a_function_without_a_name_lies_where_what_it_leaves_lies(
    p_value: float, after: float, rows: int, told: bool, everywhere: bool
) -> None:
    """Structure says that noise is not all that is left, or its amount does."""
    frame = made.campaign()
    added = np.full(frame.size, 0.1)
    function = made.discovery("motor_torque", "unknown", added, ("time",), simulation_rows=({},) * rows)
    own = made.outcome(frame, "motor_torque", [replace(function, everywhere=added if everywhere else None)], SIGMA)
    own.structure = Structure(p_value, "test")
    own.rmse["after"] = after * own.floor
    own.whole[frame.recording == 1] -= 0.4
    unexplained(own)
    (found,) = own.discoveries
    for beyond in (found.beyond, *((found.everywhere,) if found.everywhere is not None else ())):
        elsewhere = np.median(np.abs(beyond[frame.recording == 0]))
        more = np.median(np.abs(beyond[frame.recording == 1])) / elsewhere
        assert more == pytest.approx(4.0 if told else 1.0, rel=0.1)


@pytest.mark.parametrize(("levels", "inside", "told"), [(0.0, 1.0, 1), (2.0, 1.0, 0), (2.0, 1.6, 1)])
def test_levels_that_differ_as_those_of_the_fitted_recordings_are_offsets(
    levels: float, inside: float, told: int
) -> None:
    """Unless what is left inside the recordings is more than noise as well."""
    own = made.outcome(made.campaign(), "motor_torque", [], SIGMA)
    own.levels = levels * own.floor**2
    own.rmse |= {"after": 1.6 * own.floor, "after_steady": 1.6 * own.floor, "after_inside": inside * own.floor}
    unexplained(own)
    assert len(own.discoveries) == told


def test_a_recording_is_scored_about_its_own_mean_as_well() -> None:
    total = _Sum()
    for level in (-3.0, 1.0, 3.0):
        total.add(level + np.array([-1.0, 1.0]))
    assert total.usual_inside() == pytest.approx(1.0)
    assert total.usual() == pytest.approx(np.sqrt(10.0))
    assert _Sum().usual_inside() is None


def test_levels_beyond_the_noise_of_a_sample_are_no_matter_of_noise() -> None:
    own = made.outcome(made.campaign(), "transmission_error", [], SIGMA)
    own.levels = 40.0 * own.floor**2
    own.rmse |= {"after": 2.6 * own.floor, "after_steady": 2.6 * own.floor, "after_inside": own.floor}
    unexplained(own)
    assert [d.effect for d in own.discoveries] == ["unknown"]


@pytest.mark.parametrize(
    ("channel", "effect", "size", "told"),
    [
        ("transmission_error", "", 0.0, True),
        ("transmission_error", "te.harmonic", 6.0, True),
        # a form may be off by a fifth of an effect: of six times the noise that is more of it than is left
        ("transmission_error", "te.lost_motion", 6.0, False),
        ("transmission_error", "te.lost_motion", 2.0, True),
        ("motor_torque", "", 0.0, False),
        ("temperature", "", 0.0, False),
    ],
)
def test_what_comes_and_goes_is_seen_in_all_steady_samples(channel: str, effect: str, size: float, told: bool) -> None:
    frame = made.campaign()
    added = size * SIGMA * np.sign(frame.velocity)
    found = [made.discovery(channel, effect, added, ("angle",))] if effect else []
    own = made.outcome(frame, channel, list(found), SIGMA)
    own.rmse |= {"after_steady": own.floor, "after_altogether": 1.6 * own.floor, "after": 1.6 * own.floor}
    unexplained(own)
    assert ("unknown" in [d.effect for d in own.discoveries]) is told


@pytest.mark.parametrize(("bursts", "told"), [(None, False), (0.5, False), (1e-4, True)])
def test_blocks_too_loud_for_noise_leave_no_room_for_an_uncertain_floor(bursts: float | None, told: bool) -> None:
    own = made.outcome(made.campaign(), "transmission_error", [], SIGMA)
    own.floor_std = 0.1 * own.floor
    own.structure = Structure(1.0, "test", bursts)
    own.rmse |= {"after_steady": 1.35 * own.floor, "after_altogether": 1.35 * own.floor}
    unexplained(own)
    assert bool(own.discoveries) is told


@pytest.mark.parametrize(
    ("tone", "left", "told"), [(None, 1.18, False), (0.5, 1.18, False), (1e-4, 1.18, True), (1e-4, 1.04, False)]
)
def test_a_tone_of_a_few_recordings_and_more_left_than_noise_are_two_witnesses(
    tone: float | None, left: float, told: bool
) -> None:
    own = made.outcome(made.campaign(), "transmission_error", [], SIGMA)
    own.structure = Structure(1.0, "test", None, tone)
    own.rmse |= {"after": left * own.floor, "after_steady": own.floor, "after_altogether": left * own.floor}
    unexplained(own)
    assert bool(own.discoveries) is told


def test_a_wave_over_the_angle_lies_at_every_speed() -> None:
    """Forty periods a revolution are several in a second of the fast recordings, whose mean is nothing."""
    frame = made.campaign()
    wave = 20.0 * SIGMA * np.sqrt(2.0) * np.sin(40.0 * frame.theta + frame.recording**2)
    own = made.outcome(frame, "transmission_error", [], SIGMA)
    own = replace(own, rows=replace(own.rows, y=own.rows.y + wave))
    size = averaged(own.left, own)
    speed = np.abs(frame.velocity)
    slow, fast = (float(np.sqrt(np.mean(size[rows] ** 2))) for rows in (speed < 0.07, speed > 0.15))
    assert slow == pytest.approx(20.0 * SIGMA, rel=0.05)
    assert fast == pytest.approx(20.0 * SIGMA, rel=0.05)
