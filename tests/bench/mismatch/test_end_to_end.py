"""One folder with a concealed effect, one without: what is told of them, and every figure worked out another way."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fakes.concealed
from bench.mismatch.given import Given
from bench.mismatch.prediction import Predictor, predict_all
from bench.mismatch.prediction import compared as sample_by_sample
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.recordings.loading import load
from bench.mismatch.recordings.prepared import prepare
from bench.mismatch.regression.problem import CHANNELS, fixed_part, nominal_base
from bench.mismatch.report.report import Report
from bench.mismatch.run import run
from bench.proof.make import make_case
from bench.proof.seal import read_truth
from bench.recording import RecordingFolder
from bench.simulation.frame import FloatArray
from bench.simulation.model import Simulation
from fakes.concealed.design import Design
from fakes.concealed.recordings import generate_recordings
from tests.program import bench

EFFECT, CHANNEL = "friction.stribeck", "motor_torque"
RATE = 125.0
DESIGN = Design(
    loads=(-1000.0, -400.0, 0.0, 400.0, 1000.0),
    speeds=(2.5, 5.0, 7.5, 10.0),
    warm_ups=1,
    levels=2,
    grid=14,
    validation=4,
    anchors=1,
    transients=(1, 0, 1),
    heat_time=120.0,
)


class Examiner:
    """The generator at a lower sample rate."""

    @staticmethod
    def open_folder(case: Any) -> Any:
        folder = fakes.concealed.open_folder(case)

        class Slow:
            truth = staticmethod(folder.truth)

            @staticmethod
            def recordings() -> Any:
                return generate_recordings(folder.campaign, folder.sensors, folder.start, folder.tally, rate_hz=RATE)

        return Slow


@dataclass(frozen=True)
class Compared:
    """A folder, its truth, what was told of it."""

    folder: Path
    out: Path
    truth: dict[str, Any]
    report: Report
    data: Dataset

    @property
    def told(self) -> dict[str, Any]:
        content: dict[str, Any] = json.loads((self.out / "report.json").read_text(encoding="utf-8"))
        return content

    @property
    def model(self) -> Simulation:
        return Simulation.load(self.out / "model.json")

    def row(self, channel: str) -> dict[str, Any]:
        return next(c for c in self.told["channels"] if c["channel"] == channel)

    def finding(self) -> dict[str, Any]:
        return next(f for f in self.told["findings"] if f["effect"] == EFFECT)


def compared(number: int, tmp: Path) -> Compared:
    case = replace(list(fakes.concealed.cases("quick", 1))[number], design=DESIGN)
    if case.strengths:
        case = replace(case, strengths=(1.6,))
    truth = read_truth(make_case(Examiner, case, tmp))
    folder = tmp / "recordings" / case.alias
    return Compared(folder, tmp / "out", truth, run(folder, tmp / "out"), load(folder))


@pytest.fixture(scope="module")
def clear(tmp_path_factory: pytest.TempPathFactory) -> Compared:
    return compared(0, tmp_path_factory.mktemp("clear"))


@pytest.fixture(scope="module")
def null(tmp_path_factory: pytest.TempPathFactory) -> Compared:
    return compared(1, tmp_path_factory.mktemp("null"))


def beyond(own: Compared) -> FloatArray:
    """What of the file's term plain least squares over all samples compared leaves of the nominal simulation."""
    rows = own.data.rows[CHANNEL]
    frame = rows.frame
    root = np.sqrt(np.where(frame.direction != 0, rows.number, 0.0))
    columns = np.hstack([term.regressor.columns(frame) for term in nominal_base(CHANNEL, ())])
    columns = columns / np.maximum(np.abs(columns).max(axis=0), 1e-12)
    known = Given.of(own.model).known[CHANNEL]
    term = np.sum([k.regressor.columns(frame) @ k.coefficients for k in known], axis=0)
    return np.asarray(term - columns @ np.linalg.lstsq(columns * root[:, None], term * root, rcond=1e-9)[0])


def test_the_effect_is_named_and_nothing_else(clear: Compared) -> None:
    assert clear.told["verdict"] == "mismatch"
    assert [(f["effect"], f["status"]) for f in clear.told["findings"]] == [(EFFECT, "named")]
    assert 0.5 < clear.finding()["confidence"] <= 1.0
    assert clear.finding()["evidence"]["p_value"] < 0.01


def test_a_folder_without_an_effect_gets_no_finding(null: Compared) -> None:
    assert null.told["findings"] == []
    assert null.told["verdict"] != "mismatch"


@pytest.mark.parametrize("name", ["clear", "null"])
def test_the_floor_is_the_noise_that_was_put_in(name: str, request: pytest.FixtureRequest) -> None:
    own: Compared = request.getfixturevalue(name)
    for channel, true in own.truth["noise_rms"].items():
        # the load torque is compared with the load motor's level, smoothed: of that one's noise little is left
        below = 0.2 if channel == "load_torque" else 0.1
        assert (1.0 - below) * true < own.row(channel)["noise_floor"] < 1.1 * true, channel


def test_after_is_what_the_file_leaves_of_recordings_held_out(clear: Compared) -> None:
    held = {name.removesuffix(".h5") for name in clear.told["recordings"]["held_out"]}
    assert held
    folder = RecordingFolder.open(clear.folder)
    squares = {channel: [0.0, 0.0] for channel in ("motor_torque", "temperature")}
    for recording, predicted in predict_all(clear.out / "model.json", folder.recordings):
        if recording.recording_id not in held:
            continue
        for channel, own in squares.items():
            # wild samples and corners of the motion are not compared
            side = sample_by_sample(prepare(recording, 0, clear.data.folder, group=1), channel)
            measured, counts = recording.si(channel), side.counts
            own[0] += float(np.sum((measured - predicted[channel])[counts] ** 2))
            own[1] += float(counts.sum())
    for channel, (total, number) in squares.items():
        assert clear.row(channel)["held_out_rmse_after"] == pytest.approx(np.sqrt(total / number), rel=0.02), channel


def dense(own: Compared) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """On all rows of the torque: what plain least squares on the training rows leaves of the nominal simulation; the
    same of what the file's term adds; samples a row, held-out ones and all compared.
    """
    given = Given.of(own.model)
    rows = own.data.rows[CHANNEL]
    frame = rows.frame
    counts = np.where(frame.direction != 0, rows.number, 0.0)
    held = np.isin(frame.recording, list(own.data.held_out()))
    columns = np.hstack([term.regressor.columns(frame) for term in nominal_base(CHANNEL, ())])
    term = np.zeros(frame.size)
    for known in given.known[CHANNEL]:
        assert known.coefficients is not None
        term += known.regressor.columns(frame) @ known.coefficients
    scale = np.maximum(np.abs(columns).max(axis=0), 1e-12)
    weight = np.sqrt(np.where(held, 0.0, counts))[:, None]

    def left(values: FloatArray) -> FloatArray:
        beta = np.linalg.lstsq(columns / scale * weight, values * weight[:, 0], rcond=1e-6)[0]
        return np.asarray(values - columns / scale @ beta)

    return left(rows.y - fixed_part(CHANNEL, frame, ())), left(term), np.where(held, counts, 0.0), counts


def test_before_is_the_simulation_refitted_without_the_effect(clear: Compared) -> None:
    row = clear.row(CHANNEL)
    rows = clear.data.rows[CHANNEL]
    predicted = Predictor(Given.of(clear.model)).channel(CHANNEL, rows.frame)
    without, _, held, _ = dense(clear)
    more = float(np.sum((without**2 - (rows.y - predicted) ** 2) * held) / held.sum())
    before = np.sqrt(row["held_out_rmse_after"] ** 2 + more)
    # plain least squares weighs the rows otherwise: what is missing moves the two calibrations apart, here by 7 %
    assert row["held_out_rmse_before"] == pytest.approx(before, rel=0.08)
    # the only finding: the model without it is the simulation
    evidence = clear.finding()["evidence"]
    assert evidence["held_out_rmse_before"] == pytest.approx(row["held_out_rmse_before"], rel=0.03)
    assert evidence["held_out_rmse_after"] == pytest.approx(row["held_out_rmse_after"], rel=1e-9)
    gained = evidence["held_out_rmse_before"] ** 2 - evidence["held_out_rmse_after"] ** 2
    excess = evidence["held_out_rmse_before"] ** 2 - row["noise_floor"] ** 2
    # what is left may lie below the floor by chance: no more than all of the excess is explained
    assert clear.finding()["location"]["share_of_excess"] == pytest.approx(min(gained / excess, 1.0), rel=1e-3)
    assert row["held_out_rmse_as_given"] is None


def test_the_place_holds_nine_tenths_of_what_the_effect_adds(clear: Compared) -> None:
    where = clear.finding()["location"]
    frame = clear.data.rows[CHANNEL].frame
    energy = beyond(clear) ** 2 * dense(clear)[3]
    inside = np.ones(frame.size, dtype=bool)
    # a steady stretch has one speed, whatever an encoder's counts make of it
    stretch = (2 * frame.recording + (frame.last_direction > 0)).astype(np.int64)
    steady = (frame.steady > 0.5) & (frame.direction != 0)
    mean = np.bincount(stretch[steady], np.abs(frame.velocity[steady]) * frame.count[steady], stretch.max() + 1)
    mean /= np.maximum(np.bincount(stretch[steady], frame.count[steady], stretch.max() + 1), 1.0)
    for name, values in (
        ("velocity", np.where(steady, mean[stretch], np.abs(frame.velocity))),
        ("load_torque", frame.torque_level),
        ("temperature", frame.temperature),
    ):
        low, high = where["conditions"][name]
        inside &= (values >= low - 1e-9) & (values <= high + 1e-9)
        span = where["span"][name]
        assert span[0] - 1e-9 <= low < high <= span[1] + 1e-9
    assert energy[inside].sum() >= 0.88 * energy.sum()
    assert where["conditions"]["velocity"][1] < 0.8 * where["span"]["velocity"][1]
    by_recording = np.bincount(frame.recording, energy)
    names = [m.name for m in clear.data.members]
    told = [by_recording[names.index(name)] for name in where["recordings"]]
    assert told == sorted(told, reverse=True)
    assert told[0] == by_recording.max()
    assert sum(told) >= 0.25 * by_recording.sum()


def test_parameters_are_those_of_the_file(clear: Compared) -> None:
    term = clear.model.terms[EFFECT]
    parameters = clear.finding()["parameters"]
    assert parameters
    for own in parameters:
        assert own["value"] == pytest.approx(term.parameters[own["symbol"]].value, rel=1e-9)
        assert own["std"] is None or own["std"] > 0.0
    assert parameters[0]["std"] is not None


def test_alternatives_were_refitted(clear: Compared) -> None:
    evidence = clear.finding()["evidence"]
    for alternative in clear.finding()["alternatives"]:
        assert alternative["effect"] != EFFECT
        assert (
            alternative["held_out_rmse"] is None or alternative["held_out_rmse"] > 0.9 * evidence["held_out_rmse_after"]
        )


def test_what_was_found_is_not_found_again(clear: Compared, tmp_path: Path) -> None:
    # by the program, as the README does it
    asked = ["mismatch", str(clear.folder), "--out", str(tmp_path), "--simulation", str(clear.out / "model.json")]
    done = bench([*asked, "--json"])
    assert done.code == 0, done.err
    again = json.loads((tmp_path / "report.json").read_text("utf-8"))
    assert json.loads(done.out) == again
    assert EFFECT not in {f["effect"] for f in again["findings"]}
    assert again["simulation"]["kind"] == "model"
    for channel in again["channels"]:
        first = clear.row(channel["channel"])
        assert channel["held_out_rmse_as_given"] == pytest.approx(first["held_out_rmse_after"], rel=1e-6)
    assert {c["channel"] for c in again["channels"]} <= set(CHANNELS)
