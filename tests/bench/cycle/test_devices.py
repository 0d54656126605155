"""Whatever is registered offers what the bench uses of it, and the bench uses all that it asks for."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import pysoem
import pytest

import bench
from bench import devices
from bench.configuration import load_bench
from bench.configuration.bus import SlowSensor
from bench.cycle.ahead import AheadLink
from bench.cycle.assembly import assemble
from bench.cycle.link import Link
from bench.cycle.plugins import DRIVERS, plugin
from bench.errors import DeviceError

BENCH = load_bench("rh380n").configuration


def members(protocol: type) -> dict[str, Any]:
    """Members of a protocol, its bases' as well; None for a plain attribute."""
    found: dict[str, Any] = {}
    for base in protocol.__mro__:
        if base.__module__.startswith("bench.devices"):
            named = {**dict.fromkeys(inspect.get_annotations(base)), **vars(base)}
            found |= {name: value for name, value in named.items() if not name.startswith("_")}
    return found


def lacking(device: Any, protocol: type) -> list[str]:
    """Members a device does not offer as the protocol wants them; properties are not evaluated."""
    return [name for name, wanted in members(protocol).items() if not offers(device, name, wanted)]


def offers(device: Any, name: str, wanted: Any) -> bool:
    try:
        offered = inspect.getattr_static(device, name)
    except AttributeError:
        return False
    if not inspect.isfunction(wanted):
        return not inspect.isroutine(offered)
    return inspect.isroutine(offered) and accepts(getattr(device, name), wanted)


def accepts(offered: Callable[..., Any], wanted: Callable[..., Any]) -> bool:
    """Whether every call the protocol allows is a call of what is offered, by place and by name."""
    parameters = [p for p in inspect.signature(wanted).parameters.values() if p.name != "self"]
    signature = inspect.signature(offered)
    try:
        signature.bind(*parameters)
        signature.bind(**{p.name: p for p in parameters})
    except TypeError:
        return False
    return True


def slow_bench() -> Any:
    """The bench with its thermometer on a serial line that nobody opens."""
    kept = [slave for slave in BENCH.bus.slaves if slave.role != "temperature_terminal"]
    slaves = tuple(slave.model_copy(update={"position": i}) for i, slave in enumerate(kept, 1))
    options = {"role": "temperature", "driver": "pt100_modbus_rtu", "period": "0.5 s", "options": {"port": "/dev/null"}}
    bus = BENCH.bus.model_copy(update={"slaves": slaves, "slow_sensors": (SlowSensor.model_validate(options),)})
    return BENCH.model_copy(update={"bus": bus})


def made() -> dict[str, tuple[Any, type]]:
    """A device of each kind that is registered, by name, with what is used of it."""
    parts = assemble(BENCH, seed=0, real_time=False)
    apart = assemble(BENCH, seed=0, real_time=True, own_process=True)
    slow = assemble(slow_bench(), seed=0, real_time=False).thermometer
    return {
        "emulated": (parts.master, devices.Master),
        "emulated, replayed": (parts.master, devices.ReplayMaster),
        "ethercat": (parts.block_bus, devices.BlockBus),
        "ethercat_process": (apart.process_bus, devices.ProcessBus),
        "cia402, input": (parts.input_drive, devices.Drive),
        "cia402, load": (parts.load_drive, devices.Drive),
        "analog_input": (parts.torque_terminal, devices.AnalogInput),
        "digital_input": (parts.safety, devices.SafetyInputs),
        "pt100_terminal": (parts.thermometer, devices.Thermometer),
        "slow thermometer": (slow, devices.Thermometer),
        "background_reader": (slow._readers[0], devices.Reader),  # type: ignore[attr-defined]
        "a reading": (slow._readers[0].latest(), devices.Reading),  # type: ignore[attr-defined]
        "a spec": (parts.bus.specs[0], devices.SlaveSpec),
    }


@pytest.fixture(scope="module")
def registered() -> dict[str, tuple[Any, type]]:
    return made()


NAMES = (
    "emulated",
    "emulated, replayed",
    "ethercat",
    "ethercat_process",
    "cia402, input",
    "cia402, load",
    "analog_input",
    "digital_input",
    "pt100_terminal",
    "slow thermometer",
    "background_reader",
    "a reading",
    "a spec",
)


def test_every_kind_is_looked_at(registered: dict[str, tuple[Any, type]]) -> None:
    assert set(registered) == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_registered_offers_what_is_used(name: str, registered: dict[str, tuple[Any, type]]) -> None:
    device, protocol = registered[name]
    assert device is not None
    assert members(protocol)
    assert lacking(device, protocol) == []


def test_the_real_master_offers_what_is_used() -> None:
    """Its methods are compiled and say no signature: only their being there can be looked at."""
    found = {name: inspect.isfunction(wanted) for name, wanted in members(devices.Master).items()}
    assert [name for name in found if not hasattr(pysoem.Master, name)] == []
    assert all(callable(getattr(pysoem.Master, name)) for name, is_method in found.items() if is_method)


@pytest.mark.parametrize("name", NAMES)
def test_a_member_that_is_taken_away_is_missed(name: str, registered: dict[str, tuple[Any, type]]) -> None:
    device, protocol = registered[name]
    whole = {member: inspect.getattr_static(device, member) for member in members(protocol)}
    for gone in whole:
        part = type("Part", (), {member: value for member, value in whole.items() if member != gone})()
        assert lacking(part, protocol) == [gone]


def test_a_method_of_other_parameters_is_no_such_method(registered: dict[str, tuple[Any, type]]) -> None:
    drive, protocol = registered["cia402, input"]
    whole = {member: inspect.getattr_static(drive, member) for member in members(protocol)}
    fewer = type("Fewer", (), {**whole, "set_torque": lambda self, torque_nm: None})()
    renamed = type("Renamed", (), {**whole, "set_torque": lambda self, torque, n: None})()
    more = type("More", (), {**whole, "set_torque": lambda self, torque_nm, n, more: None})()
    for changed in (fewer, renamed, more):
        assert lacking(changed, protocol) == ["set_torque"]


def test_temperatures_of_both_thermometers(registered: dict[str, tuple[Any, type]]) -> None:
    """What is recorded of a reading has the type the thermometer says."""
    thermometer, _ = registered["slow thermometer"]
    block = thermometer.read(3, 1)
    assert lacking(block, devices.Temperatures) == []
    assert block.raw.dtype == thermometer.dtype
    terminal, _ = registered["pt100_terminal"]
    inputs = assemble(BENCH, seed=0, real_time=False).bus.inputs["temperature_terminal"]
    terminal.attach(None, inputs)
    block = terminal.read(3, 1)
    assert lacking(block, devices.Temperatures) == []
    assert block.raw.dtype == terminal.dtype


BESIDE = ("pt100_modbus_tcp", "pt100_modbus_rtu", "pt100_serial")
NO_DEVICES = {
    "error",
    "real_time",
    "cia402_protection",
    "absolute_deadlines",
    "torque_scale",
    "torque_tare",
    "torque_plausibility",
    "torque_plausibility_limits",
}


def test_no_registered_device_is_forgotten() -> None:
    looked_at = {name.partition(",")[0] for name in (*NAMES, *BESIDE)}
    assert {entry.name for entry in entry_points(group=DRIVERS)} - NO_DEVICES <= looked_at


@pytest.mark.parametrize("driver", BESIDE)
def test_thermometers_beside_the_bus_are_what_the_reader_asks(driver: str) -> None:
    kind = inspect.signature(plugin(DRIVERS, driver)).return_annotation
    module = inspect.getmodule(plugin(DRIVERS, driver))
    asked = getattr(module, kind)
    assert callable(asked.measure)
    assert callable(asked.close)


def test_the_bench_uses_all_that_it_asks_for() -> None:
    root = Path(bench.__file__).parent
    used = "\n".join(
        path.read_text("utf-8")
        for folder in ("cycle", "commissioning", "matrix")
        for path in sorted((root / folder).rglob("*.py"))
    )
    protocols = [getattr(devices, name) for name in devices.__all__]
    wanted = {(protocol.__name__, name) for protocol in protocols for name in members(protocol)}
    assert {(where, name) for where, name in wanted if not re.search(rf"\.{name}\b", used)} == set()


def test_a_link_and_a_bus_that_do_not_fit_are_refused() -> None:
    parts = assemble(BENCH, seed=0, real_time=False)
    apart = assemble(BENCH, seed=0, real_time=True, own_process=True)
    with pytest.raises(DeviceError, match="with a process of its own; this one has none"):
        AheadLink(BENCH, parts)
    with pytest.raises(DeviceError, match="should be handed over ahead"):
        Link(BENCH, apart, paced=False)._exchange(1)
    with pytest.raises(DeviceError, match="without a bus"):
        _ = replace(parts, block_bus=None).bus


def test_a_master_that_cannot_go_back_is_not_asked_to() -> None:
    master: Any = pysoem.Master()
    parts = replace(assemble(BENCH, seed=0, real_time=False), master=master)
    with pytest.raises(DeviceError, match="cannot be put back"):
        Link(BENCH, parts, paced=False).remember()
