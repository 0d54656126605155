"""What a serial port raises when its adapter is pulled out."""

from __future__ import annotations

import importlib.util

import serial


def _port_errors() -> tuple[type[Exception], ...]:
    errors: tuple[type[Exception], ...] = (serial.SerialException, OSError)
    if importlib.util.find_spec("termios") is None:
        return errors
    import termios

    # No OSError, though it carries an errno: flushing a port that has hung up raises it.
    return (*errors, termios.error)


PORT_ERRORS = _port_errors()
"""Exceptions of a serial port that has failed."""
