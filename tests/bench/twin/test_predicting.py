"""The model in force on the next recording: what it predicts there is what it was calibrated for."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from bench.mismatch.prediction import predictions_of
from bench.recording import RecordingFolder
from bench.simulation.terms import TEMPERATURE
from bench.twin.predicting import Predicting
from tests.bench.twin.conftest import Known


def test_what_the_model_takes_off_the_loss_is_taken_off(known: Known, tmp_path: Path) -> None:
    recordings = sorted(RecordingFolder.open(known.without).recordings, key=lambda r: r.started_at)
    warm_up = max(recordings, key=lambda r: float(np.ptp(r.si(TEMPERATURE))))
    content = json.loads(known.model.read_text())
    (heating,) = (row for row in content["terms"] if row["effect"] == "thermal.loss_heating")
    left = {}
    for name, less in (("all", []), ("zero", ["load zero"]), ("rest", ["rest of the motor torque"])):
        heating["less"] = less
        model = tmp_path / f"{name}.json"
        model.write_text(json.dumps(content))
        residual, rows = Predicting(model, [warm_up]).left(warm_up)[TEMPERATURE]
        ((_, predicted),) = predictions_of(model, [warm_up], None, (TEMPERATURE,))
        samples = np.asarray(warm_up.si(TEMPERATURE)) - predicted[TEMPERATURE].values
        left[name] = residual
        # samples against rows of two seconds
        assert abs(float(residual[-1]) - float(samples[-int(rows.frame.count[-1]) :].mean())) < 0.01
    assert abs(left["zero"][-1] - left["all"][-1]) > 0.02
    assert abs(left["rest"][-1] - left["all"][-1]) > 1e-4
