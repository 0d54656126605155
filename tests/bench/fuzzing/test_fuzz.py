"""A few spoiled files of each kind, and that the fuzzer sees what may not be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.fuzzing import KINDS, fuzz, samples
from bench.fuzzing.mutations import MUTATIONS, mutate
from bench.fuzzing.page import page
from bench.fuzzing.readers import READ, READERS, SILENT, read_recording
from bench.fuzzing.run import case
from bench.recording import guarded


def test_few_of_each_kind_are_never_believed_wrongly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(guarded, "CPU_S", 2.0)
    tallies = fuzz([kind for kind in KINDS if kind != "journal"], 3, seed=1)
    assert [(tally.done, tally.wrong) for tally in tallies] == [(3, [])] * len(tallies)
    text = page(tallies, "bench benchmark fuzz --count 3", 1, "abc")
    assert "| recording (`.h5`) | 3 of 3 |" in text
    assert "with seed 1 at revision abc" in text


def test_valid_files_are_read_as_they_were_written(tmp_path: Path) -> None:
    valid = samples.make(tmp_path)
    for kind in KINDS:
        if kind != "part":
            assert READERS[kind](valid[kind]) == READ, kind


def test_wrong_samples_without_a_word_are_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = samples.recording(tmp_path / "a.h5")
    true = samples.columns

    def another(start: int, stop: int) -> dict[str, np.ndarray]:
        return {**true(start, stop), "cycle": true(start, stop)["cycle"] + 1}

    monkeypatch.setattr(samples, "columns", another)
    assert read_recording(path) == SILENT


def test_a_case_can_be_repeated_and_is_never_the_valid_file(tmp_path: Path) -> None:
    path = samples.recording(tmp_path / "a.h5")
    assert case("h5", path, 3, 14) == case("h5", path, 3, 14) != case("h5", path, 3, 15)
    data = bytes(range(200))
    for number in range(200):
        assert mutate(data, np.random.default_rng(number)) != data


def test_every_mutation_bears_the_shortest_file() -> None:
    for spoil in MUTATIONS:
        for data in (b"", b"a"):
            changed = bytearray(data)
            spoil(changed, np.random.default_rng(0))
            assert len(changed) <= len(data) + 64
