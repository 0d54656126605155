"""The rows of the matrix: one fault each, when it strikes, what may be the cause found, and how long the stop may take.

A fault of the emulated bench is written as ``bench emulate --fault`` takes it: ``name[:slave][=value]``.
"""

from __future__ import annotations

from dataclasses import dataclass

PLANT, SETUP, HOST, WIRE = "plant and bus", "setup", "host", "processes on real frames"
SLOW, SERVICE = "thermometer beside the bus", "service and locks"
"""Kinds of rows: struck while turning; met before anything moves; on a line of its own; of the computer; on a wire."""


@dataclass(frozen=True, slots=True)
class Row:
    """One fault.

    Attributes
    ----------
    fault : how it is switched on; a name of its own where it is not one of the emulator.
    text : what breaks, for people.
    causes : names of :class:`~bench.safety.Cause` that are right; none where the bench has to run on.
    within_s : longest time from the fault until the shafts rest without torque; includes finding it.
    expected_text : word that the operator's sentence must hold.
    kind : one of the kinds above.
    last_s : how long the motion lasts in which it strikes.
    block : cycles between two looks at the true shafts.
    standing : states in which the emulated drives may be left; both must be without torque.
    """

    fault: str
    text: str
    causes: tuple[str, ...]
    within_s: float = 5.0
    expected_text: str = ""
    kind: str = PLANT
    last_s: float = 3.0
    block: int = 400
    standing: tuple[str, ...] = ("SWITCH_ON_DISABLED",)

    @property
    def name(self) -> str:
        """Name and slave, without value."""
        return self.fault.partition("=")[0]


_FAULT = ("SWITCH_ON_DISABLED", "FAULT")
_JUMP = ("ENCODER_DISAGREEMENT", "VELOCITY_ERROR", "MOTOR_SPEED", "MOTOR_ACCELERATION")
_FROZEN = ("MOTOR_ENCODER_FROZEN", "MOTOR_VELOCITY_FROZEN", "VELOCITY_ERROR", "ENCODER_DISAGREEMENT")

_PLANT_ROWS: tuple[Row, ...] = (
    Row("emergency_stop", "emergency stop pressed", ("EMERGENCY_STOP",), 1.5, "emergency stop"),
    Row("safety_wire", "wire of the emergency stop input broken", ("EMERGENCY_STOP",), 1.5, "emergency stop"),
    Row("sto:input_drive", "safe torque off of the input drive", ("SAFE_TORQUE_OFF",), 5.0, "safe torque off"),
    Row("sto:load_drive", "safe torque off of the load drive", ("SAFE_TORQUE_OFF",), 5.0, "safe torque off"),
    Row(
        "drive_fault:input_drive=0x2310",
        "input drive trips",
        ("INPUT_DRIVE_FAULT",),
        5.0,
        "input drive",
        standing=_FAULT,
    ),
    Row("drive_fault:load_drive=0x4310", "load drive trips", ("LOAD_DRIVE_FAULT",), 1.5, "load drive", standing=_FAULT),
    Row("slave_lost:input_drive", "input drive loses its power", ("LOST_CYCLES",), 5.0, "lost cycles", standing=_FAULT),
    Row("slave_lost:load_drive", "load drive loses its power", ("LOST_CYCLES",), 5.0, "lost cycles", standing=_FAULT),
    Row(
        "slave_lost:torque_terminal",
        "torque terminal does not answer",
        ("LOST_CYCLES",),
        2.0,
        "lost cycles",
        standing=_FAULT,
    ),
    Row(
        "slave_lost:temperature_terminal",
        "PT100 terminal does not answer",
        ("LOST_CYCLES",),
        2.0,
        "lost cycles",
        standing=_FAULT,
    ),
    Row(
        "slave_lost:safety_terminal",
        "safety terminal does not answer",
        ("LOST_CYCLES",),
        2.0,
        "lost cycles",
        standing=_FAULT,
    ),
    Row(
        "cable_pulled:input_drive",
        "cable before the first slave pulled",
        ("LOST_CYCLES",),
        5.0,
        "lost cycles",
        standing=_FAULT,
    ),
    Row(
        "cable_pulled:load_drive",
        "cable between the drives pulled",
        ("LOST_CYCLES",),
        5.0,
        "lost cycles",
        standing=_FAULT,
    ),
    Row(
        "cable_pulled:torque_terminal",
        "cable behind the drives pulled",
        ("LOST_CYCLES",),
        2.0,
        "lost cycles",
        standing=_FAULT,
    ),
    Row(
        "wkc_short:load_drive",
        "load drive takes no part in process data",
        ("LOST_CYCLES",),
        5.0,
        "lost cycles",
        standing=_FAULT,
    ),
    Row(
        "wkc_short:torque_terminal",
        "torque terminal takes no part in process data",
        ("LOST_CYCLES",),
        2.0,
        "lost cycles",
        standing=_FAULT,
    ),
    Row("frame_lost=1", "one frame lost", (), expected_text="missing"),
    Row("frame_lost=15", "fifteen frames lost, fewer than limits.lost_cycles", (), expected_text="missing"),
    Row("frame_lost=2000", "no frame comes back for a second", ("LOST_CYCLES",), 5.0, "lost cycles", standing=_FAULT),
    Row("input_encoder_frozen", "motor encoder stands still", _FROZEN, 3.0),
    Row("input_encoder_jump", "motor encoder jumps by half a revolution", _JUMP, 2.0, standing=_FAULT),
    Row("input_encoder_wrap", "motor encoder loses its count of revolutions", _JUMP, 2.0, standing=_FAULT),
    Row(
        "load_encoder_frozen",
        "load encoder stands still",
        ("LOAD_ENCODER_FROZEN", "LOAD_VELOCITY_FROZEN", "ENCODER_DISAGREEMENT"),
        5.0,
    ),
    Row("load_encoder_jump", "load encoder jumps", (*_JUMP, "LOAD_SPEED"), 2.0, standing=_FAULT),
    Row("load_encoder_wrap=20", "load encoder loses its upper bits", (*_JUMP, "LOAD_SPEED"), 2.0, standing=_FAULT),
    Row("torque_sensor_saturated", "torque sensor at full scale", ("TORQUE_SENSOR_RANGE",), 5.0, "torque sensor"),
    Row(
        "torque_sensor_open",
        "wire of the torque sensor broken",
        ("TORQUE_DISAGREEMENT", "LOAD_TORQUE_RATE"),
        5.0,
        "torque",
    ),
    Row("torque_sensor_frozen", "torque sensor stands still", ("TORQUE_SENSOR_FROZEN",), 5.0, "torque sensor"),
    Row(
        "torque_sensor_drift=2",
        "torque sensor's zero runs away by 2 N·m/s",
        ("TORQUE_DRIFT", "TORQUE_DISAGREEMENT"),
        110.0,
        "torque sensor",
        last_s=130.0,
        block=2000,
    ),
    Row(
        "torque_sensor_gain=0.3",
        "torque sensor shows a third",
        ("TORQUE_DISAGREEMENT", "LOAD_TORQUE_RATE"),
        5.0,
        "torque",
    ),
    Row("pt100_open", "PT100 open circuit", ("TEMPERATURE_SENSOR",), 5.0, "thermometer"),
    Row("pt100_short", "PT100 short circuit", ("TEMPERATURE_SENSOR",), 5.0, "thermometer"),
    Row(
        "pt100_frozen",
        "PT100 shows the same for ever",
        ("TEMPERATURE_FROZEN",),
        130.0,
        "temperature",
        last_s=140.0,
        block=4000,
    ),
    Row("pt100_offset=10", "PT100 jumps by 10 K", ("TEMPERATURE_RATE",), 5.0, "temperature"),
    Row("ambient_pt100_open", "PT100 of the surroundings open (a label, nothing depends on it)", ()),
    Row("ambient_pt100_short", "PT100 of the surroundings short", ()),
    Row(
        "input_current_off",
        "input drive gives no current and does not say so",
        ("VELOCITY_ERROR", "TORQUE_ERROR", "MOTOR_TORQUE_FROZEN"),
        2.0,
    ),
    Row(
        "load_current_off",
        "load drive gives no current and does not say so",
        ("TORQUE_ERROR", "LOAD_TORQUE_RATE"),
        2.0,
        "torque",
    ),
    Row(
        "input_runaway=20",
        "input drive gives 20 N·m whatever its set value",
        ("VELOCITY_ERROR", "MOTOR_TORQUE", "MOTOR_ACCELERATION"),
        3.0,
    ),
    Row(
        "load_runaway=1000",
        "load drive gives 1000 N·m whatever its set value",
        ("TORQUE_ERROR", "LOAD_TORQUE_RATE", "LOAD_TORQUE", "VELOCITY_ERROR", "ENCODER_DISAGREEMENT"),
        3.0,
    ),
    Row(
        "load_uncoupled",
        "coupling open under load",
        ("ENCODER_DISAGREEMENT", "LOAD_TORQUE_RATE", "TORQUE_DISAGREEMENT"),
        3.0,
    ),
    Row(
        "output_stalled=2500",
        "load side dragged by 2.5 kN·m",
        ("VELOCITY_ERROR", "LOAD_TORQUE", "LOAD_TORQUE_RATE", "TORQUE_DISAGREEMENT", "MOTOR_TORQUE"),
        3.0,
    ),
    Row("input_stalled", "input shaft blocked", ("VELOCITY_ERROR", "MOTOR_TORQUE", "LOAD_TORQUE_RATE"), 2.0),
    Row(
        "friction_raised=10",
        "lubricant lost: ten times the friction",
        ("FRICTION", "MOTOR_TORQUE", "VELOCITY_ERROR"),
        5.0,
    ),
    Row(
        "heating_external=20000",
        "20 kW from elsewhere into the lubricant",
        ("TEMPERATURE_HIGH", "TEMPERATURE_RATE"),
        70.0,
        "temperature",
        last_s=80.0,
        block=2000,
    ),
)
"""Every fault the emulated bench knows in process."""

_SETUP_ROWS: tuple[Row, ...] = (
    Row("wrong_order", "two terminals are interchanged", (), expected_text="order of the cables", kind=SETUP),
    Row("wrong_identity", "another device in place of the input drive", (), expected_text="input_drive", kind=SETUP),
    Row("missing_slave", "the last terminal is not there", (), expected_text="safety_terminal", kind=SETUP),
    Row(
        "default_settings",
        "a drive comes back with default settings",
        ("LOST_CYCLES",),
        5.0,
        "lost cycles",
        kind=SETUP,
        standing=_FAULT,
    ),
)

_HOST_ROWS: tuple[Row, ...] = (
    Row(
        "disk_full", "the disk is full in the middle of a recording", ("RECORDER",), 5.0, "cannot be written", kind=HOST
    ),
    Row("slow_disk", "the disk takes half a second for every write, all the while", (), kind=HOST),
    Row("clock_step", "the clock of the computer jumps by an hour, forth and back, all the while", (), kind=HOST),
    Row("two_runs_in_a_folder", "a second run into the folder of the first", (), expected_text="in use", kind=HOST),
)

_LOST = ("LOST_CYCLES", "BUS_STOPPED", "BUS_ENDED")
_AGE, _SENSOR = ("TEMPERATURE_AGE", "TEMPERATURE_SENSOR"), ("TEMPERATURE_SENSOR",)
_SLOW_ROWS: tuple[Row, ...] = tuple(
    Row(fault, text, causes, 4.0, kind=SLOW)
    for fault, text, causes in (
        ("modbus_silence", "the transmitter does not answer", _AGE),
        ("modbus_crc", "its answers have a wrong check sum", _AGE),
        ("modbus_wrong_device", "another device answers", _AGE),
        ("modbus_exception", "it answers with an exception", _AGE),
        ("transmitter_open", "PT100 at the transmitter open", _SENSOR),
        ("transmitter_short", "PT100 at the transmitter short", _SENSOR),
        ("serial_silent", "the thermometer on the serial line does not answer", _AGE),
        ("serial_unplugged", "the serial line is unplugged", _AGE),
    )
)

_SERVICE_ROWS: tuple[Row, ...] = (
    Row("service_killed", "the service is killed while its run goes on", (), expected_text="finished", kind=SERVICE),
    Row("two_services", "a second service for the same bench", (), expected_text="runs already", kind=SERVICE),
    Row("two_runs_on_a_bus", "a second program wants the bus", (), expected_text="in use", kind=SERVICE),
)

_WIRE_ROWS: tuple[Row, ...] = (
    Row("writer_killed", "the process of rig and recorder is killed (SIGKILL)", ("BUS_STOPPED",), 4.0, kind=WIRE),
    Row("bus_process_killed", "the process that has the bus is killed", ("BUS_ENDED",), 4.0, "bus process", kind=WIRE),
    Row("cable_pulled_on_the_wire", "cable before the first slave pulled", _LOST, 4.0, kind=WIRE),
    Row("frame_late", "a frame comes back 50 ms late", (), kind=WIRE),
)

ROWS: tuple[Row, ...] = (*_PLANT_ROWS, *_SETUP_ROWS, *_SLOW_ROWS, *_HOST_ROWS, *_SERVICE_ROWS, *_WIRE_ROWS)
