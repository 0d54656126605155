from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.configuration import load_bench, on_interface
from bench.errors import LimitError
from bench.safety import Act, Latch, LatchFile, Standing
from bench.safety.latch import NEXT
from bench.safety.places import VARIABLE, latch_path, state_folder

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
    path.write_text("{")
    assert LatchFile(path).read().standing is Standing.STOPPED


def test_an_emulated_bench_keeps_its_latch_with_its_run_and_a_wired_one_with_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "state"))
    file = load_bench("rh380n")
    assert latch_path(file.configuration, tmp_path / "run") == tmp_path / "run" / "latch.json"
    wired = on_interface(file, "eth1").configuration
    assert state_folder(wired) == tmp_path / "state" / "rh380n@eth1"
    assert latch_path(wired, tmp_path / "run").parent == state_folder(wired)
