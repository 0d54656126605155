"""What parties that none of us wrote find in the emulator: tshark's dissector, SOEM's slaveinfo, the KickCAT master.

Each is asked where it is installed, and skipped with the reason where it is not.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time

import pysoem
import pytest

from tests.veth import Emulator, real_time_allowed

SLAVEINFO = os.environ.get("BENCH_SLAVEINFO") or shutil.which("slaveinfo")
TSHARK = shutil.which("tshark")
PRIORITY = 10
"""Of the master where real-time scheduling is allowed; below that of the emulator."""
KICKCAT_SCRIPT = """
import kickcat, os, sys, time
if len(sys.argv) > 2:
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(int(sys.argv[2])))
bus = kickcat.Bus(kickcat.create_link(sys.argv[1], ""))
bus.init(1.0)
names = [bus.read_sdo(s, 0x1008, 0, kickcat.Access.PARTIAL, 64, 1.0) for s in bus.slaves()]
bus.create_mapping(4096)
sizes = [(s.output_size, s.input_size) for s in bus.slaves()]
bus.request_state(kickcat.State.SAFE_OP)
bus.wait_for_state(kickcat.State.SAFE_OP, 2.0)
for s in bus.slaves():
    if s.output_size:
        s.set_output_bytes(bytes(s.output_size))
bus.process_data_no_check()
bus.request_state(kickcat.State.OPERATIONAL)
for _ in range(200):
    bus.process_data_no_check()
    time.sleep(0.001)
bus.wait_for_state(kickcat.State.OPERATIONAL, 2.0)
print(sizes, [bytes(n).rstrip(bytes(1)) for n in names], [str(bus.get_state(s)) for s in bus.slaves()])
"""


@pytest.fixture(scope="module")
def emulator(veth, tmp_path_factory):
    made = Emulator(veth.far, tmp_path_factory.mktemp("conformance"))
    yield made
    assert made.stop()["malformed"] == 0


@pytest.mark.skipif(TSHARK is None, reason="tshark is not installed")
def test_tshark_finds_no_malformed_frame(veth, emulator, tmp_path):
    """A start-up, SDO aborts and a run. SOEM's own source address is a group address: that remark is not ours."""
    capture = tmp_path / "run.pcapng"
    command = [TSHARK, "-i", veth.near, "-f", "ether proto 0x88a4", "-w", str(capture), "-a", "duration:60"]
    sniffer = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    while "Capturing" not in sniffer.stderr.readline():
        assert sniffer.poll() is None, "tshark ended"
    time.sleep(0.5)
    _talk(veth.near)
    time.sleep(0.5)
    sniffer.terminate()
    sniffer.communicate(timeout=30)
    fields = ["-T", "fields", "-e", "_ws.expert.message", "-e", "_ws.malformed"]
    shown = subprocess.run([TSHARK, "-r", str(capture), *fields], capture_output=True, text=True, check=True).stdout
    lines = shown.splitlines()
    assert len(lines) > 1000
    remarks = {line.strip() for line in lines if line.strip()}
    assert all("Source MAC" in remark for remark in remarks), remarks


def _talk(interface):
    master = pysoem.Master()
    master.open(interface)
    assert master.config_init() == 5
    master.config_map()
    master.config_dc()
    with pytest.raises(pysoem.SdoError):
        master.slaves[0].sdo_read(0x5FFF, 0)
    assert len(master.slaves[2].od) > 10
    master.state = pysoem.OP_STATE
    master.write_state()
    for _ in range(300):
        master.send_processdata()
        master.receive_processdata(100_000)
    master.state = pysoem.INIT_STATE
    master.write_state()
    master.close()


@pytest.mark.skipif(SLAVEINFO is None, reason="SOEM's slaveinfo is not installed (BENCH_SLAVEINFO names it)")
def test_slaveinfo_reads_identity_mapping_and_dictionary(veth, emulator):
    command = [SLAVEINFO, veth.near, "-sdo", "-map"]
    shown = subprocess.run(command, capture_output=True, text=True, timeout=60).stdout
    assert "5 slaves found and configured" in shown
    assert "Calculated workcounter 9" in shown
    for text in ("SD-17.5-13", "SD-1650-25", "AI-10V-16", "RTD-2", "ID: 04020d01", "Position actual value"):
        assert text in shown
    assert "Not all slaves reached" not in shown


def test_kickcat_reaches_operational(veth, emulator):
    pytest.importorskip("kickcat", reason="the KickCAT master is not installed")
    command = [sys.executable, "-c", KICKCAT_SCRIPT, veth.near]
    command += [str(PRIORITY)] if real_time_allowed() else []
    for _ in range(6):  # its patience with a mailbox is shorter than a loaded machine may need
        ended = subprocess.run(command, capture_output=True, text=True, timeout=60)
        if ended.returncode == 0:
            break
        time.sleep(0.5)
    assert ended.returncode == 0, ended.stderr
    result = ended.stdout.splitlines()[-1]
    assert result.count("OPERATIONAL") == 5
    assert "Emulated servo drive" in result
