"""The matrix of faults: everything that can break on the emulated bench and its host, and what then happens."""

from bench.matrix.outcome import Outcome
from bench.matrix.rows import HOST, PLANT, ROWS, SETUP, SLOW, WIRE, Row

__all__ = ["HOST", "PLANT", "ROWS", "SETUP", "SLOW", "WIRE", "Outcome", "Row"]
