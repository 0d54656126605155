"""EtherCAT slave information files (ESI, ETG.2000) of the emulated slaves, so that other tools recognise them.

``python -m fakes.ethercat.esi FOLDER`` writes one file a device of every plant that ships.
"""

from __future__ import annotations

import sys
import xml.etree.ElementTree as Xml
from collections.abc import Iterator
from pathlib import Path

from fakes.ethercat.benches import bench_of
from fakes.ethercat.drive.objects import PROFILE_SERVO
from fakes.ethercat.objects.identity import VENDOR_NAME
from fakes.ethercat.objects.pdo import RX_ASSIGN, TX_ASSIGN
from fakes.ethercat.slaves.slave import (
    INPUT_ADDRESS,
    MAILBOX_IN_ADDRESS,
    MAILBOX_OUT_ADDRESS,
    MAILBOX_SIZE,
    OUTPUT_ADDRESS,
    Slave,
)
from fakes.ethercat.wire import sii
from fakes.plant.plant_file import shipped_plants

_ENGLISH = "1033"
_CYCLE_S = 0.0005


def device_information(slave: Slave) -> Xml.Element:
    """Return the ``EtherCATInfo`` element of one slave."""
    identity = slave.identity
    root = Xml.Element("EtherCATInfo", Version="1.12")
    vendor = Xml.SubElement(root, "Vendor")
    _text(vendor, "Id", _hex(identity.vendor))
    _text(vendor, "Name", VENDOR_NAME)
    descriptions = Xml.SubElement(root, "Descriptions")
    group = Xml.SubElement(Xml.SubElement(descriptions, "Groups"), "Group")
    _text(group, "Type", "EmulatedBench")
    _text(group, "Name", VENDOR_NAME, LcId=_ENGLISH)
    device = Xml.SubElement(Xml.SubElement(descriptions, "Devices"), "Device", Physics="YY")
    _text(device, "Type", identity.order, ProductCode=_hex(identity.product), RevisionNo=_hex(identity.revision))
    _text(device, "Name", identity.name, LcId=_ENGLISH)
    _text(device, "GroupType", "EmulatedBench")
    profile = Xml.SubElement(device, "Profile")
    _text(profile, "ProfileNo", "402" if identity.profile == PROFILE_SERVO else str(identity.profile))
    for use in ("Outputs", "Inputs", "MBoxState"):
        _text(device, "Fmmu", use)
    _sync_managers(device, slave)
    for tag, assignment, manager in (("RxPdo", RX_ASSIGN, 2), ("TxPdo", TX_ASSIGN, 3)):
        _pdos(device, slave, tag, assignment, manager)
    mailbox = Xml.SubElement(device, "Mailbox", DataLinkLayer="true")
    features = ("SdoInfo", "PdoAssign", "PdoConfig", "CompleteAccess", "SegmentedSdo")
    Xml.SubElement(mailbox, "CoE", dict.fromkeys(features, "true"))
    mode = Xml.SubElement(Xml.SubElement(device, "Dc"), "OpMode")
    _text(mode, "Name", "DC")
    _text(mode, "Desc", "SYNC0")
    _text(mode, "AssignActivate", "#x0300")
    eeprom = Xml.SubElement(device, "Eeprom")
    _text(eeprom, "ByteSize", str(sii.SIZE))
    _text(eeprom, "ConfigData", sii.build(slave)[:14].hex().upper())
    return root


def _sync_managers(device: Xml.Element, slave: Slave) -> None:
    outputs, inputs = slave.layout(RX_ASSIGN).size, slave.layout(TX_ASSIGN).size
    rows = (
        ("MBoxOut", MAILBOX_OUT_ADDRESS, MAILBOX_SIZE, sii.SM_MAILBOX_OUT),
        ("MBoxIn", MAILBOX_IN_ADDRESS, MAILBOX_SIZE, sii.SM_MAILBOX_IN),
        ("Outputs", OUTPUT_ADDRESS, outputs, sii.SM_OUTPUTS),
        ("Inputs", INPUT_ADDRESS, inputs, sii.SM_INPUTS),
    )
    for use, start, size, control in rows:
        _text(
            device,
            "Sm",
            use,
            DefaultSize=str(size),
            StartAddress=f"#x{start:04X}",
            ControlByte=f"#x{control:02X}",
            Enable=str(int(size > 0)),
        )


def _pdos(device: Xml.Element, slave: Slave, tag: str, assignment: int, manager: int) -> None:
    """Add every PDO of one direction; those assigned by default name their sync manager."""
    d = slave.dictionary
    first = 0x1600 if assignment == RX_ASSIGN else 0x1A00
    assigned = [d.integer(assignment, sub) for sub in range(1, d.integer(assignment) + 1)]
    for index in (i for i in d.objects if first <= i < first + 0x200):
        pdo = Xml.SubElement(device, tag, Fixed=str(d.objects[index].entries[0].access == "ro").lower())
        if index in assigned:
            pdo.set("Sm", str(manager))
        _text(pdo, "Index", f"#x{index:04X}")
        _text(pdo, "Name", d.objects[index].name)
        for sub in range(1, d.integer(index) + 1):
            word = d.integer(index, sub)
            mapped = d.entry(word >> 16, word >> 8 & 0xFF)
            entry = Xml.SubElement(pdo, "Entry")
            _text(entry, "Index", f"#x{word >> 16:04X}")
            _text(entry, "SubIndex", str(word >> 8 & 0xFF))
            _text(entry, "BitLen", str(word & 0xFF))
            _text(entry, "Name", mapped.name)
            _text(entry, "DataType", mapped.type.name)


def _text(parent: Xml.Element, tag: str, text: str, **attributes: str) -> None:
    Xml.SubElement(parent, tag, attributes).text = text


def _hex(number: int) -> str:
    return f"#x{number:08X}"


def files() -> Iterator[tuple[str, bytes]]:
    """Yield name and content of one file for each device of the plants that ship."""
    for plant in shipped_plants():
        for slave in bench_of(plant, 0, _CYCLE_S).slaves:
            root = device_information(slave)
            Xml.indent(root)
            yield f"{slave.identity.order}.xml", Xml.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"


def main() -> None:
    """Write the files into the folder given."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files():
        (folder / name).write_bytes(content)


if __name__ == "__main__":
    main()
