"""Hidden physics: exact replay of every kind, what is told of it is what is measured, the ledger, plant files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from fakes.plant import Plant, PlantError, PlantTruth, read_plant
from fakes.plant.draw import RANGES, draw, draw_plant
from fakes.plant.hidden.kinds import KINDS, NUMBER, SHOWN, Hidden
from fakes.plant.hidden.ledger import EVERY, read_ledger
from fakes.plant.hidden.twist import FIRST, LAST
from tests.fakes.plant.motion import bring_up, commands, quiet, ramped, smooth

SCATTER = ("defect", "scraper", "eccentric", "cage", "resonance", "sideband", "harmonic")
"""kinds that come and go within the second looked at: their scatter is compared, not their mean"""
SHORT = {
    "second_spring": (5e-5, 200.0),
    "stribeck": (0.2, 30.0, 1.0),
    "stribeck_rational": (0.2, 30.0, 1.0),
    "dahl": (0.3, 40.0),
    "lugre": (0.3, 40.0, 0.5, 30.0),
    "maxwell": (0.3, 60.0),
    "preload": (9.0, 300.0),
    "hot_magnets": (0.1, 0.1, 1.0),
    "defect": (2e-5, 300.0, 0.3),
    "housing": (0.1, 2.0),
    "room": (900.0,),
    "room_wave": (900.0, 900.0),
    "creep": (2e-5, 2.0),
    "unbalance_behind": (8.0, 1.2),
    "zero_warm": (-0.9,),
    "curved": (10.0,),
    "latent": (2e4, 22.0, 2.0),
}
"""numbers with which a kind shows within the three seconds of the test, where a campaign's would not"""
ELSEWHERE = ("ripple", "floor", "delay")
"""kinds with a test of their own: the inertias take most of them, or they show only where the torque changes"""


@pytest.fixture(scope="module")
def truth() -> PlantTruth:
    return read_plant("rh380n").without_weak_orders()


@pytest.fixture(scope="module")
def still(truth: PlantTruth) -> PlantTruth:
    return smooth(quiet(truth))


@pytest.mark.parametrize("kind", list(KINDS))
def test_every_kind_replays_and_blocks_equal_single_cycles(truth: PlantTruth, kind: str) -> None:
    with_kind = replace(truth, hidden=(draw(kind, np.random.default_rng(3)),))
    rows = np.concatenate([ramped(0.12, 0.0, 60.0, 0.0, 500.0), ramped(0.12, 60.0, -40.0, 500.0, -400.0)])
    one, whole = Plant(with_kind, seed=9), Plant(with_kind, seed=9)
    single = np.concatenate([one.step(rows[i : i + 1]) for i in range(rows.size)])
    token = whole.snapshot()
    first = whole.step(rows)
    assert single.tobytes() == first.tobytes()
    assert one.state == whole.state
    whole.restore(token)
    assert whole.step(rows).tobytes() == first.tobytes()
    assert np.isfinite(one.state["motor_velocity"])


@pytest.mark.parametrize("kind", ["dahl", "lugre", "maxwell", "scraper", "stribeck"])
def test_friction_that_is_hidden_heats_the_gearbox(still: PlantTruth, kind: str) -> None:
    """At a steady speed what both motors give is heat, but for what springs and inertias hold."""
    hidden = Hidden(kind, SHORT[kind]) if kind in SHORT else draw(kind, np.random.default_rng(3))
    plant = Plant(replace(still, hidden=(hidden,)))
    bring_up(plant, 30.0, 0.0)
    before = plant.state
    rows = plant.step(commands(2.0, 30.0, 0.0))
    after = plant.state
    change = {name: after[name] - before[name] for name in ("work_motor", "work_load", "loss_gearbox", "loss_bearing")}
    given = change["work_motor"] + change["work_load"]
    assert given == pytest.approx(change["loss_gearbox"] + change["loss_bearing"], rel=0.02)
    torque = plant.truth.input_drive.polarity * float(rows["input_torque"].mean())
    assert change["work_motor"] == pytest.approx(torque * 30.0 * 2.0, rel=0.02)


def measured(plant: Plant) -> dict[str, NDArray[np.float64]]:
    """Bring a plant to motion under load, through a reversal; the channels of a second of it."""
    plant.step(ramped(0.6, 0.0, -60.0, 0.0, -500.0))
    plant.step(ramped(0.6, -60.0, 30.0, -500.0, 400.0))
    plant.step(commands(0.8, 30.0, 400.0))
    rows = plant.step(commands(1.0, 30.0, 400.0))
    truth = plant.truth
    revolution = 2.0 * np.pi
    theta = rows["input_position"] * revolution / 2.0**truth.input_encoder.bits / truth.gearbox.ratio
    q = truth.load_drive.polarity * rows["load_position"] * revolution / 2.0**truth.load_encoder.bits
    sensor = truth.torque_sensor
    return {
        "transmission_error": q - theta,
        "motor_torque": truth.input_drive.polarity * rows["input_torque"],
        "load_torque": rows["torque_adc"] * sensor.rated_torque / sensor.full_scale_counts,
        "temperature": np.full(rows.size, plant.state["sensed_temperature"]),
    }


@pytest.mark.parametrize("kind", [name for name in KINDS if name not in ELSEWHERE])
def test_what_is_told_of_a_kind_is_what_is_measured(
    truth: PlantTruth, still: PlantTruth, tmp_path: Path, kind: str
) -> None:
    """The difference to the same bench without it is what the ledger says, in the channel where it shows most."""
    hidden = Hidden(kind, SHORT[kind]) if kind in SHORT else draw(kind, np.random.default_rng(11))
    if kind == "resonance":
        still = replace(still, transmission_error=truth.transmission_error)
    ledger = tmp_path / "ledger"
    with_it = Plant(replace(still, hidden=(hidden,), ledger=str(ledger)), seed=1)
    found, plain = measured(with_it), measured(Plant(still, seed=1))
    channel = hidden.definition.channel
    ledger_values = read_ledger(ledger, 1)["shown"][-2000 // EVERY :, 0, SHOWN.index(channel)].astype(np.float64)
    difference = found[channel] - plain[channel]
    floor = {"transmission_error": 2e-8, "motor_torque": 2e-3, "load_torque": 0.3, "temperature": 1e-6}[channel]
    if channel == "temperature":
        assert difference[-1] == pytest.approx(ledger_values[-1], rel=0.1, abs=floor)
    elif kind in SCATTER:
        assert np.std(difference) == pytest.approx(np.std(ledger_values), rel=0.3, abs=floor)
    else:
        assert np.mean(difference) == pytest.approx(np.mean(ledger_values), rel=0.12, abs=floor)
    assert np.max(np.abs(ledger_values)) > 2.0 * floor


TWISTS = [name for name in KINDS if FIRST <= NUMBER[name] <= LAST]


@pytest.mark.parametrize("load", [0.0, 300.0, 900.0])
@pytest.mark.parametrize("kind", [*TWISTS, "hardening backwards"])
def test_no_twist_shakes_the_bench_by_itself(truth: PlantTruth, kind: str, load: float) -> None:
    """The largest of a kind over the least torque: at constant set values the spring's torque stays as quiet."""
    name = kind.split()[0]
    (size, *others) = RANGES[name]
    values = (-size[1] if kind != name else size[1], *(low for low, _ in others))

    def scatter(hidden: tuple[Hidden, ...]) -> float:
        plant = Plant(replace(truth, ripple=(), hidden=hidden), seed=2)
        bring_up(plant, 20.0, load)
        torques = []
        for _ in range(400):
            plant.step(commands(0.001, 20.0, load))
            torques.append(plant.state["torque"])
        return float(np.std(torques))

    assert scatter((Hidden(name, values),)) < 2.0 * scatter(())


def test_the_inertias_take_what_shakes_them_fast(still: PlantTruth) -> None:
    """24 waves a turn at 30 rad/s are 115 Hz: the velocity loop answers a part of the motor's ripple only."""
    found, plain = (
        measured(Plant(replace(still, hidden=hidden), seed=1)) for hidden in ((Hidden("ripple", (0.1, 0.4)),), ())
    )
    assert 0.005 < np.std(found["motor_torque"] - plain["motor_torque"]) < 0.05
    # an open coupling's worth of torque stays behind where the machine next door shakes the load motor
    shaken = measured(Plant(replace(still, hidden=(Hidden("floor", (6.0, 5.0)),)), seed=1))
    assert np.std(shaken["load_torque"] - plain["load_torque"]) == pytest.approx(6.0 / np.sqrt(2.0), rel=0.1)


def test_a_delay_is_whole_cycles_of_the_torque_channel(still: PlantTruth) -> None:
    rows = [ramped(0.4, 0.0, 30.0, 0.0, 900.0), ramped(0.4, 30.0, 30.0, 900.0, -900.0)]
    late, prompt = Plant(replace(still, hidden=(Hidden("delay", (7.0,)),)), seed=1), Plant(still, seed=1)
    for each in (late, prompt):
        each.step(rows[0])
    after, before = late.step(rows[1])["torque_adc"], prompt.step(rows[1])["torque_adc"]
    np.testing.assert_array_equal(after[7:], before[:-7])


def test_all_kinds_of_the_vocabulary_and_many_that_no_name_fits() -> None:
    effects = [kind.effect for kind in KINDS.values()]
    assert effects.count("unknown") >= 10
    assert set(RANGES) == set(KINDS)
    assert all(len(RANGES[name]) == len(kind.parameters) for name, kind in KINDS.items())


def test_ledger_rows_stand_at_their_cycles_after_a_replay(truth: PlantTruth, tmp_path: Path) -> None:
    path = tmp_path / "ledger"
    plant = Plant(replace(truth, hidden=(draw("stribeck", np.random.default_rng(3)),), ledger=str(path)), seed=9)
    plant.step(ramped(0.1, 0.0, 30.0, 0.0, 500.0))
    token = plant.snapshot()
    plant.step(ramped(0.1, 30.0, -60.0, 500.0, 0.0))
    plant.restore(token)
    rows = plant.step(commands(0.1, 30.0, 500.0))
    ledger = read_ledger(path, 1)
    np.testing.assert_array_equal(ledger["load_position"][200 // EVERY :], rows["load_position"][::EVERY])


def test_a_drawn_plant_is_its_seed_s(truth: PlantTruth) -> None:
    first, again, other = (draw_plant(truth, seed, 2) for seed in (5, 5, 6))
    assert (first.hidden, first.friction) == (again.hidden, again.friction)
    assert first.hidden != other.hidden
    assert not draw_plant(truth, 5, 0).hidden


def test_a_plant_file_may_switch_kinds_on(tmp_path: Path) -> None:
    source = Path(__file__).parents[3] / "fakes" / "plants" / "rh380n.toml"
    path = tmp_path / "plant.toml"
    row = '\n[[hidden]]\nkind = "dahl"\namplitude = 0.2\nangle = 2.0\n'
    path.write_text(source.read_text(encoding="utf-8") + row, encoding="utf-8")
    assert read_plant(path).hidden == (Hidden("dahl", (0.2, 2.0)),)
    for old, new, message in (("dahl", "dal", "kind must be"), ("angle", "reach", "has the parameters")):
        path.write_text(source.read_text(encoding="utf-8") + row.replace(old, new), encoding="utf-8")
        with pytest.raises(PlantError, match=message):
            read_plant(path)
