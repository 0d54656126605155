from __future__ import annotations

import json
import pickle
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

import pytest

from bench.proof import analyse, make
from bench.proof.analyse import Job, prove_case
from bench.proof.run import prove


@pytest.fixture
def analyser(monkeypatch: pytest.MonkeyPatch):
    """A stand-in that calls every folder a match; counts its calls."""
    calls: list[str] = []

    def run(job: Job, name: str, target: Path) -> str:
        calls.append(name)
        assert list((job.out / make.RECORDINGS / name).glob("*.h5"))
        target.mkdir(parents=True)
        noise = make.read_truth(job.out / make.TRUTHS / f"{name}.json")["noise_rms"]
        rows = [{"channel": channel, "held_out_rmse_after": rms} for channel, rms in noise.items()]
        (target / "report.json").write_text(json.dumps({"verdict": "match", "findings": [], "channels": rows}))
        return ""

    monkeypatch.setattr(analyse, "_run", run)
    return calls


def test_prove_resumes_and_throws_recordings_away(examiner, analyser, tmp_path) -> None:
    jobs = [Job("null", "null-000", 5, False, tmp_path), Job("switched_off", "switched_off-000", 5, False, tmp_path)]
    scores = prove(jobs)
    assert [s.every_point_right for s in scores] == [True, False]
    assert not (tmp_path / make.RECORDINGS / "null-000").exists()
    again = prove(jobs)
    assert again == scores
    assert analyser == ["null-000", "switched_off-000"]


def test_another_analyser_is_asked_anew(examiner, analyser, tmp_path, monkeypatch) -> None:
    job = Job("null", "null-000", 5, False, tmp_path, keep=True)
    prove_case(job)
    first = make.read_truth(tmp_path / make.TRUTHS / "null-000.json")
    monkeypatch.setattr(analyse, "analyser_digest", lambda: "another")
    outcome = prove_case(job)
    assert analyser == ["null-000", "null-000"]
    assert outcome.truth == first


def test_a_sweep_changes_the_strength(examiner, analyser, tmp_path) -> None:
    name = next(c.name for c in examiner.cases("clear", 5) if c.forms[0].effect == "friction.viscous_quadratic")
    job = Job("clear", name, 5, False, tmp_path, strength=0.3, label="swept")
    truth = prove_case(job).truth
    assert truth["effects"][0]["strength"] == pytest.approx(0.3, rel=0.07)
    assert truth["case"] == "swept"


def test_a_failing_analyser_is_said_to_have_failed(examiner, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(analyse, "_RUN", "raise SystemExit('no analyser today')")
    outcome = prove_case(Job("null", "null-000", 5, False, tmp_path))
    assert outcome.report is None
    assert "no analyser today" in outcome.failed


def test_a_slow_analyser_is_stopped(examiner, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(analyse, "_RUN", "import time; time.sleep(60)")
    outcome = prove_case(Job("null", "null-000", 5, False, tmp_path, time_limit_s=0.5))
    assert "no report within" in outcome.failed


class _FakeCluster:
    """The part of ``distributed`` that a map over jobs needs, finishing in reverse order."""

    addresses: ClassVar[list[str]] = []

    def __init__(self, address: str) -> None:
        self.addresses.append(address)

    def __enter__(self) -> _FakeCluster:
        return self

    def __exit__(self, *_error: object) -> None:
        return None

    def submit(self, function, job, pure):
        assert pure is False
        return _FakeFuture(pickle.loads(pickle.dumps(function)), pickle.loads(pickle.dumps(job)))


class _FakeFuture:
    def __init__(self, function, job) -> None:
        self.function, self.job = function, job

    def result(self):
        return self.function(self.job)


def test_a_dask_cluster_gives_the_same_scores(examiner, analyser, tmp_path, monkeypatch) -> None:
    cluster = SimpleNamespace(Client=_FakeCluster, as_completed=lambda futures: reversed(list(futures)))
    monkeypatch.setitem(sys.modules, "distributed", cluster)
    jobs = [Job("null", name, 5, False, tmp_path) for name in ("null-000", "null-001")]
    here = prove(jobs)
    there = prove(jobs, dask="tcp://scheduler:8786")
    assert there == here
    assert [score.case for score in there] == ["null-000", "null-001"]
    assert _FakeCluster.addresses == ["tcp://scheduler:8786"]


def test_without_dask_the_way_out_is_said(examiner, tmp_path, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(make.ProofError, match="optional dependencies 'dask'"):
        prove([Job("null", "null-000", 5, False, tmp_path)], dask="tcp://scheduler:8786")
