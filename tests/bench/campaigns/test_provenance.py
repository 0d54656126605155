from __future__ import annotations

from pathlib import Path

import pytest

from bench.campaigns.records import provenance

COMMIT = "0123456789abcdef0123456789abcdef01234567"


def test_the_work_tree_is_that_of_the_project() -> None:
    assert Path(__file__).resolve().parents[3] == provenance.WORK_TREE


@pytest.mark.parametrize(
    ("head", "revision"),
    [("ref: refs/heads/main", COMMIT), (COMMIT, COMMIT), (None, "")],
    ids=["branch", "bare", "none"],
)
def test_a_recording_names_the_commit_of_the_program(
    head: str | None, revision: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if head is not None:
        (tmp_path / ".git" / "refs" / "heads").mkdir(parents=True)
        (tmp_path / ".git" / "HEAD").write_text(head + "\n")
        (tmp_path / ".git" / "refs" / "heads" / "main").write_text(COMMIT + "\n")
    monkeypatch.setattr(provenance, "WORK_TREE", tmp_path)
    assert provenance.revision.__wrapped__() == revision
