"""Servo drives of the CiA 402 profile (IEC 61800-7-201) over CoE."""

from drivers.cia402.config import ServoDriveConfig
from drivers.cia402.encoder import EncoderExtender
from drivers.cia402.factory import servo_drive
from drivers.cia402.faults import describe, describe_emergency
from drivers.cia402.lead import lead
from drivers.cia402.modes import CST, CSV, Mode
from drivers.cia402.parameters import DriveLimits, FaultReaction, Parameter, QuickStopOption
from drivers.cia402.sequence import Goal, Outcome, Sequence, advance, begin
from drivers.cia402.servo_drive import ServoDrive
from drivers.cia402.states import State, decode, decode_block
from drivers.cia402.units import DriveUnits

__all__ = [
    "CST",
    "CSV",
    "DriveLimits",
    "DriveUnits",
    "EncoderExtender",
    "FaultReaction",
    "Goal",
    "Mode",
    "Outcome",
    "Parameter",
    "QuickStopOption",
    "Sequence",
    "ServoDrive",
    "ServoDriveConfig",
    "State",
    "advance",
    "begin",
    "decode",
    "decode_block",
    "describe",
    "describe_emergency",
    "lead",
    "servo_drive",
]
