from __future__ import annotations

import importlib.metadata
from typing import Any

import numpy as np
import pytest

from drivers.devices import Place
from drivers.digital_input import digital_input
from drivers.entries import entries_dtype
from drivers.errors import DriverError
from drivers.ethercat import SlaveSpec

PLACE = Place("safety", 5, 0x2, 0x03EC3052)
ON_BUS: dict[str, dict[str, Any]] = {
    "cia402": {"mode": "csv", "limits": {"torque_nm": 10.0, "speed_rad_s": 100.0}},
    "analog_input": {},
    "pt100_terminal": {},
    "digital_input": {"names": ["e_stop"]},
}
"""Drivers on the bus, with the least options they need."""


def entry_points() -> dict[str, importlib.metadata.EntryPoint]:
    return {point.name: point for point in importlib.metadata.entry_points(group="bench.drivers")}


@pytest.mark.parametrize("name", sorted(ON_BUS))
def test_every_driver_is_found_by_entry_point_and_gives_a_slave(name: str) -> None:
    factory = entry_points()[name].load()
    device = factory(PLACE, ON_BUS[name])
    assert isinstance(device.spec, SlaveSpec)
    assert (device.spec.name, device.spec.position, device.spec.product) == ("safety", 5, 0x03EC3052)
    device.attach(
        np.zeros(1, entries_dtype(device.spec.outputs)) if device.spec.outputs else None,
        np.zeros(1, entries_dtype(device.spec.inputs)),
    )


@pytest.mark.parametrize("name", sorted(ON_BUS))
def test_every_driver_refuses_options_it_does_not_know(name: str) -> None:
    with pytest.raises(DriverError, match="safety: option 'colour' is not known; the options are "):
        entry_points()[name].load()(PLACE, ON_BUS[name] | {"colour": "blue"})


def test_digital_input_reads_bits_by_name() -> None:
    terminal = digital_input(PLACE, {"names": ["e_stop", "door"], "active_low": ["e_stop"]})
    inputs = np.zeros(4, entries_dtype(terminal.spec.inputs))
    terminal.attach(None, inputs)
    inputs["6000:01"] = [0b00, 0b01, 0b10, 0b11]
    np.testing.assert_array_equal(terminal.read("e_stop", 4), [True, False, True, False])
    np.testing.assert_array_equal(terminal.read("door", 4), [False, False, True, True])
    with pytest.raises(DriverError, match="no input 'gate'; it has e_stop, door"):
        terminal.read("gate", 1)


def test_digital_input_needs_names_and_process_data() -> None:
    with pytest.raises(DriverError, match="option 'names' is missing"):
        digital_input(PLACE, {})
    with pytest.raises(DriverError, match="attach"):
        digital_input(PLACE, {"names": ["e_stop"]}).read("e_stop", 1)
