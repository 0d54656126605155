"""What points left out say against an effect, and which of them are asked."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from bench.mismatch.regression import pruning, refuted
from bench.mismatch.regression.beside import shaped
from bench.mismatch.regression.equivalent import says_most_of
from bench.mismatch.regression.folds import carried
from bench.mismatch.regression.model import ChannelModel, Chosen, add_block
from bench.mismatch.regression.refuted import borne_out, not_refuted, worse_with
from bench.mismatch.regression.regressors import Free, named
from bench.mismatch.regression.search import begun
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.tables import Grid
from bench.simulation.terms import MOTOR_TORQUE
from tests.bench.mismatch.regression.synthetic import EACH, campaign, problem

WARM_UP = 23
PRESSURE: FloatArray = 3.0 + np.sin(0.21 * np.arange(24 * EACH))
"""of an oil, bar, at the rows of a campaign"""


def warmed() -> Frame:
    """A campaign whose last recording warms up, six times as fast as any other."""
    frame = campaign()
    fast = frame.recording == WARM_UP
    return replace(frame, velocity=np.where(fast, -1.0, frame.velocity))


def churning(frame: Frame, y: FloatArray) -> tuple[Search, Chosen]:
    """A search on measured values (n,), and churning as it finds it."""
    search = begun(problem(frame, y))
    found = shaped(search, [], named("friction.viscous_quadratic", MOTOR_TORQUE, "square"))
    assert found is not None
    search.model.price = search.scan([], search.model.fit).price
    return search, found


def measured(frame: Frame, seed: int) -> FloatArray:
    """Dry, viscous and churning friction with noise, and offsets of the recordings."""
    rng = np.random.default_rng(seed)
    omega = frame.omega
    drag = 0.5 * frame.direction + 0.006 * omega + 4e-6 * omega * np.abs(omega)
    return np.asarray(drag + rng.normal(0.0, 0.01, frame.size) + np.repeat(rng.normal(0.0, 0.02, 24), EACH))


def test_the_only_point_that_shows_an_effect_cannot_refute_it() -> None:
    frame = warmed()
    for seed in range(5):
        search, found = churning(frame, measured(frame, seed))
        model = search.model
        shares = carried(model.bank, model.blocks([found]), found.main, model.folds, model.refitted([found]))
        assert int(np.argmax(shares)) == WARM_UP
        assert shares[WARM_UP] > 0.9
        assert np.delete(shares, WARM_UP).max() < 0.5
        assert not_refuted(search.model, [found]) == [found]


def test_what_the_other_points_are_predicted_worse_with_is_not_told() -> None:
    """Drag that differs from point to point, and noise so small that a curve through it is sure of itself."""
    frame = campaign()
    rng = np.random.default_rng(3)
    noise = rng.normal(0.0, 0.001, frame.size) + np.repeat(rng.normal(0.0, 0.2, 24), EACH) * (frame.recording % 8 == 7)
    search, found = churning(frame, 0.5 * frame.direction + 0.006 * frame.omega + noise)
    search.model.variances = (1e-12,)
    assert found.shape is not None
    # a correction that may go wherever the fitted points lie
    wild = replace(found, shape=replace(found.shape, precision=1e-4 * found.shape.precision))
    assert not_refuted(search.model, [wild]) == []
    assert "not reported" in search.model.notes[-1]


@pytest.mark.parametrize("lasts", [True, False])
def test_a_function_without_a_name_that_recordings_held_out_do_not_bear_out_is_not_told(lasts: bool) -> None:
    frame = campaign()
    rng = np.random.default_rng(4)
    bump = 0.3 * np.exp(-(((frame.temperature - 30.0) / 3.0) ** 2)) * frame.direction
    out = frame.recording % 3 == 0
    y = 0.5 * frame.direction + 0.006 * frame.omega + rng.normal(0.0, 0.01, frame.size)
    y += bump if lasts else np.where(out, -bump, bump)
    own = replace(problem(frame, y), folds=np.where(np.arange(24) % 3 == 0, -1, np.arange(24)))
    search = begun(own)
    model = search.model
    free = Free(MOTOR_TORQUE, (Grid(("temperature",), "d", ((22.0, 26.0, 28.0, 30.0, 32.0, 34.0, 40.0),)),))
    table = Chosen(add_block(own, model.bank, free, 1e-3))
    model = replace(model, chosen=[table], fit=model.refitted([table]))
    assert borne_out(model) == ([table] if lasts else [])
    assert bool(model.notes) is not lasts


def with_two_tables(frame: Frame) -> tuple[ChannelModel, Chosen, Chosen]:
    """Dry friction with two functions of the temperature beside it; every third recording is held out."""
    y = 0.5 * frame.direction + np.random.default_rng(5).normal(0.0, 0.01, frame.size)
    own = replace(problem(frame, y), folds=np.where(np.arange(24) % 3 == 0, -1, np.arange(24)))
    model = begun(own).model
    knots = (22.0, 26.0, 30.0, 34.0, 40.0)
    tables = [Free(MOTOR_TORQUE, (Grid(("temperature",), times, (knots,)),)) for times in ("1", "d")]
    first, second = (Chosen(add_block(own, model.bank, table, 1e-3)) for table in tables)
    model = replace(model, chosen=[first, second], fit=model.refitted([first, second]))
    return model, first, second


def test_a_function_is_asked_again_without_the_one_that_made_up_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside the second the first does no harm; without it, it does."""
    frame = campaign()
    model, _, second = with_two_tables(frame)
    left = {2: 1.0, 1: 0.5, 0: 0.1}

    def remaining(_model: object, chosen: list[Chosen]) -> FloatArray:
        return np.full(frame.size, np.sqrt(1.1 if chosen == [second] else left[len(chosen)]))

    monkeypatch.setattr(refuted, "_left", remaining)
    assert borne_out(model) == []
    assert len(model.notes) == 2


@pytest.mark.parametrize("without_both", [0.9, 1.1])
def test_functions_that_only_make_up_for_each_other_are_not_told(
    without_both: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Either alone predicts worse than both, and nothing predicts better than both."""
    frame = campaign()
    model, first, second = with_two_tables(frame)
    left = {2: 1.0, 1: 2.0, 0: without_both}
    monkeypatch.setattr(refuted, "_left", lambda _model, chosen: np.full(frame.size, np.sqrt(left[len(chosen)])))
    assert borne_out(model) == ([] if without_both < 1.0 else [first, second])
    assert sum("together" in note for note in model.notes) == (without_both < 1.0)


def with_a_table(frame: Frame) -> tuple[ChannelModel, Chosen]:
    """Dry friction with a function of the temperature beside it; every third recording is held out."""
    y = 0.5 * frame.direction + np.random.default_rng(5).normal(0.0, 0.01, frame.size)
    own = replace(problem(frame, y), folds=np.where(np.arange(24) % 3 == 0, -1, np.arange(24)))
    model = begun(own).model
    table = Free(MOTOR_TORQUE, (Grid(("temperature",), "1", ((22.0, 26.0, 30.0, 34.0, 40.0),)),))
    one = Chosen(add_block(own, model.bank, table, 1e-3))
    model = replace(model, chosen=[one], fit=model.refitted([one]))
    return model, one


def with_churning(frame: Frame) -> tuple[ChannelModel, Chosen]:
    """The same dry friction with churning beside it."""
    model, _ = with_a_table(frame)
    churn = Chosen(add_block(model.problem, model.bank, named("friction.viscous_quadratic", MOTOR_TORQUE, "square")))
    return replace(model, chosen=[churn], fit=model.refitted([churn])), churn


def test_a_function_that_predicts_no_better_is_not_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a true one would be seen to predict better: as good as without it is not enough."""
    frame = campaign()
    model, one = with_a_table(frame)
    sign = np.resize([1.0, -1.0], frame.size)

    def remaining(better: float) -> object:
        return lambda _model, chosen: 1.0 + (0.1 * sign - better if chosen else np.zeros(frame.size))

    monkeypatch.setattr(refuted, "_left", remaining(0.0))
    assert borne_out(model) == []
    monkeypatch.setattr(refuted, "_left", remaining(0.02))
    assert borne_out(model) == [one]


@pytest.mark.parametrize(("beyond", "stays"), [(0.0, False), (2.0, True)])
def test_a_function_that_predicts_better_stays_where_more_than_noise_is_left(
    monkeypatch: pytest.MonkeyPatch, beyond: float, stays: bool
) -> None:
    """Better, but not by more than chance: enough where something is missing for certain."""
    frame = campaign()
    model, one = with_a_table(frame)
    sign = 0.1 * np.resize([1.0, -1.0], frame.size) + np.where(frame.recording % 2 == 0, 0.003, -0.003)
    left = model.floor * beyond * np.sin(2.0 * np.pi * np.arange(frame.size) / EACH)
    model = replace(
        model, problem=replace(model.problem, rows=replace(model.problem.rows, y=model.problem.rows.y + left))
    )

    def remaining(_model: object, chosen: list[Chosen]) -> FloatArray:
        return np.asarray(1.0 + (sign - 0.0052 if chosen else np.zeros(frame.size)))

    monkeypatch.setattr(refuted, "_left", remaining)
    assert borne_out(model) == ([one] if stays else [])


def test_a_function_that_predicts_worse_is_not_told_however_little_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each recording differs by more than all together: that they come out worse still speaks against the function."""
    frame = campaign()
    model, one = with_a_table(frame)
    sign = np.where(frame.recording % 2 == 0, 1.0, -1.0)

    def remaining(better: float) -> object:
        return lambda _model, chosen: 1.0 + (0.01 * sign - better if chosen else np.zeros(frame.size))

    monkeypatch.setattr(refuted, "_left", remaining(-0.001))
    assert borne_out(model) == []
    monkeypatch.setattr(refuted, "_left", remaining(0.001))
    assert borne_out(model) == [one]


def with_a_pressure(drag: FloatArray | float = 0.0) -> tuple[ChannelModel, Chosen]:
    """Dry friction and a ``drag`` (n,) with a function of an oil pressure beside it; every third recording is held
    out.
    """
    frame = campaign()
    frame = replace(frame, aux={"oil": PRESSURE})
    y = 0.5 * frame.direction + drag + np.random.default_rng(5).normal(0.0, 0.01, frame.size)
    own = replace(problem(frame, y), folds=np.where(np.arange(24) % 3 == 0, -1, np.arange(24)))
    model = begun(own).model
    one = Chosen(add_block(own, model.bank, Free(MOTOR_TORQUE, (Grid(("aux/oil",), "1", ((2.0, 3.0, 4.0),)),)), 1e-3))
    return replace(model, chosen=[one], fit=model.refitted([one])), one


@pytest.mark.parametrize("lasts", [True, False])
def test_a_function_of_a_foreign_quantity_that_recordings_held_out_contradict_is_not_told(lasts: bool) -> None:
    drag = 0.1 * (PRESSURE - 3.0)
    out = campaign().recording % 3 == 0
    model, one = with_a_pressure(drag if lasts else np.where(out, -drag, drag))
    worse = worse_with(model, [one], one)
    assert worse is None if lasts else worse is not None and worse > 1.5
    assert borne_out(model) == ([one] if lasts else [])


@pytest.mark.parametrize(("worse", "refuted_"), [(-0.01, False), (0.0005, False), (0.01, True)])
def test_a_function_of_a_foreign_quantity_may_be_worse_by_chance(
    monkeypatch: pytest.MonkeyPatch, worse: float, refuted_: bool
) -> None:
    """One of the bench's own quantities may not."""
    model, one = with_a_pressure()
    own, table = with_a_table(campaign())
    sign = np.where(campaign().recording % 2 == 0, 1.0, -1.0)

    def remaining(_model: object, chosen: list[Chosen]) -> FloatArray:
        return np.asarray(1.0 + (0.01 * sign + worse if chosen else 0.0 * sign))

    monkeypatch.setattr(refuted, "_left", remaining)
    assert (worse_with(model, [one], one) is not None) is refuted_
    assert (worse_with(own, [table], table) is not None) is (worse > 0.0)


def test_without_recordings_held_out_nothing_of_a_foreign_quantity_is_refuted() -> None:
    model, one = with_a_pressure()
    all_fitted = replace(model, problem=replace(model.problem, folds=np.arange(24)))
    assert worse_with(all_fitted, [one], one) is None


@pytest.mark.parametrize(("gain", "stays"), [(-1.0, False), (3.0, False), (50.0, True)])
def test_a_point_that_is_as_wrong_as_the_name_says_does_not_refute_it(
    monkeypatch: pytest.MonkeyPatch, gain: float, stays: bool
) -> None:
    """``gain``: of log density at the one point that the name, which is surely better, predicts badly."""
    model, name = with_churning(campaign())
    model = replace(model, price=5.0)
    folds = 24
    bad = np.arange(folds) == 3

    def has(blocks: object) -> bool:
        return any(b.regressor.effect == name.effect for b in blocks)  # type: ignore[attr-defined]

    def squares(_bank: object, blocks: object, *_rest: object) -> FloatArray:
        return np.where(bad & has(blocks), 900.0, 100.0)

    monkeypatch.setattr(refuted, "squares", squares)
    monkeypatch.setattr(refuted, "carried", lambda *_args: np.zeros(folds))
    monkeypatch.setattr(refuted, "_sure_gain", lambda *_args: np.where(bad, gain, 0.0))
    assert refuted.not_refuted(model, [name]) == ([name] if stays else [])


def test_a_name_is_asked_again_without_the_function_that_took_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """A name goes beside a function without a name; when points left out refute the function, the name stands."""
    frame = campaign()
    own = problem(frame, 0.5 * frame.direction + np.random.default_rng(5).normal(0.0, 0.01, frame.size))
    search = begun(own)
    table = Free(MOTOR_TORQUE, (Grid(("temperature",), "1", ((22.0, 26.0, 30.0, 34.0, 40.0),)),))
    function = Chosen(add_block(own, search.model.bank, table, 1e-3))
    other = Free(MOTOR_TORQUE, (Grid(("speed",), "1", ((0.0, 0.05, 0.1, 0.2),)),), effect="friction.stribeck")
    name = Chosen(add_block(own, search.model.bank, other, 1e-3))
    for step in ("pruned", "_believed", "no_mere_form", "_that_add"):
        monkeypatch.setattr(pruning, step, lambda _search, chosen, *_price, **_keep: list(chosen))
    alone = lambda _search, chosen: [c for c in chosen if c is function] or list(chosen)  # noqa: E731
    monkeypatch.setattr(pruning, "_above_the_rest", alone)
    monkeypatch.setattr(pruning, "not_refuted", lambda _model, chosen: [c for c in chosen if c is not function])
    assert pruning._kept(search, [name, function], 5.0) == [name]
    assert pruning._kept(search, [function], 5.0) == []


@pytest.mark.parametrize(("size", "stays"), [(0.1, False), (0.5, True)])
def test_a_small_function_of_the_load_beside_a_name_of_the_torque_is_its_form(
    monkeypatch: pytest.MonkeyPatch, size: float, stays: bool
) -> None:
    """A saturation of the motor's torque that is another than the library's leaves something over the load's size."""
    frame = campaign()
    y = 0.5 * frame.direction + np.random.default_rng(5).normal(0.0, 0.01, frame.size)
    search = begun(problem(frame, y))
    table = Free(MOTOR_TORQUE, (Grid(("load",), "d", ((0.0, 200.0, 500.0, 1000.0),)),))
    function = Chosen(add_block(search.model.problem, search.model.bank, table, 1e-3))
    gain = named("motor.torque_constant", MOTOR_TORQUE, "gain")
    name = Chosen(add_block(search.model.problem, search.model.bank, gain))
    sizes = {id(function): size, id(name): 1.0}
    monkeypatch.setattr(pruning, "_strength_among", lambda _s, _c, one: SimpleNamespace(acts=sizes[id(one)]))
    assert (function in pruning.no_mere_form(search, [name, function])) == stays


@pytest.mark.parametrize(("over", "size", "stays"), [("time", 0.1, False), ("time", 0.5, True), ("angle", 0.1, True)])
def test_a_small_table_with_a_name_beside_a_name_of_the_same_kind_is_its_form(
    monkeypatch: pytest.MonkeyPatch, over: str, size: float, stays: bool
) -> None:
    """What a law of the temperature leaves of a sharper one comes while the gearbox warms up: it is no drift."""
    frame = campaign()
    search = begun(problem(frame, 0.5 * frame.direction + np.random.default_rng(5).normal(0.0, 0.01, frame.size)))
    table = Free(MOTOR_TORQUE, (Grid((over,), "d", ((0.0, 2.0, 4.0, 6.0),)),), "friction.position_dependent")
    small = Chosen(add_block(search.model.problem, search.model.bank, table, 1e-3))
    viscosity = named("friction.viscous_temperature", MOTOR_TORQUE, "exponential", (0.03,))
    name = Chosen(add_block(search.model.problem, search.model.bank, viscosity))
    sizes = {id(small): size, id(name): 1.0}
    monkeypatch.setattr(pruning, "_strength_among", lambda _s, _c, one: SimpleNamespace(acts=sizes[id(one)]))
    kept = pruning.no_mere_form(search, [small, name])
    assert name in kept
    assert (small in kept) == stays


@pytest.mark.parametrize(
    ("over", "size", "where", "stays"),
    [
        ("seconds", 0.3, "there", False),
        ("recent_speed_9s", 0.3, "there", False),
        ("seconds", 0.6, "there", True),
        ("seconds", 0.3, "elsewhere", True),
        ("angle", 0.3, "there", True),
    ],
)
def test_a_function_of_how_motion_began_is_the_form_of_presliding_where_that_acts(
    monkeypatch: pytest.MonkeyPatch, over: str, size: float, where: str, stays: bool
) -> None:
    """``size``: of the function over that of pre-sliding friction, in the rows where that acts or in all others."""
    frame = campaign()
    search = begun(problem(frame, 0.5 * frame.direction + np.random.default_rng(5).normal(0.0, 0.01, frame.size)))
    table = Free(MOTOR_TORQUE, (Grid((over,), "d", ((0.0, 2.0, 4.0, 6.0),)),))
    function = Chosen(add_block(search.model.problem, search.model.bank, table, 1e-3))
    sliding = named("friction.presliding", MOTOR_TORQUE, "dahl", (0.5,))
    name = Chosen(add_block(search.model.problem, search.model.bank, sliding))
    begins = np.arange(frame.size) % EACH < 4
    values = {id(name): 1.0 * begins, id(function): size * (begins if where == "there" else ~begins)}
    monkeypatch.setattr(ChannelModel, "contribution", lambda _m, one, *_: values[id(one)])
    monkeypatch.setattr(type(search.model.calibration), "projected", lambda _c, course: 0.0 * course)
    monkeypatch.setattr(pruning, "_strength_among", lambda *_: SimpleNamespace(acts=1.0))
    kept = pruning.no_mere_form(search, [name, function])
    assert name in kept
    assert (function in kept) == stays


@pytest.mark.parametrize(
    ("worse", "beside", "goes"), [(-0.1, 1, 0), (0.002, 1, 1), (0.1, 1, 1), (-0.1, 0, 0), (0.002, 0, 1)]
)
def test_a_name_goes_where_recordings_held_out_are_predicted_worse(
    monkeypatch: pytest.MonkeyPatch, worse: float, beside: int, goes: int
) -> None:
    frame = campaign()
    model, table = with_a_table(frame)
    churn = Chosen(add_block(model.problem, model.bank, named("friction.viscous_quadratic", MOTOR_TORQUE, "square")))
    chosen = [churn, *[table][:beside]]
    model = replace(model, chosen=chosen, fit=model.refitted(chosen))
    sign = np.where(frame.recording % 2 == 0, 1.0, -1.0)

    def remaining(_model: object, chosen: list[Chosen]) -> FloatArray:
        return 2.0 + (0.05 * sign + worse if churn in chosen else 0.0 * sign) - (1.0 if table in chosen else 0.0)

    monkeypatch.setattr(refuted, "_left", remaining)
    assert (churn not in borne_out(model)) == bool(goes)
    assert len(model.notes) == goes


@pytest.mark.parametrize(("within", "stays"), [(0.0, False), (0.1, False), (0.5, True)])
def test_levels_of_recordings_refute_no_name_that_predicts_better_within_them(
    monkeypatch: pytest.MonkeyPatch, within: float, stays: bool
) -> None:
    """``within``: by how much what is left swings less about the level of each recording, which lies 1 further off."""
    frame = campaign()
    model, churn = with_churning(frame)
    swing = np.resize([1.0, -1.0], frame.size)

    def remaining(_model: object, chosen: list[Chosen]) -> FloatArray:
        return np.asarray(3.0 + (1.0 - within) * swing if chosen else 2.0 + swing)

    monkeypatch.setattr(refuted, "_left", remaining)
    assert borne_out(model) == ([churn] if stays else [])
    # without set operating points the recordings' levels are what tells friction
    free = replace(model, noise=replace(model.noise, independent_rows=float(frame.size)))
    assert borne_out(free) == []


@pytest.mark.parametrize("share", [0.1, 1.0])
def test_recordings_in_which_a_name_hardly_acts_say_nothing_of_it(
    monkeypatch: pytest.MonkeyPatch, share: float
) -> None:
    """``share``: how large it is in the recordings held out, over what it is in the fitted ones."""
    frame = campaign()
    model, churn = with_churning(frame)
    added = np.where(frame.recording % 3 == 0, share, 1.0)

    def remaining(_model: object, chosen: list[Chosen]) -> FloatArray:
        return 2.0 + (added if churn in chosen else 0.0 * added)

    monkeypatch.setattr(refuted, "_left", remaining)
    monkeypatch.setattr(refuted, "_vague", lambda *_: False)
    assert (churn not in borne_out(model)) is (share == 1.0)


def test_a_name_that_another_took_with_it_is_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside a second name the first is refuted, and then the second: alone the first stands."""
    frame = campaign()
    own = problem(frame, 0.5 * frame.direction + np.random.default_rng(5).normal(0.0, 0.01, frame.size))
    search = begun(own)
    first, second = (
        Chosen(add_block(own, search.model.bank, named(effect, MOTOR_TORQUE, form)))
        for effect, form in (("friction.viscous_quadratic", "square"), ("load.unbalance", "gravity"))
    )
    monkeypatch.setattr(pruning, "pruned", lambda _search, chosen, *_price, **_keep: list(chosen))
    monkeypatch.setattr(pruning, "not_refuted", lambda _model, chosen: [c for c in chosen if c is first])
    assert pruning._tested_again(search, [first, second], [], 5.0) == [first]
    assert pruning._tested_again(search, [second], [], 5.0) == []


def test_of_an_effect_that_is_reported_no_note_says_that_it_is_not() -> None:
    frame = campaign()
    search, found = churning(frame, measured(frame, 0))
    model = search.model
    said = [
        f"{words} gained in likelihood, but: it is not reported" for words in (found.main.regressor.words, "a mass")
    ]
    model.notes[:] = list(said)
    refuted.forget(model)
    assert model.notes == said
    model.chosen = [found]
    refuted.forget(model)
    assert model.notes == said[1:]


@pytest.mark.parametrize(
    ("others", "names", "refuted_"),
    # one warm-up is predicted badly by what predicts all other points better; a few of these are too little
    [(-50.0, True, False), (-50.0, False, True), (1.0, True, True)],
)
def test_one_point_refutes_no_name_that_most_others_want(others: float, names: bool, refuted_: bool) -> None:
    squared = np.full(20, 100.0)
    whole = squared + others * np.r_[0.0, np.ones(19)]
    whole[0] = squared[0] + 1e5
    beyond, _ = refuted._worse(whole, squared, np.ones(20, dtype=bool), 5.0, names)
    assert (beyond > 0.0) is refuted_


def test_an_explanation_of_something_else_says_little_of_an_effect() -> None:
    """A name with fewer numbers takes the place of another, or leaves it ambiguous, only where it says most of it."""
    frame = campaign()
    search, churn = churning(frame, measured(frame, 2))
    model = search.model
    power = shaped(search, [], named("friction.viscous_quadratic", MOTOR_TORQUE, "power", (1.8,)))
    assert power is not None
    once = frame.recording == 5
    table = Free(MOTOR_TORQUE, (Grid(("time",), "d", (tuple(frame.time[once][[0, -1]].tolist()),)),))
    elsewhere = Chosen(add_block(model.problem, model.bank, table, 1e-3))
    assert says_most_of(model, [], churn, power)
    assert not says_most_of(model, [], churn, elsewhere)
