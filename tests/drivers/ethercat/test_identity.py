import pytest

from drivers.entries import Entry
from drivers.errors import BusError, IdentityError
from drivers.ethercat import Pdo, SlaveSpec
from drivers.ethercat.identity import check_identity, check_specs
from tests.drivers.ethercat.scripted import ScriptedSlave, slave_for

INPUT = SlaveSpec("input_drive", 1, 0xE0, 0x11, (Pdo(0x1600, (Entry("6040:00", "u2"),)),))
LOAD = SlaveSpec("load_drive", 2, 0xE0, 0x12)
TORQUE = SlaveSpec("torque_terminal", 3, 0xE0, 0x13)
ALL = (INPUT, LOAD, TORQUE)


def found(*specs: SlaveSpec) -> list[ScriptedSlave]:
    return [slave_for(spec) for spec in specs]


def test_right_slaves_pass() -> None:
    check_identity(ALL, found(*ALL), "eth1")


def test_swapped_slaves_are_told_from_foreign_ones() -> None:
    with pytest.raises(IdentityError, match=r"position 1 on eth1 should be input_drive .* what load_drive should be"):
        check_identity(ALL, found(LOAD, INPUT, TORQUE), "eth1")
    stranger = ScriptedSlave(0x99, 0x11, 1, "Fan")
    with pytest.raises(IdentityError, match=r"position 3 .* but is 'Fan' \(vendor 0x00000099.*check the device"):
        check_identity(ALL, [*found(INPUT, LOAD), stranger], "eth1")


def test_revision_counts_only_where_it_is_asked_for() -> None:
    slave = ScriptedSlave(0xE0, 0x11, 7, "drive")
    check_identity((INPUT,), [slave], "eth1")
    strict = SlaveSpec("input_drive", 1, 0xE0, 0x11, revision=8)
    with pytest.raises(IdentityError, match="revision 0x00000008"):
        check_identity((strict,), [slave], "eth1")


def test_missing_and_surplus_slaves() -> None:
    with pytest.raises(IdentityError, match="2 slaves but 3 are configured; the first missing one is torque_terminal"):
        check_identity(ALL, found(INPUT, LOAD), "eth1")
    with pytest.raises(IdentityError, match="3 slaves but 2 are configured; position 3"):
        check_identity(ALL[:2], found(*ALL), "eth1")


def test_specs_are_brought_into_the_order_of_the_bus() -> None:
    assert check_specs((TORQUE, INPUT, LOAD)) == ALL


def test_specs_that_contradict_each_other() -> None:
    with pytest.raises(BusError, match=r"positions are \[1, 3\]"):
        check_specs((INPUT, TORQUE))
    with pytest.raises(BusError, match="same name"):
        check_specs((INPUT, SlaveSpec("input_drive", 2, 0xE0, 0x12)))
    twin = SlaveSpec("twin", 2, 0xE0, 0x11, (Pdo(0x1600, (Entry("6071:00", "i2"),)),))
    with pytest.raises(BusError, match=r"same identity .* but different process data"):
        check_specs((INPUT, twin))
