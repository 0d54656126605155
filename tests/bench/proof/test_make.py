from __future__ import annotations

import json
import re

import pytest

from bench.errors import ProofError
from bench.proof import make, seal
from bench.proof.analyse import draw_case
from bench.proof.run import Plan, jobs_of, sweep_jobs
from bench.recording import RecordingFolder


def test_recordings_are_readable_and_tell_nothing(made) -> None:
    folder = RecordingFolder.open(made.out / make.RECORDINGS / made.clear.alias)
    assert len(folder.recordings) > 10
    assert not folder.rejected
    for recording in folder.recordings:
        assert recording.problems == ()
        assert "stribeck" not in (recording.config or "")
        words = " ".join((recording.recording_id, recording.campaign_id, *(e.text for e in recording.events)))
        assert not re.search(r"clear|null|case|point|constant|seed|\b0*[0-9]{1,3}\b", words), words
    assert made.clear.name not in str(folder.path)
    files = {p.suffix for p in (made.out / make.RECORDINGS / made.clear.alias).iterdir()}
    assert files == {".h5"}


def test_every_case_has_names_of_its_own(examiner) -> None:
    drawn = [
        c
        for group in ("clear", "faint", "null")
        for clutter in (False, True)
        for c in examiner.cases(group, 3, None, False, clutter)
    ]
    assert len({case.alias for case in drawn}) == len(drawn)
    assert examiner.with_strength(drawn[0], 0.2, "other").alias != drawn[0].alias
    assert not any(case.name in case.alias or case.group in case.alias for case in drawn)


def test_a_truncated_recording_is_open(made) -> None:
    recordings = RecordingFolder.open(made.out / make.RECORDINGS / made.null.alias).recordings
    assert [r.complete for r in recordings].count(False) == 1


def test_truth_is_sealed_and_tampering_is_noticed(made, tmp_path) -> None:
    truth = seal.read_truth(made.truths["clear"])
    assert truth["effects"][0]["effect"] == "friction.stribeck"
    copy = tmp_path / "truth.json"
    copy.write_bytes(made.truths["clear"].read_bytes())
    copy.with_suffix(".sha256").write_bytes(made.truths["clear"].with_suffix(".sha256").read_bytes())
    seal.read_truth(copy)
    copy.write_text(copy.read_text().replace("friction.stribeck", "friction.run_in"))
    with pytest.raises(ProofError, match="seal"):
        seal.read_truth(copy)


def test_a_case_is_made_once(made, examiner) -> None:
    before = made.truths["clear"].stat().st_mtime_ns
    make.make_case(examiner, made.clear, made.out)
    assert made.truths["clear"].stat().st_mtime_ns == before


def test_seal_of_seals_changes_with_any_truth(made) -> None:
    whole = seal.seal_of_seals(made.out)
    beside = made.truths["null"].with_suffix(".sha256")
    text = beside.read_text()
    beside.write_text("0" * 64)
    assert seal.seal_of_seals(made.out) != whole
    beside.write_text(text)


def test_a_switched_off_term_comes_as_a_simulation(made) -> None:
    path = make.simulation_for(made.out, made.off.alias)
    assert path is not None
    (term,) = json.loads(path.read_text())["terms"]
    assert term == {"effect": made.off.switched_off[0], "enabled": False}
    truth = seal.read_truth(made.truths["switched_off"])
    assert [e["effect"] for e in truth["effects"]] == list(made.off.switched_off)
    assert make.simulation_for(made.out, made.clear.alias) is None


def test_jobs_of_a_plan(examiner, tmp_path) -> None:
    jobs = jobs_of(Plan(("clear", "null"), seed=2, count=3, nulls=5), tmp_path, keep=False)
    assert [job.group for job in jobs] == ["clear"] * 3 + ["null"] * 5
    swept = sweep_jobs(jobs[:2], [0.1, 0.4])
    assert len({job.label for job in swept}) == 4
    with pytest.raises(ProofError, match="no set"):
        jobs_of(Plan(("nonsense",)), tmp_path, keep=False)


def test_small_nulls_are_many_short_and_rough(examiner, tmp_path) -> None:
    import fakes.concealed as concealed

    jobs = jobs_of(Plan(("null_small",), nulls=130, clutter=True), tmp_path, keep=False)
    assert len({job.name for job in jobs}) == len(jobs) == 130
    assert draw_case(examiner, jobs[-1]).name == jobs[-1].name
    drawn = list(concealed.cases("null_small", 1))
    assert len(drawn) == 100
    assert len({case.nuisance for case in drawn}) == 5
    assert all(case.design.grid <= 20 and not case.forms for case in drawn)


def test_quick_is_one_effect_and_one_null(examiner, tmp_path) -> None:
    jobs = jobs_of(Plan(("quick",)), tmp_path, keep=False)
    concealed = [len(draw_case(examiner, job).forms) for job in jobs]
    assert concealed == [1, 0]
