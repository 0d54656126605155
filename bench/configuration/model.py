"""The whole bench file: what a laboratory knows of its bench."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from bench.configuration.bus import Bus
from bench.configuration.operation import (
    Commissioning,
    Heating,
    Limits,
    Motion,
    Nominal,
    Stopping,
    Storage,
    Tuning,
    Unattended,
)
from bench.configuration.parts import Coupling, Encoder, Gearbox, Motor, Section, TemperatureSensor, TorqueSensor


class BenchConfiguration(Section):
    """A bench as its file describes it; all numbers in SI, temperatures in °C."""

    format: Literal["bench-configuration"]
    format_version: Literal["1.0"]
    name: str
    title: str
    zero_id: str | None = None
    """Which referencing of the two encoders is in force; commissioning gives a new one."""
    gearbox: Gearbox
    input_motor: Motor
    load_motor: Motor
    input_encoder: Encoder
    load_encoder: Encoder
    coupling: Coupling
    torque_sensor: TorqueSensor
    lubricant_sensor: TemperatureSensor
    bus: Bus
    limits: Limits
    motion: Motion
    heating: Heating
    stopping: Stopping
    tuning: Tuning
    nominal: Nominal
    storage: Storage
    unattended: Unattended = Unattended()
    commissioning: Commissioning = Commissioning()

    @model_validator(mode="after")
    def _limits_within_parts(self) -> BenchConfiguration:
        limits, gearbox = self.limits, self.gearbox
        table = (
            ("motor_speed", limits.motor_speed, "input_motor.maximum_speed", self.input_motor.maximum_speed, "rad/s"),
            ("motor_torque", limits.motor_torque, "input_motor.maximum_torque", self.input_motor.maximum_torque, "N*m"),
            ("load_torque", limits.load_torque, "gearbox.rated_torque", gearbox.rated_torque, "N*m"),
            ("load_torque", limits.load_torque, "torque_sensor.rated_torque", self.torque_sensor.rated_torque, "N*m"),
            (
                "load_motor_torque",
                limits.load_motor_torque,
                "load_motor.maximum_torque",
                self.load_motor.maximum_torque,
                "N*m",
            ),
        )
        for key, value, bound_key, bound, unit in table:
            if value > bound:
                raise ValueError(f"limits.{key} = {value:g} {unit} lies above {bound_key} = {bound:g} {unit}")
        if self.heating.motor_speed > limits.motor_speed:
            raise ValueError(
                f"heating.motor_speed = {self.heating.motor_speed:g} rad/s lies above limits.motor_speed ="
                f" {limits.motor_speed:g} rad/s"
            )
        if self.limits.motor_speed / gearbox.ratio > self.load_motor.maximum_speed:
            raise ValueError(
                f"limits.motor_speed / gearbox.ratio = {self.limits.motor_speed / gearbox.ratio:g} rad/s lies above"
                f" load_motor.maximum_speed = {self.load_motor.maximum_speed:g} rad/s"
            )
        return self
