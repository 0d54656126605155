"""What a long command keeps: found again, and refused where it is something else."""

from pathlib import Path

import pytest

from bench.cli._stored import load_stored, store
from bench.errors import BenchError

EMPTY = {"format": "bench-x", "bench": "a", "campaigns": []}


def test_what_is_stored_is_read_again_a_line_a_row(tmp_path: Path) -> None:
    path = tmp_path / "x.json"
    content = EMPTY | {"campaigns": [{"key": "ä"}, {"key": "b"}]}
    store(path, content)
    assert load_stored(path, EMPTY) == content
    assert path.read_text("utf-8").count("\n") == 4


def test_without_a_file_or_a_path_it_is_empty(tmp_path: Path) -> None:
    store(None, EMPTY)
    assert load_stored(None, EMPTY) == EMPTY == load_stored(tmp_path / "none.json", EMPTY)


@pytest.mark.parametrize("text", ["{", '{"format": "bench-y", "bench": "a"}', '{"format": "bench-x", "bench": "b"}'])
def test_another_file_is_refused_by_name(tmp_path: Path, text: str) -> None:
    path = tmp_path / "x.json"
    path.write_text(text, "utf-8")
    with pytest.raises(BenchError, match=r"x\.json"):
        load_stored(path, EMPTY, ("format", "bench"))
