from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import uniform_filter1d

import fakes.concealed as concealed
from bench.proof import analyse, make, recompute
from bench.proof.analyse import Job
from bench.recording import Recording
from tests.fakes.concealed.test_effects import SMALL


@lru_cache(maxsize=8)
def _generated(case: Any) -> SimpleNamespace:
    """The folder of a case; many tests write the same one, and its recordings are generated once."""
    folder = concealed.open_folder(case)
    recordings = tuple(folder.recordings())
    return SimpleNamespace(truth=folder.truth, recordings=lambda: iter(recordings))


class SmallExaminer:
    """The real examiner on a design of a few short recordings."""

    GROUPS = concealed.GROUPS
    open_folder = staticmethod(_generated)
    with_strength = staticmethod(concealed.with_strength)

    @staticmethod
    def cases(
        group: str, seed: int, count: int | None = None, held_back: bool = False, clutter: bool = False
    ) -> Iterator[Any]:
        for case in concealed.cases(group, seed, count, held_back, clutter):
            yield replace(case, design=SMALL, truncate=group == "null")


@pytest.fixture
def examiner(monkeypatch: pytest.MonkeyPatch) -> type[SmallExaminer]:
    monkeypatch.setattr(make, "load_examiner", lambda: SmallExaminer)
    return SmallExaminer


class BlindAnalyser:
    """Calls every folder a match, in files as an analyser writes them; knows the recordings' folder and no truth."""

    def __init__(self) -> None:
        self.folders: list[str] = []

    def __call__(self, job: Job, folder: str, target: Path) -> str:
        self.folders.append(folder)
        assert list((job.out / make.RECORDINGS / folder).glob("*.h5"))
        target.mkdir(parents=True)
        report = {"verdict": "match", "findings": [], "channels": [], "recordings": {"held_out": []}}
        (target / "report.json").write_text(json.dumps(report))
        (target / "model.json").write_text(json.dumps({"terms": []}))
        return ""


def smoothed(_model: object, recording: Recording) -> dict[str, np.ndarray[Any, Any]]:
    """A prediction for lack of a better one: each channel without its fast scatter; it leaves about the white noise."""
    out = {}
    for channel in ("transmission_error", "motor_torque", "load_torque", "temperature"):
        measured = recompute.measured_channel(recording, channel)
        assert measured is not None
        out[channel] = uniform_filter1d(measured, 1001 if channel == "temperature" else 11)
    return out


def each(predict: Callable[[Any, Recording], Mapping[str, Any]]) -> recompute.Predict:
    """A prediction of whole campaigns from one of single recordings."""

    def whole(model: Any, recordings: Sequence[Recording], channels: Collection[str] = ()) -> Iterator[Any]:
        for recording in recordings:
            out = predict(model, recording)
            yield recording, {c: v for c, v in out.items() if not channels or c in channels}

    return whole


@pytest.fixture
def blind(monkeypatch: pytest.MonkeyPatch) -> BlindAnalyser:
    analyser = BlindAnalyser()
    monkeypatch.setattr(analyse, "_run", analyser)
    monkeypatch.setattr(recompute, "predictor", lambda: each(smoothed))
    return analyser


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """One folder with Stribeck friction and one cut short without effect, on the disk."""
    out: Path = tmp_path_factory.mktemp("exam")
    clear = next(c for c in SmallExaminer.cases("clear", 3) if c.forms[0].effect == "friction.stribeck")
    null = next(SmallExaminer.cases("null", 3))
    off = next(SmallExaminer.cases("switched_off", 3))
    paths = {case.group: make.make_case(SmallExaminer, case, out) for case in (clear, null, off)}
    return SimpleNamespace(out=out, clear=clear, null=null, off=off, truths=paths)
