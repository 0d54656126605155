"""ESI files: what they say is what the slaves and their EEPROMs are."""

from __future__ import annotations

import xml.etree.ElementTree as Xml
from pathlib import Path

import pytest

from fakes.ethercat.esi import device_information, files
from fakes.ethercat.wire import sii
from tests.fakes.ethercat.simple_plant import simple_bench

FOLDER = Path(__file__).parents[3] / "docs" / "esi"


def test_the_files_that_ship_are_those_of_the_slaves():
    made = dict(files())
    assert set(made) == {path.name for path in FOLDER.glob("*.xml")}
    for name, content in made.items():
        assert (FOLDER / name).read_bytes() == content, (
            f"python -m fakes.ethercat.esi docs/esi brings {name} up to date"
        )


@pytest.mark.parametrize("position", range(4))
def test_identity_and_sizes(position):
    slave = simple_bench().slaves[position]
    root = device_information(slave)
    device = root.find("Descriptions/Devices/Device")
    kind = device.find("Type")
    assert int(root.findtext("Vendor/Id")[2:], 16) == slave.identity.vendor
    assert int(kind.get("ProductCode")[2:], 16) == slave.identity.product
    assert int(kind.get("RevisionNo")[2:], 16) == slave.identity.revision
    sizes = {sm.text: int(sm.get("DefaultSize")) for sm in device.findall("Sm")}
    assert sizes == {"MBoxOut": 256, "MBoxIn": 256, "Outputs": slave.outputs.size, "Inputs": slave.inputs.size}
    for tag, use in (("RxPdo", "Outputs"), ("TxPdo", "Inputs")):
        bits = sum(int(e.text) for pdo in device.findall(tag) if pdo.get("Sm") for e in pdo.findall("Entry/BitLen"))
        assert bits == 8 * sizes[use]
    assert bytes.fromhex(device.findtext("Eeprom/ConfigData")) == sii.build(slave)[:14]


def test_files_are_well_formed():
    for path in FOLDER.glob("*.xml"):
        assert Xml.parse(path).getroot().tag == "EtherCATInfo"
