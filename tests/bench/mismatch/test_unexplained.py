"""Tones stay at one frequency whatever the speed; wander outlasts noise; neither is seen in noise alone."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from bench.mismatch.channels import Analysis
from bench.mismatch.evaluate import Scores
from bench.mismatch.tones import search, tone_spectrum
from bench.mismatch.unexplained import determined, undetermined
from bench.mismatch.wander import wander
from bench.simulation.frame import Frame
from bench.simulation.terms.memory import settled
from tests.bench.mismatch.test_terms import frame

RATE, SECONDS, RECORDINGS = 500.0, 30.0, 14


def _noise(rng: np.random.Generator, size: int, memory: float) -> np.ndarray:
    keep = np.exp(-1.0 / (memory * RATE))
    out = np.empty(size)
    value = rng.normal()
    for i, shock in enumerate(rng.normal(0.0, np.sqrt(1.0 - keep**2), size)):
        value = keep * value + shock
        out[i] = value
    return 0.6 * out + 0.8 * rng.normal(size=size)


def _heard(rng: np.random.Generator, tone: float, order: float, hertz: float = 7.3) -> list:
    time = np.arange(int(RATE * SECONDS)) / RATE
    yes = np.ones(time.size, dtype=bool)
    out = []
    for index in range(RECORDINGS):
        turning = (0.3, 0.45, 0.7)[index % 3]  # Hz, one of three speeds
        signal = _noise(rng, time.size, 0.2)
        signal += tone * np.sin(2 * np.pi * hertz * time + rng.uniform(0, 6)) + order * np.sin(
            2 * np.pi * 12 * turning * time
        )
        out.append(tone_spectrum(index, signal, yes, yes, RATE, np.full(time.size, 2 * np.pi * turning)))
    return [s for s in out if s is not None]


def test_a_tone_is_found_at_its_frequency_with_its_amplitude() -> None:
    (tone,) = search(_heard(np.random.default_rng(1), 0.4, 1.0))
    assert tone.frequency == pytest.approx(7.3, abs=0.15)
    assert tone.amplitude == pytest.approx(0.4, rel=0.25)
    assert len(tone.recordings) > RECORDINGS // 2


def test_a_slow_limit_cycle_is_a_tone() -> None:
    (tone,) = search(_heard(np.random.default_rng(2), 0.6, 0.0, 0.83))
    assert tone.frequency == pytest.approx(0.83, abs=0.1)


def test_orders_of_the_shaft_and_coloured_noise_are_no_tones() -> None:
    for seed in range(4):
        assert search(_heard(np.random.default_rng(seed), 0.0, 1.0)) == []


def test_a_short_recording_has_no_spectrum() -> None:
    yes = np.ones(1000, dtype=bool)
    assert tone_spectrum(0, np.zeros(1000), yes, yes, RATE, np.ones(1000)) is None


def _frame() -> Frame:
    step, rows = 0.25, 200
    time = np.tile(np.arange(rows) * step, RECORDINGS)
    index = np.repeat(np.arange(RECORDINGS), rows)
    return replace(frame(time.size), recording=index, elapsed=time, steady=np.ones(time.size))


def test_a_level_that_switches_now_and_then_wanders_and_noise_does_not() -> None:
    rng = np.random.default_rng(3)
    rows = _frame()
    yes = np.ones(rows.size, dtype=bool)
    noise = rng.normal(size=rows.size)
    assert wander(noise, rows, yes, 1.0) is None
    switching = np.where(np.sin(2 * np.pi * rows.elapsed / 40.0 + rows.recording) > 0, 0.5, -0.5)
    slow = wander(noise + switching, rows, yes, 1.0)
    assert slow is not None
    assert slow.deviation == pytest.approx(0.5, rel=0.35)
    assert slow.ratio > 1.6


def test_offsets_between_recordings_do_not_wander() -> None:
    rng = np.random.default_rng(4)
    rows = _frame()
    residual = rng.normal(size=rows.size) + 3.0 * rng.normal(size=RECORDINGS)[rows.recording]
    assert wander(residual, rows, np.ones(rows.size, dtype=bool), 1.0) is None


def test_settled_levels_lose_their_noise_and_ramps_stay() -> None:
    rng = np.random.default_rng(5)
    rows = _frame()
    level = np.where(rows.recording % 2 == 0, 500.0, -500.0)
    ramp = rows.recording == 3
    load = np.where(ramp, np.linspace(-500.0, 500.0, rows.size), level + rng.normal(size=rows.size))
    out = settled(load, rows)
    assert np.ptp(out[rows.recording == 0]) == 0.0
    assert np.array_equal(out[ramp][:5], load[ramp][:5])


@pytest.mark.parametrize(
    ("forward", "backward", "enough"), [(12, 12, True), (12, 4, False), (12, 0, True), (0, 0, False)]
)
def test_a_residual_says_nothing_where_few_revolutions_calibrate_the_series(
    forward: int, backward: int, enough: bool
) -> None:
    turns = [SimpleNamespace(direction=1.0)] * forward + [SimpleNamespace(direction=-1.0)] * backward
    transmission = SimpleNamespace(harmonics=SimpleNamespace(turns=turns))
    analysis = Analysis(transmission=cast(Any, transmission))
    assert determined(analysis, "transmission_error") is enough
    assert determined(analysis, "motor_torque")


def test_what_few_revolutions_leave_is_undetermined_with_the_reason() -> None:
    turns = [SimpleNamespace(direction=1.0)] * 4
    angle = SimpleNamespace(frame=SimpleNamespace(recording=np.zeros(1, dtype=np.int64)))
    transmission = SimpleNamespace(harmonics=SimpleNamespace(turns=turns), angle=angle)
    analysis = Analysis(transmission=cast(Any, transmission))
    high = Scores(9.0, 8.0, 1.0, np.ones(1, dtype=bool), np.zeros(1), np.zeros(1))
    assert "8.0 times its noise" in undetermined(analysis, {"transmission_error": high})
    assert undetermined(analysis, {"transmission_error": replace(high, after=1.1)}) == ""
    assert undetermined(analysis, {}) == ""
