"""EtherCAT master: a bus of slaves with their process data, on pysoem's API."""

from drivers.entries import Entry, entries_dtype, entry_name
from drivers.ethercat.bus import EtherCatBus
from drivers.ethercat.emergency import EmergencyMessage
from drivers.ethercat.exchange import Exchange
from drivers.ethercat.pacing import AbsoluteDeadlines, FreeRunning, Pacing
from drivers.ethercat.recovery import Condition, Recovery
from drivers.ethercat.sdo import SdoClient
from drivers.ethercat.slave import Pdo, SlaveSpec
from drivers.ethercat.soem import soem_master

__all__ = [
    "AbsoluteDeadlines",
    "Condition",
    "EmergencyMessage",
    "Entry",
    "EtherCatBus",
    "Exchange",
    "FreeRunning",
    "Pacing",
    "Pdo",
    "Recovery",
    "SdoClient",
    "SlaveSpec",
    "entries_dtype",
    "entry_name",
    "soem_master",
]
