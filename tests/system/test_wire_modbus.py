"""The shipped bench for the wire: its PT100 on Modbus RTU, slaves and transmitter those of one emulator."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from bench.configuration import load_bench, on_interface, parse_bench
from bench.cycle.rig import Rig
from tests.veth import Emulator, VethPair


def test_the_lubricants_temperature_comes_over_modbus(veth: VethPair, tmp_path: Path) -> None:
    line = tmp_path / "pt100"
    shipped = load_bench("rh380n-wire").text
    assert shipped.count("/tmp/pt100") == 2
    file = parse_bench(shipped.replace("/tmp/pt100", str(line)), "rh380n-wire.toml")
    emulator = Emulator(veth.far, tmp_path, modbus_rtu=str(line), without=["temperature_terminal"])
    try:
        assert [slave["role"] for slave in emulator.places["slaves"]] == [
            slave.role for slave in file.configuration.bus.slaves
        ]
        emulator.order("fault pt100_offset=15")
        time.sleep(0.3)
        with Rig(on_interface(file, veth.near)) as rig:
            assert rig.temperature == pytest.approx(36.0, abs=3.0)
            assert rig.source == "emulator"
    finally:
        emulator.stop()
