from __future__ import annotations

import numpy as np
import pytest

from bench.identification import Identification
from bench.identification.series.harmonics import single_recording
from bench.identification.series.inputs import make_design
from bench.identification.series.polish import estimate_spread, fit_linear, fit_polar
from bench.identification.series.refined import identify_direction
from bench.simulation import basis
from bench.simulation.terms.nominal.transmission_error import PAPER_ORDERS
from tests.bench.identification.synthetic import true_model


def _standardised_errors(found: Identification) -> np.ndarray:
    """(estimate − truth) / standard deviation of all coefficients of both directions."""
    out = []
    truth = true_model()
    for direction, sign in (("positive", 1.0), ("negative", -1.0)):
        true, fourier = truth.direction(sign), found.refined[direction].fourier
        assert true is not None
        assert fourier.amplitude_std is not None
        assert fourier.phase_std is not None
        assert fourier.offset_std is not None
        difference = fourier.phase - true.phase
        difference[:, 9] = (difference[:, 9] + np.pi) % (2.0 * np.pi) - np.pi
        out += [(fourier.amplitude - true.amplitude) / fourier.amplitude_std, difference / fourier.phase_std]
        out.append(((fourier.offset - true.offset) / fourier.offset_std)[None, :])
    return np.concatenate([z.ravel() for z in out])


def test_intervals_cover_the_true_parameters(found: Identification) -> None:
    z = _standardised_errors(found)
    covered = float(np.mean(np.abs(z) < 1.96))
    assert 0.90 <= covered <= 0.98
    assert np.abs(z).max() < 8.0


def test_refined_is_at_the_bound_and_beats_the_paper_on_validation_points(found: Identification) -> None:
    rows = [s for s in found.scores if s.kind == "validation"]
    assert len(rows) == 3
    for s in rows:
        assert s.rmse["refined"] < 1.02 * s.rmse["bound"]
        assert s.rmse["refined"] < s.rmse["paper"]
        assert s.mae["refined"] < s.rmse["refined"]


def test_close_orders_are_told_apart_by_the_joint_fit(found: Identification) -> None:
    k = PAPER_ORDERS.index(13)
    truth = true_model()
    joint, windowed = [], []
    for r in found.reductions:
        assert r.steady is not None
        assert r.paper is not None
        s = r.steady
        true = truth.direction(s.window.direction)
        assert true is not None
        level = true.amplitude[k] @ basis(s.torque.mean() - 2.0, s.velocity.mean(), s.temperature.mean())
        joint.append(abs(single_recording(s, found.orders, found.notch_orders)[0][k]) / level - 1.0)
        windowed.append(r.paper.amplitude[k] / level - 1.0)
    assert np.sqrt(np.mean(np.square(joint))) < 0.01
    assert np.sqrt(np.mean(np.square(windowed))) > 0.05


def test_what_the_file_says_holds_for_the_recorded_torque(found: Identification) -> None:
    # the sensor reads 2 N·m without load: they are in the channel, and the constant of the motor's balance answers
    assert found.load_side.values["z_0"] == pytest.approx(2.0, abs=0.05)
    assert found.friction.values["tau_0"] == pytest.approx(0.04 - 2.0 / 185.0, abs=3e-4)


def test_spread_grows_with_scatter_and_shrinks_with_overstated_noise() -> None:
    rng = np.random.default_rng(0)
    within = np.full(400, 1.0)
    assert estimate_spread(3.0 * rng.normal(size=400), within, 10).scatter == pytest.approx(8.0, rel=0.2)
    small = estimate_spread(0.5 * rng.normal(size=400), within, 10)
    assert small.scatter == 0.0
    assert small.factor == pytest.approx(0.25, rel=0.2)
    assert estimate_spread(0.1 * np.ones(5), np.ones(5), 4).factor == 1.0


def test_linear_fit_with_scatter_has_honest_deviations() -> None:
    rng = np.random.default_rng(1)
    x = np.column_stack([np.ones(60), rng.normal(size=60)])
    z = []
    for _ in range(200):
        y = x @ [1.0, 2.0] + 0.3 * rng.normal(size=60)
        p, c, _ = fit_linear(x, y, np.full(60, 0.01))
        z.append((p - [1.0, 2.0]) / np.sqrt(np.diag(c)))
    assert 0.9 < float(np.mean(np.abs(z) < 1.96)) < 0.98


def test_polar_fit_follows_phases_through_many_turns_and_small_amplitudes() -> None:
    rng = np.random.default_rng(2)
    inputs = np.column_stack([rng.uniform(-1000, 1000, 120), rng.uniform(0.04, 0.17, 120), rng.uniform(20, 50, 120)])
    design = make_design(inputs)
    size = design.kept.size
    amplitude, phase = np.zeros(size), np.zeros(size)
    constant = int(np.flatnonzero(design.kept == 9)[0])
    amplitude[constant], amplitude[3] = 1e-5, 4e-6
    phase[constant], phase[3], phase[4] = 2.9, 2.0, -1.5
    z = (design.regressors @ amplitude) * np.exp(1j * (design.regressors @ phase))
    z = z + 1e-8 * (rng.normal(size=120) + 1j * rng.normal(size=120))
    fit = fit_polar(z, np.full(120, 1e-16), design)
    assert fit.amplitude == pytest.approx(amplitude, abs=1e-8)
    assert fit.phase == pytest.approx(phase, abs=5e-3)


def test_orders_without_a_gap_between_them_still_have_a_noise(found: Identification) -> None:
    # With the proposed orders 1 … 24 may all be in the model: the noise is then taken from further off.
    group = [r for r in found.reductions if r.steady is not None and r.steady.window.direction > 0]
    result = identify_direction(group, tuple(range(1, 40)), (150,), "positive")
    assert result is not None
    assert all(np.isfinite(h.variance).all() and (h.variance > 0).all() for h in result.harmonics)
    assert np.isfinite(result.fourier.amplitude).all()


def test_what_recordings_of_a_point_share_is_in_the_intervals() -> None:
    """Three temperatures at each speed and torque, with the same error: they do not average it out."""
    rng = np.random.default_rng(11)
    points = np.array(
        [(t, v, c) for t in (-800.0, 30.0, 800.0) for v in (0.10, 0.14, 0.18) for c in (22.0, 30.0, 38.0)]
    )
    design = make_design(points)
    true = design.regressors[:, np.argmax(design.kept == 9)] * 1e-5
    shared = np.repeat(np.arange(9), 3)
    held: dict[bool, list[bool]] = {True: [], False: []}
    for _ in range(40):
        error = rng.normal(size=(2, 9))[:, shared] * 1e-7 + rng.normal(size=(2, 27)) * 3e-8
        z = true + error[0] + 1j * error[1]
        for together in held:
            fit = fit_polar(z, np.full(27, 9e-16), design, None, together)
            std = np.sqrt(np.diag(fit.covariance))[: design.kept.size]
            torque = int(np.flatnonzero(design.kept == 3)[0])
            held[together].append(abs(fit.amplitude[torque]) < 2.1 * std[torque])
    assert np.mean(held[True]) >= 0.85
    assert np.mean(held[False]) < np.mean(held[True])
