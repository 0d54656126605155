"""``bench emulate`` and ``bench benchmark wire`` from the command line."""

from __future__ import annotations

import json
import signal
import subprocess
import sys

import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.errors import BenchError, ConfigurationError, DeviceError

START = "from bench.cli import main; main()"


def bench(*arguments: str) -> list[str]:
    return [sys.executable, "-c", START, *arguments]


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(bench(*arguments), capture_output=True, text=True, timeout=60)


def refusal(*arguments: str) -> BenchError:
    error = CliRunner().invoke(make_app(), ["emulate", *arguments]).exception
    assert isinstance(error, BenchError), error
    return error


def test_help_names_what_one_may_ask_for():
    shown = CliRunner().invoke(make_app(), ["emulate", "--help"], terminal_width=200)
    assert shown.exit_code == 0
    for option in ("--interface", "--modbus-rtu", "--fault", "--control"):
        assert option in shown.output


def test_a_missing_interface_is_named():
    error = refusal("--interface", "nothere0")
    assert isinstance(error, DeviceError)
    assert "nothere0" in str(error)


@pytest.mark.parametrize(
    ("option", "value", "text"),
    [
        ("--fault", "melted", "no fault 'melted'"),
        ("--fault", "drive_fault:input drive", "must be name[:slave][=value][@seconds]"),
        ("--fault", "modbus_crc", "needs a PT100 transmitter"),
        ("--plant", "nowhere", "no plant file"),
        ("--cycle-time-ms", "0", "must be greater than 0"),
    ],
)
def test_wrong_options_are_named(veth, option, value, text):
    error = refusal("--interface", veth.far, option, value)
    assert isinstance(error, ConfigurationError)
    assert text in str(error)


def test_it_says_where_everything_is_and_ends_on_interrupt(veth, tmp_path):
    link = tmp_path / "line"
    command = bench("emulate", "--interface", veth.far, "--serial", str(link), "--modbus-tcp", "0", "--json")
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    places = json.loads(process.stdout.readline())
    assert [slave["role"] for slave in places["slaves"]][:2] == ["input_drive", "load_drive"]
    assert places["serial"] == str(link)
    assert link.is_symlink()
    assert places["modbus_tcp"] > 0
    assert "another emulator" in str(refusal("--interface", veth.far))
    process.send_signal(signal.SIGINT)
    out, error = process.communicate(timeout=30)
    assert process.returncode == 0, error
    assert json.loads(out)["cycles"] > 0
    assert not link.exists()


def test_wire_benchmark_counts_every_cycle(veth):
    ended = run("benchmark", "wire", "--interface", veth.near, "--far", veth.far, "--seconds", "0.5", "--json")
    assert ended.returncode == 0, ended.stderr
    figures = json.loads(ended.stdout)
    assert figures["cycles"] == 1000
    assert figures["lost"] + figures["wrong"] < 1000
    assert 0 < figures["median_us"] <= figures["p99_us"] <= figures["maximum_us"]
    assert figures["emulator"]["process_frames"] >= 1000 - figures["lost"]
