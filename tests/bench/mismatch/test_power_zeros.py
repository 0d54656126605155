"""A zero of the torque sensor heats nothing: the temperature says so."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from bench.mismatch import criteria
from bench.mismatch.given import Known
from bench.mismatch.outcomes import of_zeros
from bench.mismatch.power_zeros import (
    GAIN,
    LIFTED,
    LOAD,
    LOADS_RECORDINGS,
    RECORDINGS,
    REPORTED,
    REST,
    UNNAMED,
    Zeros,
    _energies,
    _likeliest,
    chosen,
)
from bench.mismatch.recordings.beginning import START_S
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression import problem as problems
from bench.mismatch.regression import refuted
from bench.mismatch.regression.model import Block
from bench.mismatch.regression.noise import MEMORIES_S, Mixture
from bench.mismatch.regression.prior import zeros_settled
from bench.mismatch.regression.problem import (
    SHORTEST_STRETCH_S,
    STRETCH_S,
    BaseTerm,
    ChannelProblem,
    WanderingZero,
    fixed_part,
    nominal_base,
    squared_speed_time,
    zero_precisions,
)
from bench.mismatch.regression.regressors import Named
from bench.mismatch.regression.search import begun, searched
from bench.mismatch.regression.strength import trusted
from bench.simulation.frame import ARRAYS, FloatArray, Frame, concatenate
from bench.simulation.terms import LIBRARY, LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE

RATIO, SPEED, STEP = 185.0, 0.9, 2.0
ZERO = 4.0
"""N·m of the torque sensor"""
CAPACITY, RESISTANCE, AMBIENT = 7000.0, 0.3, 21.0
RECORDINGS_MADE, EACH = 24, 60
PERIOD_H = 2.0


LOSS = np.random.default_rng(5).uniform(60.0, 180.0, RECORDINGS_MADE)
"""W of each recording"""


def heated(zero: float | FloatArray, seed: int = 0, swing: float = 0.0) -> Rows:
    """Heating runs both ways whose true loss is :data:`LOSS`; the sensor reads ``zero`` N·m beside the load, or in each
    recording another (recordings,); the surroundings go up and down by ``swing`` K every :data:`PERIOD_H`.
    """
    rng = np.random.default_rng(seed)
    parts, y, level = [], [], 25.0
    for number in range(RECORDINGS_MADE):
        side = 1.0 if number % 2 == 0 else -1.0
        elapsed = STEP * np.arange(EACH)
        motor = np.full(EACH, side * LOSS[number] / (SPEED * RATIO))
        torque = np.full(EACH, np.broadcast_to(zero, RECORDINGS_MADE)[number])
        values: dict[str, FloatArray] = {name: np.zeros(EACH) for name in ARRAYS}
        temperature = np.empty(EACH)
        for k in range(EACH):
            temperature[k] = level
            hours = (500.0 * number + elapsed[k]) / 3600.0
            outside = AMBIENT + swing * np.sin(2.0 * np.pi * hours / PERIOD_H)
            level += STEP * (LOSS[number] - (level - outside) / RESISTANCE) / CAPACITY
        read = temperature + rng.normal(0.0, 0.002, EACH)
        values |= {
            "count": np.full(EACH, 100.0),
            "time": 500.0 * number + elapsed,
            "elapsed": elapsed,
            "velocity": np.full(EACH, side * SPEED),
            "direction": np.full(EACH, side),
            "last_direction": np.full(EACH, side),
            "torque": torque,
            "motor_torque": motor,
            "power": np.abs(motor * side * SPEED * RATIO - torque * side * SPEED),
            "temperature": read,
            "step": np.where(elapsed > 0.0, STEP, 0.0),
        }
        values["recording"] = np.full(EACH, number, dtype=np.int64)
        parts.append(Frame(ratio=RATIO, **values))  # type: ignore[arg-type]
        y.append(read)
        level -= 3.0  # it stands and cools before the next
    frame = concatenate(parts)
    return Rows(frame, np.concatenate(y), np.full(frame.size, 100.0), np.full(frame.size, 1e-4))


def problem(rows: Rows) -> ChannelProblem:
    """The temperature with its nominal balance."""
    base: tuple[BaseTerm, ...] = tuple(nominal_base(TEMPERATURE, ()))
    usable = np.ones(rows.size, dtype=bool)
    return ChannelProblem(TEMPERATURE, rows, usable, np.arange(RECORDINGS_MADE) % 5, base)


def torque_model(rows: Rows, effect: str, constant: float) -> Any:
    """A calibrated model of a torque whose constant is known and that leaves nothing."""
    block = SimpleNamespace(regressor=SimpleNamespace(effect=effect), indices=(0,))
    fit = SimpleNamespace(of=lambda _place: (np.array([constant]), np.zeros((1, 1))))

    def predict(frame: Frame, *_fitted: Any) -> FloatArray:
        return frame.torque if effect.startswith("load") else frame.motor_torque - fixed_part(MOTOR_TORQUE, frame, ())

    own = replace(rows, y=predict(rows.frame))
    whole = SimpleNamespace(rows=own, usable=np.ones(rows.size, dtype=bool), switched_off=())
    return SimpleNamespace(base=[block], chosen=[], fit=fit, problem=whole, predict=predict)


@pytest.mark.parametrize("wrong", [0.0, 0.1])
def test_slow_noise_of_the_motor_torque_heats_nothing_where_its_model_is_right(wrong: float) -> None:
    """``wrong``: N·m by which the model is off in half of the recordings."""
    rows = heated(0.0)
    true = rows.frame
    noise = np.cumsum(np.random.default_rng(3).normal(0.0, 0.002, true.size))
    read = true.motor_torque + noise - np.mean(noise)
    rows = replace(rows, frame=replace(true, motor_torque=read, power=np.abs(read * true.omega)))
    model = torque_model(rows, "motor.torque_offset", 0.0)
    off = wrong * np.sign(true.velocity) * (true.recording % 4 < 2)
    model.predict = lambda frame, *_: true.motor_torque + off - fixed_part(MOTOR_TORQUE, frame, ())
    found = chosen(cast("Any", {MOTOR_TORQUE: model}), problem(rows))
    assert (REST in found.which) is (wrong == 0.0)
    if wrong == 0.0:
        assert np.allclose(found.less(rows.frame).power, LOSS[rows.frame.recording])


@pytest.mark.parametrize(("zero", "taken"), [(ZERO, True), (0.0, False)])
def test_the_heat_tells_whether_a_constant_is_a_zero(zero: float, taken: bool) -> None:
    rows = heated(zero)
    models = {
        LOAD_TORQUE: torque_model(rows, "load.torque_offset", ZERO),
        MOTOR_TORQUE: torque_model(rows, "motor.torque_offset", 0.0),
    }
    found = chosen(cast("Any", models), problem(rows))
    assert (LOAD in found.which) is taken
    power = found.less(rows.frame).power
    assert np.allclose(power, LOSS[rows.frame.recording])


def test_a_zero_is_seen_where_the_surroundings_swing_and_beside_them() -> None:
    rows = heated(ZERO, swing=20.0)
    models = {
        LOAD_TORQUE: torque_model(rows, "load.torque_offset", ZERO),
        MOTOR_TORQUE: torque_model(rows, "motor.torque_offset", 0.0),
    }
    term = LIBRARY["thermal.ambient_drift"]
    wave = Named(term, TEMPERATURE, next(f for f in term.forms[TEMPERATURE] if f.name == "wave"), (PERIOD_H,))
    drift = Block(wave, (), np.zeros(2))
    assert LOAD in chosen(cast("Any", models), problem(rows)).which
    assert LOAD in chosen(cast("Any", models), problem(rows), [drift]).which
    less = replace(rows, frame=Zeros((LOAD,), {LOAD_TORQUE: ZERO}).less(rows.frame))
    plain, without = (problem(one) for one in (rows, less))
    beside = BaseTerm(drift.regressor, (0.0, 0.0))
    # beside the swing what is left without the zero is more of what is left with it
    alone = _energies(plain).sum() / _energies(without).sum()
    both = [_energies(replace(own, base=(*own.base, beside))).sum() for own in (plain, without)]
    assert both[0] > alone * both[1]


@pytest.mark.parametrize(
    ("plain", "taken"),
    # what each of four recordings leaves without the zero of the load torque; with it: 3, 1, 3, 1
    [((1.0, 2.0, 1.0, 2.0), (LOAD,)), ((1.0, 0.5, 1.0, 0.5), ()), ((9.0, 9.0, 9.0, 9.0), (LOAD,))],
)
def test_the_zero_of_the_sensor_is_taken_off_unless_the_recordings_say_no(
    plain: tuple[float, ...], taken: tuple[str, ...]
) -> None:
    """Two recordings better and two worse are no evidence against it; all of them are."""
    sets = [(), (LOAD,), (LOAD, RECORDINGS)]
    left = [np.array(plain), np.array([3.0, 1.0, 3.0, 1.0]), np.array([2.9, 1.1, 3.0, 1.0])]
    assert sets[_likeliest(sets, left)] == taken


def test_a_zero_of_a_recording_is_taken_off_once() -> None:
    """The motor torque is predicted from what the sensor of the load reads: the mean that is left of it holds the
    sensor's zero as well as the drive's own.
    """
    rng = np.random.default_rng(8)
    zeros, drive = rng.normal(0.0, 6.0, RECORDINGS_MADE), rng.normal(0.0, 0.05, RECORDINGS_MADE)
    rows = heated(zeros)
    real, frame = rows.frame.motor_torque, rows.frame
    says = real + drive[frame.recording]
    power = np.abs(says * frame.omega - frame.torque * frame.velocity)
    rows = replace(rows, frame=replace(frame, motor_torque=says, power=power))
    load = torque_model(rows, "load.torque_offset", 0.0)
    load.predict = lambda frame, *_: np.zeros(frame.size)
    motor = torque_model(rows, "motor.torque_offset", 0.0)
    motor.predict = lambda *_: real
    found = chosen(cast("Any", {MOTOR_TORQUE: motor, LOAD_TORQUE: load}), problem(rows))
    assert {RECORDINGS, REST} & set(found.which)
    assert np.allclose(found.less(rows.frame).power, LOSS[frame.recording], atol=1e-6)
    assert np.allclose(list(found.levels[LOAD_TORQUE].values()), zeros)


def test_the_zeros_of_the_load_may_be_taken_off_alone() -> None:
    """What is left of the motor torque's means may be friction, and then it heats."""
    zeros = np.random.default_rng(8).normal(0.0, 6.0, RECORDINGS_MADE)
    rows = heated(zeros)
    load = torque_model(rows, "load.torque_offset", 0.0)
    load.predict = lambda frame, *_: np.zeros(frame.size)
    motor = torque_model(rows, "motor.torque_offset", 0.0)
    unknown = np.random.default_rng(9).normal(0.0, 0.1, RECORDINGS_MADE)
    motor.predict = lambda frame, *_: motor.problem.rows.y - unknown[frame.recording]
    found = chosen(cast("Any", {MOTOR_TORQUE: motor, LOAD_TORQUE: load}), problem(rows))
    assert LOADS_RECORDINGS in found.which
    assert np.allclose(found.less(rows.frame).power, LOSS[rows.frame.recording], atol=1e-6)


def test_each_recording_has_its_own() -> None:
    frame = heated(0.0).frame
    zeros = Zeros((RECORDINGS,), {}, {MOTOR_TORQUE: {0: 0.1, 1: 0.1}})
    change = zeros.less(frame).power - frame.power
    # the motor's zero counts with the direction of its speed; both ways it puts in less than it says or more
    assert np.allclose(change[frame.recording == 0], -0.1 * SPEED * RATIO)
    assert np.allclose(change[frame.recording == 1], +0.1 * SPEED * RATIO)
    assert np.all(change[frame.recording > 1] == 0.0)


def test_no_zero_is_common_to_all_recordings() -> None:
    """Beside heating runs at one torque it would be taken for a part of the heat capacity, and no file holds it."""
    frame = heated(0.0).frame
    columns = WanderingZero().columns(frame)
    precisions = zero_precisions(frame, None)
    assert columns.shape[1] == len(precisions)
    for column in columns.T:
        assert np.unique(frame.recording[column != 0.0]).size == 1


def test_a_stretch_of_a_long_recording_wanders_as_far_as_the_torque_is_noisy() -> None:
    frame = heated(0.0).frame
    stretches = WanderingZero().columns(frame).shape[1] - RECORDINGS_MADE
    assert stretches == RECORDINGS_MADE * int(np.ceil(EACH * STEP / STRETCH_S))
    quiet = zero_precisions(frame, Mixture(0.05**2, (0.0,) * len(MEMORIES_S), 500.0))[-1]
    parts = np.zeros(len(MEMORIES_S))
    parts[-1] = 0.05**2
    slow = zero_precisions(frame, Mixture(0.0, tuple(parts), 500.0))[-1]
    # a mean of independent samples has a variance of v/n, of samples that remember m seconds of some 2*v*m/T
    assert quiet == pytest.approx((problems.CAPACITY / 0.05) ** 2 * 500.0 * STRETCH_S)
    assert slow == pytest.approx((problems.CAPACITY / 0.05) ** 2 * STRETCH_S / (2.0 * MEMORIES_S[-1]), rel=0.1)


def test_one_zero_stands_for_a_walk_as_long_as_it_bends_by_no_more_than_a_row_is_noisy() -> None:
    """A light gearbox, a fast motor and slow noise: within 100 s the walk bends by several times a row's noise."""
    frame, row = heated(0.0).frame, 0.01
    parts = np.zeros(len(MEMORIES_S))
    parts[-1] = 0.05**2
    slow = Mixture(0.0, tuple(parts), 500.0)
    most = squared_speed_time(slow, row, CAPACITY)
    omega, density = SPEED * RATIO, 2.0 * 0.05**2 * MEMORIES_S[-1]
    length = most / omega**2
    assert SHORTEST_STRETCH_S < length < STRETCH_S
    # a Brownian bridge has a quarter of the walk's variance in its middle
    assert density * length / 4.0 * (omega / CAPACITY) ** 2 == pytest.approx(row**2, rel=0.1)
    stretches = WanderingZero(most).columns(frame).shape[1] - RECORDINGS_MADE
    assert stretches == RECORDINGS_MADE * int(np.ceil(EACH * STEP / length))
    precisions = zero_precisions(frame, slow, capacity=CAPACITY, most=most)
    assert len(precisions) == RECORDINGS_MADE + stretches
    # the mean over a shorter stretch is as much less sure
    whole = zero_precisions(frame, slow, capacity=CAPACITY)[-1]
    assert precisions[-1] == pytest.approx(whole * length / STRETCH_S, rel=0.05)
    # of a slower recording one zero is enough for longer
    slower = replace(frame, velocity=0.1 * frame.velocity)
    assert WanderingZero(most).columns(slower).shape[1] == WanderingZero().columns(frame).shape[1]


def test_zeros_that_no_file_holds_are_doubt_of_a_prediction() -> None:
    """What a recording's own zero adds up to in one that was held out."""
    rows = heated(0.0)
    plain = problem(rows)
    held = replace(plain, folds=np.where(np.arange(RECORDINGS_MADE) == 3, -1, plain.folds))
    term = BaseTerm(WanderingZero(), zero_precisions(rows.frame, None, capacity=CAPACITY))
    model = begun(replace(held, base=(*held.base, term))).model
    elapsed = rows.frame.elapsed[rows.frame.recording == 3]
    warmed = SPEED * RATIO / CAPACITY * (elapsed - elapsed[elapsed < START_S].mean())
    late = np.maximum(elapsed - STRETCH_S, 0.0) * SPEED * RATIO / CAPACITY
    early = np.minimum(elapsed, STRETCH_S) * SPEED * RATIO / CAPACITY
    early = early - early[elapsed < START_S].mean()
    square = sum(float(np.mean(part**2)) for part in (warmed, early, late))
    assert of_zeros(model, held.held_out) == pytest.approx(problems.TORQUE_ZERO**2 * square, rel=0.05)
    assert of_zeros(begun(held).model, held.held_out) == 0.0


def test_a_recordings_own_zero_speaks_against_no_effect() -> None:
    """Held out, its heat grows far above the noise, and whatever is added to it makes that larger or smaller."""
    rows = heated(0.0)
    own = rows.frame.recording == 3
    warmed = 0.1 * SPEED * RATIO / CAPACITY * rows.frame.elapsed * own
    swinging = 0.03 * np.sin(2.0 * np.pi * rows.frame.elapsed / 15.0) * own
    plain = problem(replace(rows, y=rows.y + warmed + swinging))
    held = replace(plain, folds=np.where(np.arange(RECORDINGS_MADE) == 3, -1, plain.folds))
    term = BaseTerm(WanderingZero(), zero_precisions(rows.frame, None, capacity=CAPACITY))
    without, beside = (
        refuted._left(begun(replace(held, base=base)).model, [])[own] for base in (held.base, (*held.base, term))
    )
    assert np.std(without) > 0.8 * np.std(warmed[own])
    # what is no heat of a zero stays
    assert np.std(beside) == pytest.approx(np.std(swinging[own]), rel=0.1)
    assert np.corrcoef(beside, swinging[own])[0, 1] > 0.9


def test_what_the_torque_transducer_is_not_trusted_with_may_heat() -> None:
    rows = heated(0.0)
    share = np.random.default_rng(8).uniform(0.2, 1.0, RECORDINGS_MADE)[rows.frame.recording]
    loaded = replace(
        rows, frame=replace(rows.frame, torque=np.full(rows.size, 1000.0), velocity=rows.frame.velocity * share)
    )
    false_heat = rows.frame.elapsed * criteria.TRANSDUCER * 1000.0 * SPEED * share / CAPACITY
    # what another loss, another cooling or another room would do as well is no matter of trust
    warmth = np.concatenate([STEP * np.cumsum(rows.y[a : a + EACH]) for a in range(0, rows.size, EACH)])
    columns = np.column_stack([rows.frame.elapsed * LOSS[rows.frame.recording], warmth, rows.frame.elapsed])
    beyond = np.sort((false_heat - columns @ np.linalg.lstsq(columns, false_heat, rcond=None)[0]) ** 2)[::-1]
    held = int(np.searchsorted(np.cumsum(beyond), 0.95 * beyond.sum())) + 1
    assert trusted(begun(problem(loaded)).model) == pytest.approx(np.sqrt(beyond[:held].mean()), rel=0.1)
    assert trusted(begun(problem(rows)).model) == 0.0


def test_what_the_simulation_absorbs_of_the_transducer_is_no_reason_for_doubt() -> None:
    rows = heated(0.0)
    loaded = replace(rows, frame=replace(rows.frame, torque=np.full(rows.size, 1000.0)))
    last = EACH * STEP * criteria.TRANSDUCER * 1000.0 * SPEED / CAPACITY
    # the same speed throughout: the false heat is one of the surroundings
    assert trusted(begun(problem(loaded)).model) < 0.02 * last


def test_zeros_of_recordings_take_nothing_from_the_size_of_an_effect() -> None:
    rows = heated(0.0)
    plain = problem(rows)
    zeros = BaseTerm(WanderingZero(), zero_precisions(rows.frame, None))
    model = begun(replace(plain, base=(*plain.base, zeros))).model
    # what differs from recording to recording as a zero does is beyond the simulation all the same
    rng = np.random.default_rng(2)
    course = rows.frame.elapsed * rng.normal(size=RECORDINGS_MADE)[rows.frame.recording]
    assert np.std(course - model.calibration.projected(course)) > 0.9 * np.std(course)


def test_zeros_differ_as_far_as_the_motor_torque_shows() -> None:
    frame = heated(0.0).frame
    usual, wide = zero_precisions(frame, None)[0], zero_precisions(frame, None, 3.0 * problems.TORQUE_ZERO)[0]
    assert usual == pytest.approx(9.0 * wide)


@pytest.mark.parametrize(("size", "smaller"), [(0.0, True), (2.0, False)])
def test_zeros_are_as_large_as_the_recordings_say(size: float, smaller: bool) -> None:
    """Heat that a zero of each recording's motor torque makes up, of the size that data sheets allow twice, or none."""
    rows = heated(0.0)
    off = size * problems.TORQUE_ZERO * np.random.default_rng(6).normal(size=RECORDINGS_MADE)
    power = rows.frame.power + (off * SPEED * RATIO)[rows.frame.recording]
    rows = replace(rows, frame=replace(rows.frame, power=power))
    plain = problem(rows)
    term = BaseTerm(WanderingZero(), zero_precisions(rows.frame, None))
    search = begun(replace(plain, base=(*plain.base, term)))
    model = search.model
    (before,) = (b for b in model.base if b.regressor.effect == "nuisance")
    (after,) = (b for b in zeros_settled(model.problem, model.bank, model.base) if b.regressor.effect == "nuisance")
    assert bool(np.all(after.precision > before.precision)) is smaller
    assert smaller or np.array_equal(after.precision, before.precision)


def test_a_heat_capacity_is_told_once_the_zeros_are_known_to_be_none() -> None:
    rows = heated(0.0)
    plain = problem(rows)
    term = BaseTerm(WanderingZero(), zero_precisions(rows.frame, None))
    found = searched(replace(plain, base=(*plain.base, term))).model
    loss = next(b for b in found.base if b.regressor.effect == "thermal.loss_heating")
    value, covariance = found.fit.of(loss.indices)
    assert value[0] == pytest.approx(1.0 / CAPACITY, rel=5e-3)
    assert np.sqrt(covariance[0, 0]) < 3e-3 / CAPACITY


@pytest.mark.parametrize("name", [GAIN, UNNAMED, LIFTED])
@pytest.mark.parametrize("wrong", [0.0, 0.08])
def test_the_loss_is_that_of_the_torque_and_not_of_its_report(wrong: float, name: str) -> None:
    """An error of the reported motor torque that was found is taken off the loss, if heat flows as if it were."""
    rows = heated(0.0)
    frame = rows.frame
    rows = replace(
        rows, frame=replace(frame, motor_torque=frame.motor_torque * (1.0 + wrong), power=frame.power * (1.0 + wrong))
    )
    found = SimpleNamespace(
        effect=REPORTED[name], columns=lambda own: own.motor_torque[:, None] * wrong / (1.0 + wrong)
    )
    zeros = Zeros((name,), reported={name: (Known(cast(Any, found), np.ones(1)),)})
    np.testing.assert_allclose(zeros.less(rows.frame).power, frame.power, rtol=1e-9)
    assert np.allclose(Zeros((), reported=zeros.reported).less(rows.frame).power, rows.frame.power)


def test_the_heat_capacity_is_that_of_the_recordings() -> None:
    rows = heated(0.0)
    everywhere = np.ones(rows.size, dtype=bool)
    base = problem(rows).base
    assert problems.heat_capacity(rows, base, everywhere) == pytest.approx(CAPACITY, rel=0.02)
    # a gearbox that was never warmed up does not tell
    cold = replace(rows, y=np.random.default_rng(3).normal(20.0, 0.01, rows.size))
    assert problems.heat_capacity(cold, base, everywhere) == problems.CAPACITY
    assert problems.heat_capacity(rows, (), everywhere) == problems.CAPACITY


def test_zeros_heat_a_light_gearbox_more() -> None:
    frame = heated(0.0).frame
    heavy, light = (zero_precisions(frame, None, capacity=c)[0] for c in (2.0e4, 5.0e3))
    assert heavy == pytest.approx(16.0 * light)


def test_a_function_without_a_name_has_to_predict_with_those_zeros_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    """It claims nothing but that it predicts; a name may be drowned by the heat of a zero."""
    rows = heated(0.0)
    plain = problem(rows)
    held = replace(plain, folds=np.where(np.arange(RECORDINGS_MADE) == 3, -1, plain.folds))
    term = BaseTerm(WanderingZero(), zero_precisions(rows.frame, None, capacity=CAPACITY))
    models = [begun(replace(held, base=base)).model for base in ((*held.base, term), held.base)]
    squares = iter((1.21, 1.0, 1.0, 1.21))
    monkeypatch.setattr(refuted, "_left_as_it_is", lambda *_: np.full(rows.size, np.sqrt(next(squares))))
    assert refuted._worse_as_it_is(models[0], ([], [])) == pytest.approx(1.1)
    assert refuted._worse_as_it_is(models[0], ([], [])) is None
    # without such zeros what is left is what is left
    assert refuted._worse_as_it_is(models[1], ([], [])) is None
