"""Standard deviations and their degrees of freedom where noise remembers itself, leverage is uneven, regressors err."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t

from bench.identification import Identification
from bench.identification.balances.heat import identify_heat
from bench.identification.balances.load_side import identify_load_side
from bench.identification.balances.slow_equations import friction_of
from bench.identification.samples.blocks import make_blocks
from bench.identification.samples.reduction import Reduction
from bench.identification.series.orders import nuisance_orders
from bench.identification.series.refined import identify_direction
from bench.identification.statistics.regression import regress
from tests.bench.identification.synthetic import true_model

RATE = 20.0


def _recording(name: str, kind: str, channels: dict[str, np.ndarray]) -> Reduction:
    size = channels["time"].size
    blocks = make_blocks(channels, RATE, np.zeros(size, dtype=bool), np.empty(0, dtype=np.int64))
    return Reduction(name, kind, 185.0, 0.0, (0.0, 0.0, 0.0), False, blocks, None, None, None, ())


def test_intervals_hold_with_offsets_memory_and_uneven_groups() -> None:
    rng = np.random.default_rng(4)
    held = []
    for _ in range(150):
        sizes = rng.integers(20, 60, 14)
        sizes[0] = 600
        group = np.repeat(np.arange(14), sizes)
        x = np.repeat(rng.normal(size=14), sizes) + 0.2 * rng.normal(size=group.size)
        slow = np.repeat(rng.normal(size=14), sizes) + np.cumsum(rng.normal(size=group.size)) * 0.05
        fit = regress({"one": np.ones(group.size), "slope": x}, 1.0 + 2.0 * x + slow, group)
        held.append(abs(fit.values["slope"] - 2.0) < t.ppf(0.975, fit.freedom["slope"]) * fit.std["slope"])
    assert 0.91 <= np.mean(held) <= 0.995


def test_intervals_hold_where_recordings_of_a_level_share_an_error() -> None:
    """Six torques of nine recordings each: what goes with the torque is known from six values, not from 54."""
    rng = np.random.default_rng(8)
    group = np.repeat(np.arange(54), 20)
    level, speed = group // 9, group % 3
    torque, omega = np.array([-5.0, -4.0, -0.3, 0.4, 4.2, 5.0])[level], np.array([18.0, 26.0, 32.0])[speed]
    columns = {"one": np.ones(group.size), "torque": np.abs(torque), "omega": omega}
    held: dict[str, list[bool]] = {"alone": [], "shared": []}
    for _ in range(120):
        error = 0.05 * rng.normal(size=6)[level] + 0.02 * rng.normal(size=54)[group] + 0.1 * rng.normal(size=group.size)
        target = 1.0 + 0.04 * np.abs(torque) + 0.006 * omega + error
        alone = regress(columns, target, group)
        shared = regress(columns, target, group, (), (level,))
        for name, fit in (
            ("alone", alone),
            ("shared", shared),
        ):
            off = abs(fit.values["torque"] - 0.04)
            held[name].append(off < t.ppf(0.975, fit.freedom["torque"]) * fit.std["torque"])
    assert np.mean(held["alone"]) < 0.75
    assert 0.9 <= np.mean(held["shared"]) <= 1.0


def test_rows_of_no_level_and_few_levels_add_nothing() -> None:
    rng = np.random.default_rng(9)
    group = np.repeat(np.arange(30), 20)
    x, target = rng.normal(size=600), rng.normal(size=600)
    alone = regress({"x": x, "one": np.ones(600)}, target, group)
    for labels in (np.full(600, -1), group % 3):
        again = regress({"x": x, "one": np.ones(600)}, target, group, (), (labels,))
        assert again.std == pytest.approx(alone.std)
        assert again.freedom == pytest.approx(alone.freedom)


def test_freedom_counts_the_groups_that_carry_a_parameter() -> None:
    group = np.repeat(np.arange(20), 50)
    rng = np.random.default_rng(0)
    even, few = rng.normal(size=1000), np.where(group < 2, rng.normal(size=1000), 0.0)
    fit = regress({"even": even, "few": few}, rng.normal(size=1000), group)
    assert fit.freedom["even"] > 12.0
    assert fit.freedom["few"] < 3.0


def test_nuisance_is_fitted_and_not_reported() -> None:
    rng = np.random.default_rng(1)
    x, wave = rng.normal(size=400), rng.normal(size=400)
    fit = regress({"x": x, "wave": wave}, 2.0 * x + 5.0 * wave, np.arange(400) // 20, ["wave"])
    assert set(fit.values) == {"x"}
    assert fit.rmse == pytest.approx(0.0, abs=1e-9)


def _loaded(level: float, offset: float, d: float, seed: int) -> Reduction:
    """A load side of 3 kg·m² and 8 N·m with ripple; the drive's report errs by ``offset`` at this level."""
    rng = np.random.default_rng(seed)
    time = np.arange(int(40.0 * RATE)) / RATE
    # speeds up all the way
    angle = d * (0.05 * time + 0.5 * 0.02 * time**2 / 4.0)
    reported = level + offset + 0.01 * rng.normal(size=time.size)
    torque = level + 8.0 * d + 3.0 * d * 0.005 + 5.0 * np.sin(6.0 * angle)
    channels = {"time": time, "motor_angle": 185.0 * angle, "load_angle": angle, "load_torque": torque}
    return _recording(f"l{seed}", "constant_velocity", channels | {"load_motor_torque": reported})


def test_offsets_of_levels_widen_the_zero_and_leave_friction_alone() -> None:
    offsets = {-500.0: 0.2, 100.0: -0.1, 700.0: -0.16}
    runs = [
        _loaded(v, e, d, k) for k, (v, e, d) in enumerate((v, e, d) for v, e in offsets.items() for d in (1.0, -1.0))
    ]
    fit, _ = identify_load_side(runs, (6,))
    assert fit.freedom["z_0"] == 2.0
    assert fit.std["z_0"] == pytest.approx(np.std(list(offsets.values()), ddof=1) / np.sqrt(3.0), rel=0.02)
    assert fit.values["f_b"] == pytest.approx(8.0, abs=0.02)
    without, _ = identify_load_side(runs, ())
    assert fit.rmse < 0.05 < without.rmse


def _turning(speed: float, temperature: float, extra: float, kind: str, seed: int) -> Reduction:
    rng = np.random.default_rng(seed)
    time = np.arange(400) / RATE
    d = np.sign(speed)
    torque = 0.5 * d + (0.006 - 1e-4 * (temperature - 25.0)) * speed + extra + 1e-3 * rng.normal(size=time.size)
    channels = {"time": time, "motor_angle": speed * time, "motor_torque": torque, "load_torque": np.zeros(time.size)}
    return _recording(f"f{seed}", kind, channels | {"temperature": np.full(time.size, temperature)})


def test_heating_counts_for_friction_only_where_nothing_else_tells() -> None:
    slow = [
        _turning(d * v, c, 0.0, "constant_velocity", k)
        for k, (d, v, c) in enumerate((d, v, c) for d in (1, -1) for v in (8.0, 20.0, 32.0) for c in (22.0, 35.0))
    ]
    hot = [_turning(200.0, 28.0 + k, 0.02, "heating", 50 + k) for k in range(2)]
    fit, _ = friction_of([*slow, *hot])
    assert fit.values["f_v"] == pytest.approx(0.006, rel=2e-3)
    cold = [r for r in slow if r.blocks.temperature[0] < 30.0]
    fit, _ = friction_of([*cold, *hot])
    assert "f_vT" in fit.values


def _yielding(speed: float, seed: int) -> Reduction:
    """A steady speed whose loop gives way to a swing of the load that the torque balance does not have."""
    time = np.arange(1200) / RATE
    swing = 0.02 * np.sin(2.0 * np.pi * 0.35 * time + seed)
    angle = speed * time - np.cumsum(swing) / (0.6 * RATE)
    noise = 1e-4 * np.random.default_rng(seed).normal(size=time.size)
    torque = 0.5 * np.sign(speed) + 0.006 * speed + swing + noise
    channels = {"time": time, "motor_angle": angle, "motor_torque": torque, "load_torque": np.zeros(time.size)}
    blocks = make_blocks(channels, RATE, np.ones(time.size, dtype=bool), np.empty(0, dtype=np.int64))
    return Reduction(f"y{seed}", "constant_velocity", 185.0, 0.0, (0.0, 0.0, 0.0), False, blocks, None, None, None, ())


def test_a_speed_that_answers_to_its_equations_error_does_not_bias_the_friction() -> None:
    runs = [_yielding(d * v, k) for k, (d, v) in enumerate((d, v) for d in (1, -1) for v in (3.0, 4.0, 5.0))]
    fit, _ = friction_of(runs)
    # 5e-4 less where each row's own speed counts
    assert fit.values["f_v"] == pytest.approx(0.006, abs=2e-4)


@pytest.mark.parametrize(("count", "much"), [(1e-9, True), (1e-3, False)])
def test_a_fine_encoder_tells_the_inertia_from_steady_speeds_as_well(count: float, much: bool) -> None:
    runs = []
    for k, d in enumerate((1.0, -1.0, 1.0, -1.0, 1.0)):
        time = np.arange(1200) / RATE
        angle = d * (0.15 * time + 2e-3 * np.sin(1.5 * time + k))
        rate = -d * 2e-3 * 1.5**2 * np.sin(1.5 * time + k)
        torque = 8.0 * d + 3.0 * rate + 1e-3 * np.random.default_rng(k).normal(size=time.size)
        zero = np.zeros(time.size)
        channels = {"time": time, "load_angle": angle, "motor_angle": 185.0 * angle, "load_torque": torque}
        blocks = make_blocks(
            channels | {"load_motor_torque": zero}, RATE, np.ones(time.size, dtype=bool), np.empty(0, dtype=np.int64)
        )
        one = Reduction(f"a{k}", "constant_velocity", 185.0, 0.0, (0.0, 0.0, 0.0), False, blocks, None, None, None, ())
        runs.append(replace(one, load_count=count))
    fit, _ = identify_load_side(runs)
    assert ("J_L" in fit.values) is much
    if much:
        # 20 rows a second and a triangle of two: a wave of 1.5 rad/s passes alike in torque and acceleration
        assert fit.values["J_L"] == pytest.approx(3.0, abs=3.0 * fit.std["J_L"])
        assert fit.std["J_L"] < 0.1


def _heated(start: float, power: float, seed: int, spin: float = 0.0) -> Reduction:
    time = np.arange(int(1500 * RATE)) / RATE
    end = 21.0 + power * 0.25
    temperature = (
        end + (start - end) * np.exp(-time / 6250.0) + 0.02 * np.random.default_rng(seed).normal(size=time.size)
    )
    omega = 150.0 + spin * time
    channels = {
        "time": time,
        "motor_angle": 150.0 * time + 0.5 * spin * time**2,
        "load_angle": np.zeros(time.size),
        # what spins the rotor up does not heat
        "motor_torque": power / omega + 0.5 * spin,
        "load_torque": np.zeros(time.size),
        "temperature": temperature,
    }
    return _recording(f"h{seed}", "heating", channels)


def test_power_that_errs_recording_by_recording_is_within_the_intervals() -> None:
    rng = np.random.default_rng(7)
    deviates = []
    for trial in range(10):
        runs = []
        for k, (start, power) in enumerate([(22.0, 300.0), (30.0, 300.0), (45.0, 30.0), (60.0, 30.0)]):
            run = _heated(start, power, 100 * trial + k)
            gain = 1.0 + 5e-4 * rng.normal()
            runs.append(replace(run, blocks=replace(run.blocks, motor_torque=run.blocks.motor_torque * gain)))
        fit = identify_heat(runs)
        deviates.append([(fit.values[s] - v) / fit.std[s] for s, v in (("C", 25e3), ("R", 0.25), ("T_amb", 21.0))])
    assert 0.7 < float(np.sqrt(np.mean(np.square(deviates)))) < 1.3


def test_stored_energy_is_not_lost() -> None:
    runs = [_heated(22.0 + 6.0 * k, 300.0 - 90.0 * k, k, spin=0.05) for k in range(4)]
    blind, knowing = identify_heat(runs), identify_heat(runs, inertia=0.5)
    assert abs(knowing.values["C"] - 25e3) < 3.0 * knowing.std["C"]
    assert abs(blind.values["C"] - 25e3) > 3.0 * blind.std["C"]


def test_orders_beside_those_asked_for_are_no_noise(found: Identification) -> None:
    true = true_model().direction(1.0)
    assert true is not None
    group = [r for r in found.reductions if r.steady is not None and r.steady.window.direction > 0 and not r.validation]
    rest = [f for f in (*found.orders, 2, 5, 37, 110) if f not in (1, 3)]
    beside = identify_direction(group, (1, 3), (150,), "positive", rest)
    blind = identify_direction(group, (1, 3), (150,), "positive")
    assert beside is not None
    assert blind is not None
    sharp, wide = (np.mean([h.variance[0] for h in d.harmonics]) for d in (beside, blind))
    assert sharp < 0.01 * wide
    assert beside.fourier.amplitude_std is not None
    off = np.abs(beside.fourier.amplitude - true.amplitude[:2]) / beside.fourier.amplitude_std
    assert np.mean(off < t.ppf(0.975, beside.freedom)) >= 0.85


def test_the_command_finds_the_weaker_orders_by_itself(found: Identification) -> None:
    assert {5, 37, 110} <= set(nuisance_orders(found.proposals, found.notch_orders, 312))
    assert not set(nuisance_orders(found.proposals, found.notch_orders, 312)) & {*found.orders, *found.notch_orders}
    assert 110 not in nuisance_orders(found.proposals, found.notch_orders, 100)


def test_half_a_count_of_the_load_encoder_is_in_the_constant_of_the_offset_alone(found: Identification) -> None:
    group = [
        replace(r, load_count=0.0)
        for r in found.reductions
        if r.steady is not None and r.steady.window.direction > 0 and not r.validation
    ]
    coarse = [replace(r, load_count=4e-5) for r in group]
    fine, wide = (identify_direction(some, (1, 3), (150,), "positive") for some in (group, coarse))
    assert fine is not None
    assert wide is not None
    assert fine.fourier.offset_std is not None
    assert wide.fourier.offset_std is not None
    added = wide.fourier.offset_std**2 - fine.fourier.offset_std**2
    np.testing.assert_allclose(added[:9], 0.0, atol=1e-30)
    assert np.sqrt(added[9]) == pytest.approx(2e-5)
    np.testing.assert_array_equal(wide.fourier.phase_std, fine.fourier.phase_std)
