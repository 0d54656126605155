"""``bench benchmark wire``: round trip of cyclic frames between SOEM and the emulator."""

from __future__ import annotations

import json
from contextlib import ExitStack
from dataclasses import replace
from typing import Annotated

import typer

from bench.cli._plain import say
from bench.errors import ConfigurationError


def wire(
    seconds: Annotated[float, typer.Option(min=0.1, help="How long to cycle.")] = 60.0,
    cycle_time_ms: Annotated[float, typer.Option(min=0.05, help="Bus cycle, ms.")] = 0.5,
    interface: Annotated[
        str | None, typer.Option(help="Interface of the master; default: a veth pair is made.")
    ] = None,
    far: Annotated[
        str | None, typer.Option(help="Interface the emulator is started on; default: slaves are there already.")
    ] = None,
    priority: Annotated[
        int | None, typer.Option(min=2, max=98, help="SCHED_FIFO priority of the master; the emulator gets one more.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Measure the round trip of process data: median, 99 %, 99.9 %, maximum; frames lost, slots missed.

    Needs CAP_NET_RAW, to make a veth pair root rights; with --priority CAP_SYS_NICE and CAP_IPC_LOCK.
    """
    from bench.cycle import round_trip

    if far is not None and interface is None:
        raise ConfigurationError("--far needs --interface: the two ends of one cable")
    cycle_time_s = cycle_time_ms / 1000.0
    with ExitStack() as closing:
        near, other = (interface, far) if interface else closing.enter_context(round_trip.veth_pair())
        counters = {}
        with ExitStack() as emulating:
            if other is not None:
                options = () if priority is None else ("--priority", str(priority + 1))
                counters = emulating.enter_context(round_trip.emulator(other, cycle_time_s, *options))
            figures = round_trip.measure(near, seconds, cycle_time_s, priority)
        figures = replace(figures, emulator=counters)
    if as_json:
        say(json.dumps(figures.as_dict()))
        return
    say(
        f"{figures.cycles:,} cycles of {cycle_time_ms:g} ms: round trip median {figures.median_us:.1f} µs, "
        f"99 % {figures.p99_us:.1f} µs, 99.9 % {figures.p999_us:.1f} µs, maximum {figures.maximum_us:.1f} µs\n"
        f"{figures.lost} frames lost, {figures.wrong} with a wrong working counter, {figures.missed} slots missed; "
        f"the host took {figures.steal_s:.2f} s away"
    )
    if counters:
        say(
            f"emulator: {counters['process_frames']:,} frames, longest answer {counters['longest_answer_us']:.0f} µs, "
            f"{counters['added_cycles']} cycles added and {counters['left_out_cycles']} left out to keep to the clock"
        )
