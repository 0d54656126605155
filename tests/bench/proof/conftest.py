from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import fakes.concealed as concealed
from bench.proof import make
from tests.fakes.concealed.test_effects import SMALL


class SmallExaminer:
    """The real examiner on a design of a few short recordings."""

    GROUPS = concealed.GROUPS
    open_folder = staticmethod(concealed.open_folder)
    with_strength = staticmethod(concealed.with_strength)

    @staticmethod
    def cases(group: str, seed: int, count: int | None = None, held_back: bool = False) -> Iterator[Any]:
        for case in concealed.cases(group, seed, count, held_back):
            yield replace(case, design=SMALL, truncate=group == "null")


@pytest.fixture
def examiner(monkeypatch: pytest.MonkeyPatch) -> type[SmallExaminer]:
    monkeypatch.setattr(make, "load_examiner", lambda: SmallExaminer)
    return SmallExaminer


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """One folder with Stribeck friction and one cut short without effect, on the disk."""
    out: Path = tmp_path_factory.mktemp("exam")
    clear = next(c for c in SmallExaminer.cases("clear", 3) if c.forms[0].effect == "friction.stribeck")
    null = next(SmallExaminer.cases("null", 3))
    off = next(SmallExaminer.cases("switched_off", 3))
    paths = {case.group: make.make_case(SmallExaminer, case, out) for case in (clear, null, off)}
    return SimpleNamespace(out=out, clear=clear, null=null, off=off, truths=paths)
