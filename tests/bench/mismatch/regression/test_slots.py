"""A name that a free function leaves no probability is not told."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from bench.mismatch import criteria
from bench.mismatch.regression import slots, succession
from bench.mismatch.regression.beside import in_its_form, shaped
from bench.mismatch.regression.equivalent import heirs_of, holds, predict_alike
from bench.mismatch.regression.heredity import without_laws
from bench.mismatch.regression.model import Block, Chosen, add_block
from bench.mismatch.regression.regressors import Free, Named, Regressor, named
from bench.mismatch.regression.search import begun
from bench.mismatch.regression.slots import Contender, Slot, called_as_good
from bench.mismatch.regression.succession import (
    _by_chance,
    _disowned,
    _drawn_by_the_unknown,
    _part_of_the_unknown,
    _plainest_first,
    _simpler,
    _succession,
    without_empty_laws,
)
from bench.simulation.tables import Grid
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE, TEMPERATURE
from tests.bench.mismatch.regression.synthetic import campaign, problem
from tests.bench.mismatch.regression.test_free_motion import COULOMB, INERTIA, VISCOUS, asked, free, noise, swinging

DRAG = "friction.viscous_quadratic"
FORMS = {form.name: form for form in LIBRARY[DRAG].forms[MOTOR_TORQUE]}


def chosen(effect: str) -> Chosen:
    """An effect of the temperature's, or a function without a name."""
    regressor: Regressor
    if effect == "unknown":
        regressor = Free(TEMPERATURE, ())
    else:
        term = LIBRARY[effect]
        regressor = Named(term, TEMPERATURE, term.forms[TEMPERATURE][0])
    return Chosen(Block(regressor, (), np.zeros(0)))


def contender(effect: str, weight: float) -> Contender:
    """An alternative of that weight."""
    return Contender(chosen(effect), np.zeros(0), 0.0, 1.0, weight, True)


@pytest.mark.parametrize(
    ("effect", "weight", "others", "disowned"),
    [
        ("thermal.convection_speed", 0.04, (("unknown", 0.96),), True),
        ("thermal.convection_speed", 0.30, (("unknown", 0.70),), False),
        # two names that share their probability are still names
        ("thermal.convection_speed", 0.10, (("thermal.second_mass", 0.30), ("unknown", 0.60)), False),
        ("unknown", 0.04, (("unknown", 0.96),), False),
        # a term of the nominal simulation that was switched off is known to be there
        ("thermal.convection", 0.04, (("unknown", 0.96),), False),
    ],
)
def test_who_is_disowned(effect: str, weight: float, others: tuple[Any, ...], disowned: bool) -> None:
    alternatives = tuple(contender(name, share) for name, share in others)
    slot = Slot(chosen(effect), 10.0, 0.001, weight, alternatives)
    nameless = max((r for r in alternatives if r.chosen.effect == "unknown"), key=lambda r: cast("float", r.weight))
    assert _disowned(slot, nameless) is disowned
    assert not _disowned(slot, None)


@pytest.mark.parametrize(("weight", "gone"), [(0.02, True), (0.4, False)])
def test_of_two_functions_without_a_name_the_likelier_stays(weight: float, gone: bool) -> None:
    slot = Slot(chosen("unknown"), 10.0, 0.001, weight, (contender("unknown", 0.95 - weight),))
    own = cast("Any", SimpleNamespace(chosen=[slot.chosen], problem=SimpleNamespace(lacking=(), free=False)))
    expected = [slot.alternatives[0].chosen] if gone else None
    assert _succession(own, slot) == expected


@pytest.mark.parametrize(
    ("effect", "beside", "surely", "part"),
    [
        ("thermal.convection_speed", "unknown", False, True),
        ("thermal.convection_speed", "unknown", True, False),
        ("thermal.convection_speed", "thermal.second_mass", False, False),
        # the simulation has it: that it is asked for is no surprise
        ("thermal.convection", "unknown", False, False),
        ("unknown", "unknown", False, False),
    ],
)
def test_a_name_beside_unknown_physics_has_to_beat_a_free_function(
    effect: str, beside: str, surely: bool, part: bool
) -> None:
    own, other = chosen(effect), chosen(beside)
    model = cast("Any", SimpleNamespace(chosen=[own, other] if effect != "unknown" else [own]))
    nameless = Contender(chosen("unknown"), np.zeros(0), 15.0, 10.0, 0.1, False, surely_worse=surely)
    assert _part_of_the_unknown(model, Slot(own, 50.0, 0.001, 0.9, (nameless,)), nameless) is part


@pytest.mark.parametrize(
    ("over", "times", "drawn"),
    [(("speed",), "d", True), (("speed",), "1", False), (("temperature",), "d", False)],
)
def test_a_function_of_the_speed_draws_any_stribeck_curve(over: tuple[str, ...], times: str, drawn: bool) -> None:
    curve = Chosen(Block(named("friction.stribeck", MOTOR_TORQUE, "gaussian", (5.0,)), (), np.zeros(0)))
    table = Chosen(Block(Free(MOTOR_TORQUE, (Grid(over, times, ((0.0, 1.0),)),)), (), np.zeros(0)))
    model = cast("Any", SimpleNamespace(chosen=[curve, table], channel=MOTOR_TORQUE))
    assert _drawn_by_the_unknown(model, curve) is drawn
    assert not _drawn_by_the_unknown(model, table)
    assert not _drawn_by_the_unknown(cast("Any", SimpleNamespace(chosen=[curve], channel=MOTOR_TORQUE)), curve)


@pytest.mark.parametrize(("part", "heirs"), [(0.02, {1: 0}), (0.6, {})])
def test_a_function_gives_way_to_the_name_that_it_says_but_for_a_trifle(part: float, heirs: dict[int, int]) -> None:
    """A gain error, larger in one direction by twice a ``part``: too little to be told, or a matter of its own."""
    frame = campaign()
    rng = np.random.default_rng(1)
    gain = 0.01 * frame.torque / frame.ratio * (1.0 + part * frame.direction)
    y = 0.5 * frame.direction + 0.006 * frame.omega + gain
    search = begun(problem(frame, np.asarray(y + rng.normal(0.0, 0.01, frame.size))))
    name = shaped(search, [], named("motor.torque_constant", MOTOR_TORQUE, "gain", ()))
    assert name is not None
    table = Free(
        MOTOR_TORQUE, tuple(Grid(("torque",), way, (tuple(np.linspace(-1000, 1000, 5)),)) for way in ("p", "n"))
    )
    own = Chosen(add_block(search.model.problem, search.bank, table, 1e-3))
    assert heirs_of(search.model, [], (replace(name, shape=None), own))[0] == heirs


@pytest.mark.parametrize(
    ("largest", "heirs", "needless"), [(100.0, {1: 0}, False), (1.0, {}, False), (1e5, {1: 0}, True)]
)
def test_the_plainer_name_stands_where_no_transducer_tells_the_two_apart(
    largest: float, heirs: dict[int, int], needless: bool
) -> None:
    """Drag with the speed to the power of 2.05, next to no noise: the recordings are sure that it is not 2."""
    frame = campaign()
    omega = frame.omega
    rng = np.random.default_rng(1)
    drag = 0.5 * frame.direction + 0.006 * omega + 4e-4 * np.sign(omega) * np.abs(omega) ** 2.05
    frame = replace(frame, motor_torque=np.full(frame.size, largest))
    search = begun(problem(frame, np.asarray(drag + rng.normal(0.0, 1e-5, frame.size))))
    square, power = (
        shaped(search, [], Named(LIBRARY[DRAG], MOTOR_TORQUE, form, point))
        for form, point in ((FORMS["square"], ()), (FORMS["power"], (2.05,)))
    )
    assert square is not None
    assert power is not None
    square, power = replace(square, shape=None), replace(power, shape=None)
    assert float((search.density([power]) - search.density([square])).sum()) > 10.0
    assert heirs_of(search.model, [], (square, power)) == (heirs, needless)


@pytest.mark.parametrize(
    ("richer", "form", "point", "plain", "inside"),
    [
        ("motor.torque_constant", "cubic", (0.0,), "sensor.torque_gain", True),
        ("friction.position_dependent", "constant", (1.0,), "load.unbalance", False),
        ("friction.stribeck", "gaussian", (8.0,), DRAG, False),
    ],
)
def test_two_effects_are_one_only_where_one_is_a_case_of_the_other(
    richer: str, form: str, point: tuple[float, ...], plain: str, inside: bool
) -> None:
    """In one direction an unbalance and a friction over the angle are alike to rounding, and still two things."""
    frame = campaign()
    frame = frame.take(frame.direction > 0.0)
    own = problem(frame, np.zeros(frame.size))

    def alone(effect: str, form: str, point: tuple[float, ...]) -> Chosen:
        term = LIBRARY[effect]
        chosen = next((f for f in term.forms[MOTOR_TORQUE] if f.name == form), term.forms[MOTOR_TORQUE][0])
        return Chosen(Block(Named(term, MOTOR_TORQUE, chosen, point), (), np.zeros(0)))

    assert holds(own, alone(richer, form, point), alone(plain, "", ())) is inside


@pytest.mark.parametrize(("viscous", "effects"), [(0.0, ["unknown"]), (VISCOUS, ["friction.viscous", "unknown"])])
def test_a_law_of_no_size_is_not_reported_for_the_sake_of_its_change(viscous: float, effects: list[str]) -> None:
    frame = swinging()
    frame = replace(frame, aux={"pressure": np.sin(0.37 * frame.time)})
    torque = COULOMB * frame.direction + INERTIA * frame.acceleration + noise(frame)
    torque = torque + (viscous + 0.02 * frame.aux["pressure"]) * frame.omega
    search = begun(asked(frame, torque, "friction.coulomb", "motor.inertia", lacking=("friction.viscous",)))
    model = search.model
    law = named("friction.viscous", MOTOR_TORQUE, LIBRARY["friction.viscous"].forms[MOTOR_TORQUE][0].name, ())
    change = without_laws(free("aux/pressure", "w", -1.0, 0.0, 1.0), frame)
    both = [Chosen(add_block(model.problem, search.bank, own)) for own in (law, change)]
    search.model = replace(model, chosen=both, fit=model.refitted(both), price=3.0)
    left = without_empty_laws(search, [Slot(own, 10.0, 0.001, 0.9, ()) for own in both])
    assert [slot.chosen.effect for slot in left] == effects
    assert [own.effect for own in search.model.chosen] == effects


@pytest.mark.parametrize(
    ("other", "odds", "loss", "surely", "as_good"),
    [
        ("thermal.second_mass", 0.3, 8.0, True, True),
        # forty to one, but the forms of two names differ by as much from nature's
        ("thermal.second_mass", 0.025, 3.7, True, True),
        ("thermal.second_mass", 0.006, 5.1, True, False),
        # a few points make such a difference by chance
        ("thermal.second_mass", 0.006, 7.0, False, True),
        ("thermal.second_mass", 0.006, 11.0, False, False),
        # a function without a name has no form that could be another
        ("unknown", 0.025, 3.7, False, False),
        ("unknown", 0.3, 1.2, True, True),
    ],
)
def test_who_is_as_good(other: str, odds: float, loss: float, surely: bool, as_good: bool) -> None:
    assert called_as_good(chosen("thermal.convection_speed"), chosen(other), odds, loss, surely) is as_good


def test_of_a_name_at_the_end_of_its_range_chance_tells_no_other_apart() -> None:
    own, other = chosen("thermal.second_mass"), chosen("thermal.convection_speed")
    assert not called_as_good(own, other, 0.006, 16.0, surely=False)
    assert called_as_good(own, other, 0.006, 16.0, surely=False, at_its_end=True)
    assert not called_as_good(own, other, 0.006, 16.0, surely=True, at_its_end=True)
    assert not called_as_good(own, chosen("unknown"), 0.006, 16.0, surely=False, at_its_end=True)


@pytest.mark.parametrize(("worth", "taken"), [((10.0, 9.0), 1), ((10.0, 4.0), 0), ((9.0, 10.0), 1)])
def test_a_name_meets_an_effect_in_a_form_of_which_the_effect_is_no_case(
    monkeypatch: pytest.MonkeyPatch, worth: tuple[float, float], taken: int
) -> None:
    """A cubic with a linear part says what a gain error says and more; the cubic alone is another explanation."""
    forms = [chosen("thermal.second_mass"), chosen("thermal.second_mass")]
    monkeypatch.setattr(slots, "holds", lambda _problem, form, _own: form is forms[0])
    search = SimpleNamespace(model=SimpleNamespace(problem=None))
    assert slots._meeting(cast(Any, search), chosen("thermal.convection_speed"), forms, np.array(worth)) == taken


@pytest.mark.parametrize(("bent", "corrected"), [(0.0, False), (0.08, True)])
def test_a_form_is_corrected_where_the_recordings_ask_for_it(bent: float, corrected: bool) -> None:
    """A drag with the square of the speed as it is, and one that falls off at the highest speeds."""
    frame = campaign()
    size = np.abs(frame.omega)
    drag = 0.5 * frame.direction + 0.006 * frame.omega + 1e-4 * frame.omega * size * (1.0 - bent * np.sqrt(size))
    drag = drag + np.random.default_rng(4).normal(0.0, 1e-4, frame.size)
    search = begun(problem(frame, np.asarray(drag)))
    own = shaped(search, [], Named(LIBRARY[DRAG], MOTOR_TORQUE, FORMS["square"], ()))
    assert own is not None
    assert own.shape is not None
    assert (in_its_form(search, [], own, search.density([own]))[0].shape is not None) is corrected


def test_two_names_are_told_apart_with_their_corrections_and_without() -> None:
    """A correction is a share of what the simulation cannot say, and does not reach the other's form."""
    frame = campaign()
    size = np.abs(frame.omega)
    drag = 0.5 * frame.direction + 0.006 * frame.omega + 4e-4 * frame.direction * size**1.8
    drag = drag + np.random.default_rng(5).normal(0.0, 0.005, frame.size)
    search = begun(problem(frame, np.asarray(drag)))
    stribeck = LIBRARY["friction.stribeck"]
    form = next(f for f in stribeck.forms[MOTOR_TORQUE] if f.name == "slow_rational")
    both = (
        shaped(search, [], Named(LIBRARY[DRAG], MOTOR_TORQUE, FORMS["power"], (1.8,))),
        shaped(search, [], Named(stribeck, MOTOR_TORQUE, form, (5.0,))),
    )

    def loss(first: Chosen | None, second: Chosen | None) -> float:
        assert first is not None
        assert second is not None
        return float((search.density([first]) - search.density([second])).sum())

    assert loss(*both) > 2.0 * criteria.VERY_STRONG
    formed = [in_its_form(search, [], own, search.density([own]))[0] for own in both if own is not None]
    assert loss(*formed) >= loss(*both)


@pytest.mark.parametrize(("other", "taken"), [(0.9, True), (0.3, False)])
def test_a_name_gives_way_to_one_that_is_far_likelier(other: float, taken: bool) -> None:
    own = chosen("thermal.convection_speed")
    alternative = Contender(chosen("thermal.second_mass"), np.zeros(0), 2.0, 1.0, other, True)
    asked_of = SimpleNamespace(rows=SimpleNamespace(frame=None), lacking=(), free=False)
    model = SimpleNamespace(problem=asked_of, chosen=[own], channel=TEMPERATURE)
    found = _succession(cast("Any", model), Slot(own, 20.0, 1e-4, 0.95 - other, (alternative,)))
    assert found == ([alternative.chosen] if taken else None)


@pytest.mark.parametrize(
    ("loss", "error", "as_good", "handicap", "p_value", "taken"),
    [
        (1.7, 2.6, True, 0.0, 0.001, True),
        (3.0, 2.6, True, 0.0, 0.001, False),
        (-0.4, 0.1, True, 0.0, 0.001, True),
        (1.7, 2.6, False, 0.0, 0.001, False),
        # at the end of its range, or a loop that was never turned
        (1.7, 2.6, True, 3.0, 0.001, False),
        # by itself no more than chance
        (1.7, 2.6, True, 0.0, 0.02, False),
    ],
)
def test_of_names_that_are_as_good_the_one_with_fewer_numbers_is_told_first(
    monkeypatch: pytest.MonkeyPatch,
    loss: float,
    error: float,
    as_good: bool,
    handicap: float,
    p_value: float,
    taken: bool,
) -> None:
    cubic = Chosen(Block(named("sensor.torque_nonlinearity", MOTOR_TORQUE, "cubic", ()), (), np.zeros(0)))
    gain = Chosen(Block(named("sensor.torque_gain", MOTOR_TORQUE, "gain", ()), (), np.zeros(0)))
    monkeypatch.setattr(succession, "handicap_of", lambda _search, _chosen: handicap)
    asked: list[float] = []
    search = SimpleNamespace(scans=[SimpleNamespace(p_value=lambda gain: asked.append(gain) or p_value)])
    for tested, other, simpler in ((cubic, gain, taken), (gain, cubic, False)):
        slot = Slot(tested, 50.0, 1e-4, 0.5, (Contender(other, np.zeros(0), loss, error, 0.3, as_good),))
        found = _simpler(cast("Any", search), slot)
        assert (found is not None) is simpler
        assert found is None or found.chosen is other
    assert set(asked) <= {50.0 - loss}


@pytest.mark.parametrize(("kept", "first"), [(True, "sensor.torque_gain"), (False, "sensor.torque_nonlinearity")])
def test_the_name_with_fewer_numbers_comes_first_where_recordings_held_out_bear_it_out(
    monkeypatch: pytest.MonkeyPatch, kept: bool, first: str
) -> None:
    cubic = Chosen(Block(named("sensor.torque_nonlinearity", MOTOR_TORQUE, "cubic", ()), (), np.zeros(0)))
    gain = Chosen(Block(named("sensor.torque_gain", MOTOR_TORQUE, "gain", ()), (), np.zeros(0)))
    found = [Slot(cubic, 50.0, 1e-4, 0.5, (Contender(gain, np.zeros(0), 1.0, 2.0, 0.3, True),))]
    search = SimpleNamespace(model=SimpleNamespace(chosen=[cubic], refitted=lambda _: None), scans=[])
    monkeypatch.setattr(succession, "handicap_of", lambda _search, _chosen: 0.0)
    monkeypatch.setattr(succession, "replace", lambda old, **new: SimpleNamespace(**{**vars(old), **new}))
    monkeypatch.setattr(succession, "borne_out", lambda model: model.chosen if kept else [])
    monkeypatch.setattr(succession, "slots", lambda of: [Slot(c, 49.0, 1e-4, 0.4, ()) for c in of.model.chosen])
    told = _plainest_first(cast("Any", search), found)
    assert [slot.chosen.effect for slot in told] == [first]
    assert [c.effect for c in search.model.chosen] == [first]


@pytest.mark.parametrize(
    ("effect", "p_value", "gone"),
    [
        ("thermal.convection_speed", 0.4, True),
        ("thermal.convection_speed", 0.001, False),
        # a term of the nominal simulation that was switched off is known to be there
        ("thermal.convection", 0.4, False),
    ],
)
def test_what_gains_no_more_than_noise_beside_all_others_goes(effect: str, p_value: float, gone: bool) -> None:
    assert _by_chance(Slot(chosen(effect), 3.0, p_value, 0.9, ())) is gone


def test_what_gains_no_more_than_noise_goes_after_every_exchange(monkeypatch: pytest.MonkeyPatch) -> None:
    # found as a function, exchanged twice, and its last name is no more than chance
    effects = [chosen("unknown"), chosen("unknown"), chosen("thermal.convection_speed")]
    met = iter(effects)
    model = SimpleNamespace(chosen=[next(met)], refitted=lambda _: None)
    search = SimpleNamespace(model=model)
    monkeypatch.setattr(succession, "one_or_two", lambda _: None)
    monkeypatch.setattr(succession, "_name_by_course", lambda _: None)
    monkeypatch.setattr(succession, "_without_needless_corrections", lambda _: None)
    monkeypatch.setattr(succession, "no_mere_form", lambda _, found: found)
    monkeypatch.setattr(succession, "no_name_at_its_end", lambda _, found: found)
    monkeypatch.setattr(succession, "replace", lambda old, **new: SimpleNamespace(**{**vars(old), **new}))
    monkeypatch.setattr(succession, "slots", lambda of: [Slot(c, 3.0, 0.4, 0.9, ()) for c in of.model.chosen])
    monkeypatch.setattr(succession, "_least_sure", lambda _: None)
    monkeypatch.setattr(succession, "_succession", lambda _, slot: [] if slot.chosen is effects[-1] else [next(met)])
    assert succession._succeeded(cast("Any", search)) == []
    assert search.model.chosen == []


@pytest.mark.parametrize(("apart", "alike"), [(0.005, True), (0.02, False)])
def test_names_that_predict_alike_need_more_evidence(apart: float, alike: bool) -> None:
    rows = np.random.default_rng(2).normal(size=400)
    said = {"nothing": 0.0 * rows, "one": rows, "two": rows + apart * np.roll(rows, 1)}
    weighed = SimpleNamespace(rows=SimpleNamespace(frame=None, number=np.ones(400)), train=np.ones(400, dtype=bool))
    model = SimpleNamespace(
        problem=weighed,
        refitted=lambda own: None,
        predict=lambda _frame, own, _fit: said[own[-1] if own else "nothing"],
    )
    assert predict_alike(cast("Any", model), [], cast("Any", "one"), cast("Any", "two")) is alike
