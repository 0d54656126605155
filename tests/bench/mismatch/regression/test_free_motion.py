"""The search where a motion follows no set speeds: what a number costs there, and laws that their changes belong to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.outcomes import impossible_numbers
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.alone import alone
from bench.mismatch.regression.beside import free_function, sound_beside
from bench.mismatch.regression.candidates import free_candidates
from bench.mismatch.regression.copies import copies, notes_of
from bench.mismatch.regression.description import description
from bench.mismatch.regression.discoveries import discoveries, no_better_than_a_parabola, one_way_only
from bench.mismatch.regression.equivalent import draws_wave, foresees, heirs_of
from bench.mismatch.regression.heredity import laws, orphaned, without, without_laws
from bench.mismatch.regression.model import Block, Chosen, add_block, left_by
from bench.mismatch.regression.noise import alike_for, of_free_motion
from bench.mismatch.regression.problem import BaseTerm, ChannelProblem
from bench.mismatch.regression.regressors import Free, Named, named
from bench.mismatch.regression.search import as_noisy_as_left, begun, carried_over, searched
from bench.mismatch.regression.succession import _drawn_by_the_unknown, settle
from bench.simulation.frame import ARRAYS, FloatArray, Frame, concatenate
from bench.simulation.tables import Grid
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE

RATE, PIECE = 20.0, 100
"""rows a second, rows a piece"""
COULOMB, VISCOUS, INERTIA = 0.3, 0.05, 0.2
SIGMA = 0.02


def swinging(pieces: int = 12, size: float = 1.0, seed: int = 0) -> Frame:
    """One motion of three sines on a shaft without a gearbox, in pieces."""
    rng = np.random.default_rng(seed)
    time = np.arange(pieces * PIECE) / RATE
    rates, phases, sizes = np.array([1.3, 2.9, 4.1]), rng.uniform(0.0, 6.0, 3), size * np.array([1.0, 0.4, 0.2])
    waves = rates * time[:, None] + phases
    angle, speed = np.sin(waves) @ sizes, np.cos(waves) @ (rates * sizes)
    parts = []
    for number in range(pieces):
        own = slice(number * PIECE, (number + 1) * PIECE)
        values: dict[str, FloatArray] = {name: np.zeros(PIECE) for name in ARRAYS}
        values |= {
            "count": np.full(PIECE, 10.0),
            "time": time[own],
            "elapsed": time[own] - time[own.start],
            "theta": angle[own],
            "q": angle[own],
            "velocity": speed[own],
            "acceleration": -(np.sin(waves) @ (rates**2 * sizes))[own],
            "direction": np.sign(speed[own]),
            "last_direction": np.sign(speed[own]),
            "temperature": np.full(PIECE, 25.0),
            "travel": np.cumsum(np.abs(speed))[own] / RATE,
            "reversal_travel": np.full(PIECE, 1.0),
            "reversal_time": np.full(PIECE, 1.0),
            "step": np.full(PIECE, 1.0 / RATE),
        }
        parts.append(Frame(ratio=1.0, **values | {"recording": np.full(PIECE, number, dtype=np.int64)}))  # type: ignore[arg-type]
    return concatenate(parts)


def asked(frame: Frame, y: FloatArray, *effects: str, lacking: tuple[str, ...] = ()) -> ChannelProblem:
    """A motor torque whose simulation has some terms; pieces of one recording, every piece a fold."""
    base = tuple(BaseTerm(Named(LIBRARY[e], MOTOR_TORQUE, LIBRARY[e].forms[MOTOR_TORQUE][0])) for e in effects)
    folds = np.arange(int(frame.recording.max()) + 1, dtype=np.int64)
    rows = Rows(frame, y, frame.count)
    every = np.ones(frame.size, dtype=bool)
    return ChannelProblem(
        MOTOR_TORQUE, rows, every, folds, base, switched_off=lacking, lacking=lacking, free=True, cut=True
    )


def noise(frame: Frame, seed: int = 9) -> FloatArray:
    return np.random.default_rng(seed).normal(0.0, SIGMA, frame.size)


def plain(frame: Frame) -> FloatArray:
    return COULOMB * frame.direction + VISCOUS * frame.omega + INERTIA * frame.acceleration


NOMINAL = ("friction.coulomb", "friction.viscous", "motor.inertia")


def free(name: str, times: str, *knots: float) -> Free:
    return Free(MOTOR_TORQUE, (Grid((name,), times, (knots,)),))


def test_what_the_simulation_has_is_no_discovery() -> None:
    frame = swinging()
    assert searched(asked(frame, plain(frame) + noise(frame), *NOMINAL)).model.chosen == []


def test_gravity_beside_all_terms_is_found_with_its_size() -> None:
    frame = swinging()
    found = searched(asked(frame, plain(frame) + 1.5 * np.sin(frame.q) + noise(frame), *NOMINAL)).model
    (own,) = found.chosen
    assert own.effect == "load.unbalance"
    assert np.hypot(*found.fit.of(own.main.indices)[0]) == pytest.approx(1.5, rel=0.05)


def test_a_term_that_is_left_out_is_found_beside_what_hides_it() -> None:
    frame = swinging(size=0.6)
    left = asked(
        frame,
        plain(frame) + 1.5 * np.sin(frame.q) + noise(frame),
        "friction.coulomb",
        "friction.viscous",
        lacking=("motor.inertia",),
    )
    assert {"motor.inertia", "load.unbalance"} <= {c.effect for c in searched(left).model.chosen}


def test_a_number_costs_half_the_logarithm_of_the_rows_that_tell_it() -> None:
    frame = swinging()
    search = begun(asked(frame, plain(frame) + noise(frame), *NOMINAL))
    telling = search.model.noise.independent_rows
    assert telling is not None
    assert telling <= frame.size
    block = next(b for b in search.blocks if b.regressor.numbers == 2)
    assert description(search.model, Chosen(block)) == pytest.approx(np.log(telling))
    points = begun(replace(asked(frame, plain(frame) + noise(frame), *NOMINAL), free=False))
    assert description(points.model, Chosen(block)) == 0.0


def test_a_residual_that_lasts_counts_for_as_many_rows_as_it_has_moments() -> None:
    frame = swinging()
    starts = np.arange(0, frame.size + 1, PIECE)
    white = noise(frame)
    assert alike_for(white, starts) == pytest.approx(1.0, abs=0.3)
    lasting = np.repeat(white[::10], 10)
    assert alike_for(lasting, starts) == pytest.approx(10.0, rel=0.4)
    own = of_free_motion(Rows(frame, lasting, frame.count), lasting)
    assert own.independent_rows == pytest.approx(frame.size / alike_for(lasting, starts))
    assert own.sigma[0] > 2.0 * np.std(lasting)


def test_a_change_of_a_law_is_told_beside_the_law_alone() -> None:
    square = Named(LIBRARY["friction.stribeck"], MOTOR_TORQUE, LIBRARY["friction.stribeck"].forms[MOTOR_TORQUE][0])
    assert laws(square) == ("friction.coulomb",)
    assert orphaned(square, (), ("friction.coulomb",))
    assert not orphaned(square, ("friction.coulomb",), ("friction.coulomb",))
    assert not orphaned(square, (), ())  # the simulation has it
    coulomb = Named(LIBRARY["friction.coulomb"], MOTOR_TORQUE, LIBRARY["friction.coulomb"].forms[MOTOR_TORQUE][0])
    law, change = (Chosen(Block(own, [], np.zeros(0))) for own in (coulomb, square))
    assert without([law, change], law, ("friction.coulomb",)) == []
    assert without([law, change], law, ()) == [change]
    assert without([law, change], change, ("friction.coulomb",)) == [law]


def test_drag_that_no_name_fits_is_not_two_of_one_name_against_each_other() -> None:
    frame = swinging(pieces=24)
    smooth = COULOMB * np.tanh(frame.omega / 0.3) + VISCOUS * frame.omega + INERTIA * frame.acceleration
    (own,) = searched(asked(frame, smooth + noise(frame), *NOMINAL)).model.chosen
    assert isinstance(own.main.regressor, Free)
    assert own.main.regressor.variables == ("speed",)


def test_a_law_is_told_without_its_changes_and_as_uncertain_as_they_make_it() -> None:
    frame = swinging(size=2.0)
    churning = 0.02 * frame.omega * np.abs(frame.omega)
    left = asked(
        frame,
        plain(frame) + churning + noise(frame),
        "friction.viscous",
        "motor.inertia",
        lacking=("friction.coulomb",),
    )
    model = searched(left).model
    assert {c.effect for c in model.chosen} == {"friction.coulomb", "friction.viscous_quadratic"}
    law = next(c for c in model.chosen if c.effect == "friction.coulomb")
    change = next(c for c in model.chosen if c is not law)
    own, (beside, covariance) = alone(model, law), model.fit.of(law.main.indices)
    assert own is not None
    assert beside == pytest.approx(COULOMB, abs=0.02)
    assert own.coefficients[0] < COULOMB - 0.05  # a line through a parabola starts below it
    assert own.coefficients == pytest.approx(model.refitted([law]).of(law.main.indices)[0])
    assert own.coefficients + own.shift == pytest.approx(beside)
    assert abs(own.coefficients[0] - COULOMB) < 2.0 * own.widened(own.std)[0]
    assert own.widened(np.sqrt(np.diag(covariance)))[0] > 5.0 * np.sqrt(covariance[0, 0])
    assert alone(model, change) is None
    assert alone(replace(model, problem=replace(model.problem, free=False)), law) is None


@pytest.mark.parametrize(("size", "sound"), [(-0.3, False), (0.3, True)])
def test_an_effect_that_makes_friction_negative_is_none(size: float, sound: bool) -> None:
    frame = swinging(size=2.0)
    drag = frame.direction * (size + np.exp(-np.abs(frame.omega) / 5.0))
    rest = VISCOUS * frame.omega + INERTIA * frame.acceleration + noise(frame)
    search = begun(asked(frame, drag + rest, *NOMINAL))
    model = search.model
    coulomb = next(b for b in model.base if b.regressor.effect == "friction.coulomb")
    assert model.fit.of(coulomb.indices)[0] > 0.0
    decaying = add_block(model.problem, search.bank, named("friction.stribeck", MOTOR_TORQUE, "exponential", (5.0,)))
    assert sound_beside(search, [], decaying, model.refitted([Chosen(decaying)])) is sound


@pytest.mark.parametrize(("name", "sound"), [("pull", False), ("pressure", True)])
def test_an_effect_takes_nothing_from_a_term_that_it_shares_nothing_with(name: str, sound: bool) -> None:
    frame = swinging()
    # what pulls one way with the acceleration may be the inertia; what goes with a pressure is not
    frame = replace(frame, aux={"pull": np.sign(frame.acceleration), "pressure": np.sin(0.37 * frame.time)})
    search = begun(asked(frame, plain(frame) + noise(frame), *NOMINAL))
    model = search.model
    own = add_block(model.problem, search.bank, free(f"aux/{name}", "1", -1.0, 1.0))
    fitted = model.refitted([Chosen(own)])
    (inertia,) = next(b for b in model.base if b.regressor.effect == "motor.inertia").indices
    negative = np.where(np.array(fitted.index) == inertia, -INERTIA, fitted.coefficients)
    far = np.where(np.array(fitted.index) == own.indices[0], 1.0, negative)
    assert sound_beside(search, [], own, replace(fitted, coefficients=far)) is sound


def test_a_table_says_nothing_of_what_a_law_says() -> None:
    frame = swinging()
    table = free("temperature", "d", 20.0, 25.0, 30.0)
    varied = replace(frame, temperature=25.0 + 4.0 * np.sin(0.3 * frame.time))
    own = without_laws(table, varied)
    assert own.numbers == table.numbers - 1
    columns = own.columns(varied)
    assert np.abs(columns.T @ varied.direction).max() < 1e-9 * np.abs(table.columns(varied)).sum()
    assert own.values(np.ones(own.numbers)).shape == (3,)
    untouched = free("angle", "abs_tau", -1.0, 0.0, 1.0)
    assert without_laws(untouched, varied) is untouched


def test_another_reading_of_a_channel_is_a_copy_and_no_cause() -> None:
    frame = swinging()
    y = plain(frame) + noise(frame)
    aux = {"degrees": np.degrees(frame.q) + 30.0, "amperes": y / 0.07, "oil": np.sin(0.2 * frame.time)}
    own = asked(replace(frame, aux=aux), y, *NOMINAL)
    assert copies(own) == {"degrees": "motor_angle", "amperes": MOTOR_TORQUE}
    assert notes_of({"amperes": MOTOR_TORQUE}) == [
        "aux/amperes is motor_torque once more: nothing is said to depend on it"
    ]
    names = {name for b in begun(own).blocks for name in b.regressor.variables}
    assert "aux/oil" in names
    assert not any("amperes" in name or "degrees" in name for name in names)


def one_way(speeds: tuple[float, ...], way: float = 3.0, seconds: float = 4.0) -> Frame:
    """Moves from the lowest point of an arm, each at a speed of its own, one way or the other: which way it goes and
    where it is are one thing.
    """
    size = int(RATE * seconds)
    parts = []
    for number, speed in enumerate(speeds):
        time = np.arange(1, size + 1) / RATE
        began = np.exp(-time / 0.1)
        angle = np.sign(speed) * np.minimum(np.abs(speed) * (time - 0.1 * (1.0 - began)), way)
        moves = np.abs(angle) < way
        values: dict[str, FloatArray] = {name: np.zeros(size) for name in ARRAYS}
        values |= {
            "count": np.full(size, 10.0),
            "time": time,
            "elapsed": time,
            "theta": angle,
            "q": angle,
            "velocity": np.where(moves, speed * (1.0 - began), 0.0),
            "acceleration": np.where(moves, speed * began / 0.1, 0.0),
            "direction": np.where(moves, np.sign(speed), 0.0),
            "last_direction": np.full(size, np.sign(speed)),
            "temperature": np.full(size, 25.0),
            "travel": np.abs(angle),
            "reversal_travel": np.full(size, 10.0),
            "reversal_time": np.full(size, 10.0),
            "step": np.full(size, 1.0 / RATE),
        }
        parts.append(Frame(ratio=1.0, **values | {"recording": np.full(size, number, dtype=np.int64)}))  # type: ignore[arg-type]
    return concatenate(parts)


def arm(frame: Frame, second: float) -> FloatArray:
    """Torque of an arm with friction and inertia, and a ``second`` part of its gravity that no name has."""
    weight = 38.0 * np.sin(frame.q) + second * np.sin(2.0 * frame.q)
    motion = 12.0 * frame.direction + 2.5 * frame.omega + 2.4 * frame.acceleration
    return np.asarray(weight + motion + np.random.default_rng(4).normal(0.0, 1.0, frame.size))


def of_the_arm(second: float) -> ChannelProblem:
    frame = one_way(tuple(side * v for v in np.linspace(0.2, 1.5, 12) for side in (1.0, -1.0)))
    problem = asked(frame, arm(frame, second), *NOMINAL, "motor.torque_offset")
    return replace(problem, usable=frame.direction != 0, cut=False)


def test_a_simulation_that_far_too_little_noise_calibrated_is_calibrated_anew() -> None:
    problem = of_the_arm(0.0)
    found = searched(problem)
    left = left_by(found.model)
    little = carried_over(found, begun(problem, 0, 0.1 * left))
    little.model.notes = ["a function was refuted"]
    again = as_noisy_as_left(little)
    assert again.model.noise.sigma[0] == pytest.approx(found.model.noise.sigma[0], rel=0.1)
    assert [c.effect for c in again.model.chosen] == [c.effect for c in found.model.chosen]
    assert "a function was refuted" in again.model.notes
    assert as_noisy_as_left(found) is found


def test_a_number_that_is_not_possible_is_said_with_its_bound() -> None:
    frame = swinging()
    y = 0.3 * frame.direction - 0.05 * frame.omega + INERTIA * frame.acceleration + noise(frame)
    (sentence,) = impossible_numbers(begun(asked(frame, y, *NOMINAL)).model)
    assert sentence.startswith("f_v (viscous friction) comes out as -0.05")
    assert "beyond 0, which is not possible" in sentence
    assert impossible_numbers(begun(asked(frame, plain(frame) + noise(frame), *NOMINAL)).model) == []


@pytest.mark.parametrize(("second", "heirs"), [(0.05, {0: 1}), (0.8, {})])
def test_a_table_that_is_off_a_name_by_no_more_than_its_form_has_that_name(
    second: float, heirs: dict[int, int]
) -> None:
    frame = swinging()
    weight = 1.5 * np.sin(frame.q) + second * np.sin(2.0 * frame.q)
    search = begun(asked(frame, plain(frame) + weight + noise(frame), *NOMINAL))
    model = search.model
    gravity = named("load.unbalance", MOTOR_TORQUE, "gravity")
    tables = (b for b in search.blocks if isinstance(b.regressor, Free) and b.regressor.times == ("1",))
    # the coarser of two tables, which is off by its knots as well
    table = next(b for b in tables if b.regressor.variables == ("angle_about_zero",) and b.regressor.numbers > 1)
    contenders = (free_function(search, [], table), Chosen(add_block(model.problem, model.bank, gravity)))
    assert heirs_of(model, [], contenders) == (heirs, False)


@pytest.mark.parametrize(
    ("size", "spring", "parabola"),
    [(0.03, 0.0, True), (1.0, 0.0, False), (0.03, 20.0, True), (0.15, 10.0, True)],
    ids=["hardly varies", "varies", "a spring", "a spring further"],
)
def test_a_sine_of_an_angle_that_hardly_varies_is_no_surer_than_a_spring(
    size: float, spring: float, parabola: bool
) -> None:
    frame = swinging(size=size)
    weight = spring * frame.q if spring else 20.0 * np.sin(frame.q)
    # the noise beside whatever describes the weight best, and the sine in place of that
    model = searched(asked(frame, plain(frame) + weight + noise(frame), *NOMINAL)).model
    gravity = named("load.unbalance", MOTOR_TORQUE, "gravity")
    found = Chosen(add_block(model.problem, model.bank, gravity))
    model = replace(model, chosen=[found], fit=replace(model, chosen=[found]).refitted([found]))
    assert no_better_than_a_parabola(model, found) == parabola


@pytest.mark.parametrize(
    ("middle", "name"), [(0.0, "angle_about_zero"), (np.pi, "angle")], ids=["about zero", "opposite"]
)
def test_a_function_of_the_angle_does_not_jump_where_a_joint_swings_about_zero(middle: float, name: str) -> None:
    frame = swinging(size=0.3)
    frame = replace(frame, theta=frame.theta + middle, q=frame.q + middle)
    tables = [c for c in free_candidates(MOTOR_TORQUE, frame, straight=True) if c.variables[0].startswith("angle")]
    assert {c.variables for c in tables} == {(name,)}
    assert {c.effect for c in tables if c.times == ("d",)} == {"friction.position_dependent"}
    # a straight line, as of a spring, and none over a swing that gravity bends
    assert min(c.numbers for c in tables) == 2
    wide = swinging(size=1.0)
    of_angle = [c for c in free_candidates(MOTOR_TORQUE, wide, straight=True) if c.variables[0].startswith("angle")]
    assert min(c.numbers for c in of_angle) > 2
    stop = np.maximum(frame.q - middle - 0.1, 0.0)
    y = plain(frame) + 5.0 * stop + noise(frame)
    model = searched(asked(frame, y, "friction.coulomb", "friction.viscous", "motor.inertia")).model
    assert {c.main.regressor.variables for c in model.chosen if isinstance(c.main.regressor, Free)} == {(name,)}
    assert np.std(left_by(model)) < 1.3 * np.std(left_by(model)[frame.q[model.problem.train] < middle])


def test_how_friction_builds_up_is_asked_as_closely_as_the_finer_recordings_tell() -> None:
    (form,) = (f for f in LIBRARY["friction.presliding"].forms[MOTOR_TORQUE] if f.name == "reversal")

    def reversing(frame: Frame, slower: float) -> Frame:
        return replace(
            frame,
            theta=frame.theta / slower,
            reversal_time=np.zeros(frame.size),
            reversed_before=np.ones(frame.size),
            reversal_travel=np.abs(frame.theta - np.roll(frame.theta, 20)) / slower,
        )

    slow, fast = reversing(swinging(), 100.0), reversing(swinging(), 1.0)
    both = concatenate([slow, replace(fast, recording=fast.recording + int(slow.recording.max()) + 1)])
    ends = [min(point[0] for point in form.grid(frame)) for frame in (slow, both, fast)]
    assert ends[0] < 1.5 * ends[1] < 0.1 * ends[2]


@pytest.mark.parametrize("one_way", [True, False])
def test_friction_over_the_angle_is_told_by_motion_both_ways(one_way: bool) -> None:
    frame = swinging()
    if one_way:
        ones = np.ones(frame.size)
        frame = replace(frame, direction=ones, last_direction=ones, velocity=np.abs(frame.velocity))
    y = plain(frame) + 0.2 * frame.direction * np.cos(3.0 * frame.q) + noise(frame)
    search = searched(asked(frame, y, *NOMINAL))
    assert one_way_only(search.model) is one_way
    found = [
        d
        for d in discoveries(search, settle(search), search.model.predict(frame), frame.count)
        if d.effect == "friction.position_dependent"
    ]
    assert found
    assert all((d.confidence < 0.6) is one_way for d in found if d.confidence is not None)
    assert any("goes one way" in note for note in search.model.notes) is one_way


def one_way_swing(pieces: int = 8, each: int = 40) -> Frame:
    """One slow swing through five radians, cut into pieces: each is the only one that was at its angles."""
    size = pieces * each
    time = np.arange(size) / RATE
    x = time / time[-1]
    angle = -2.0 + 5.0 * (10.0 * x**3 - 15.0 * x**4 + 6.0 * x**5)
    speed = np.gradient(angle, time)
    frame = swinging(pieces=pieces * each // PIECE + 1).take(np.arange(size))
    ones = np.ones(size)
    return replace(
        frame,
        recording=np.repeat(np.arange(pieces), each),
        time=time,
        elapsed=time % (each / RATE),
        theta=angle,
        q=angle,
        velocity=speed,
        acceleration=np.gradient(speed, time),
        direction=ones,
        last_direction=ones,
        travel=angle - angle[0],
    )


def test_a_table_that_says_nothing_where_nobody_has_been_gives_way_to_the_name_that_does() -> None:
    frame = one_way_swing()
    y = plain(frame) + 1.5 * np.sin(frame.q) + noise(frame)
    search = begun(asked(frame, y, *NOMINAL))
    model = search.model
    knots = tuple(np.linspace(-2.0, 3.0, 8))
    function = add_block(model.problem, model.bank, free("angle_about_zero", "d", *knots))
    table = free_function(search, [], function)
    gravity = Chosen(add_block(model.problem, model.bank, named("load.unbalance", MOTOR_TORQUE, "gravity")))
    assert foresees(model, [], gravity, table)
    assert not foresees(model, [], table, gravity)
    search.model = replace(model, chosen=[table], fit=model.refitted([table]))
    (slot,) = settle(search)
    assert slot.chosen.effect == "load.unbalance"
    # where the pieces were run apart on purpose their densities decide
    apart_on_purpose = replace(model, problem=replace(model.problem, free=False))
    assert not foresees(apart_on_purpose, [], gravity, table)


@pytest.mark.parametrize(("spring", "drawn"), [(2.0, True), (0.1, False)])
def test_gravity_beside_a_function_of_the_angle_that_is_as_large_is_a_part_of_it(spring: float, drawn: bool) -> None:
    frame = swinging()
    beyond = spring * np.maximum(frame.q - 0.5, 0.0) ** 2
    search = begun(asked(frame, plain(frame) + 0.6 * np.sin(frame.q) + beyond + noise(frame), *NOMINAL))
    model = search.model
    gravity = Chosen(add_block(model.problem, model.bank, named("load.unbalance", MOTOR_TORQUE, "gravity")))
    knots = tuple(np.linspace(float(frame.q.min()), float(frame.q.max()), 9))
    function = add_block(model.problem, model.bank, free("angle_about_zero", "1", *knots))
    both = [gravity, free_function(search, [gravity], function)]
    model = replace(model, chosen=both, fit=model.refitted(both))
    assert draws_wave(both[1], gravity.main.regressor)
    assert not draws_wave(gravity, gravity.main.regressor)
    if drawn:
        assert _drawn_by_the_unknown(model, gravity)
    # what stands beside it in the other direction is another thing
    other = Chosen(replace(function, regressor=free("angle_about_zero", "d", *knots)))
    assert not draws_wave(other, gravity.main.regressor)
