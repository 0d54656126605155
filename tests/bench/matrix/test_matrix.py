"""Every row of the matrix, as `bench benchmark faults` runs it; those on real frames where there may be a wire."""

import os
from pathlib import Path

import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.configuration import BenchFile, load_bench
from bench.cycle.round_trip import veth_pair
from bench.errors import DeviceError
from bench.matrix import PLANT, ROWS, SETUP, SLOW, WIRE, Outcome, Row
from bench.matrix.outcome import Envelope
from bench.matrix.plant import Strike
from bench.matrix.run import run_rows
from bench.matrix.shafts import Look, Shafts
from bench.matrix.table import page
from bench.safety import Cause
from fakes.ethercat.faults import BUS_FAULTS
from fakes.plant.faults import FAULTS
from fakes.slow_devices import NAMES
from tests.conftest import REQUIRE_WIRE

QUICK = [row for row in ROWS if row.kind not in (SLOW, WIRE) and row.last_s < 60.0]
ON_EVERY_MACHINE = ("writer_killed",)
ATTEMPTS = 3
"""A host that takes processor time away for long loses cycles by itself; that is not what these rows are about."""
LONG = [row for row in ROWS if row.last_s >= 60.0]


@pytest.fixture(scope="module")
def file() -> BenchFile:
    return load_bench("rh380n")


@pytest.mark.parametrize("row", [*QUICK, *LONG], ids=lambda row: row.name)
def test_row(row: Row, file: BenchFile) -> None:
    (outcome,) = run_rows([row], file)
    assert outcome.problems == []
    assert outcome.read_back >= (0 if row.told in ("in use", "runs already") else 1)


def test_rows_of_a_thermometer_beside_the_bus(file: BenchFile) -> None:
    rows = [row for row in ROWS if row.kind == SLOW]
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
    for _ in range(ATTEMPTS):
        (outcome,) = run_rows([row], file)
        if outcome.passed:
            break
    assert outcome.problems == []


def test_every_fault_of_the_emulator_has_a_row() -> None:
    struck = {Strike.of(row.fault).name for row in ROWS}
    known = {fault.name for fault in (*BUS_FAULTS, *FAULTS)} | set(NAMES)
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
    wrong = Row("emergency_stop", "another cause", ("MOTOR_SPEED",), within_s=0.1, told="banana", kind=PLANT)
    (outcome,) = run_rows([wrong], file)
    text = "; ".join(outcome.problems)
    for part in ("cause found is EMERGENCY_STOP", "banana", "allowed 0.1 s"):
        assert part in text
    unknown = Row("missing_slave", "the slave is there", (), told="banana", kind=SETUP)
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
    bad = Outcome("modbus_crc", "check sum", SLOW, problems=["it went on"])
    text = page([good, bad], 29.0, 325.0, "motor 264 rad/s")
    assert "| `sto:load_drive` | safe torque off | safe torque off | 0.5 ms | disable voltage | 0.30 s |" in text
    assert "1 of 2 rows" in text
    assert "it went on" in text
    assert Envelope.of(file.configuration).motor_speed == pytest.approx(264.0)


def test_the_command_writes_the_page_and_fails_where_a_row_does(tmp_path: Path) -> None:
    table = tmp_path / "faults.md"
    done = CliRunner().invoke(make_app(), ["benchmark", "faults", "--only", "sto:", "--table", str(table)])
    assert done.exit_code == 0
    assert done.output.count("right") == 2
    assert "`sto:input_drive`" in table.read_text()


def test_the_page_in_the_docs_has_every_row() -> None:
    text = (Path(__file__).parents[3] / "docs" / "faults.md").read_text("utf-8")
    for row in ROWS:
        assert f"| `{row.name}` |" in text, f"run bench benchmark faults --table docs/faults.md: {row.name} is missing"
    assert f"{len(ROWS)} of {len(ROWS)} rows are as they should be" in text
