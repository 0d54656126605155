import json
import threading
import time
from datetime import UTC, datetime
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.configuration import load_bench, on_interface
from bench.errors import LimitError
from bench.safety import Act, Latch, LatchFile, Standing, latch_file
from bench.safety.latch import NEXT
from bench.safety.paths import VARIABLE, latch_path, machine_latch_path, spare_path, state_folder

STOPPED = Latch().stopped("MOTOR_SPEED", "too fast", "2026-11-21T12:00:00")


def test_three_acts_in_their_order_and_no_other() -> None:
    latch = STOPPED
    for act in (Act.ACKNOWLEDGE, Act.RESET, Act.RESUME):
        with pytest.raises(LimitError, match="too fast"):
            latch.require_clear()
        for other in set(Act) - {act}:
            with pytest.raises(LimitError, match="comes first"):
                latch.after(other, "me")
        latch = latch.after(act, "me")
    latch.require_clear()
    assert [done.act for done in latch.acts] == ["acknowledge", "reset", "resume"]
    assert {done.by for done in latch.acts} == {"me"}
    with pytest.raises(LimitError, match="nothing is latched"):
        latch.after(Act.ACKNOWLEDGE, "me")


@given(st.lists(st.sampled_from([*Act, None]), max_size=12))
def test_torque_is_free_only_after_all_three_acts_since_the_last_stop(wishes: list[Act | None]) -> None:
    latch, done = Latch(), 3
    for wish in wishes:
        if wish is None:
            latch, done = latch.stopped("X", "x", ""), 0
        elif NEXT[latch.standing] is wish:
            latch, done = latch.after(wish, "me"), done + 1
        assert (latch.standing is Standing.CLEAR) == (done == 3)


def test_a_latch_outlives_its_process_and_a_broken_one_counts_as_a_stop(tmp_path: Path) -> None:
    path = tmp_path / "state" / "latch.json"
    assert LatchFile(path).read() == Latch()
    LatchFile(path).write(STOPPED)
    LatchFile(path).act(Act.ACKNOWLEDGE, "me")
    again = LatchFile(path).read()
    assert again.standing is Standing.ACKNOWLEDGED
    assert again.text == "too fast"
    assert [entry.name for entry in path.parent.iterdir()] == ["latch.json"]


@pytest.mark.parametrize("content", ["", "{", '{"standing": "cle', "[]", "null", "[" * 5000, "\0"])
@pytest.mark.parametrize("name", ["latch.json", "latch.json.new"])
def test_an_unreadable_copy_is_a_stop(tmp_path: Path, name: str, content: str) -> None:
    LatchFile(tmp_path / "latch.json").write(Latch())
    (tmp_path / name).write_text(content)
    assert LatchFile(tmp_path / "latch.json").read().standing is Standing.STOPPED


def test_a_half_written_first_stop_is_a_stop(tmp_path: Path) -> None:
    (tmp_path / "latch.json.new").touch()
    with pytest.raises(LimitError, match=r"latch\.json\.new cannot be read"):
        LatchFile(tmp_path / "latch.json").read().require_clear()


def test_a_stop_with_one_state_folder_holds_with_another_and_all_acts_free_both(tmp_path: Path) -> None:
    machine = tmp_path / "machine.json"
    one, other = (LatchFile(tmp_path / name / "latch.json", machine) for name in ("one", "other"))
    one.stopped("MOTOR_SPEED", "too fast", datetime.now(UTC))
    assert one.settle() is None
    assert other.read().text == "too fast"
    for act in Act:
        other.act(act, "me")
    assert other.read().standing is Standing.CLEAR
    assert not machine.exists()
    assert one.read().standing is Standing.STOPPED, "its own folder was not told"


def test_a_stop_holds_at_once_while_the_disk_is_frozen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    thaw, path = threading.Event(), tmp_path / "latch.json"
    monkeypatch.setattr("os.fsync", lambda _: thaw.wait(5.0))
    latch = LatchFile(path)
    began = time.monotonic()
    latch.stopped("MOTOR_SPEED", "too fast", datetime.now(UTC))
    assert latch.read().text == LatchFile(path).read().text == "too fast"
    assert time.monotonic() - began < 0.1
    assert "does not answer" in str(latch.settle(0.01))
    thaw.set()
    assert latch.settle() is None
    assert json.loads(path.read_text())["standing"] == "stopped"


def test_a_stop_that_cannot_be_stored_holds_and_is_told(tmp_path: Path) -> None:
    path = tmp_path / "file" / "latch.json"
    path.parent.write_text("no folder")
    latch = LatchFile(path)
    latch.stopped("MOTOR_SPEED", "too fast", datetime.now(UTC))
    message = str(latch.settle())
    assert "could not be stored" in message
    spare = spare_path(path)
    assert spare is not None
    assert str(spare) in message
    # a process that comes after this one knows it from memory
    latch_file._held.clear()
    assert LatchFile(path).read().text == "too fast"
    with pytest.raises(LimitError, match="cannot be stored"):
        LatchFile(path).act(Act.ACKNOWLEDGE, "me")
    assert LatchFile(path).read().standing is Standing.STOPPED
    path.parent.unlink()
    for act in Act:
        LatchFile(path).act(act, "me")
    assert not spare.exists()


def test_no_link_in_a_folder_of_all_users_is_followed(tmp_path: Path) -> None:
    victim, machine = tmp_path / "victim", tmp_path / "machine.json"
    victim.write_text("precious")
    (tmp_path / "machine.json.new").symlink_to(victim)
    machine.symlink_to(victim)
    latch = LatchFile(tmp_path / "latch.json", machine)
    assert latch.read().standing is Standing.STOPPED
    latch.stopped("MOTOR_SPEED", "too fast", datetime.now(UTC))
    assert "machine.json" in str(latch.settle())
    assert victim.read_text() == "precious"


def test_an_emulated_bench_keeps_its_latch_with_its_run_and_a_wired_one_with_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "state"))
    file = load_bench("rh380n")
    assert latch_path(file.configuration, tmp_path / "run") == tmp_path / "run" / "latch.json"
    wired = on_interface(file, "eth1").configuration
    assert state_folder(wired) == tmp_path / "state" / "rh380n@eth1"
    assert latch_path(wired, tmp_path / "run").parent == state_folder(wired)
    assert machine_latch_path(file.configuration) is None
    monkeypatch.setenv(VARIABLE, str(tmp_path / "another"))
    assert "eth1" in str(machine_latch_path(wired))
