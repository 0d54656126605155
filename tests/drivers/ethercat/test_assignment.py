from drivers.entries import Entry
from drivers.ethercat import Pdo, SdoClient, SlaveSpec
from drivers.ethercat.assignment import assign_pdos
from tests.drivers.ethercat.scripted import ScriptedSlave

OUT = (Entry("6040:00", "u2"), Entry("60FF:00", "i4"))
IN = (Entry("6041:00", "u2"),)


def run(spec: SlaveSpec, slave: ScriptedSlave) -> list[tuple[int, int, int]]:
    assign_pdos(SdoClient(slave, spec.name), spec)
    return [(index, sub, int.from_bytes(data, "little")) for index, sub, data in slave.writes]


def test_mapping_is_written_with_the_assignment_empty_and_the_pdo_off() -> None:
    spec = SlaveSpec("drive", 1, 1, 2, (Pdo(0x1600, OUT),), (Pdo(0x1A00, IN),))
    assert run(spec, ScriptedSlave(1, 2, 3, "drive")) == [
        (0x1C12, 0, 0),
        (0x1600, 0, 0),
        (0x1600, 1, 0x60400010),
        (0x1600, 2, 0x60FF0020),
        (0x1600, 0, 2),
        (0x1C12, 1, 0x1600),
        (0x1C12, 0, 1),
        (0x1C13, 0, 0),
        (0x1A00, 0, 0),
        (0x1A00, 1, 0x60410010),
        (0x1A00, 0, 1),
        (0x1C13, 1, 0x1A00),
        (0x1C13, 0, 1),
    ]


def test_fixed_pdos_are_only_assigned() -> None:
    spec = SlaveSpec(
        "terminal", 1, 1, 2, (), (Pdo(0x1A00, IN, fixed=True), Pdo(0x1A02, (Entry("6010:01", "u2"),), True))
    )
    slave = ScriptedSlave(1, 2, 3, "terminal")
    slave.put(0x1C13, 0, "u1", 1)
    slave.put(0x1C13, 1, "u2", 0x1A00)
    assert run(spec, slave) == [(0x1C13, 0, 0), (0x1C13, 1, 0x1A00), (0x1C13, 2, 0x1A02), (0x1C13, 0, 2)]


def test_a_fixed_assignment_that_is_right_is_not_touched() -> None:
    spec = SlaveSpec("terminal", 1, 1, 2, (), (Pdo(0x1A00, IN, fixed=True),))
    slave = ScriptedSlave(1, 2, 3, "terminal")
    slave.put(0x1C13, 0, "u1", 1)
    slave.put(0x1C13, 1, "u2", 0x1A00)
    assert run(spec, slave) == []
