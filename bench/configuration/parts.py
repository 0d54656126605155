"""The parts of a bench, as their data sheets and calibration certificates describe them."""

from __future__ import annotations

import datetime
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from bench.configuration.quantities import Angle, Inertia, Ratio, Speed, Stiffness, Torque, Voltage

Count = Annotated[int, Field(gt=0)]


class Section(BaseModel):
    """A table of the bench file: unknown keys are refused, values do not change once read."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Part(Section):
    """Anything with a name plate."""

    manufacturer: str
    model: str
    serial: str


class Calibration(Section):
    """Where the numbers of a measuring chain come from."""

    date: datetime.date
    certificate: str
    valid_until: datetime.date | None = None

    @model_validator(mode="after")
    def _check_dates(self) -> Calibration:
        if self.valid_until is not None and self.valid_until < self.date:
            raise ValueError("valid_until lies before the calibration's own date")
        return self


class Teeth(Section):
    """Tooth, lobe and pin numbers of a two-stage cycloidal drive (bench-physics.md)."""

    z1: Count
    z2: Count
    z3: Count
    z4: Count


class Gearbox(Part):
    """The transmission under test."""

    ratio: Annotated[float, Field(gt=0)]
    teeth: Teeth | None = None
    rated_torque: Annotated[Torque, Field(gt=0)]
    stiffness: Annotated[Stiffness, Field(gt=0)]

    @model_validator(mode="after")
    def _ratio_of_teeth(self) -> Gearbox:
        if self.teeth is not None:
            expected = 1.0 + self.teeth.z2 / self.teeth.z1 * self.teeth.z4
            if abs(expected - self.ratio) > 1e-6 * expected:
                raise ValueError(f"ratio {self.ratio:g} does not follow from the teeth; 1 + z2/z1·z4 = {expected:g}")
        return self


class Motor(Part):
    """A motor on either side of the gearbox; torques and inertia at its own shaft."""

    nominal_torque: Annotated[Torque, Field(gt=0)]
    maximum_torque: Annotated[Torque, Field(gt=0)]
    maximum_speed: Annotated[Speed, Field(gt=0)]
    pole_pairs: Count
    inertia: Annotated[Inertia, Field(gt=0)]
    brake_torque: Annotated[Torque, Field(gt=0)] | None = None
    """Of the holding brake, closed while the drive has no voltage; absent: no brake."""

    @model_validator(mode="after")
    def _maximum_above_nominal(self) -> Motor:
        if self.maximum_torque < self.nominal_torque:
            raise ValueError("maximum_torque lies below nominal_torque")
        return self


class Encoder(Part):
    """A shaft encoder: its resolution and where its zero is (which way it counts is its drive's polarity)."""

    bits: Annotated[int, Field(ge=8, le=32)]
    zero: Angle


class Coupling(Part):
    """Between gearbox output and load motor."""

    stiffness: Annotated[Stiffness, Field(gt=0)]


class TorqueSensor(Part):
    """Analogue torque sensor behind an input terminal: torque = rated_torque · u / rated_voltage · polarity."""

    rated_torque: Annotated[Torque, Field(gt=0)]
    rated_voltage: Annotated[Voltage, Field(gt=0)]
    polarity: Literal[-1, 1]
    zero: Torque
    nonlinearity: Annotated[Ratio, Field(ge=0)]
    calibration: Calibration


class TemperatureSensor(Part):
    """Resistance thermometer of the lubricant or of the surroundings (IEC 60751)."""

    kind: Literal["pt100", "pt1000"]
    tolerance_class: Literal["AA", "A", "B", "C"]
    calibration: Calibration
