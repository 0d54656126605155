"""Friction of the gearbox and the input motor: shows in motor_torque."""
