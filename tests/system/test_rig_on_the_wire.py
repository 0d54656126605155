"""The rig on real frames: unmodified pysoem on one end of a veth pair, the wire-level emulator on the other."""

from pathlib import Path

import pytest

from bench.configuration import load_bench, on_interface
from bench.cycle.rig import Rig
from bench.errors import ConfigurationError
from tests.veth import Emulator, VethPair


def test_the_same_bench_file_runs_on_an_interface(veth: VethPair, tmp_path: Path) -> None:
    # nothing here depends on how punctual a busy machine is: slots may be missed, the drives stay without voltage
    file = on_interface(load_bench("rh380n"), veth.near)
    emulator = Emulator(veth.far, tmp_path, plant="rh380n")
    try:
        with Rig(file) as rig:
            assert rig.is_real_time
            assert 10.0 < rig.temperature < 30.0
            assert abs(rig.zeros.load_torque) < 50.0
            assert rig.elapsed_s > 0.0
    finally:
        counters = emulator.stop()
    assert counters


def test_only_master_and_interface_change() -> None:
    file = load_bench("rv80n")
    moved = on_interface(file, "eth7")
    assert (moved.configuration.bus.master, moved.configuration.bus.interface) == ("soem", "eth7")
    back = moved.text.replace('"soem"', '"emulated"', 1).replace('"eth7"', '"emulated"', 1)
    assert back == file.text
    assert moved.digest != file.digest


def test_a_file_without_an_interface_line_is_a_sentence() -> None:
    file = load_bench("rh380n")
    odd = type(file)(file.configuration, file.text.replace("interface = ", "# interface = "), "odd.toml")
    with pytest.raises(ConfigurationError, match=r"odd\.toml: bus\.interface"):
        on_interface(odd, "eth0")
