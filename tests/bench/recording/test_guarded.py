from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from bench.errors import RecordingError
from bench.recording import Recording, guarded
from tests.bench.recording import builders


def test_a_crash_is_one_sentence_and_the_next_file_is_read(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5")
    with pytest.raises(RecordingError, match=r"a\.h5: reading it ended in a crash .*SIGABRT"):
        guarded.call(path, os.abort)
    assert Recording.open(path).size == 3000


def test_a_hang_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(guarded, "TIME_S", 0.3)
    began = time.monotonic()
    with pytest.raises(RecordingError, match=r"a\.h5: could not be read within 0 s"):
        guarded.call(tmp_path / "a.h5", time.sleep, 60.0)
    assert time.monotonic() - began < 10.0


def test_memory_has_a_limit(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"a\.h5: cannot be read within 4 GiB of memory"):
        guarded.call(tmp_path / "a.h5", bytearray, guarded.MEMORY_BYTES + 1)


def test_what_the_function_raises_is_raised(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="invalid literal"):
        guarded.call(tmp_path / "a.h5", int, "x")


def test_one_child_serves_many_files(tmp_path: Path) -> None:
    seen = {guarded.call(tmp_path, os.getpid) for _ in range(5)}
    assert len(seen) == 1
    assert os.getpid() not in seen


def test_relative_paths_mean_what_they_mean_to_the_caller(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.txt").write_text(name)
        monkeypatch.chdir(tmp_path / name)
        assert guarded.call(Path("a.txt"), Path.read_text, Path("a.txt")) == name


def compute(seconds: float) -> str:
    """Compute for so long, as a child does that shares its processor with others."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        pass
    return "done"


def test_a_child_that_computes_is_judged_by_its_processor_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(guarded, "TIME_S", 0.2)
    assert guarded.call(tmp_path, compute, 0.8) == "done"
    monkeypatch.setattr(guarded, "CPU_S", 0.5)
    with pytest.raises(RecordingError, match="processor time"):
        guarded.call(tmp_path, compute, 60.0)


def ask_a_child(path: Path) -> str:
    """What a child does that opens its files in a child of its own: it waits, and only that one computes."""
    child = guarded.Child()
    try:
        return str(child.ask((compute, (1.5,), {}, None, None), 30.0)[1])
    finally:
        child.end()


def test_a_child_whose_own_child_computes_does_not_hang(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(guarded, "TIME_S", 0.2)
    assert guarded.call(tmp_path, ask_a_child, tmp_path) == "done"
