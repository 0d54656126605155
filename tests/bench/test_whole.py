from __future__ import annotations

import os
from pathlib import Path

import pytest

from bench.errors import ConfigurationError
from bench.simulation import Simulation
from bench.whole import write_whole


def test_a_file_is_written_and_replaced_and_nothing_lies_beside(tmp_path: Path) -> None:
    for text in ("one", "zwei °"):
        write_whole(tmp_path / "a.json", text)
        assert (tmp_path / "a.json").read_text("utf-8") == text
    assert os.listdir(tmp_path) == ["a.json"]


def test_a_disk_that_refuses_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "model.json"
    Simulation.nominal().save(path)
    before = path.read_bytes()

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        Simulation.nominal().save(path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["model.json"]


def test_a_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "b.json").symlink_to(tmp_path / "a.json")
    write_whole(tmp_path / "b.json", "text")
    assert (tmp_path / "b.json").is_symlink()
    assert (tmp_path / "a.json").read_text() == "text"


def test_a_cut_model_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    Simulation.nominal().save(path)
    path.write_bytes(path.read_bytes()[:-30])
    with pytest.raises(ConfigurationError, match="not readable as JSON"):
        Simulation.load(path)
