"""The location of a finding: the smallest ranges that hold nine tenths of its energy, recomputed another way."""

from __future__ import annotations

import itertools
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from bench.mismatch.discovery import ChannelOutcome, Discovery
from bench.mismatch.report.location import HELD, Location, by_recording, location_of, of_recordings, strongest, to_json
from bench.mismatch.report.smallest import interval
from bench.mismatch.report.words import text
from bench.simulation.frame import FloatArray, Frame
from tests.bench.mismatch.report import made


def _placed(found: Discovery, frame: Frame) -> tuple[Location, ChannelOutcome]:
    own = made.outcome(frame, found.channel, [found])
    return location_of(found, own, made.dataset(frame, found.channel, own.rows)), own


@pytest.mark.parametrize("seed", range(20))
def test_the_shortest_interval_is_found(seed: int) -> None:
    rng = np.random.default_rng(seed)
    values, energy = rng.integers(0, 12, 40).astype(float), rng.exponential(1.0, 40) ** 3
    least = 0.9 * float(energy.sum())
    found = interval(values, energy, least)
    places = np.unique(values)
    possible = [
        (b - a) for a, b in itertools.product(places, places) if energy[(values >= a) & (values <= b)].sum() >= least
    ]
    assert found is not None
    assert found[1] - found[0] == min(possible)
    assert energy[(values >= found[0]) & (values <= found[1])].sum() >= least * (1 - 1e-9)


def test_too_little_energy_has_no_interval() -> None:
    assert interval(np.arange(3.0), np.ones(3), 4.0) is None
    assert interval(np.arange(3.0), np.zeros(3), 0.0) is None


def test_slow_friction_is_below_a_speed_and_everywhere_else() -> None:
    frame = made.campaign()
    found = made.discovery("motor_torque", "friction.stribeck", made.stribeck(frame), ("speed",))
    where, own = _placed(found, frame)
    energy = np.where(own.usable, found.added**2 * own.rows.number, 0.0)
    low, high = where.ranges["velocity"]
    speed = np.abs(frame.velocity)
    inside = (speed >= low - 1e-12) & (speed <= high + 1e-12)
    assert energy[inside].sum() >= 0.9 * energy.sum()
    assert energy[speed <= 0.021].sum() < 0.9 * energy.sum()
    assert (low, high) == pytest.approx((0.02, 0.06))
    assert where.ranges["load_torque"] == where.span["load_torque"] == (-1000.0, 1000.0)
    assert where.ranges["temperature"] == (frame.temperature.min(), frame.temperature.max())
    assert where.direction == "both"
    assert text(where) == "below 3.44 deg/s, both directions, all loads, all temperatures"


@pytest.mark.parametrize(
    ("side", "name", "limits"),
    [
        (("speed", "below", 0.08), "velocity", (0.02, 0.08)),
        (("speed", "above", 0.08), "velocity", (0.08, 0.17)),
        (("load", "below", 700.0), "load_torque", (-700.0, 700.0)),
        (("load", "above", 700.0), "load_torque", (-1000.0, 1000.0)),
        (("torque", "below", -600.0), "load_torque", (-1000.0, -600.0)),
    ],
)
def test_states_that_lie_on_one_side_of_a_limit_are_all_of_that_side(
    side: tuple[str, str, float], name: str, limits: tuple[float, float]
) -> None:
    """Scatter at one set speed, and none at the next: the place is all below what lies between."""
    frame = made.campaign()
    course = np.where(np.abs(frame.velocity) < 0.03, 0.1, 0.0)
    found = replace(made.discovery("motor_torque", "unknown", course, (side[0],)), side=side)
    where, _ = _placed(found, frame)
    assert where.ranges[name] == pytest.approx(limits)
    others = {"velocity", "load_torque", "temperature"} - {name}
    assert all(where.ranges[other] == where.span[other] for other in others)
    told = text(where)
    assert ("beyond ±700 N·m" in told) is (side == ("load", "above", 700.0))
    assert ("all loads" in told) is (name != "load_torque")


@pytest.mark.parametrize(("side", "late"), [("above", True), ("below", False)])
def test_times_on_one_side_of_a_limit_are_a_window_to_the_end_or_from_the_beginning(side: str, late: bool) -> None:
    frame = made.campaign()
    course = np.where((frame.time > 6000.0) == late, 0.1, 0.0)
    found = replace(made.discovery("motor_torque", "unknown", course, ("time",)), side=("time", side, 5700.0))
    where, _ = _placed(found, frame)
    ends = (5700.0, float(frame.time.max())) if late else (float(frame.time.min()), 5700.0)
    assert where.time_window == pytest.approx(tuple(made.START + end for end in ends))


@pytest.mark.parametrize(("lowest", "limits"), [(-500.0, (700.0, 1000.0)), (-1000.0, (-1000.0, 1000.0))])
def test_large_loads_of_one_sign_are_told_by_their_range(lowest: float, limits: tuple[float, float]) -> None:
    frame = made.campaign()
    frame = replace(frame, torque=np.maximum(frame.torque, lowest), torque_level=np.maximum(frame.torque_level, lowest))
    found = replace(
        made.discovery("motor_torque", "unknown", np.where(frame.torque > 800.0, 0.1, 0.0), ("load",)),
        side=("load", "above", 700.0),
    )
    where, _ = _placed(found, frame)
    assert where.ranges["load_torque"] == pytest.approx(limits)
    assert ("beyond" in text(where)) is (lowest < -700.0)


def test_recordings_are_those_of_the_largest_energy_in_order() -> None:
    frame = made.campaign()
    found = made.discovery("motor_torque", "friction.stribeck", made.stribeck(frame) * frame.temperature, ("speed",))
    where, own = _placed(found, frame)
    usable = np.flatnonzero(own.usable)
    held: dict[str, float] = {}
    for row in usable:
        name = f"r{frame.recording[row]:02d}"
        held[name] = held.get(name, 0.0) + float(found.added[row] ** 2 * own.rows.number[row])
    ordered = sorted(held, key=lambda name: held[name], reverse=True)
    assert list(where.recordings) == ordered[: len(where.recordings)]
    told = sum(held[name] for name in where.recordings)
    assert told >= HELD * sum(held.values()) > told - held[where.recordings[-1]]


def test_two_quantities_together_hold_nine_tenths() -> None:
    frame = made.campaign()
    added = np.where((np.abs(frame.velocity) < 0.07) & (frame.torque > 300.0), 1.0, 0.02)
    found = made.discovery("motor_torque", "unknown", added, ("speed", "torque"))
    where, own = _placed(found, frame)
    energy = np.where(own.usable, added**2 * own.rows.number, 0.0)
    inside = np.ones(frame.size, dtype=bool)
    for name, values in (("velocity", np.abs(frame.velocity)), ("load_torque", frame.torque)):
        inside &= (values >= where.ranges[name][0] - 1e-9) & (values <= where.ranges[name][1] + 1e-9)
    assert energy[inside].sum() >= 0.9 * energy.sum()
    assert where.ranges["velocity"] == pytest.approx((0.02, 0.06))
    assert where.ranges["load_torque"] == (400.0, 1000.0)
    assert text(where).startswith("below 3.44 deg/s, above 400 N·m, both directions")


def test_a_direction_is_told_where_the_energy_is_and_not_where_the_bench_ran() -> None:
    frame = made.campaign()
    one = made.discovery("motor_torque", "unknown", np.where(frame.direction > 0, 1.0, 0.1), ("direction",))
    assert _placed(one, frame)[0].direction == "positive"
    lopsided = replace(frame, last_direction=np.where(frame.recording == 0, -1.0, 1.0))
    even = made.discovery("motor_torque", "unknown", np.ones(frame.size), ("direction",))
    assert _placed(even, lopsided)[0].direction == "both"


@pytest.mark.parametrize(("driven", "direction"), [(False, "both"), (True, "negative")])
def test_a_band_of_load_that_was_driven_one_way_tells_no_direction(driven: bool, direction: str) -> None:
    """At 400 N·m the bench went back only, and at -1000 N·m and 0 both ways; or at 400 N·m both ways as well."""
    frame = made.campaign()
    at = frame.torque == 400.0
    back = frame.direction < 0
    if not driven:
        frame = replace(frame, torque=np.where(at & ~back, -300.0, frame.torque))
        frame = replace(frame, torque_level=frame.torque)
    course = np.where((frame.torque == 400.0) & back, 0.1, 0.0)
    where, _ = _placed(made.discovery("motor_torque", "unknown", course, ("torque",)), frame)
    assert where.direction == direction


@pytest.mark.parametrize("one_way", [False, True])
def test_a_cold_start_one_way_is_no_direction(one_way: bool) -> None:
    """The bench is cold at the highest speed one way only: drag that is larger then is so either way, unless it is not
    where both ways were driven.
    """
    frame = made.campaign()
    fast, back = np.abs(frame.velocity) > 0.15, frame.direction < 0
    cold = np.where(fast, back, frame.torque < 0.0)
    frame = replace(frame, temperature=np.where(cold, 22.0, 38.0))
    thick = np.where(fast, 0.7, 1.0) * np.exp(-0.2 * (frame.temperature - 22.0))
    course = np.where(one_way & ~back, 0.0, frame.direction * thick)
    found = made.discovery("motor_torque", "friction.viscous_temperature", course, ("speed", "temperature"))
    where, _ = _placed(found, frame)
    assert where.direction == ("negative" if one_way else "both")


def test_a_warm_up_one_way_at_a_speed_of_its_own_is_no_direction() -> None:
    frame = made.campaign()
    fast = frame.recording == 0
    frame = replace(
        frame, velocity=np.where(fast, 1.1, frame.velocity), last_direction=np.where(fast, 1.0, frame.direction)
    )
    drag = made.discovery("motor_torque", "unknown", frame.last_direction * np.abs(frame.velocity), ("speed",))
    assert _placed(drag, frame)[0].direction == "both"
    one_way = np.where(frame.last_direction > 0, np.abs(frame.velocity), 0.0)
    assert _placed(made.discovery("motor_torque", "unknown", one_way, ("speed",)), frame)[0].direction == "positive"


def test_heat_has_no_direction() -> None:
    frame = made.campaign()
    one_way = np.where(frame.last_direction > 0, 1.0, 0.0)
    lag = made.discovery("temperature", "thermal.sensor_lag", one_way, ("transient",))
    assert _placed(lag, frame)[0].direction == "both"
    forward = replace(frame, last_direction=np.ones(frame.size))
    assert _placed(lag, forward)[0].direction == "positive"
    nameless = made.discovery("temperature", "unknown", one_way, ("direction",))
    assert _placed(nameless, frame)[0].direction == "positive"


def test_lost_motion_is_where_it_changes() -> None:
    frame = made.campaign()
    ramp = np.linspace(-1000.0, 1000.0, frame.size)
    frame = replace(frame, torque=ramp, torque_level=ramp)
    step = np.tanh(ramp / 50.0)
    added = step - ramp * float(ramp @ step) / float(ramp @ ramp)
    where, _ = _placed(made.discovery("transmission_error", "te.lost_motion", added, ("torque",)), frame)
    low, high = where.ranges["load_torque"]
    assert -130.0 < low < -30.0
    assert 30.0 < high < 130.0
    assert "within ±" in text(where)


def test_what_the_recordings_do_not_tell_from_lost_motion_is_where_it_adds_something() -> None:
    """A torsion that is stiffer on one side is no step; nothing was recorded between the loads."""
    frame = made.campaign()
    loads = np.resize(np.array([-900.0, -300.0, 300.0, 900.0]), frame.size)
    frame = replace(frame, torque=loads, torque_level=loads)
    added = np.sign(loads) * np.where(np.abs(loads) < 600.0, 0.5, -0.3)
    ambiguous = made.discovery("transmission_error", "te.lost_motion", added, ("torque",), status="ambiguous")
    where, _ = _placed(ambiguous, frame)
    assert where.ranges["load_torque"] == (-900.0, 900.0)


def test_a_temperature_is_placed_by_what_is_added_to_it() -> None:
    frame = made.campaign()
    # heat that comes in at high speed, and slowly goes again at low speed: the slow recordings have most of the energy
    rate = np.where(np.abs(frame.velocity) > 0.15, 0.01, -0.02 * (np.abs(frame.velocity) < 0.07))
    added = np.concatenate([np.cumsum(rate[frame.recording == number]) for number in range(20)])
    found = made.discovery("temperature", "thermal.convection_speed", added, ("speed",))
    where, own = _placed(found, frame)
    assert where.ranges["velocity"][0] == pytest.approx(0.02)
    energy = np.where(own.usable, added**2 * own.rows.number, 0.0)
    inside = np.abs(frame.velocity) <= where.ranges["velocity"][1] + 1e-9
    assert energy[inside].sum() >= 0.9 * energy.sum()


def test_a_time_window_is_in_times() -> None:
    frame = made.campaign()
    added = np.where((frame.recording >= 5) & (frame.recording < 9), 1.0, 0.0)
    where, _ = _placed(made.discovery("motor_torque", "te.drift_time", added, ("time",)), frame)
    assert where.time_window_iso is not None
    begin, end = (datetime.fromisoformat(t) for t in where.time_window_iso)
    assert begin >= datetime.fromtimestamp(made.START + 5 * 600.0 - 1.0, UTC)
    assert end <= datetime.fromtimestamp(made.START + 8 * 600.0 + 15.0, UTC)
    assert end > datetime.fromtimestamp(made.START + 8 * 600.0, UTC)
    told = made.discovery("motor_torque", "unknown", added, ("speed",), time_window=(0.0, 60.0))
    assert _placed(told, frame)[0].time_window == (made.START, made.START + 60.0)


def test_orders_and_windows_are_in_the_words() -> None:
    frame = made.campaign()
    orders = tuple(float(f) for f in range(1, 12))
    found = made.discovery(
        "transmission_error", "te.harmonic", np.ones(frame.size), ("angle",), orders=orders, angle_windows=((0.1, 0.2),)
    )
    told = text(_placed(found, frame)[0])
    assert "at orders 1, 2, 3, 4, 5, 6, 7, 8 and 3 more" in told
    assert "5.7 to 11.5°" in told


def test_lost_motion_is_placed_by_its_own_term_where_that_is_known() -> None:
    frame = made.campaign()
    ramp = np.linspace(-1000.0, 1000.0, frame.size)
    frame = replace(frame, torque=ramp, torque_level=ramp)
    row = {
        "effect": "te.lost_motion",
        "form": "tanh",
        "point": [50.0],
        "channels": ["transmission_error"],
        "parameters": {"j_2": {"value": 2e-5, "unit": "rad"}},
    }
    # what is added wavers with other quantities
    added = 2e-5 * np.sign(np.sin(frame.temperature * 3.0)) * np.tanh(ramp / 50.0)
    found = made.discovery("transmission_error", "te.lost_motion", added, ("torque",), simulation_rows=(row,))
    low, high = _placed(found, frame)[0].ranges["load_torque"]
    assert -100.0 < low < -30.0
    assert 30.0 < high < 100.0


def test_what_no_recording_measured_has_no_range() -> None:
    frame = made.campaign()
    data = made.dataset(frame, "motor_torque", made.outcome(frame, "motor_torque", []).rows)
    for member in data.members:
        member.recording.channels = ("motor_torque",)  # type: ignore[misc]
    own = made.discovery("motor_torque", "friction.stribeck", np.ones(frame.size), ("speed",))
    told = to_json(location_of(own, made.outcome(frame, "motor_torque", [own]), data), "", None)
    assert told["conditions"]["temperature"] is told["conditions"]["load_torque"] is None
    assert told["span"]["temperature"] is None
    assert told["conditions"]["velocity"] is not None


def test_what_acts_just_after_a_start_acts_where_no_row_is_compared() -> None:
    frame = made.campaign()
    early = frame.elapsed < 1.0
    sizes = np.where(frame.recording < 3, 0.2, 0.02)
    found = made.discovery("motor_torque", "friction.presliding", np.where(early, sizes, 1e-4), ("since_reversal",))
    own = made.outcome(frame, "motor_torque", [found])
    # the rows of the start are left out in the recordings in which it acts most
    rows = replace(own.rows, number=np.where(early & (frame.recording < 3), 0.0, own.rows.number))
    left_out = replace(own, rows=rows)
    data = made.dataset(frame, "motor_torque", rows)
    first = {data.name(r) for r in range(3)}
    assert set(location_of(found, left_out, data).recordings) == first
    otherwise = replace(found, variables=("time",))
    assert not first & set(location_of(otherwise, left_out, data).recordings)


def _energies(found: Discovery, frame: Frame, swing: dict[int, float]) -> tuple[FloatArray, FloatArray, ChannelOutcome]:
    own = made.outcome(frame, found.channel, [found])
    data = replace(made.dataset(frame, found.channel, own.rows), swing=swing)
    plain = by_recording(frame, np.where(own.usable, found.added**2 * own.rows.number, 0.0))
    energies = np.where(own.usable, found.added**2 * own.rows.number, 0.0)
    return plain, of_recordings(found, own, energies, data), own


def test_a_delay_is_strongest_where_the_torque_swings_faster_than_rows_last() -> None:
    frame = made.campaign()
    delay = 0.0015
    found = made.discovery("load_torque", "sensor.timing_skew", -delay * frame.torque_rate, ("torque_rate",))
    found = replace(found, parameters=({"symbol": "delta", "value": delay, "unit": "s", "std": 1e-5},))
    plain, energies, own = _energies(found, frame, {3: 1200.0**2})
    samples = by_recording(frame, np.where(own.usable, own.rows.number, 0.0))
    expected = plain.copy()
    expected[3] += delay**2 * samples[3] * 1200.0**2
    assert energies == pytest.approx(expected)
    assert strongest(energies)[0] == 3


def test_what_one_direction_alone_was_driven_warm_for_acts_in_both() -> None:
    """Staircases of the load in either direction, the second warmer than anything else: no like state tells of it."""
    frame = made.campaign()
    forward, last = frame.last_direction > 0, frame.recording == int(frame.recording.max())
    staircase = (frame.recording == int(frame.recording[forward][-1])) | last
    assert not forward[last].any()
    frame = replace(frame, temperature=np.where(last, 80.0, frame.temperature))
    found = made.discovery("load_torque", "sensor.timing_skew", np.where(staircase, 2.0, 1e-3), ("torque_rate",))
    found = replace(found, parameters=({"symbol": "delta", "value": 0.0015, "unit": "s", "std": 1e-5},))
    own = made.outcome(frame, "load_torque", [found])
    data = made.dataset(frame, "load_torque", own.rows)
    assert location_of(found, own, data).direction == "both"
    one = replace(found, added=np.where(staircase & forward, 2.0, 1e-3))
    assert location_of(one, made.outcome(frame, "load_torque", [one]), data).direction == "positive"


def test_what_acts_at_rest_counts_where_something_is_compared() -> None:
    frame = made.campaign()
    found = made.discovery("transmission_error", "te.velocity_nonlinear", np.full(frame.size, 1e-6), ("speed",))
    everywhere = np.where(frame.recording == 5, 3e-6, 1e-6)
    found = replace(found, everywhere=everywhere)
    _, energies, own = _energies(found, frame, {})
    assert energies == pytest.approx(by_recording(frame, everywhere**2 * own.rows.number))
    assert strongest(energies)[0] == 5
