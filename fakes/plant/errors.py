"""Errors of the emulated plant."""


class PlantError(Exception):
    """A plant file with a wrong key or value, an unknown fault, or a command of the wrong shape (one sentence)."""
