"""The small file that says which variable of an FMU is which channel; TOML, unknown keys refused.

.. code-block:: toml

    fmu = "joint.fmu"                 # beside this file

    [inputs]
    w_rel = "motor_velocity"          # variable = channel, where the FMU says the variable's unit
    [inputs.tau_arm]
    channel = "load_torque"
    unit = "N*m"
    scale = -1                        # other sign

    [outputs]
    tau_drive = "motor_torque"

    [parameters]
    d = {}                            # may be recalibrated
    [start]
    J = 0.12                          # value of a parameter, before the run
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from bench.errors import ConfigurationError


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Variable(_Strict):
    """A variable of the FMU: its channel, its unit (else the FMU's own), a factor beside the unit."""

    channel: str
    unit: str | None = None
    scale: float = 1.0


class FreeParameter(_Strict):
    """A parameter that may be recalibrated; ``step`` of the finite difference, in its own unit."""

    step: float | None = Field(default=None, gt=0.0)


class Mapping(_Strict):
    """Which variable is which channel, which parameters are free, and how the FMU is run.

    ``type``: by default co-simulation where the FMU has it; ``rate`` in Hz, by default the recording's own.
    """

    fmu: str
    inputs: dict[str, Variable] = {}
    outputs: dict[str, Variable]
    parameters: dict[str, FreeParameter] = {}
    start: dict[str, float | int | bool] = {}
    type: Literal["co-simulation", "model-exchange"] | None = None
    rate: float | None = Field(default=None, gt=0.0)

    @field_validator("inputs", "outputs", mode="before")
    @classmethod
    def _expand_short_form(cls, value: object) -> object:
        """``variable = "channel"`` is short for a table."""
        if not isinstance(value, dict):
            return value
        return {name: {"channel": entry} if isinstance(entry, str) else entry for name, entry in value.items()}

    @field_validator("outputs")
    @classmethod
    def _not_empty(cls, value: dict[str, Variable]) -> dict[str, Variable]:
        if not value:
            raise ValueError("should name a variable that is a channel; without one nothing is predicted")
        return value


def load_mapping(path: Path) -> Mapping:
    """Read a mapping.

    Raises
    ------
    ConfigurationError
        With the file, the key, what is wrong and what would be right.
    """
    try:
        return Mapping.model_validate(tomllib.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError as error:
        raise ConfigurationError(f"{path}: there is no such file.") from error
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ConfigurationError(f"{path}: not readable as TOML ({error}).") from error
    except ValidationError as error:
        # a key that is misspelt is missing, too: the misspelling is what helps
        first = min(error.errors(), key=lambda problem: problem["type"] != "extra_forbidden")
        key = ".".join(str(part) for part in first["loc"])
        if first["type"] == "extra_forbidden":
            *tables, _ = (str(part) for part in first["loc"])
            table = Variable if set(tables) & {"inputs", "outputs"} else FreeParameter if tables else Mapping
            raise ConfigurationError(
                f"{path}: {key} is no key there; keys are {', '.join(table.model_fields)}."
            ) from error
        raise ConfigurationError(f"{path}: {key or 'the file'}: {first['msg']}.") from error
