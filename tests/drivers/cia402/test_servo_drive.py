from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from drivers.cia402 import CST, CSV, DriveLimits, Goal, Mode, Outcome, ServoDrive, ServoDriveConfig, State, lead
from drivers.cia402.factory import servo_drive
from drivers.cia402.objects import DEFAULT_INPUTS
from drivers.devices import Place
from drivers.entries import entries_dtype
from drivers.errors import DriveFaultError, DriverError, ParameterMismatchError
from drivers.ethercat import SdoClient
from tests.drivers.ethercat.scripted import ScriptedSlave

LIMITS = DriveLimits(40.0, 300.0)
WORD = {State.SWITCH_ON_DISABLED: 0x0250, State.READY_TO_SWITCH_ON: 0x0231, State.SWITCHED_ON: 0x0233}
ENABLED, FAULT = 0x0237, 0x0218


def configured(mode: Mode = CSV, polarity: int = 1, **options: Any) -> tuple[ServoDrive, ScriptedSlave]:
    config = ServoDriveConfig("input_drive", 1, 0xE0, 0x11, mode, LIMITS, polarity=polarity, **options)
    drive = ServoDrive(config)
    slave = ScriptedSlave(0xE0, 0x11, 1, "drive")
    for index, sub, value in ((0x6502, 0, 0x300), (0x6092, 1, 8192), (0x6092, 2, 1), (0x6076, 0, 17_500)):
        slave.put(index, sub, "u4", value)
    slave.put(0x60A9, 0, "u4", 0xFDB44700)
    drive.configure(SdoClient(slave, "input_drive"))
    return drive, slave


def attached(capacity: int = 8, **options: Any) -> tuple[ServoDrive, NDArray[Any], NDArray[Any]]:
    drive, _ = configured(**options)
    spec = drive.spec
    outputs, inputs = np.zeros(capacity, entries_dtype(spec.outputs)), np.zeros(capacity, entries_dtype(spec.inputs))
    inputs["6061:00"] = drive.config.mode
    drive.attach(outputs, inputs)
    return drive, outputs, inputs


def test_limits_and_mode_are_in_the_drive_before_anything_is_enabled() -> None:
    drive, slave = configured()
    assert slave.get(0x6072, 0, "u2") == 2285  # 40 N·m of 17.5 N·m, rounded down
    assert slave.get(0x6080, 0, "u4") == 2864
    assert slave.get(0x6060, 0, "i1") == 9
    assert drive.verify(SdoClient(slave, "input_drive")) == ()


def test_a_drive_that_cannot_run_the_mode() -> None:
    drive, slave = configured()
    slave.put(0x6502, 0, "u4", 0x0001)
    with pytest.raises(DriverError, match="does not support cyclic synchronous velocity"):
        drive.configure(SdoClient(slave, "input_drive"))


def test_scaling_of_drive_and_configuration_must_agree() -> None:
    with pytest.raises(ParameterMismatchError, match="8192 in the drive but 4096 in the configuration"):
        configured(counts_per_turn=4096.0)
    with pytest.raises(ParameterMismatchError, match="rated torque"):
        configured(rated_torque_nm=20.0)


@given(st.lists(st.floats(-400, 400), min_size=1, max_size=8), st.sampled_from([1, -1]))
def test_set_velocities_are_rounded_to_counts_in_the_drives_direction(velocities: list[float], polarity: int) -> None:
    drive, outputs, inputs = attached(polarity=polarity)
    n = len(velocities)
    drive.set_velocity(np.array(velocities), n)
    unit = drive.units.velocity_rad_s
    sent = outputs["60FF:00"][:n] * unit * polarity
    np.testing.assert_allclose(sent, velocities, atol=0.51 * unit)
    # What is sent comes back as the same velocity in the bench's direction.
    inputs["606C:00"][:n] = outputs["60FF:00"][:n]
    np.testing.assert_allclose(drive.velocity(n), velocities, atol=0.51 * unit)


def test_torque_has_a_sign_of_its_own_where_it_counts_against_motion() -> None:
    drive, outputs, inputs = attached(mode=CST, polarity=-1, torque_polarity=1)
    drive.set_torque(3.5, 2)
    np.testing.assert_array_equal(outputs["6071:00"][:2], [200, 200])
    inputs["6077:00"][:2] = 100
    np.testing.assert_allclose(drive.torque(2), [1.75, 1.75])
    inputs["606C:00"][:2] = 1000
    assert (drive.velocity(2) < 0).all()


def test_set_values_saturate_instead_of_wrapping_and_must_be_numbers() -> None:
    drive, outputs, _ = attached(mode=CST)
    drive.set_torque([1e9, -1e9], 2)
    np.testing.assert_array_equal(outputs["6071:00"][:2], [32767, -32768])
    with pytest.raises(DriverError, match="not a number"):
        drive.set_torque(math.nan, 1)


def test_nothing_but_zero_is_sent_while_not_enabled() -> None:
    drive, outputs, inputs = attached()
    drive.set_velocity(100.0, 4)
    drive.prepare(4)
    assert not outputs["60FF:00"].any()
    inputs["6041:00"] = ENABLED
    drive.request(Goal.ENABLED)
    drive.digest(4)
    drive.set_velocity(100.0, 4)
    drive.prepare(4)
    assert (outputs["60FF:00"][:4] > 0).all()
    assert (outputs["6040:00"][:4] == 0x0F).all()
    assert (outputs["6060:00"][:4] == 9).all()


def test_the_first_cycle_of_a_block_that_is_not_enabled_counts() -> None:
    drive, _, inputs = attached()
    inputs["6041:00"] = ENABLED
    drive.request(Goal.ENABLED)
    assert drive.digest(8) == 8
    inputs["6041:00"][5:] = FAULT
    inputs["603F:00"][5:] = 0x7305
    assert drive.digest(8) == 5
    assert drive.sequence.outcome is Outcome.FAULTED
    with pytest.raises(DriveFaultError, match=r"input_drive is in fault: error 0x7305 \(encoder 1 fault\)"):
        drive.check(8)
    drive.prepare(8)
    inputs["6041:00"] = ENABLED  # nobody asked again
    drive.digest(8)
    assert drive.sequence.controlword == 0


def test_a_fault_that_was_over_within_the_block_is_seen_all_the_same() -> None:
    drive, _, inputs = attached()
    inputs["6041:00"] = ENABLED
    drive.request(Goal.ENABLED)
    drive.digest(8)
    inputs["6041:00"][3] = WORD[State.SWITCH_ON_DISABLED]
    assert drive.digest(8) == 3
    assert drive.sequence.outcome is Outcome.LEFT
    with pytest.raises(DriveFaultError, match="left the goal 'enabled'"):
        drive.check()


def test_positions_are_extended_over_blocks_and_scaled() -> None:
    drive, _, inputs = attached(polarity=-1)
    inputs["6064:00"] = np.arange(2**31 - 4, 2**31 + 4).astype(np.int32)
    first = drive.position(8)
    inputs["6064:00"] = np.arange(2**31 + 4, 2**31 + 12).astype(np.int32)
    second = drive.position(8)
    np.testing.assert_array_equal(np.diff(np.concatenate((first, second))), 1)
    assert drive.position_rad(8192) == pytest.approx(-2 * math.pi)


class FakeBus:
    """Moves the drive's state machine on by one state a cycle."""

    def __init__(self, outputs: NDArray[Any], inputs: NDArray[Any], last: int) -> None:
        self.outputs, self.inputs, self.last, self.seen = outputs, inputs, last, 0
        inputs["6041:00"] = WORD[State.SWITCH_ON_DISABLED]

    def exchange(self, n: int = 1) -> str:
        steps = {0x06: WORD[State.READY_TO_SWITCH_ON], 0x07: WORD[State.SWITCHED_ON], 0x0F: self.last}
        self.inputs["6041:00"] = steps.get(int(self.outputs["6040:00"][0]), WORD[State.SWITCH_ON_DISABLED])
        self.seen += 1
        return "exchange"


def test_lead_walks_up_and_shows_every_cycle() -> None:
    drive, outputs, inputs = attached()
    bus = FakeBus(outputs, inputs, ENABLED)
    seen: list[Any] = []
    cycles = lead(bus, [drive], Goal.ENABLED, on_cycle=seen.append)
    assert drive.sequence.state is State.OPERATION_ENABLED
    assert cycles == bus.seen == len(seen)


def test_lead_ends_with_the_fault_on_the_way() -> None:
    drive, outputs, inputs = attached()
    inputs["603F:00"] = 0x3220
    with pytest.raises(DriveFaultError, match=r"did not reach the goal 'enabled' .*0x3220 \(DC link under-voltage\)"):
        lead(FakeBus(outputs, inputs, FAULT), [drive], Goal.ENABLED)


def test_lead_gives_up_in_time() -> None:
    drive, outputs, inputs = attached()
    bus = FakeBus(outputs, inputs, WORD[State.SWITCHED_ON])
    with pytest.raises(DriveFaultError, match="it is in switched on"):
        lead(bus, [drive], Goal.ENABLED, timeout_s=0.05)
    assert bus.seen == 100


def test_use_before_configuration_or_attachment_is_told() -> None:
    drive = ServoDrive(ServoDriveConfig("input_drive", 1, 0xE0, 0x11, CSV, LIMITS))
    with pytest.raises(DriverError, match="the bus should configure"):
        drive.units.torque_nm  # noqa: B018
    with pytest.raises(DriverError, match="attach"):
        drive.prepare(1)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"polarity": 0}, "polarity is 0; it should be 1 or -1"),
        ({"inputs": ("6041:00",)}, "lacks 6064:00"),
        ({"outputs": ("6040:00", "6071:00")}, "lacks 60FF:00, needed for cyclic synchronous velocity"),
        ({"mode": Mode.HOMING}, "cannot run homing"),
    ],
)
def test_configurations_that_cannot_work(options: dict[str, Any], words: str) -> None:
    with pytest.raises(DriverError, match=words):
        ServoDriveConfig(
            **{"name": "d", "position": 1, "vendor": 1, "product": 1, "mode": CSV, "limits": LIMITS, **options}
        )


PLACE = Place("load_drive", 2, 0xE0, 0x12)


def test_factory_reads_options() -> None:
    drive = servo_drive(
        PLACE,
        {
            "mode": "cst",
            "polarity": -1,
            "limits": {"torque_nm": 1400.0, "speed_rad_s": 5.0, "quick_stop": "current_limit_and_stay"},
            "inputs": ["6041:00", "6064:00", "6061:00", "2010:01/i4"],
            "parameters": [{"index": 0x6073, "subindex": 0, "type": "u2", "value": 2000, "why": "current limit"}],
        },
    )
    assert drive.config.mode is CST
    assert drive.config.limits.quick_stop == 7
    assert drive.spec.inputs[-1].type == "i4"
    assert drive.config.parameters[0].value == 2000


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"mode": "csp"}, "mode is 'csp'; it should be one of csv, cst"),
        ({}, "mode is None"),
        ({"mode": "csv"}, "limits: option 'torque_nm' is missing"),
        ({"mode": "csv", "limits": {"torque_nm": 1, "speed_rad_s": 1}, "gain": 3}, "option 'gain' is not known"),
        ({"mode": "csv", "limits": {"torque_nm": 1, "speed_rad_s": 1, "quick_stop": "now"}}, "quick_stop is 'now'"),
        (
            {"mode": "csv", "limits": {"torque_nm": 1, "speed_rad_s": 1}, "inputs": [*DEFAULT_INPUTS, "9999:00"]},
            "9999:00/i4",
        ),
    ],
)
def test_factory_refuses_with_what_would_be_right(options: dict[str, Any], words: str) -> None:
    with pytest.raises(DriverError, match=words):
        servo_drive(PLACE, options)


def test_a_goal_is_asked_for_and_answered_by_its_name() -> None:
    drive, _, inputs = attached()
    inputs["6041:00"] = WORD[State.SWITCH_ON_DISABLED]
    drive.digest(8)
    drive.request("ENABLED")
    assert drive.sequence.goal is Goal.ENABLED
    assert drive.goal_name == "ENABLED"
    assert drive.state_name == "SWITCH_ON_DISABLED"
    assert not drive.reached()
    inputs["6041:00"] = ENABLED
    drive.digest(8)
    assert drive.state_name == "OPERATION_ENABLED"
    assert drive.reached()
    assert drive.reached("ENABLED")
    assert not drive.reached("DISABLED")
    with pytest.raises(KeyError):
        drive.request("NOWHERE")


def test_a_drive_goes_back_to_its_snapshot() -> None:
    drive, _, inputs = attached()
    inputs["6041:00"] = ENABLED
    drive.request(Goal.ENABLED)
    drive.digest(8)
    before = drive.snapshot()
    inputs["6041:00"] = FAULT
    drive.digest(8)
    assert not drive.reached()
    drive.restore(before)
    assert drive.reached("ENABLED")
    assert drive.state_name == "OPERATION_ENABLED"
