"""Ring-down: what the load torque strikes as it crosses zero is told, what every start strikes is not."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch import criteria
from bench.mismatch.unnamed.ring_down import FINE_S, Finely, RingDown, Ringing, crossings, on_grid, ring_down, to_read
from bench.simulation.frame import ARRAYS, FloatArray, Frame, concatenate

NOISE = 0.05
FREQUENCY, DECAY, SIZE = 3.3, 0.9, 0.2
STEPS = round(40.0 / FINE_S)
STARTS = (0.2, 20.0)
"""s: begin of the motion, and the moment at which it turns round"""
CROSSINGS = (8.0, 14.0, 30.0)


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


def rung(frame: Frame, struck: tuple[float, ...], seed: int) -> FloatArray:
    """Noise, and an oscillation that fades from each moment at which something was struck."""
    rng = np.random.default_rng(seed)
    out = rng.normal(scale=NOISE, size=frame.size)
    for moment in struck:
        after = frame.elapsed - moment
        ring = np.exp(-after / DECAY) * np.sin(2.0 * np.pi * FREQUENCY * after + rng.uniform(0.0, 6.0))
        out += SIZE * np.where(after >= 0.0, ring, 0.0)
    return out


def looked(where: str, seed: int = 1) -> RingDown | None:
    """The look at four recordings whose load crosses zero and four whose load stays."""
    frames = [recording(number, number < 4, seed) for number in range(8)]
    struck = {"crossings": CROSSINGS, "starts": STARTS, "all": (*CROSSINGS, *STARTS), "nothing": ()}[where]
    apart = [tuple(t for t in struck if number < 4 or t in STARTS) for number in range(8)]
    left = [rung(frame, at, seed + 10 * k) for k, (frame, at) in enumerate(zip(frames, apart, strict=True))]

    def read(number: int) -> Finely:
        return Finely(frames[number], left[number])

    return ring_down(read, to_read(concatenate(frames)).tolist(), [True] * 8)


def told(where: str, seed: int = 1) -> Ringing:
    found = looked(where, seed)
    assert found is not None
    assert found.p_value < criteria.ERROR_RATE_OF_A_CHANNEL
    assert found.ringing is not None
    return found.ringing


def test_what_crossings_strike_is_told_with_its_frequency_decay_and_size() -> None:
    found = told("crossings")
    assert len(found.rings) == 4 * len(CROSSINGS)
    for (value, std), true in ((found.frequency, FREQUENCY), (found.decay, DECAY), (found.size, SIZE)):
        assert abs(value - true) < max(4.0 * std, 0.1 * true)
        assert 0.0 < std < 0.3 * true


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("where", ["nothing", "starts"])
def test_noise_and_what_every_start_strikes_are_not_told(where: str, seed: int) -> None:
    found = looked(where, seed)
    assert found is not None
    assert found.p_value > criteria.ERROR_RATE_OF_A_CHANNEL
    assert found.ringing is None


def test_crossings_are_told_beside_starts_that_ring_as_much() -> None:
    assert len(told("all").rings) == 4 * len(CROSSINGS)


def test_it_lies_after_the_crossings_alone() -> None:
    found = told("crossings")
    frame = recording(0, True)
    size = found.on_rows(frame)
    after = np.min([np.where(frame.elapsed >= t - 0.1, frame.elapsed - t, np.inf) for t in CROSSINGS], axis=0)
    assert np.all(size[after > 2.2] == 0.0)
    assert np.sqrt(np.mean(size[np.abs(after) < 0.3] ** 2)) > 0.3 * SIZE
    assert not found.on_rows(recording(6, False)).any()


def test_a_load_at_zero_that_scatters_crosses_nothing() -> None:
    frame = recording(0, True)
    quiet = recording(1, False)
    assert np.allclose(frame.elapsed[crossings(frame)], CROSSINGS, atol=0.2)
    scattering = np.random.default_rng(3).normal(size=frame.size)
    none = Frame(**{name: getattr(quiet, name) for name in ARRAYS} | {"ratio": 185.0, "torque": scattering})
    assert crossings(none).size <= 6
    assert to_read(quiet).size == 0


def test_a_crossing_at_a_turn_counts_from_the_turn() -> None:
    frame = recording(0, False)
    torque = np.where(frame.elapsed < STARTS[1] - 0.1, -100.0, 100.0)
    turned = Frame(**{name: getattr(frame, name) for name in ARRAYS} | {"ratio": 185.0, "torque": torque})
    assert np.allclose(frame.elapsed[crossings(turned)], [STARTS[1]], atol=FINE_S)


def test_rows_of_another_length_are_told_in_equal_steps() -> None:
    frame = recording(2, True).take(np.arange(0, STEPS, 3))
    finely = on_grid(frame, frame.torque, 2)
    assert finely is not None
    assert np.allclose(np.diff(finely.frame.elapsed), FINE_S)
    assert np.allclose(finely.left, finely.frame.torque)
    assert np.max(np.abs(finely.left - np.interp(finely.frame.elapsed, frame.elapsed, frame.torque))) < 10.0
    assert on_grid(frame, frame.torque, 1) is None
