"""Precedence is taken, given back, and said where it is refused."""

from __future__ import annotations

import os

import pytest

from bench.cycle.precedence import precedence


def test_precedence_is_given_back(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    monkeypatch.setattr(os, "getpriority", lambda *_: 3)
    monkeypatch.setattr(os, "setpriority", lambda _, __, nice: asked.append(nice))
    with precedence() as note:
        assert note is None
        assert asked == [-10]
    assert asked == [-10, 3]


def test_a_refusal_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: int, __: int, nice: int) -> None:
        if nice < 0:
            raise PermissionError

    monkeypatch.setattr(os, "getpriority", lambda *_: 0)
    monkeypatch.setattr(os, "setpriority", refuse)
    with precedence() as note:
        assert note is not None
        assert "CAP_SYS_NICE" in note


def test_nothing_is_asked_where_nothing_is_wanted() -> None:
    before = os.getpriority(os.PRIO_PROCESS, 0)
    with precedence(wanted=False) as note:
        assert os.getpriority(os.PRIO_PROCESS, 0) == before
        assert note is None
