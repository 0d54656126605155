"""Recordings compared with simulations from elsewhere: as given, recalibrated, and what they leave out."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.errors import ConfigurationError
from bench.exchange.predicted import predict_recordings
from bench.foreign.base import Base, Free
from bench.foreign.columns import Columns
from bench.mismatch import wrong_parameters
from bench.mismatch.run import run
from tests.bench.foreign.machine import F_C, F_V, NOISE, record


def report_of(folder: Path, out: Path, simulation: str) -> dict[str, Any]:
    run(folder, out, Path(simulation))
    content: dict[str, Any] = json.loads((out / "report.json").read_text(encoding="utf-8"))
    return content


def test_channels_predicted_elsewhere_are_scored_untouched_and_their_gap_is_named(tmp_path: Path) -> None:
    folder = record(tmp_path / "in", stribeck=0.2, simulated={"f_c": F_C, "f_v": F_V})
    report = report_of(folder, tmp_path / "out", "columns")
    assert report["simulation"] == {"kind": "columns", "file": "columns", "recalibrated": []}
    assert [f["effect"] for f in report["findings"]] == ["friction.stribeck"]
    (row,) = report["channels"]
    assert row["held_out_rmse_as_given"] > 5 * NOISE
    assert row["held_out_rmse_after"] == pytest.approx(NOISE, rel=0.1)
    model = json.loads((tmp_path / "out" / "model.json").read_text(encoding="utf-8"))
    assert model["base"]["kind"] == "columns"
    # what the file predicts is what lies in the recordings and what was found
    *_, last = predict_recordings(tmp_path / "out" / "model.json", folder)
    assert last.channels[0].rms == pytest.approx(NOISE, rel=0.1)


def test_a_wrong_parameter_is_a_finding_and_nothing_is_added(tmp_path: Path) -> None:
    folder = record(tmp_path / "in", f_c=1.2 * F_C)
    report = report_of(folder, tmp_path / "out", "tests.bench.foreign.machine:joint")
    assert report["simulation"]["recalibrated"] == ["f_c", "f_v"]
    (found,) = report["findings"]
    assert found["effect"] == "parameter"
    assert found["parameters"][0]["symbol"] == "f_c"
    assert found["parameters"][0]["given"] == F_C
    assert found["parameters"][0]["value"] == pytest.approx(1.2 * F_C, rel=0.01)
    (row,) = report["channels"]
    assert row["held_out_rmse_as_given"] > 10 * NOISE
    assert row["held_out_rmse_before"] == pytest.approx(NOISE, rel=0.1)
    assert found["evidence"]["held_out_rmse_before"] > 10 * NOISE
    again = report_of(folder, tmp_path / "again", str(tmp_path / "out" / "model.json"))
    assert (again["verdict"], again["findings"]) == ("match", [])
    assert again["channels"][0]["held_out_rmse_as_given"] == pytest.approx(NOISE, rel=0.1)


def test_what_cannot_be_opened_is_one_sentence(tmp_path: Path) -> None:
    folder = record(tmp_path / "in")
    with pytest.raises(ConfigurationError, match="importable from here"):
        run(folder, tmp_path / "out", Path("no.such:joint"))
    with pytest.raises(Exception, match="has no channel simulated/NAME"):
        run(folder, tmp_path / "out", Path("columns"))


def test_a_parameter_that_shares_with_what_was_added_is_not_called_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    ones = np.ones(50)
    regressor = SimpleNamespace(columns=lambda frame: ones[:, None])
    rows = SimpleNamespace(frame=None, number=ones)
    problem = SimpleNamespace(rows=rows, usable=ones > 0)
    model = SimpleNamespace(channel="motor_torque", problem=problem, price=5.0, floor=0.01)
    analysis: Any = SimpleNamespace(outcomes={"motor_torque": SimpleNamespace(notes=[])})
    given = Base.of(Columns(), (Free("f_c", 0.3, "N*m"),))
    monkeypatch.setattr(wrong_parameters, "models_of", lambda _: [model])
    monkeypatch.setattr(wrong_parameters, "parameters_in", lambda _: [SimpleNamespace(regressor=regressor)])
    monkeypatch.setattr(wrong_parameters, "named", lambda _: "f_c")

    def values(alone: float) -> Any:
        return lambda _analysis, _base, whole=True: ({"f_c": -0.2 if whole else alone}, {"f_c": 0.01})

    for alone in (0.35, 0.29):  # to the other side; by a fiftieth
        monkeypatch.setattr(wrong_parameters, "values_of", values(alone))
        assert wrong_parameters.wrong_parameters(analysis, given, given.at({"f_c": 0.31})) == []
    analysis.outcomes["motor_torque"].notes.clear()
    monkeypatch.setattr(wrong_parameters, "values_of", values(0.35))
    assert wrong_parameters.wrong_parameters(analysis, given, given.at({"f_c": 0.31})) == []
    (note,) = analysis.outcomes["motor_torque"].notes
    assert note.startswith("parameter f_c is 0.35 recalibrated alone and -0.2 beside what was added")
    monkeypatch.setattr(wrong_parameters, "values_of", values(0.0))
    (found,) = wrong_parameters.wrong_parameters(analysis, given, given.at({"f_c": 0.31}))
    assert found.parameters[0]["value"] == -0.2
