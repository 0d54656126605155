"""The bus in a process of its own: nobody else can delay its cycle, and it brings the drives to rest by itself."""

from drivers.ethercat.process.remote import RemoteBus
from drivers.ethercat.process.settings import Condition, Protection, RealTime, StopStep, Watch

__all__ = ["Condition", "Protection", "RealTime", "RemoteBus", "StopStep", "Watch"]
