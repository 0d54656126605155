import pysoem
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.errors import ParameterMismatchError, SdoAccessError
from drivers.ethercat import SdoClient
from drivers.ethercat.patience import PATIENCE_S, Tries
from tests.drivers.ethercat.scripted import ScriptedSlave


def client(**objects: object) -> tuple[SdoClient, ScriptedSlave]:
    slave = ScriptedSlave(1, 2, 3, "slave")
    return SdoClient(slave, "load_drive"), slave


def test_abort_is_told_with_object_code_and_reason() -> None:
    sdo, _ = client()
    with pytest.raises(
        SdoAccessError, match=r"load_drive: object 6072:00 could not be read: 0x06020000 \(object does not"
    ):
        sdo.read(0x6072, 0, "u2")


def test_abort_keeps_its_code_for_those_who_look() -> None:
    sdo, slave = client()
    slave.sdo_script = [pysoem.SdoError(1, 0x6072, 0, 0x06090031, "")]
    with pytest.raises(SdoAccessError) as caught:
        sdo.write(0x6072, 0, "u2", 7)
    assert (caught.value.index, caught.value.subindex, caught.value.abort_code) == (0x6072, 0, 0x06090031)
    assert "could not be written" in str(caught.value)


@given(st.sampled_from(["u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8"]), st.data())
def test_integers_survive_the_wire(type_: str, data: st.DataObject) -> None:
    bits = 8 * int(type_[1])
    low, high = (0, 2**bits - 1) if type_[0] == "u" else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    value = data.draw(st.integers(low, high))
    sdo, slave = client()
    sdo.write_checked(0x2000, 1, type_, value)
    assert sdo.read(0x2000, 1, type_) == value
    assert slave.writes[0][2] == value.to_bytes(bits // 8, "little", signed=type_[0] == "i")


@pytest.mark.parametrize(("type_", "value"), [("u1", 256), ("i2", 40000), ("u4", -1)])
def test_value_that_does_not_fit_is_refused_before_it_is_sent(type_: str, value: int) -> None:
    sdo, slave = client()
    with pytest.raises(SdoAccessError, match="does not fit"):
        sdo.write(0x2000, 1, type_, value)
    assert slave.writes == []


def test_wrong_length_is_an_error_not_a_number() -> None:
    sdo, slave = client()
    slave.objects[0x6041, 0] = b"\x01\x02\x03\x04"
    with pytest.raises(SdoAccessError, match="has 4 bytes, not the 2 of type u2"):
        sdo.read(0x6041, 0, "u2")


def test_silent_clipping_by_the_device_is_noticed() -> None:
    sdo, slave = client()
    slave.keeps[0x6072, 0] = (800).to_bytes(2, "little")
    with pytest.raises(ParameterMismatchError, match="6072:00 was set to 1200 but the device keeps 800"):
        sdo.write_checked(0x6072, 0, "u2", 1200)


@pytest.mark.parametrize("disturbance", [pysoem.WkcError(wkc=0), pysoem.PacketError(1, 1), AssertionError()])
def test_one_disturbed_answer_is_asked_for_again(disturbance: Exception) -> None:
    sdo, slave = client()
    slave.put(0x6041, 0, "u2", 0x0250)
    slave.sdo_script = [disturbance]
    assert sdo.read(0x6041, 0, "u2") == 0x0250


@pytest.mark.parametrize(
    ("disturbance", "words"),
    [
        (pysoem.WkcError(wkc=0), "does not answer; its cable"),
        (pysoem.PacketError(1, 1), "unexpected mailbox answer"),
        (pysoem.MailboxError(1, 2, ""), "CoE firmware is needed"),
    ],
)
def test_lasting_trouble_ends_in_a_sentence(disturbance: Exception, words: str) -> None:
    sdo, slave = client()
    sdo.cycles_wait()
    slave.sdo_script = [disturbance] * 10
    with pytest.raises(SdoAccessError, match=words):
        sdo.read(0x6041, 0, "u2")
    assert len(slave.sdo_script) == 7  # three tries, no more


def test_a_slave_that_is_late_is_waited_for() -> None:
    sdo, slave = client()
    slave.put(0x6041, 0, "u2", 0x0250)
    slave.sdo_script = [pysoem.WkcError(wkc=0)] * 10
    assert sdo.read(0x6041, 0, "u2") == 0x0250


@pytest.mark.parametrize(("answer_takes_s", "asked"), [(0.0, 211), (0.02, 70), (0.7, 3), (5.0, 3)])
def test_a_silent_slave_counts_as_gone_after_three_unanswered_requests_or_their_time(
    answer_takes_s: float, asked: int
) -> None:
    now = [0.0]

    def sleep(seconds: float) -> None:
        now[0] += seconds

    tries, more = Tries(clock=lambda: now[0], sleep=sleep), True
    while more:
        now[0] += answer_takes_s
        more = tries.again(silent=True)
    assert tries.made == pytest.approx(asked, abs=1)
    assert tries.waited_s == pytest.approx(max(PATIENCE_S, 3 * answer_takes_s), abs=0.05)


def test_what_came_late_is_dropped_before_each_try_and_when_a_slave_is_given_up() -> None:
    slave = ScriptedSlave(1, 2, 3, "slave")
    slave.put(0x6041, 0, "u2", 0x0250)
    settled: list[int] = []
    sdo = SdoClient(slave, "load_drive", lambda: settled.append(len(slave.sdo_script)))
    slave.sdo_script = [pysoem.WkcError(wkc=0), pysoem.PacketError(1, 1)]
    assert sdo.read(0x6041, 0, "u2") == 0x0250
    assert settled == [1, 0]
    now, dropped = [0.0], []
    tries = Tries(1.0, lambda: dropped.append(now[0]), lambda: now[0], lambda _: pytest.fail("it paused"))
    now[0] = 5.0
    assert [tries.again(silent=False), tries.again(silent=False)] == [True, True]
    assert dropped == []


def test_where_cycles_wait_nothing_is_dropped_and_three_tries_are_all() -> None:
    slave = ScriptedSlave(1, 2, 3, "slave")
    sdo = SdoClient(slave, "load_drive", lambda: pytest.fail("it settled"))
    sdo.cycles_wait()
    slave.sdo_script = [pysoem.WkcError(wkc=0), pysoem.PacketError(1, 1)] * 5
    with pytest.raises(SdoAccessError, match="in 3 tries"):
        sdo.read(0x6041, 0, "u2")
    assert len(slave.sdo_script) == 7


def test_a_wrong_answer_is_no_reason_to_wait() -> None:
    tries = Tries(sleep=lambda _: pytest.fail("it paused"))
    assert [tries.again(silent=False) for _ in range(3)] == [True, True, False]


def test_exists_tells_missing_from_failing() -> None:
    sdo, slave = client()
    slave.put(0x60A9, 0, "u4", 1)
    assert sdo.exists(0x60A9, 0)
    assert not sdo.exists(0x6096, 1)
    slave.sdo_script = [pysoem.SdoError(1, 0, 0, 0x06060000, "")]
    with pytest.raises(SdoAccessError, match="hardware error"):
        sdo.exists(0x60A9, 0)


def test_text_objects() -> None:
    sdo, slave = client()
    slave.objects[0x1008, 0] = b"Servo\0\0"
    assert sdo.read_text(0x1008) == "Servo"
