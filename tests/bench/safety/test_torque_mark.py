"""A process that dies with torque leaves a mark, and the mark is a stop."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from bench.configuration import BenchFile, load_bench, on_interface
from bench.errors import LimitError
from bench.safety import Act, LatchFile, Standing
from bench.safety.acts import latch_of
from bench.safety.paths import MACHINE, VARIABLE
from bench.safety.torque_mark import mark_path, torque_mark

DYING = """
import os, sys
from bench.configuration import load_bench, on_interface
from bench.safety.torque_mark import torque_mark
with torque_mark(on_interface(load_bench("rh380n"), "test0").configuration, "quick in a folder", print):
    os._exit(9) if sys.argv[1] == "dies" else None
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> BenchFile:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "state"))
    monkeypatch.setenv(MACHINE, str(tmp_path / "machine"))
    (tmp_path / "machine").mkdir()
    return on_interface(load_bench("rh380n"), "test0")


def standing(file: BenchFile, tmp_path: Path) -> Standing:
    return latch_of(file, tmp_path).read().standing


@pytest.mark.parametrize(("how", "left"), [("dies", Standing.STOPPED), ("ends", Standing.CLEAR)])
def test_only_a_death_is_a_stop(file: BenchFile, tmp_path: Path, how: str, left: Standing) -> None:
    subprocess.run([sys.executable, "-c", DYING, how], check=False, env={**os.environ})
    latch = latch_of(file, tmp_path).read()
    assert latch.standing is left
    if how == "dies":
        assert latch.cause == "DIED"
        assert "the run quick in a folder (process " in latch.text
        assert "nobody has looked" in latch.text
        # it takes the three acts, and then it is over
        for act in Act:
            latch_of(file, tmp_path).act(act, "Ann")
        assert standing(file, tmp_path) is Standing.CLEAR


def test_a_run_that_goes_on_is_none(file: BenchFile, tmp_path: Path) -> None:
    with torque_mark(file.configuration, "here", print):
        assert standing(file, tmp_path) is Standing.CLEAR
        path = mark_path(file.configuration)
        assert path is not None
        # the same id, but another process: an id used again
        path.write_text(json.dumps({**json.loads(path.read_text()), "started": "1 another boot"}))
        assert standing(file, tmp_path) is Standing.STOPPED


@pytest.mark.parametrize("content", ["", "{", "[]", '{"pid": "x"}', "\0\0"])
def test_a_mark_that_cannot_be_read_is_a_death(file: BenchFile, tmp_path: Path, content: str) -> None:
    path = mark_path(file.configuration)
    assert path is not None
    path.parent.mkdir(parents=True)
    path.write_text(content)
    assert standing(file, tmp_path) is Standing.STOPPED


def test_a_stop_that_cannot_be_stored_keeps_the_mark(
    file: BenchFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = mark_path(file.configuration)
    assert path is not None
    path.parent.mkdir(parents=True)
    path.write_text("{}")
    monkeypatch.setattr(LatchFile, "settle", lambda self: "the disk does not answer")
    latch_of(file, tmp_path)
    assert path.exists()


def test_a_folder_that_takes_no_mark_is_told(file: BenchFile, tmp_path: Path) -> None:
    (tmp_path / "state").write_text("a file, no folder")
    messages: list[str] = []
    with torque_mark(file.configuration, "here", messages.append):
        pass
    assert "cannot be written" in messages[0]


def test_a_bench_in_this_process_ends_with_it(tmp_path: Path) -> None:
    assert mark_path(load_bench("rh380n").configuration) is None


def test_go_on_after_a_death_is_refused(file: BenchFile, tmp_path: Path) -> None:
    from bench.safety.acts import require_resumable

    subprocess.run([sys.executable, "-c", DYING, "dies"], check=False, env={**os.environ})
    with pytest.raises(LimitError, match=r"ended without a word while it had torque.*next is bench acknowledge"):
        require_resumable(latch_of(file, tmp_path), resumes=True)
