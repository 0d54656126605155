"""What the examiner works out itself: nature's own signals leave the noise, and nothing else does."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.errors import ProofError
from bench.proof import make, recompute, seal
from bench.recording import Recording
from fakes.concealed import open_folder
from tests.bench.proof.conftest import each

CHANNELS = {"transmission_error", "motor_torque", "temperature", "load_torque"}


@pytest.fixture(scope="module")
def nature(made: SimpleNamespace) -> SimpleNamespace:
    """Ideal signals of the clear folder by recording, its truth and its recordings."""
    truth = seal.read_truth(made.truths["clear"])
    folder = made.out / make.RECORDINGS / truth["folder"]
    campaign = open_folder(made.clear).campaign
    ids = list(truth["noise_by_recording"])  # in running order
    ideal = dict(zip(ids, campaign.run(500.0), strict=True))
    return SimpleNamespace(truth=truth, folder=folder, ideal=ideal)


@pytest.fixture
def predicting(nature: SimpleNamespace, monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """A prediction by nature itself; rows of the model scale what the concealed friction adds."""
    ideal = nature.ideal

    def predict(model: Mapping[str, Any], recording: Recording) -> dict[str, np.ndarray]:
        signals = ideal[recording.recording_id]
        concealed = signals.added["motor_torque"]
        share = sum(term["share"] for term in model["terms"] if term["effect"] == "friction.stribeck")
        heard = recording.si("load_motor_torque") - signals.run.command
        return {
            "transmission_error": signals.load_angle - signals.motor_shaft / 185.0,
            "motor_torque": signals.motor_torque - (1.0 - share) * concealed,
            "load_torque": signals.load_torque + heard,
            "temperature": signals.probe,
        }

    monkeypatch.setattr(recompute, "predictor", lambda: each(predict))
    return nature


def own(nature: SimpleNamespace, tmp_path: Path, share: float, held_out: list[str] | None = None) -> dict[str, Any]:
    model = tmp_path / "model.json"
    term = {"effect": "friction.stribeck", "share": share, "parameters": {"f_s": {"value": -0.2, "std": 0.01}}}
    model.write_text(json.dumps({"terms": [term, {"effect": "te.harmonic", "enabled": False, "share": 0.0}]}))
    report = {
        "recordings": {"held_out": held_out or []},
        "findings": [{"effect": "friction.stribeck", "channel": "motor_torque"}],
    }
    return recompute.recompute(nature.truth, report, model, nature.folder)


def test_nature_leaves_exactly_the_noise(predicting: SimpleNamespace, tmp_path: Path) -> None:
    told = own(predicting, tmp_path, 1.0)
    assert set(told["residual"]) == CHANNELS
    assert all(value == pytest.approx(1.0, abs=2e-3) for value in told["residual"].values()), told["residual"]
    assert told["shares"]["0"] == pytest.approx(1.0, abs=0.05)
    assert told["parameters"] == {"friction.stribeck": {"f_s": [-0.2, 0.01]}}


def test_half_of_the_effect_leaves_more_than_the_noise(predicting: SimpleNamespace, tmp_path: Path) -> None:
    told = own(predicting, tmp_path, 0.5)
    assert told["residual"]["motor_torque"] > 1.05
    assert told["residual"]["transmission_error"] == pytest.approx(1.0, abs=2e-3)


def test_held_out_recordings_count_by_themselves(predicting: SimpleNamespace, tmp_path: Path) -> None:
    energy = predicting.truth["effects"][0]["location"]["recordings"]
    noise = predicting.truth["noise_by_recording"]
    strongest = max((r for r in energy if "motor_torque" in noise[r]), key=lambda r: energy[r])
    whole = own(predicting, tmp_path, 0.5)["residual"]["motor_torque"]
    assert own(predicting, tmp_path, 0.5, [strongest])["residual"]["motor_torque"] > whole


def test_a_model_that_cannot_be_predicted_says_why(
    nature: SimpleNamespace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(model: Mapping[str, Any], recording: Recording) -> dict[str, np.ndarray]:
        raise ProofError("no such form")

    monkeypatch.setattr(recompute, "predictor", lambda: refuse)
    told = own(nature, tmp_path, 1.0)
    assert told["residual"] == {}
    assert told["why"] == "model.json does not predict: no such form"


def test_without_a_model_nothing_is_predicted(nature: SimpleNamespace, tmp_path: Path) -> None:
    told = recompute.recompute(nature.truth, {}, tmp_path / "model.json", nature.folder)
    assert told["residual"] == {}
    assert "model.json" in told["why"]
