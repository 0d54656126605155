"""Ring-down: what the load torque strikes as it crosses zero is told; what starts strike, what settles and what stands
in a recording all along is not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch import criteria
from bench.mismatch.recordings.vibration import Density
from bench.mismatch.unnamed.crossings import FINE_S, FineResidual, clear_of_zero, crossings, on_grid, to_read, windows
from bench.mismatch.unnamed.ring_down import RingDown, Ringing, after_crossings, ring_down
from bench.simulation.frame import ARRAYS, FloatArray, Frame, concatenate

NOISE = 0.05
FREQUENCY, DECAY, SIZE = 3.3, 0.9, 0.2
STEPS = round(40.0 / FINE_S)
STARTS = (0.2, 20.0)
"""s: begin of the motion, and the moment at which it turns round"""
CROSSINGS = (8.0, 14.0, 30.0)
SURE = 3.0
"""N·m: three standard deviations of the load torque's noise"""
RECORDINGS = 8
HALF = RECORDINGS // 2
"""of them, in which the load crosses zero"""


def recording(number: int, crosses: bool, seed: int = 0) -> Frame:
    """A recording that starts, turns round, and ends in motion; its load goes up and down through zero or stays."""
    elapsed = FINE_S * np.arange(STEPS)
    direction = np.where(elapsed < STARTS[0], 0.0, np.where(elapsed < STARTS[1], 1.0, -1.0))
    since = np.where(elapsed < STARTS[1], elapsed - STARTS[0], elapsed - STARTS[1])
    times = [0.0, 7.0, 9.0, 13.0, 15.0, 29.0, 31.0, 40.0]
    load = np.interp(elapsed, times, [100.0, 100.0, -100.0, -100.0, 100.0, 100.0, -100.0, -100.0])
    torque = load if crosses else np.full(STEPS, 100.0)
    torque = torque + np.random.default_rng(seed + 100 * number).normal(size=STEPS)
    values: dict[str, FloatArray] = {name: np.zeros(STEPS) for name in ARRAYS}
    values |= {"elapsed": elapsed, "direction": direction, "reversal_time": np.abs(since), "count": np.ones(STEPS)}
    values |= {"torque": torque, "torque_level": torque}
    return Frame(ratio=185.0, **values | {"recording": np.full(STEPS, number, dtype=np.int64)})  # type: ignore[arg-type]


def ringing(after: FloatArray, rng: np.random.Generator) -> FloatArray:
    """An oscillation that fades, of a phase of its own."""
    return np.asarray(SIZE * np.exp(-after / DECAY) * np.sin(2.0 * np.pi * FREQUENCY * after + rng.uniform(0.0, 6.0)))


def left_in(frame: Frame, where: str, seed: int) -> FloatArray:
    """What is left in a recording: noise, and something besides."""
    number = int(frame.recording[0])
    rng = np.random.default_rng(seed + 10 * number)
    out = rng.normal(scale=NOISE, size=frame.size)
    crossed = CROSSINGS if number < HALF else ()
    for moment in {"crossings": crossed, "starts": STARTS, "all": (*crossed, *STARTS)}.get(where, ()):
        after = frame.elapsed - moment
        out += np.where(after >= 0.0, ringing(after, rng), 0.0)
    if where == "once" and number == 0:
        after = frame.elapsed - CROSSINGS[0]
        out += np.where(after >= 0.0, 10.0 * ringing(after, rng), 0.0)
    for moment in crossed:
        after = frame.elapsed - moment
        if where == "step":
            out += SIZE * np.tanh((after - 0.3) / 0.1) * (np.abs(after) < 3.0)
        elif where == "settles":
            out += SIZE * np.exp(-np.maximum(after, 0.0) / 0.25) * (after >= 0.0)
    if where == "order" and crossed:
        out += SIZE * np.sin(2.0 * np.pi * 4.0 * frame.elapsed + rng.uniform(0.0, 6.0))
    if where == "reddish" and crossed:
        for k in range(1, out.size):
            out[k] += 0.9 * out[k - 1]
    return out


def campaign(seed: int) -> list[Frame]:
    """Recordings whose load crosses zero, and as many whose load stays."""
    return [recording(number, number < HALF, seed) for number in range(RECORDINGS)]


def looked(where: str, seed: int = 1, missing: float = 0.0) -> RingDown | None:
    """The look at a campaign in which the steps after crossings are ``missing`` for so many seconds."""
    frames = campaign(seed)

    def left() -> Iterator[FineResidual]:
        for number in to_read(concatenate(frames), SURE, [True] * RECORDINGS).tolist():
            values = left_in(frames[number], where, seed)
            for moment in CROSSINGS:
                after = frames[number].elapsed - moment
                values[(after > 0.0) & (after < missing)] = np.nan
            yield FineResidual(frames[number], values + 0.3)

    return after_crossings(left(), SURE, [True] * RECORDINGS)


def told(where: str, seed: int = 1, missing: float = 0.0) -> Ringing:
    found = looked(where, seed, missing)
    assert found is not None
    assert found.p_value < criteria.ERROR_RATE_OF_A_CHANNEL
    assert found.ringing is not None
    return found.ringing


def test_what_crossings_strike_is_told_with_its_frequency_decay_and_size() -> None:
    found = told("crossings")
    assert len(found.rings) == HALF * len(CROSSINGS)
    for (value, std), true in ((found.frequency, FREQUENCY), (found.decay, DECAY), (found.size, SIZE)):
        assert std is not None
        assert abs(value - true) < max(4.0 * std, 0.1 * true)
        assert 0.0 < std < 0.3 * true


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("where", ["nothing", "starts", "step", "settles", "order", "reddish", "once"])
def test_what_is_no_ringing_of_crossings_is_not_told(where: str, seed: int) -> None:
    found = looked(where, seed)
    assert found is not None
    assert found.p_value > criteria.ERROR_RATE_OF_A_CHANNEL
    assert found.ringing is None


def noise_alone(seed: int, period: float, seconds: float, recordings: int) -> RingDown | None:
    """The look at white noise in recordings in motion, whose load goes up and down with a ``period`` in s."""
    elapsed = np.arange(0.0, seconds, FINE_S)
    load = 100.0 * (1.0 - 4.0 * np.abs(np.mod(elapsed / period, 1.0) - 0.5))
    values: dict[str, FloatArray] = {name: np.zeros(elapsed.size) for name in ARRAYS}
    values |= {"elapsed": elapsed, "direction": np.ones(elapsed.size), "torque": load, "torque_level": load}
    own = [{**values, "recording": np.full(elapsed.size, k, dtype=np.int64)} for k in range(recordings)]
    rng = np.random.default_rng(seed)
    left = (FineResidual(Frame(ratio=185.0, **v), rng.normal(size=elapsed.size)) for v in own)  # type: ignore[arg-type]
    return after_crossings(left, SURE, [True] * recordings)


@pytest.mark.parametrize(
    ("period", "seconds", "recordings"),
    [(7.2, 60.0, 3), (8.4, 60.0, 3), (20.0, 120.0, 1), (5.4, 60.0, 2)],
    ids=["windows of two lengths", "of two others", "one recording", "hardly a quiet window"],
)
def test_in_noise_a_chance_is_as_rare_as_it_says(period: float, seconds: float, recordings: int) -> None:
    found = [noise_alone(seed, period, seconds, recordings) for seed in range(40)]
    chances = np.array([1.0 if one is None else one.p_value for one in found])
    assert np.sum(chances < 0.05) <= 6  # of 40 with a chance of 0.05 each: more in one of 100
    assert np.sum(chances < criteria.ERROR_RATE_OF_A_CHANNEL) <= 1


def spectrum_of_torque(number: int) -> Density:
    """White noise of the load torque, of which a step keeps 1 N*m."""
    rate, size = 1.0 / FINE_S, 200
    return Density(number, np.full(size, 2.0 / rate), rate / 2.0 / size, 100.0, rate, 0.02)


@pytest.mark.parametrize(("order", "rings"), [(80.0, True), (150.0, False)])
def test_what_has_the_frequency_of_a_ripple_at_the_speed_there_may_be_the_ripple(order: float, rings: bool) -> None:
    """A control's ripple stands in the load torque, and a steep offset follows that where the load is near zero."""
    speed = 2.0 * np.pi * FREQUENCY / 150.0
    frames = [replace(f, velocity=speed * f.direction) for f in campaign(1)]
    residuals = {k: FineResidual(frames[k], left_in(frames[k], "crossings", 1)) for k in range(RECORDINGS)}
    found = ring_down(
        concatenate(frames),
        [spectrum_of_torque(k) for k in range(RECORDINGS)],
        np.ones(RECORDINGS, dtype=bool),
        lambda some: (residuals[k] for k in some),
        (order,),
    )
    assert (found is not None and found.ringing is not None) == rings


def test_the_begin_of_a_recording_in_motion_is_no_start() -> None:
    frame = recording(5, True)
    moving = Frame(**{name: getattr(frame, name) for name in ARRAYS} | {"ratio": 185.0, "direction": np.ones(STEPS)})
    struck, reference = windows(FineResidual(moving, np.zeros(STEPS)), SURE)
    assert len(struck) == len(CROSSINGS)
    assert not any(w.after_start for w in reference)
    assert min(w.start for w in reference) >= 1.5


def test_crossings_are_told_beside_starts_that_ring_as_much() -> None:
    assert len(told("all").rings) == HALF * len(CROSSINGS)


def test_what_is_not_compared_is_bridged_and_no_step() -> None:
    assert len(told("crossings", missing=0.1).rings) == HALF * len(CROSSINGS)
    found = looked("nothing", missing=0.1)
    assert found is not None
    assert found.ringing is None
    assert looked("crossings", missing=1.0) is None  # too much of each window


def test_it_lies_after_the_crossings_alone() -> None:
    found = told("crossings")
    frame = recording(0, True)
    size = found.on_rows(frame)
    after = np.min([np.where(frame.elapsed >= t - 0.1, frame.elapsed - t, np.inf) for t in CROSSINGS], axis=0)
    assert np.all(size[after > 2.2] == 0.0)
    assert np.sqrt(np.mean(size[np.abs(after) < 0.3] ** 2)) > 0.3 * SIZE
    assert not found.on_rows(recording(6, False)).any()


def test_a_long_row_has_its_share_of_what_rings() -> None:
    found = told("crossings")
    fine = recording(0, True)
    long = fine.take(np.arange(50, STEPS, 100))
    energy = float(np.sum(found.on_rows(fine) ** 2) * FINE_S)
    assert float(np.sum(found.on_rows(long) ** 2) * 2.0) == pytest.approx(energy, rel=0.02)


def test_a_load_at_zero_that_scatters_crosses_nothing() -> None:
    frame = recording(0, True)
    assert np.allclose(frame.elapsed[crossings(frame, SURE)], CROSSINGS, atol=0.2)
    scattering = np.random.default_rng(3).normal(size=frame.size)
    values = {name: getattr(frame, name) for name in ARRAYS}
    at_zero = Frame(**values | {"ratio": 185.0, "torque": scattering, "torque_level": scattering})
    assert crossings(at_zero, 5.0 * SURE / 3.0).size == 0
    assert to_read(at_zero, 5.0 * SURE / 3.0, [True]).size == 0
    assert to_read(recording(1, False), SURE, [True] * 2).size == 0


def test_the_sign_of_a_load_counts_beyond_the_noise_of_a_step() -> None:
    """Ten samples of white noise of 3.2 N·m make 1 N·m: a bearing that drags by 6 N·m turns the sign."""
    rate, seconds = 500.0, 10.0
    power = np.full(round(0.5 * rate * seconds) + 1, 2.0 * 3.2**2 / rate, dtype=np.float32)
    clear = clear_of_zero([Density(k, power, 1.0 / seconds, 100.0, rate, 0.02) for k in range(5)])
    assert clear == pytest.approx(3.0 * 3.2 / np.sqrt(10.0), rel=0.05)
    assert clear_of_zero([]) is None


def test_fitted_recordings_are_read_first() -> None:
    frames = concatenate([recording(number, number < 12) for number in range(14)])
    fitted = [number >= 6 for number in range(14)]
    assert to_read(frames, SURE, fitted).tolist() == [6, 7, 8, 9, 10, 11, 0, 1, 2, 3, 4, 5, 12, 13]


def test_a_crossing_at_a_turn_counts_from_the_turn() -> None:
    frame = recording(0, False)
    torque = np.where(frame.elapsed < STARTS[1] - 0.1, -100.0, 100.0)
    turned = Frame(**{name: getattr(frame, name) for name in ARRAYS} | {"ratio": 185.0, "torque": torque})
    assert np.allclose(frame.elapsed[crossings(turned, SURE)], [STARTS[1]], atol=FINE_S)


def test_windows_after_crossings_and_others_do_not_meet() -> None:
    frame = recording(0, True)
    struck, others = windows(FineResidual(frame, np.zeros(STEPS)), SURE)
    assert len(struck) == len(CROSSINGS)
    assert {w.after_start for w in others} == {False, True}
    begin = np.array([w.start for w in others])
    end = begin + FINE_S * np.array([w.left.size for w in others])
    for one in struck:
        assert np.all((end <= one.start) | (begin >= one.start + FINE_S * one.left.size - 1e-9))


def test_rows_of_another_length_are_told_in_equal_steps() -> None:
    frame = recording(2, True)
    wave = np.sin(2.0 * np.pi * 2.0 * frame.elapsed)
    for rows, most in ((np.arange(STEPS), 1e-9), (np.sort(np.random.default_rng(1).choice(STEPS, 1500, False)), 0.6)):
        finely = on_grid(frame.take(rows), wave[rows], 2)
        assert finely is not None
        assert np.allclose(np.diff(finely.frame.elapsed), FINE_S)
        assert np.nanmax(np.abs(finely.left - np.sin(2.0 * np.pi * 2.0 * finely.frame.elapsed))) < most
        assert np.mean(np.isfinite(finely.left)) > 0.9
    gap = np.flatnonzero((frame.elapsed < 10.0) | (frame.elapsed > 12.0))
    finely = on_grid(frame.take(gap), wave[gap], 2)
    assert finely is not None
    assert np.isnan(finely.left[(finely.frame.elapsed > 10.1) & (finely.frame.elapsed < 11.9)]).all()
    coarse = np.arange(0, STEPS, 5)
    assert on_grid(frame.take(coarse), wave[coarse], 2) is None
    assert on_grid(frame, wave, 1) is None
