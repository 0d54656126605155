"""What hangs on the output: shows in load_torque or motor_torque."""
