from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from drivers.torque_sensor import Findings, PlausibilityLimits, PlausibilityMonitor, TorqueScale

CYCLE = 0.0005
SCALE = TorqueScale(10.0 / 32768, 1000.0)
LIMITS = PlausibilityLimits(
    frozen_s=0.25, disagreement_nm=60.0, disagreement_s=0.1, smoothing_s=0.05, drift_nm=30.0, drift_window_s=2.0
)
Torque = NDArray[np.float64]


def measure(torque: Torque, noise_nm: float = 1.0) -> NDArray[np.int16]:
    noise = noise_nm * np.random.default_rng(3).standard_normal(len(torque))
    return np.rint((torque + noise) / SCALE.newton_metre_per_count).astype(np.int16)


def run(
    counts: NDArray[np.int16],
    expected: Torque,
    turning: bool = True,
    block: int = 1000,
    limits: PlausibilityLimits = LIMITS,
) -> Findings:
    monitor = PlausibilityMonitor(limits, CYCLE)
    parts = [
        monitor.update(
            c := counts[at : at + block], SCALE.torque(c), expected[at : at + block], np.full(len(c), turning)
        )
        for at in range(0, len(counts), block)
    ]
    return Findings(*(np.concatenate([getattr(p, f) for p in parts]) for f in Findings.__slots__))


N = 12_000
LOAD = np.full(N, 500.0)
RIPPLE = LOAD + 20.0 * np.sin(np.arange(N) * 0.3)


def test_a_sound_sensor_passes() -> None:
    found = run(measure(RIPPLE), LOAD)
    assert found.plausible.all()
    assert found.text() is None


def test_broken_wire_is_at_odds_with_the_load_motor_within_its_time() -> None:
    counts = measure(RIPPLE)
    counts[5000:] = 3  # the input floats near zero and even scatters
    counts[5000::2] += 1
    found = run(counts, LOAD)
    assert not found.frozen.any()
    first = int(np.argmax(found.at_odds))
    assert 5000 < first < 5000 + (LIMITS.disagreement_s + LIMITS.smoothing_s) / CYCLE
    assert found.at_odds[first:].all()
    text = found.text("torque sensor")
    assert text is not None
    assert "N·m away from what the load motor says" in text


def test_frozen_only_counts_while_turning() -> None:
    counts = measure(LOAD)
    counts[4000:] = counts[4000]
    found = run(counts, LOAD)
    assert int(np.argmax(found.frozen)) == pytest.approx(4000 + LIMITS.frozen_s / CYCLE, abs=1)
    assert "does not change although the shaft turns" in (found.text() or "")
    assert not run(counts, LOAD, turning=False).frozen.any()


def test_slow_drift_is_seen_before_it_is_a_disagreement() -> None:
    slow = np.concatenate((np.zeros(5000), np.linspace(0.0, 55.0, 30_000)))
    expected = np.full(len(slow), 500.0)
    found = run(measure(expected + slow), expected)
    assert not found.at_odds.any()
    assert found.drifting.any()
    assert not found.drifting[:5000].any()
    assert "drifts" in (found.text() or "")


def test_a_constant_offset_is_no_drift() -> None:
    assert not run(measure(LOAD + 40.0), LOAD).drifting.any()


def test_disagreement_may_grow_with_torque() -> None:
    far = np.full(N, 2000.0)
    assert run(measure(far * 1.1), far).at_odds.any()
    wide = replace(LIMITS, disagreement_fraction=0.1)
    assert not run(measure(far * 1.1), far, limits=wide).at_odds.any()


@settings(max_examples=20, deadline=None)
@given(st.integers(150, 3000), st.integers(0, 3))
def test_blocks_do_not_change_what_is_found(block: int, kind: int) -> None:
    counts = measure(RIPPLE)
    if kind == 1:
        counts[3000:5000] = 7
    elif kind == 2:
        counts[6000:] += np.int16(250)
    elif kind == 3:
        counts[100:] = counts[100]
    whole, parts = run(counts, LOAD, block=N), run(counts, LOAD, block=block)
    for name in ("frozen", "at_odds", "drifting"):
        np.testing.assert_array_equal(getattr(whole, name), getattr(parts, name))


def test_reset_forgets() -> None:
    monitor = PlausibilityMonitor(LIMITS, CYCLE)
    counts = np.full(4000, 100, np.int16)
    turning = np.ones(4000, bool)
    assert monitor.update(counts, SCALE.torque(counts), SCALE.torque(counts), turning).frozen.any()
    monitor.reset()
    few = counts[:100]
    assert not monitor.update(few, SCALE.torque(few), SCALE.torque(few), turning[:100]).frozen.any()


@settings(max_examples=50)
@given(st.integers(1, 30_000), st.floats(0.001, 60.0), st.integers(0, 2**32 - 1))
def test_the_difference_is_smoothed_by_a_first_order_low_pass(rows: int, time_constant_s: float, seed: int) -> None:
    from scipy.signal import lfilter

    torque = 300.0 * np.random.default_rng(seed).standard_normal(rows)
    limits = replace(LIMITS, smoothing_s=time_constant_s)
    still = np.zeros(rows, np.bool_)
    found = PlausibilityMonitor(limits, CYCLE).update(np.zeros(rows, np.int16), torque, np.zeros(rows), still)
    a = np.exp(-CYCLE / time_constant_s)
    expected, _ = lfilter([1.0 - a], [1.0, -a], torque, zi=[a * torque[0]])
    np.testing.assert_allclose(found.difference_nm, expected, rtol=1e-9, atol=1e-9)
