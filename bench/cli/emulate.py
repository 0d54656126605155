"""``bench emulate``: the whole emulated bench on a network interface, in real time."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from importlib.metadata import entry_points
from pathlib import Path
from typing import Annotated, Any

import typer

from bench.cli._plain import say
from bench.errors import ConfigurationError, DeviceError

_HELP = """Put the emulated bench on a network interface as EtherCAT slaves, in real time, until Ctrl-C.

Any EtherCAT master at the other end of the cable (or of a veth pair) finds two servo drives, an analogue and a PT100
terminal. The PT100 can be on Modbus RTU, Modbus TCP and a serial line as well. Needs CAP_NET_RAW.

Faults begin at once, or @ so many seconds after the start:
[bold]name\\[:slave]\\[=value]\\[@seconds][/], such as drive_fault:input_drive=0x2310@5,
cable_pulled:load_drive, pt100_open, modbus_crc. With --control they can be given at any time: lines [bold]fault …[/],
[bold]clear …[/], [bold]status[/], [bold]stop[/] into a Unix socket, one line of JSON back for each.

Example: [bold]bench emulate --interface eth1 --modbus-rtu pty --fault pt100_open@30[/]
"""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="emulate", help=_HELP)(emulate)


def emulate(
    interface: Annotated[str, typer.Option("--interface", help="Network interface the slaves answer on.")],
    plant: Annotated[str, typer.Option(help="Name of a shipped plant, or path of a plant file.")] = "rh380n",
    seed: Annotated[int, typer.Option(min=0, help="Seed of the plant's noise.")] = 0,
    cycle_time_ms: Annotated[float, typer.Option(help="Bus cycle the plant is stepped with, ms.")] = 0.5,
    make_up_ms: Annotated[
        float, typer.Option(help="How long the plant waits for a master that makes up for late cycles, ms.", min=0.0)
    ] = 0.0,
    without: Annotated[
        list[str] | None, typer.Option(help="Leave a terminal out, such as temperature_terminal; may be given again.")
    ] = None,
    modbus_rtu: Annotated[
        str | None,
        typer.Option(
            help="PT100 on Modbus RTU: 'pty', a serial port, or a path that becomes a link to a pseudo-terminal."
        ),
    ] = None,
    modbus_tcp: Annotated[int | None, typer.Option(help="PT100 on Modbus TCP: port on 127.0.0.1, 0 for any.")] = None,
    serial: Annotated[
        str | None, typer.Option(help="PT100 on a serial line: 'pty', or a path that becomes a link.")
    ] = None,
    fault: Annotated[list[str] | None, typer.Option("--fault", help="A fault; may be given again.")] = None,
    control: Annotated[Path | None, typer.Option(help="Unix socket for commands while the emulator runs.")] = None,
    cpu: Annotated[int | None, typer.Option(help="Processor the frame loop is pinned to.")] = None,
    priority: Annotated[
        int | None, typer.Option(help="SCHED_FIFO priority of the frame loop, 1-99.", min=1, max=99)
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Report as JSON: a line at the start, one at the end.")
    ] = False,
) -> None:
    """Emulate (the help text stands in _HELP)."""
    if cycle_time_ms <= 0.0:
        raise ConfigurationError(f"--cycle-time-ms must be greater than 0, not {cycle_time_ms:g}")
    options = {
        "interface": interface,
        "plant": plant,
        "seed": seed,
        "cycle_time_s": cycle_time_ms / 1000.0,
        "make_up_s": make_up_ms / 1000.0,
        "without": tuple(without or ()),
        "modbus_rtu": modbus_rtu,
        "modbus_tcp": modbus_tcp,
        "serial": serial,
        "faults": tuple(fault or ()),
        "control": control,
        "cpu": cpu,
        "priority": priority,
    }
    serve = _emulator()
    try:
        counters = serve(options, lambda places: _report(places, as_json))
    except OSError as error:
        raise DeviceError(str(error)) from error
    except ValueError as error:
        raise ConfigurationError(str(error)) from error
    if as_json:
        say(json.dumps(counters))
    else:
        say(
            f"{counters['frames']} frames answered, {counters['process_frames']} with process data, "
            f"{counters['cycles']} cycles of the plant, {counters['malformed']} frames malformed"
        )


def _emulator() -> Callable[[Mapping[str, Any], Callable[[dict[str, Any]], None]], dict[str, Any]]:
    found = entry_points(group="bench.emulators", name="wire")
    if not found:
        raise ConfigurationError("no emulator is installed: entry point 'wire' of group 'bench.emulators' is missing")
    serve: Callable[[Mapping[str, Any], Callable[[dict[str, Any]], None]], dict[str, Any]] = next(iter(found)).load()
    return serve


def _report(places: dict[str, Any], as_json: bool) -> None:
    """Say that the emulator answers, and where everything is."""
    if as_json:
        say(json.dumps(places))
        return
    say(f"plant {places['plant']} answers on {places['interface']}; Ctrl-C ends it")
    for position, slave in enumerate(places["slaves"], start=1):
        say(f"  {position}  {slave['role']:<21}{slave['product']}  {slave['name']}")
    for key, text in (("modbus_rtu", "Modbus RTU"), ("modbus_tcp", "Modbus TCP port"), ("serial", "serial line")):
        if key in places:
            say(f"  PT100 on {text}: {places[key]}")
