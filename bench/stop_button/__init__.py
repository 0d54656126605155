"""A way to stop a run that needs no service, no file and no lock: a listener of the run's own, and who presses it."""

from bench.stop_button.button import Press, StopButton
from bench.stop_button.listener import listening

__all__ = ["Press", "StopButton", "listening"]
