"""The input motor and its drive: shows in motor_torque."""
