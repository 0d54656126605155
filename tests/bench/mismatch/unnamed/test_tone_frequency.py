"""The frequency of a tone: as uncertain as it is, with few recordings and where the tone does not keep to it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from scipy.signal import lfilter

from bench.mismatch.discovery import Look, Structure
from bench.mismatch.recordings.vibration import Run, density_of
from bench.mismatch.unnamed.spectral_line import measured
from bench.mismatch.unnamed.structure import look_for_tone
from bench.mismatch.unnamed.tone_frequency import frequency_of
from bench.mismatch.unnamed.tone_phases import phases
from bench.mismatch.unnamed.tones import _crest, tone
from bench.simulation.frame import FloatArray
from tests.bench.mismatch.report import made

RATE, MEMORY_S = 200.0, 0.06
NEAR = 31.3
NORMAL = 1.96
"""standard deviations that hold 95 %"""

Wander = Callable[[FloatArray, np.random.Generator], FloatArray]


def steady(_time: FloatArray, _rng: np.random.Generator) -> FloatArray:
    return np.zeros(1)


def of_each_recording(time: FloatArray, rng: np.random.Generator) -> FloatArray:
    return np.asarray(2.0 * np.pi * 0.01 * rng.normal() * time)


def walking(time: FloatArray, rng: np.random.Generator) -> FloatArray:
    return np.cumsum(0.1 / np.sqrt(RATE) * rng.normal(size=time.size))


def swaying(time: FloatArray, _rng: np.random.Generator) -> FloatArray:
    """The same in each recording."""
    return np.asarray(0.3 * np.sin(0.7 * time + 0.49))


def run(number: int, rng: np.random.Generator, frequency: float, amplitude: float, wander: Wander = steady) -> Run:
    """White and coloured noise of a standard deviation of 1, a tone, and a gap filled with one value."""
    time = np.arange(round(rng.uniform(10.0, 30.0) * RATE)) / RATE
    keep = np.exp(-1.0 / (RATE * MEMORY_S))
    values = 0.8 * rng.normal(size=time.size)
    values += lfilter([0.6 * np.sqrt(1.0 - keep**2)], [1.0, -keep], rng.normal(size=time.size))
    phase = 2.0 * np.pi * frequency * time + rng.uniform(0.0, 2.0 * np.pi) + wander(time, rng)
    values += amplitude * rng.uniform(0.6, 1.3) * np.sin(phase)
    gap = int(rng.integers(time.size - 20))
    values[gap : gap + 20] = np.median(values)
    return Run(number, values, RATE, 0.01 * 1.07**number)


def folder(seed: int, recordings: int, amplitude: float, wander: Wander = steady) -> list[Run]:
    """Recordings of 24 speeds, of which the first hear the tone."""
    rng = np.random.default_rng(seed)
    return [run(k, rng, NEAR, amplitude if k < recordings else 0.0, wander) for k in range(24)]


@pytest.mark.parametrize("wander", [steady, of_each_recording, walking, swaying])
def test_the_interval_holds_the_frequency_as_often_as_it_says(wander: Wander) -> None:
    inside = []
    for seed in range(40):
        rng = np.random.default_rng([seed, 1])
        true, amplitude = NEAR + rng.uniform(-0.05, 0.05), 10.0 ** rng.uniform(-0.3, 0.7)
        found = frequency_of([run(k, rng, true, amplitude, wander) for k in range(rng.integers(3, 7))], NEAR)
        assert found is not None
        inside.append(abs(found.value - true) <= NORMAL * found.std)
    # at 0.9 for each, fewer than 32 of 40 have a chance of 2 %
    assert np.count_nonzero(inside) >= 32


def test_a_tone_that_keeps_to_its_frequency_is_told_by_its_phase_sharper_than_by_spectra() -> None:
    runs = folder(1, 5, 2.0)
    by_spectra = tone([density_of(r) for r in runs], 1)
    assert by_spectra is not None
    assert 3 <= len(by_spectra.heard) <= 5
    assert set(by_spectra.heard) <= set(range(5))
    by_phase = frequency_of(runs[:5], by_spectra.frequency)
    assert by_phase is not None
    assert by_phase.std < by_spectra.frequency_std
    assert abs(by_phase.value - NEAR) < 3.0 * by_phase.std


def told(runs: Sequence[Run]) -> tuple[float, float]:
    """Frequency and standard deviation of the tone that is reported."""
    outcome = made.outcome(made.campaign(), "transmission_error", [], 0.1)
    outcome.structure = Structure.of({"mean": Look("nothing", 0.5, 0.5)})
    densities = [density_of(r) for r in runs]
    look_for_tone(outcome, densities, runs=lambda recordings: [runs[k] for k in recordings])
    (found,) = outcome.discoveries
    frequency = found.parameters[0]
    assert frequency["std"] is not None
    return float(frequency["value"]), float(frequency["std"])


@pytest.mark.parametrize("seed", range(3))
def test_a_phase_that_sways_alike_in_all_recordings_is_no_other_frequency(seed: int) -> None:
    """Recordings that err alike do not differ: it shows in the course of the phase alone."""
    runs = folder(seed, 5, 4.0, swaying)
    value, std = told(runs)
    assert abs(value - NEAR) <= 2.0 * std
    assert 0.001 < std < 0.02
    spectra = tone([density_of(r) for r in runs], seed)
    assert spectra is not None
    assert abs(spectra.frequency - NEAR) > abs(value - NEAR)


def test_a_phase_in_noise_is_not_followed() -> None:
    rng = np.random.default_rng(4)
    assert phases(run(0, rng, NEAR, 0.0), NEAR, 24) is None
    loud = run(0, rng, NEAR, 3.0)
    assert frequency_of([loud, run(1, rng, NEAR, 0.0)], NEAR) is None
    found = phases(loud, NEAR, 6)
    assert found is not None
    assert found.time.size == found.phase.size == 6


def test_without_noise_the_frequency_is_the_tone_s() -> None:
    time = np.arange(4000) / RATE
    runs = [Run(k, np.sin(2.0 * np.pi * 31.317 * time + k), RATE, 0.01) for k in range(3)]
    found = frequency_of(runs, NEAR)
    assert found is not None
    assert found.value == pytest.approx(31.317, abs=1e-5)


def test_a_line_in_three_recordings_is_as_uncertain_as_three_tell() -> None:
    """Draws of three recordings with replacement scatter by two thirds of the variance, and are few."""
    rng = np.random.default_rng(5)
    inside = []
    for seed in range(100):
        excess = np.array([0.25, 1.0, 0.25]) + 0.03 * rng.normal(size=(3, 3))
        line = measured(excess, 0.1, seed)
        inside.append(abs(line.offset) <= NORMAL * line.offset_std)
    assert np.mean(inside) > 0.9


def test_the_crest_of_a_line_is_told_where_bins_beside_it_stand_out_as_well() -> None:
    ratio = np.ones((6, 40))
    ratio[:, 18:23] = [3.0, 250.0, 1000.0, 250.0, 3.0]
    ratio[0, 21] = 1e5
    assert [_crest(ratio, peak) for peak in (18, 19, 20, 21, 22)] == [20] * 5
    ratio[:5, 20] = np.nan
    assert _crest(ratio, 19) == 21
