"""The rig on real frames with its PT100 on Modbus RTU: slaves and transmitter are those of one emulator."""

from __future__ import annotations

import re
import time
from pathlib import Path

import pytest

from bench.configuration import load_bench, on_interface
from bench.cycle.rig import Rig
from tests.veth import Emulator, VethPair

SENSOR = """[[bus.slow_sensors]]
role = "temperature"
driver = "pt100_modbus_rtu"
period = "0.2 s"
options = {{ port = "{port}" }}

"""
_TERMINAL = re.compile(r'\[\[bus\.slaves\]\]\nrole = "temperature_terminal".*?(?=\n\[)\n', re.DOTALL)


def test_the_lubricants_temperature_comes_over_modbus(veth: VethPair, tmp_path: Path) -> None:
    line = tmp_path / "pt100"
    text, replaced = _TERMINAL.subn(SENSOR.format(port=line), load_bench("rh380n").text)
    assert replaced == 1
    path = tmp_path / "rtu.toml"
    path.write_text(text)
    emulator = Emulator(veth.far, tmp_path, modbus_rtu=str(line), without=["temperature_terminal"])
    try:
        assert [slave["role"] for slave in emulator.places["slaves"]] == [
            "input_drive",
            "load_drive",
            "torque_terminal",
        ]
        emulator.order("fault pt100_offset=15")
        time.sleep(0.3)
        with Rig(on_interface(load_bench(str(path)), veth.near)) as rig:
            assert rig.temperature == pytest.approx(36.0, abs=3.0)
    finally:
        emulator.stop()
