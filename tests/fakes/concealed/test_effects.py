from __future__ import annotations

import numpy as np
import pytest

from fakes.concealed import GROUPS, cases, vocabulary
from fakes.concealed.campaign import Campaign
from fakes.concealed.design import Design, draw_points
from fakes.concealed.effects import kernels
from fakes.concealed.effects.formula import FORMS
from fakes.concealed.exam import CONFUSIONS
from fakes.concealed.plant import draw_plant
from fakes.concealed.strength import calibrate, measure, strength

SMALL = Design(grid=6, validation=2, anchors=1, levels=2, transients=(1, 1, 1), speeds=(7.5, 10.0), heat_time=90.0)


def small_campaign(effect: object = None, seed: int = 3) -> Campaign:
    rng = np.random.default_rng(seed)
    plant = draw_plant(rng)
    points = tuple(draw_points(SMALL, rng))
    return Campaign(plant, (effect,) if effect is not None else (), points, seed)  # type: ignore[arg-type]


def test_every_vocabulary_effect_has_a_form() -> None:
    assert len(vocabulary()) == 29
    assert len([f for f in FORMS if f.effect == "unknown"]) >= 10
    assert len({f.effect for f in FORMS if f.held_back}) >= 20


@pytest.mark.parametrize("chosen", FORMS, ids=lambda f: f"{f.effect}: {f.name}")
def test_every_form_shows_in_its_first_channel(chosen) -> None:
    effect = chosen.make(np.random.default_rng(5))
    campaign = small_campaign(effect)
    largest = 0.0
    for signals in campaign.run(25.0, angle=False):
        assert all(np.isfinite(part).all() for part in signals.added.values())
        if effect.channels[0] == "temperature":
            largest = 1.0
        else:
            largest = max(largest, float(np.abs(signals.added[effect.channels[0]]).max()))
    assert largest > 0.0


@pytest.mark.parametrize("name", ["friction.stribeck", "te.sideband", "te.resonance"])
def test_without_the_load_angle_effects_add_the_same(name: str) -> None:
    """Those that modulate the series as well as those that leave it alone."""
    campaign = small_campaign(next(f for f in FORMS if f.effect == name).make(np.random.default_rng(5)))
    for whole, part in zip(campaign.run(25.0), campaign.run(25.0, angle=False), strict=True):
        assert np.isfinite(whole.load_angle).all()
        assert np.isnan(part.load_angle).all()
        assert all(np.array_equal(whole.added[channel], part.added[channel]) for channel in whole.added)


@pytest.mark.parametrize("name", ["thermal.sensor_lag", "thermal.second_mass", "thermal.ambient_drift"])
def test_thermal_effects_change_the_course_of_temperature(name: str) -> None:
    effect = next(f for f in FORMS if f.effect == name).make(np.random.default_rng(5))
    plain = [s.probe for s in small_campaign().run(10.0)]
    changed = [s.probe for s in small_campaign(effect).run(10.0)]
    assert max(float(np.abs(a - b).max()) for a, b in zip(plain, changed, strict=True)) > 0.1


def test_nominal_plant_leaves_no_excess() -> None:
    campaign = small_campaign()
    assert np.abs(measure(campaign, "motor_torque")).max() == 0.0
    assert np.abs(measure(campaign, "temperature")).max() < 2e-3


def test_strength_hits_its_target() -> None:
    effect = next(f for f in FORMS if f.effect == "friction.stribeck").make(np.random.default_rng(5))
    campaign = small_campaign(effect)
    reached, excess = calibrate(campaign, effect, 0.7, 0.05)
    assert reached == pytest.approx(0.7, rel=0.06)
    assert strength(excess.values, 0.05) == pytest.approx(reached)


def test_what_the_nominal_absorbs_has_no_strength() -> None:
    effect = next(f for f in FORMS if f.effect == "friction.viscous_quadratic").make(np.random.default_rng(5))
    effect.shape["power"] = 1.0
    excess = measure(small_campaign(effect), "motor_torque")
    assert strength(excess, 0.05) < 5e-3


@pytest.mark.parametrize("name", ["eddy-current drag of the load motor", "arm behind the torque sensor"])
def test_what_the_load_side_adds_behind_the_sensor_heats_nothing(name: str) -> None:
    """The torque sensor tells all that leaves the gearbox, so that the loss is that of the recorded torques."""
    effect = next(f for f in FORMS if f.name == name).make(np.random.default_rng(5))
    campaign = small_campaign(effect)
    for signals in campaign.run(25.0):
        run = signals.run
        sensed = signals.load_torque - campaign.plant.load_zero
        loss = np.abs(run.motor_torque * run.motor_rate - sensed * run.rate)
        np.testing.assert_allclose(signals.power, loss, atol=1e-9)


def test_campaign_is_the_same_at_any_rate() -> None:
    slow, fast = (list(small_campaign().run(rate)) for rate in (25.0, 50.0))
    for a, b in zip(slow, fast, strict=True):
        assert a.run.time[-1] == pytest.approx(b.run.time[-1], abs=1.0)
        assert a.probe[-1] == pytest.approx(b.probe[-1], abs=0.05)


def test_hysteresis_elements_remember() -> None:
    up, down = np.linspace(0.0, 500.0, 200), np.linspace(500.0, 0.0, 200)
    state = np.zeros(5)
    breaks, weights = np.array([50.0, 100.0, 150.0, 200.0]), np.full(4, 0.25)
    rising = kernels.maxwell_slip(up, breaks, weights, state)
    falling = kernels.maxwell_slip(down, breaks, weights, state)
    assert rising[-1] == pytest.approx(1.0)
    assert falling[100] < rising[100] - 0.5
    bouc = np.zeros(2)
    risen = kernels.bouc_wen(up, 80.0, 0.55, 1.4, bouc)
    assert 0.97 < risen[-1] <= 1.0
    assert kernels.bouc_wen(down, 80.0, 0.55, 1.4, bouc)[-1] < -0.9


def test_dahl_turns_within_its_reach() -> None:
    state = np.zeros(2)
    kernels.duhem(np.linspace(0.0, 1.0, 500), 0.02, state)
    back = kernels.duhem(np.linspace(1.0, 0.9, 500), 0.02, state)
    assert back[0] > 0.95
    assert back[-1] < -0.95


@pytest.mark.parametrize("group", GROUPS)
def test_cases_are_reproducible_and_named_once(group: str) -> None:
    first, again = list(cases(group, 4)), list(cases(group, 4))
    assert first == again
    assert len({case.name for case in first}) == len(first) > 0
    assert [case.seed for case in first] != [case.seed for case in cases(group, 5)]


def test_held_back_forms_stay_out_of_tuning_sets() -> None:
    for group in ("clear", "faint", "compound", "unknown"):
        assert not any(f.held_back for case in cases(group, 1) for f in case.forms)
    assert any(f.held_back for case in cases("clear", 1, held_back=True) for f in case.forms)


@pytest.mark.parametrize("pair", CONFUSIONS[1:4], ids=lambda p: p.effect)
def test_designs_cannot_tell_their_pair_apart(pair) -> None:
    rng = np.random.default_rng(11)
    plant = draw_plant(rng)
    points = tuple(draw_points(pair.design, rng))

    def excess(effect) -> np.ndarray:
        return measure(Campaign(plant, (effect,), points, 7), effect.channels[0], 20.0)

    own = next(f for f in FORMS if (f.effect, f.name) == (pair.effect, pair.form)).make(np.random.default_rng(1))
    own.shape.update(pair.shape)
    mine = excess(own)
    overlaps = []
    for rival in (f for f in FORMS if f.effect == pair.also[0]):
        other = excess(rival.make(np.random.default_rng(2)))
        overlaps.append(float((mine @ other) ** 2 / (mine @ mine) / (other @ other)))
    assert max(overlaps) > 0.9


def test_every_effect_that_can_has_forms_in_the_library_and_not_in_it() -> None:
    kept = {f.effect for f in FORMS if f.in_library}, {f.effect for f in FORMS if not f.in_library}
    one_law_only = {"sensor.motor_encoder", "sensor.torque_gain", "sensor.timing_skew", "load.unbalance"}
    assert set(vocabulary()) - kept[1] == one_law_only | {"thermal.second_mass"}
    assert set(vocabulary()) - kept[0] == set()
    shown = [f for f in FORMS if not f.held_back and f.effect not in one_law_only]
    assert sum(not f.in_library for f in shown) >= 25


def drawn(name: str, seed: int = 5):
    return next(f for f in FORMS if f.name == name).make(np.random.default_rng(seed))


def friction_of(effect, rate: float = 25.0) -> list[tuple]:
    return [(s.run, s.added["motor_torque"]) for s in small_campaign(effect).run(rate)]


def test_grease_breaks_down_in_motion_and_heals_at_rest() -> None:
    effect = drawn("thixotropic grease")
    first = []
    for run, drag in friction_of(effect):
        moving = run.sign != 0.0
        if run.point.kind == "constant_velocity" and moving.any():
            size = np.abs(drag[moving]) / effect.amplitude
            first.append(size[0])
            assert size[-1] < 0.35 * size[0]
    assert np.median(first) > 0.2


def test_a_seal_dries_at_rest_and_wets_over_a_distance() -> None:
    effect = drawn("seal that wets")
    starts = []
    for run, drag in friction_of(effect):
        moving = np.flatnonzero(run.sign != 0.0)
        if run.point.kind == "constant_velocity" and moving.size:
            starts.append(abs(drag[moving[0]]) / effect.amplitude)
            turned = run.travel[moving[-1]] - run.travel[moving[0]]
            expected = starts[-1] * effect.amplitude * np.exp(-turned / effect.shape["reach"])
            assert abs(drag[moving[-1]]) == pytest.approx(expected, rel=0.1, abs=1e-6)
    assert max(starts) > 0.1


def test_stick_slip_is_at_low_speed_and_has_no_order() -> None:
    effect = drawn("stick–slip of a scraper")
    for run, drag in friction_of(effect, 100.0):
        assert np.abs(drag[np.abs(run.rate) > 1.05 * effect.shape["limit"]]).max(initial=0.0) == 0.0
    turns = [np.flatnonzero(np.diff(drag) < -0.5 * effect.amplitude) for _run, drag in friction_of(effect, 100.0)]
    ways = np.concatenate(
        [np.diff(run.travel[at]) for (run, _d), at in zip(friction_of(effect, 100.0), turns, strict=True)]
    )
    assert np.std(ways) > 0.1 * np.mean(ways)


def test_play_knocks_only_where_the_torque_crosses_zero() -> None:
    effect = drawn("play knocks where the load torque crosses zero")
    rang = {run.point.kind: float(np.abs(drag).max()) for run, drag in friction_of(effect, 100.0)}
    assert rang["torque_ramp"] > 0.3 * effect.amplitude
    for run, drag in friction_of(effect, 100.0):
        if np.abs(run.command).min() > 20.0:
            assert np.abs(drag).max() == 0.0


def test_preload_follows_the_rate_of_warming() -> None:
    parts = friction_of(drawn("bearing preload while it warms"))
    warming = [float(np.abs(drag).max()) for run, drag in parts if run.point.kind == "heating"]
    steady = [float(np.abs(drag).max()) for run, drag in parts if run.point.kind == "constant_velocity"]
    assert max(warming) > 2.0 * np.median(steady)


def test_two_lags_show_later_than_one() -> None:
    one, two = drawn("first order"), drawn("sheath and element")
    two.amplitude = one.amplitude
    assert len(two.probe_lags()) == 2
    shown = [next(s.probe for s in small_campaign(e).run(10.0) if s.run.point.kind == "heating") for e in (one, two)]
    assert np.all(shown[1] <= shown[0] + 1e-9)
    assert np.max(shown[0] - shown[1]) > 0.02


def test_the_very_order_is_modulated_in_its_own_phase() -> None:
    effect = drawn("the very order modulated")
    for signals in small_campaign(effect).run(50.0):
        if signals.run.point.kind != "constant_velocity":
            continue
        theta, extra = signals.run.theta, signals.added["transmission_error"]
        sides = [abs(np.mean(extra * np.exp(-1j * k * theta))) for k in effect.location().orders]
        beside = abs(np.mean(extra * np.exp(-1j * (effect.shape["f"] + 20.3) * theta)))
        assert min(sides) > 0.0
        assert max(sides) > 3.0 * beside


def test_a_few_cases_of_a_group_are_drawn_by_the_seed() -> None:
    few = [[case.name for case in cases("clear", seed, 5)] for seed in range(6)]
    assert all(len(set(names)) == 5 for names in few)
    assert len({name for names in few for name in names}) > 12
    assert list(cases("clear", 1, 5)) == [c for c in cases("clear", 1) if c.name in few[1]]
