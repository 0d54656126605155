"""What goes into the plant and what comes out, one row a bus cycle.

Positions, velocities and torques of a drive are in that drive's own frame, in which a positive torque accelerates
towards positive positions. Which way a frame points on the bench is a value of the plant (``polarity`` of the drive).
"""

from __future__ import annotations

import numpy as np

MODE_VELOCITY = 9
"""cyclic synchronous velocity, CiA 402-2 object 0x6060"""
MODE_TORQUE = 10
"""cyclic synchronous torque, CiA 402-2 object 0x6060"""

COMMAND_DTYPE = np.dtype(
    [
        ("input_enable", "u1"),  # power stage on
        ("input_mode", "i1"),
        ("input_velocity", "f8"),  # rad/s, motor shaft
        ("input_torque", "f8"),  # N·m, motor shaft
        ("input_quick_stop", "u1"),
        ("load_enable", "u1"),
        ("load_mode", "i1"),
        ("load_velocity", "f8"),  # rad/s
        ("load_torque", "f8"),  # N·m
        ("load_quick_stop", "u1"),
    ]
)

MEASUREMENT_DTYPE = np.dtype(
    [
        ("input_position", "i8"),  # encoder counts, unwrapped
        ("input_velocity", "f8"),  # rad/s, the drive's estimate
        ("input_torque", "f8"),  # N·m, from the drive's current
        ("load_position", "i8"),  # encoder counts, unwrapped
        ("load_velocity", "f8"),  # rad/s, the drive's estimate
        ("load_torque", "f8"),  # N·m, from the drive's current
        ("torque_adc", "i4"),  # counts of the 16-bit analogue terminal, saturated
        ("lubricant_temperature", "f8"),  # °C at the PT100; ±10000 where it is open or short
        ("ambient_temperature", "f8"),  # °C at the second PT100
    ]
)
