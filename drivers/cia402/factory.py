"""Servo drive from a configuration file: entry point ``cia402`` of the group ``bench.drivers``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drivers.cia402.config import ServoDriveConfig
from drivers.cia402.modes import CST, CSV
from drivers.cia402.parameters import DriveLimits, FaultReaction, Parameter, QuickStopOption
from drivers.cia402.servo_drive import ServoDrive
from drivers.devices import Place, build
from drivers.errors import DriverError

_MODES = {"csv": CSV, "cst": CST}


def servo_drive(place: Place, options: Mapping[str, Any]) -> ServoDrive:
    """Make a servo drive.

    ``options`` are the fields of :class:`ServoDriveConfig`, with ``mode`` as ``"csv"`` or ``"cst"``, ``limits`` a
    mapping of the fields of :class:`DriveLimits` (options by name, such as ``quick_stop = "quick_stop_ramp"``) and
    ``parameters`` a list of mappings of the fields of :class:`Parameter`.

    Raises
    ------
    DriverError
        For an option that is unknown, missing or wrong, with what would be right.
    """
    rest: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value for key, value in options.items()}
    where = place.name
    mode = _choose(_MODES, rest.pop("mode", None), f"{where}: mode")
    limits = build(DriveLimits, f"{where}, limits", _limit_options(where, rest.pop("limits", {})))
    parameters = tuple(build(Parameter, f"{where}, parameters", item) for item in rest.pop("parameters", ()))
    config = build(
        ServoDriveConfig,
        where,
        rest,
        name=where,
        position=place.position,
        vendor=place.vendor,
        product=place.product,
        revision=place.revision,
        cycle_time_s=place.cycle_time_s,
        mode=mode,
        limits=limits,
        parameters=parameters,
    )
    return ServoDrive(config)


def _limit_options(where: str, options: Mapping[str, Any]) -> dict[str, Any]:
    rest = dict(options)
    for key, kind in (("quick_stop", QuickStopOption), ("fault_reaction", FaultReaction)):
        if isinstance(rest.get(key), str):
            choices = {option.name.lower(): option for option in kind}
            rest[key] = _choose(choices, rest[key], f"{where}, limits: {key}")
    return rest


def _choose(choices: Mapping[str, Any], value: Any, where: str) -> Any:
    if value in choices.values():
        return value
    if value not in choices:
        raise DriverError(f"{where} is {value!r}; it should be one of {', '.join(choices)}")
    return choices[value]
