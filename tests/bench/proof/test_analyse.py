from __future__ import annotations

import pickle
import sys
from types import SimpleNamespace
from typing import ClassVar

import pytest

from bench.errors import ProofError
from bench.proof import analyse, make, recompute, seal
from bench.proof.analyse import Job, prove_case
from bench.proof.run import prove
from tests.bench.proof.conftest import each, smoothed


def test_prove_resumes_and_throws_recordings_away(examiner, blind, tmp_path) -> None:
    jobs = [Job("null", "null-000", 5, False, tmp_path), Job("switched_off", "switched_off-000", 5, False, tmp_path)]
    scores = prove(jobs)
    assert [s.every_point_right for s in scores] == [True, False]
    assert all(s.recomputed for s in scores)
    assert 0.7 < scores[0].residual < 1.05
    assert not list((tmp_path / make.RECORDINGS).iterdir())
    again = prove(jobs)
    assert again == scores
    assert len(set(blind.folders)) == len(blind.folders) == 2


def test_another_analyser_is_asked_anew(examiner, blind, tmp_path, monkeypatch) -> None:
    job = Job("null", "null-000", 5, False, tmp_path, keep=True)
    prove_case(job)
    first = seal.read_truth(tmp_path / seal.TRUTHS / "null-000.json")
    monkeypatch.setattr(analyse, "analyser_digest", lambda: "another")
    outcome = prove_case(job)
    assert blind.folders == [first["folder"]] * 2
    assert outcome.truth == first


def test_a_report_is_not_believed_about_its_residual(examiner, blind, tmp_path, monkeypatch) -> None:
    def off(model, recording):
        return {name: values + 0.2 for name, values in smoothed(model, recording).items() if name == "motor_torque"}

    monkeypatch.setattr(recompute, "predictor", lambda: each(off))
    (one,) = prove([Job("null", "null-000", 5, False, tmp_path)])
    assert one.verdict_right
    assert one.residual > 2.0
    assert not one.every_point_right


def test_a_sweep_changes_the_strength(examiner, blind, tmp_path) -> None:
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


def test_a_dask_cluster_gives_the_same_scores(examiner, blind, tmp_path, monkeypatch) -> None:
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
    with pytest.raises(ProofError, match="optional dependencies 'dask'"):
        prove([Job("null", "null-000", 5, False, tmp_path)], dask="tcp://scheduler:8786")
