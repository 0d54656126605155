"""Every row of the matrix, as `bench benchmark faults` runs it; those on real frames where there may be a wire."""

import os
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.configuration import BenchFile, load_bench
from bench.cycle.round_trip import veth_pair
from bench.errors import DeviceError
from bench.matrix import PLANT, ROWS, SETUP, SLOW, WIRE, Outcome, Row, wire
from bench.matrix.outcome import Envelope, combine_tries
from bench.matrix.plant import Strike
from bench.matrix.run import RATE_TRIES, run_rows, run_rows_often
from bench.matrix.shafts import Look, Shafts
from bench.matrix.store import load, newest_outcomes, save
from bench.matrix.summary import sources, summary
from bench.matrix.table import page
from bench.safety import Cause
from fakes.ethercat.faults import BUS_FAULTS
from fakes.ethercat.master import emulated_master
from fakes.plant.faults import FAULTS
from fakes.plant.images import COMMAND_DTYPE
from fakes.slow_devices import NAMES
from tests.conftest import REQUIRE_WIRE

QUICK = [row for row in ROWS if row.kind not in (SLOW, WIRE) and row.last_s < 60.0]
ON_EVERY_MACHINE = ("writer_killed",)
LONG = [row for row in ROWS if row.last_s >= 60.0]


@pytest.fixture(scope="module")
def file() -> BenchFile:
    return load_bench("rh380n")


POOR = {
    "output_stalled": "seen in every bus cycle the true torque reaches 3894 N·m, beyond the envelope of 3724 N·m",
}
"""rows that are not as they should be: they stay poor in docs/faults.md, and the day they are mended shows here"""


def _marked(row: Row) -> Any:
    marks = [pytest.mark.xfail(strict=True, reason=POOR[row.name])] if row.name in POOR else []
    return pytest.param(row, marks=marks, id=row.name)


@pytest.mark.parametrize("row", [_marked(row) for row in (*QUICK, *LONG)])
def test_row(row: Row, file: BenchFile) -> None:
    (outcome,) = run_rows([row], file)
    assert outcome.problems == []
    assert outcome.read_back >= (0 if row.expected_text in ("in use", "runs already") else 1)


@pytest.mark.parametrize("line", ["modbus", "serial"])
def test_rows_of_a_thermometer_beside_the_bus(line: str, file: BenchFile) -> None:
    # every third: `bench benchmark faults` strikes them all
    rows = [row for row in [row for row in ROWS if row.kind == SLOW][::3] if row.name.startswith(line)]
    assert rows
    outcomes = list(run_rows(rows, file))
    assert [outcome.name for outcome in outcomes] == [row.name for row in rows]
    assert [outcome.problems for outcome in outcomes if outcome.problems] == []


@pytest.mark.parametrize("row", [row for row in ROWS if row.kind == WIRE], ids=lambda row: row.name)
def test_row_on_real_frames(row: Row, file: BenchFile) -> None:
    if row.name not in ON_EVERY_MACHINE and os.environ.get(REQUIRE_WIRE) != "1":
        pytest.skip(f"takes a quarter of a minute; .ci/run does it ({REQUIRE_WIRE}=1)")
    try:
        with veth_pair():
            pass
    except DeviceError as error:
        pytest.skip(f"no veth pair can be made here, so EtherCAT frames are not tested: {error}")
    (outcome,) = run_rows([row], file)
    assert outcome.problems == []
    assert outcome.struck is not None


def test_every_fault_of_the_emulator_has_a_row() -> None:
    struck = {Strike.of(row.fault).name for row in ROWS}
    known = {fault.name for fault in BUS_FAULTS} | {fault.name for fault in FAULTS} | set(NAMES)
    assert known - struck == set()


def test_causes_of_rows_are_causes() -> None:
    for row in ROWS:
        assert {cause for cause in row.causes if cause not in Cause.__members__} == set()
        assert row.within_s > 0.0


def test_a_bench_that_does_not_stop_is_not_right(file: BenchFile) -> None:
    # a fault that changes nothing, under the name of one that has to stop the bench
    deaf = Row("ambient_pt100_open", "nothing", ("MOTOR_SPEED",), kind=PLANT)
    (outcome,) = run_rows([deaf], file)
    assert any("did not stop" in problem for problem in outcome.problems)
    wrong = Row("emergency_stop", "another cause", ("MOTOR_SPEED",), within_s=0.1, expected_text="banana", kind=PLANT)
    (outcome,) = run_rows([wrong], file)
    text = "; ".join(outcome.problems)
    for part in ("cause found is EMERGENCY_STOP", "banana", "allowed 0.1 s"):
        assert part in text
    unknown = Row("missing_slave", "the slave is there", (), expected_text="banana", kind=SETUP)
    (outcome,) = run_rows([unknown], file)
    assert not outcome.passed


def test_shafts_that_leave_their_envelope_or_keep_torque_are_seen() -> None:
    shafts = Shafts(None, None)
    shafts.looks = [Look(0, 90.0, 0.5, 300.0, True), Look(40, 50.0, 0.3, 10.0, False), Look(80, 0.1, 0.0, 0.0, False)]
    assert shafts.peaks() == (90.0, 0.5, 300.0)
    assert shafts.settled(0, 0.5, 0.02) == (80, 40)
    shafts.looks.append(Look(120, 0.0, 0.0, 0.0, True))
    assert shafts.settled(0, 0.5, 0.02) == (80, None)


def test_the_page_says_what_was_found_and_what_was_not_right(file: BenchFile) -> None:
    good = Outcome("sto:load_drive", "safe torque off", PLANT, "SAFE_TORQUE_OFF", "told so", 0.0005, 0.3, 0.02)
    good.drives, good.rungs = {"input_drive": "SWITCH_ON_DISABLED"}, ("disable voltage",)
    good.struck, good.peaks, good.sampled_s = (0.5, 325.0), (57.0, 0.5, 330.0), 0.0005
    bad = Outcome("modbus_crc", "check sum", SLOW, problems=["it went on"])
    text = page([good, bad], "motor 264 rad/s")
    assert (
        "| `sto:load_drive` | safe torque off | 29 °/s, 325 N·m | safe torque off | 0.5 ms | disable voltage | 0.30 s |"
        " switch on disabled | 57 rad/s, 0.50 rad/s, 330 N·m (0.5 ms) | 1 of 1 |" in text
    )
    assert "1 of 2 rows" in text
    assert "it went on" in text
    assert Envelope.of(file.configuration).motor_speed == pytest.approx(264.0)


def test_what_nobody_looked_at_is_not_seen() -> None:
    unseen = Outcome("writer_killed", "killed", WIRE, rest_s=0.3, off_s=0.2)
    (row,) = [line for line in page([unseen], "").splitlines() if line.startswith("| `writer_killed` |")]
    assert row == (
        "| `writer_killed` | killed | not seen | not seen | not seen | not seen | 0.30 s | "
        "not seen | not judged | 1 of 1 |"
    )


def test_the_summary_says_what_the_rows_hold() -> None:
    loaded = Outcome("a", "a", PLANT, "LIMIT", rest_s=0.64, off_s=0.1, struck=(0.5, 325.0))
    loaded.peaks, loaded.sampled_s = (50.0, 0.5, 330.0), 0.0005
    resting = Outcome("b", "b", SETUP, rungs=("controlled ramp",), rest_s=3.0, off_s=3.1, struck=(0.0, 0.0))
    nobody = Outcome("c", "c", WIRE, problems=["it went on"])
    assert summary([loaded, resting, nobody]) == (
        f"3 of {len(ROWS)} faults were injected with this version of the matrix. "
        "2 of 3 rows are as expected. "
        "At the injection the bench moved under load in 1 rows and did not in 1; in 1 this was not observed. "
        "The true shafts were judged against their envelope in 1 rows, not judged in 2. "
        "Longest time from the injection to rest without torque without a ramp: 0.64 s (`a`). "
        "Longest time from the injection to rest without torque after a controlled ramp: 3.10 s (`b`)."
    )


def test_samples_that_are_further_apart_are_told() -> None:
    looked = Outcome("a", "a", PLANT, peaks=(1.0, 1.0, 1.0), sampled_s=0.0005)
    wired = [
        Outcome(name, "w", WIRE, peaks=(1.0, 1.0, 1.0), sampled_s=apart)
        for name, apart in (("b", 0.03), ("c", 0.0829902))
    ]
    sentence = "in 3 rows (in 2 of them on samples up to 83 ms apart, else 0.5 ms), not judged in 0."
    assert sentence in summary([looked, *wired])
    assert "(83 ms)" in page(wired, "")


def test_several_tries_are_right_only_if_all_are() -> None:
    right = Outcome("frame_late", "late", WIRE, found_s=0.1, rest_s=0.2, off_s=0.3, struck=(0.5, 300.0))
    wrong = Outcome("frame_late", "late", WIRE, rest_s=0.4, off_s=0.1, problems=["it stopped"])
    both = combine_tries([right, wrong, right])
    assert (both.passed, both.right, both.tries) == (False, 2, 3)
    assert both.problems == ["try 2: it stopped"]
    assert (both.found_s, both.stopped_s) == (None, 0.4)
    assert "| 2 of 3 |" in page([both], "")


def test_a_row_in_real_time_that_was_not_right_once_gets_a_rate(
    file: BenchFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    struck: list[tuple[str, int]] = []

    def strike(rows: Sequence[Row], file: BenchFile, seed: int = 0) -> Iterator[Outcome]:
        for row in rows:
            struck.append((row.name, seed))
            wrong = ["it stopped"] if (row.name, seed) in (("frame_late", 1), ("frame_late", 7), ("poor", 0)) else []
            yield Outcome(row.name, row.text, row.kind, problems=wrong)

    monkeypatch.setattr("bench.matrix.run.run_rows", strike)
    rows = [Row("poor", "p", (), kind=PLANT), Row("frame_late", "l", (), kind=WIRE), Row("cable", "c", (), kind=WIRE)]
    poor, late, cable = run_rows_often(rows, file)
    assert (poor.right, poor.tries) == (0, 1), "what is exact is the same every time"
    assert (late.right, late.tries) == (18, RATE_TRIES)
    assert (cable.right, cable.tries) == (3, 3)
    assert [seed for name, seed in struck if name == "frame_late"] == list(range(RATE_TRIES))
    (asked,) = run_rows_often(rows[1:2], file, 2)
    assert (asked.right, asked.tries) == (1, 2), "who asks for a number gets it"


def test_the_distance_of_looks_is_the_one_that_was() -> None:
    def order(what: str) -> dict[str, Any]:
        time.sleep(0.1)
        return {"shafts": {"motor_velocity": -3.0, "load_velocity": 0.1, "torque": -5.0}, "powered": True}

    looks = wire._watch(order, 0.3, lambda look: False)
    assert looks[0][:4] == (3.0, 0.1, 5.0, True)
    apart = wire.apart_s(looks)
    assert apart is not None
    assert apart >= 0.1
    assert wire.apart_s(looks[:1]) is None


def test_rows_of_earlier_runs_keep_their_commit(tmp_path: Path) -> None:
    rows = [row for row in ROWS if row.fault in ("emergency_stop", "safety_wire")]
    old = [Outcome(row.name, row.text, row.kind, commit="old", day="2026-01-01") for row in rows]
    save(tmp_path / "f.json", old)
    assert load(tmp_path / "f.json") == old
    assert '"told"' in (tmp_path / "f.json").read_text("utf-8")
    new = Outcome(rows[1].name, rows[1].text, rows[1].kind, commit="new", day="2026-01-02")
    shown = newest_outcomes(load(tmp_path / "f.json"), [new], rows)
    assert [outcome.commit for outcome in shown] == ["old", "new"]
    said = sources(shown)
    assert said.startswith("Rows are of 2026-01-02, commit new; of 2026-01-01, commit old: `emergency_stop`. Not run: ")
    assert "`frame_late`" in said
    assert "`safety_wire`" not in said


def test_the_truth_is_looked_at_in_every_cycle_and_what_is_taken_back_is_forgotten() -> None:
    master = emulated_master()
    plain = emulated_master()
    shafts = Shafts(None, master)
    commands = np.zeros(5, COMMAND_DTYPE)
    token = master.bench.plant.snapshot()
    master.bench.plant.step(commands)
    master.bench.plant.restore(token)
    seen = master.bench.plant.step(commands)
    assert [look.cycle for look in shafts.looks] == [0, 1, 2, 3, 4, 5]
    np.testing.assert_array_equal(seen, plain.bench.plant.step(commands))
    assert shafts.at(3) == (shafts.looks[3].load_speed, shafts.looks[3].torque)
    assert shafts.at(-1) is None


def test_the_command_writes_the_page_and_fails_where_a_row_does(tmp_path: Path) -> None:
    table, store = tmp_path / "faults.md", tmp_path / "faults.json"
    arguments = ["benchmark", "faults", "--only", "sto:", "--table", str(table), "--store", str(store)]
    done = CliRunner().invoke(make_app(), arguments)
    assert done.exit_code == 0
    assert done.output.count("1 of 1 tries right") == 2
    assert "`sto:input_drive`" in table.read_text()
    outcomes = load(store)
    assert [outcome.under_load for outcome in outcomes] == [True, True]
    assert all(outcome.sampled_s == 0.0005 and outcome.commit for outcome in outcomes)


def test_the_page_and_the_readme_say_what_the_stored_rows_hold(file: BenchFile) -> None:
    root = Path(__file__).parents[3]
    outcomes = load(root / "docs" / "faults.json")
    assert outcomes
    for name in ("docs/faults.md", "README.md"):
        assert summary(outcomes) in (root / name).read_text("utf-8"), f"{name}: run bench benchmark faults"
