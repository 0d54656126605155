"""Tasks on processes and on a cluster: the same results, in order."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from bench.errors import ConfigurationError
from bench.mismatch.many import compare, tasks_of
from bench.mismatch.mapping import over


def test_one_folder_is_reported_in_place_several_by_name(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert [t.out for t in tasks_of([tmp_path / "a"], out)] == [out]
    assert [t.out for t in tasks_of([tmp_path / "a", tmp_path / "b"], out)] == [out / "a", out / "b"]
    with pytest.raises(ConfigurationError, match="two folders are called a"):
        tasks_of([tmp_path / "a", tmp_path / "c" / "a"], out)


def test_processes_give_the_same_results_in_order() -> None:
    items = [-3.0, 2.0, -1.0]
    assert list(over(abs, items, jobs=2)) == list(over(abs, items)) == [3.0, 2.0, 1.0]


def test_a_folder_that_cannot_be_read_is_told_and_not_raised(tmp_path: Path) -> None:
    told = compare(tasks_of([tmp_path], tmp_path / "out")[0])
    assert told.report is None
    assert "no recording that can be compared" in told.sentence


class _Client:
    """The part of a cluster's client that a map needs."""

    def __init__(self, address: str) -> None:
        if not address.startswith("tcp://"):
            raise ValueError(address)

    def __enter__(self) -> _Client:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def submit(self, function: Any, item: Any, pure: bool) -> tuple[Any, Any]:
        assert pure is False
        return function, item

    def gather(self, waiting: list[tuple[Any, Any]]) -> list[Any]:
        return [function(item) for function, item in waiting]


def test_a_cluster_gives_the_same_results_in_order(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", SimpleNamespace(Client=_Client))
    assert list(over(abs, [-3.0, 2.0], dask="tcp://scheduler:8786")) == [3.0, 2.0]
    with pytest.raises(ConfigurationError, match="there is no Dask scheduler at nowhere"):
        list(over(abs, [1.0], dask="nowhere"))


def test_without_the_package_of_dask_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ConfigurationError, match="optional dependencies 'dask'"):
        list(over(abs, [1.0], dask="tcp://127.0.0.1:1"))
