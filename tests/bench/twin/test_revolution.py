"""The model over a revolution: its band has the coefficients' spread, and a condition that is not known is said."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bench.simulation import FourierSet, Simulation, TransmissionErrorModel, basis
from bench.twin.revolution import Conditions, RevolutionModel, variance

HERE = Conditions(80.0, 0.2, 31.0, {})
BINS = 256


def series(joint: np.ndarray | None = None) -> FourierSet:
    rng = np.random.default_rng(1)
    scale = 1.0 / np.maximum(np.abs(basis(HERE.torque, HERE.velocity, HERE.temperature)), 1e-3)
    amplitude, phase = 1e-6 * rng.normal(size=(2, 10)) * scale, 0.1 * rng.normal(size=(2, 10)) * scale
    return FourierSet(np.array([3.0, 12.0]), amplitude, phase, np.zeros(10), covariance=joint)


def test_the_variance_is_that_of_drawn_coefficients() -> None:
    rng = np.random.default_rng(2)
    mean = series()
    scale = 1.0 / np.maximum(np.abs(basis(HERE.torque, HERE.velocity, HERE.temperature)), 1e-3)
    scales = np.concatenate([2e-7 * scale, 0.02 * scale])
    mixed = rng.normal(size=(2, 20, 20)) / np.sqrt(20.0)
    joint = np.stack([scales[:, None] * (m @ m.T) * scales for m in mixed])
    theta = (np.arange(BINS) + 0.5) * 2 * np.pi / BINS
    curves = []
    for _ in range(3000):
        drawn = [
            np.concatenate([mean.amplitude[k], mean.phase[k]]) + scales * (mixed[k] @ rng.normal(size=20))
            for k in (0, 1)
        ]
        amplitude, phase = np.array([d[:10] for d in drawn]), np.array([d[10:] for d in drawn])
        one = FourierSet(mean.orders, amplitude, phase, np.zeros(10))
        curves.append(one.evaluate(theta, HERE.torque, HERE.velocity, HERE.temperature))
    seen = np.var(curves, axis=0)
    predicted = variance(series(joint), HERE, BINS)
    assert np.sqrt(predicted) == pytest.approx(np.sqrt(seen), rel=0.1)


def written(path: Path, **terms: object) -> Path:
    joint = np.tile(np.eye(20) * 1e-30, (2, 1, 1))
    Simulation.nominal().with_transmission_error(TransmissionErrorModel(series(joint), None)).save(path)
    content = json.loads(path.read_text("utf-8"))
    for term in content["terms"]:
        if term["effect"] == "te.fourier":
            term["left_rmse"] = {"positive": 2e-6}
    content["terms"] += [{"effect": effect, "enabled": True, **row} for effect, row in terms.items()]  # type: ignore[dict-item]
    path.write_text(json.dumps(content), "utf-8")
    return path


def test_few_degrees_of_freedom_widen_the_band(tmp_path: Path) -> None:
    path = written(tmp_path / "model.json")
    content = json.loads(path.read_text("utf-8"))
    (term,) = (one for one in content["terms"] if one["effect"] == "te.fourier")
    term["covariance"]["positive"] = {key: (1e-12 * np.eye(20) / 10).tolist() for key in term["covariance"]["positive"]}
    path.write_text(json.dumps(content), "utf-8")
    many = RevolutionModel(path).at(HERE, BINS)
    term["freedom"] = {"positive": 3.0}
    path.write_text(json.dumps(content), "utf-8")
    few = RevolutionModel(path).at(HERE, BINS)
    assert many.half is not None
    assert few.half is not None
    assert (few.half > 1.2 * many.half).mean() > 0.5


def test_what_is_not_in_the_file_is_said(tmp_path: Path) -> None:
    whole = RevolutionModel(written(tmp_path / "model.json")).at(HERE, BINS)
    assert whole.error is not None
    assert whole.half == pytest.approx(np.full(BINS, 1.95996 * 2e-6), rel=1e-3)
    assert abs(whole.error.mean()) < 1e-12
    bump = {"parameters": {"theta_p": 1.0, "w_p": 0.1, "p": 1e-5}}
    beside = RevolutionModel(written(tmp_path / "bump.json", **{"te.local_defect": bump})).at(HERE, BINS)
    assert beside.error is not None
    assert beside.half is None
    assert "no covariance of te.local_defect" in beside.why
    # the pulse is drawn where it is
    assert np.argmax(np.abs(beside.error - whole.error)) == pytest.approx(BINS / (2 * np.pi), abs=2)
    nothing = tmp_path / "nothing.json"
    Simulation.nominal().save(nothing)
    none = RevolutionModel(nothing).at(HERE, BINS)
    assert none.error is None
    assert "te.fourier" in none.why
