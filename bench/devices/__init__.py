"""What the bench uses of its devices: the seam to what is found by entry point. Imports nothing of ours.

A driver or master needs the members named here for its role, and no more; its own class is never imported. Blocks have
one row a cycle: arrays of shape (n,) belong to the n cycles exchanged last. What a driver gives only to be handed back
to a driver (a token, an object dictionary, a protection) is ``Any``: nothing of it is used in between.
"""

from bench.devices.bus import BlockBus, Bus, Exchange, ObjectDictionary, ProcessBus, SlaveSpec
from bench.devices.masters import Master, ReplayMaster
from bench.devices.slaves import AnalogInput, Device, Drive, DriveUnits, SafetyInputs
from bench.devices.thermometers import Reader, Reading, Temperatures, Thermometer

__all__ = [
    "AnalogInput",
    "BlockBus",
    "Bus",
    "Device",
    "Drive",
    "DriveUnits",
    "Exchange",
    "Master",
    "ObjectDictionary",
    "ProcessBus",
    "Reader",
    "Reading",
    "ReplayMaster",
    "SafetyInputs",
    "SlaveSpec",
    "Temperatures",
    "Thermometer",
]
