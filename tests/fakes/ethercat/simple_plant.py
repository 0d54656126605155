"""A plant of one line: each axis goes where it is told, so that slaves are tested apart from the real plant."""

from __future__ import annotations

import numpy as np

from fakes.ethercat.bench import EmulatedBench, input_drive_data, load_drive_data

MEASUREMENT_DTYPE = np.dtype(
    [
        ("input_position", "i8"),
        ("input_velocity", "f8"),
        ("input_torque", "f8"),
        ("load_position", "i8"),
        ("load_velocity", "f8"),
        ("load_torque", "f8"),
        ("torque_adc", "i4"),
        ("lubricant_temperature", "f8"),
        ("ambient_temperature", "f8"),
    ]
)


class SimplePlant:
    """Velocity follows its set value at once, at most 1000 rad/s² while ramping down; torque likewise."""

    def __init__(self, cycle_time_s: float = 0.0005) -> None:
        self.cycle_time_s = cycle_time_s
        self.speed = 0.0
        self.angle = 0.0
        self.cycles = 0
        self.steps = 0
        self.torque_adc = 1234
        self.lubricant = 40.0

    def step(self, commands):
        n = len(commands)
        self.steps += n
        measured = np.zeros(n, MEASUREMENT_DTYPE)
        for i, row in enumerate(commands):
            if row["input_enable"] and row["input_quick_stop"]:
                self.speed -= np.sign(self.speed) * min(abs(self.speed), 1000.0 * self.cycle_time_s)
            elif row["input_enable"]:
                self.speed = float(row["input_velocity"])
            else:
                self.speed = 0.0
            self.angle += self.speed * self.cycle_time_s
            measured[i]["input_position"] = int(self.angle / (2 * np.pi) * 8192)
            measured[i]["input_velocity"] = self.speed
            measured[i]["load_torque"] = row["load_torque"] if row["load_enable"] else 0.0
            measured[i]["load_position"] = int(self.angle / (2 * np.pi) * (1 << 25) / 185)
            measured[i]["torque_adc"] = self.torque_adc
            measured[i]["lubricant_temperature"] = self.lubricant + 0.01 * self.cycles
            measured[i]["ambient_temperature"] = 21.0
            self.cycles += 1
        return measured

    def snapshot(self):
        return (self.speed, self.angle, self.cycles)

    def restore(self, token):
        self.speed, self.angle, self.cycles = token


def simple_bench(cycle_time_s: float = 0.0005) -> EmulatedBench:
    return EmulatedBench(
        SimplePlant(cycle_time_s),
        input_drive_data(13, 17.5, 52.5),
        load_drive_data(25, 1650.0, 3400.0),
        cycle_time_s,
        without=("safety_terminal",),
    )
