"""The emulator as a service: slaves on an interface, transmitters beside them, faults on command.

Entry point ``wire`` of the group ``bench.emulators``; ``bench emulate`` and the tests start it.
"""

from __future__ import annotations

import ctypes
import gc
import json
import os
import signal
import threading
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from fakes import slow_devices
from fakes.ethercat.bench import ROLES, EmulatedBench
from fakes.ethercat.benches import bench_of
from fakes.ethercat.fault_text import FaultRequest, parse_fault
from fakes.ethercat.wire.control import TIMEOUT_S, ControlServer
from fakes.ethercat.wire.port import Port
from fakes.ethercat.wire.responder import Responder
from fakes.plant import Plant, PlantError

_SHAFTS = ("motor_velocity", "load_velocity", "torque")
_LOCK_ALL = 1 | 2
"""mlockall: present and future pages."""


@dataclass(frozen=True, slots=True)
class EmulatorOptions:
    """How to emulate.

    ``without`` names terminals the bus has not, ``faults`` are texts as
    :func:`~fakes.ethercat.fault_text.parse_fault` has them, ``control`` is the path of a Unix socket for orders.
    ``cpu`` pins the frame loop to a processor, ``priority`` (1-99) gives it SCHED_FIFO; both need the right to.
    ``make_up_s`` as of :class:`~fakes.ethercat.wire.responder.Responder`.
    """

    interface: str
    plant: str = "rh380n"
    seed: int = 0
    cycle_time_s: float = 0.0005
    without: tuple[str, ...] = ()
    modbus_rtu: str | None = None
    modbus_tcp: int | None = None
    serial: str | None = None
    faults: tuple[str, ...] = ()
    control: Path | None = None
    cpu: int | None = None
    priority: int | None = None
    make_up_s: float = 0.0


class Service:
    """A running emulator: passes orders to the frame loop and to the transmitters."""

    def __init__(self, responder: Responder, slow: slow_devices.SlowDeviceProcess | None) -> None:
        self._responder = responder
        self._slow = slow

    def order(self, verb: str, argument: str) -> dict[str, Any]:
        """Carry out an order from another thread; raises ValueError where it makes no sense."""
        done = threading.Event()
        result: dict[str, Any] = {}

        def act() -> None:
            try:
                result.update(self._execute(verb, argument))
            except ValueError as error:
                result["error"] = str(error)
            done.set()

        self._responder.commands.append(act)
        if not done.wait(TIMEOUT_S):
            raise ValueError(f"the frame loop did not take {verb!r} within {TIMEOUT_S:g} s")
        if "error" in result:
            raise ValueError(result["error"])
        return result

    def apply(self, request: FaultRequest) -> None:
        """Switch a fault on, now or at its time."""
        if request.name in slow_devices.NAMES:
            if self._slow is None:
                raise ValueError(f"fault {request.name!r} needs a PT100 transmitter, and none is emulated")
            self._slow.switch(request.name, True)
            return
        bench = self._responder.bench
        at = None if request.at_s is None else bench.cycle + round(request.at_s / bench.cycle_time_s)
        self._responder.faults.apply(request.name, request.role, request.value, at_cycle=at)

    def _execute(self, verb: str, argument: str) -> dict[str, Any]:
        orders: dict[str, Callable[[str], dict[str, Any]]] = {
            "fault": self._fault,
            "clear": self._clear,
            "status": lambda _: self._status(),
            "stop": lambda _: self._stop(),
        }
        if verb not in orders:
            raise ValueError(f"order {verb!r} is not known; there are {', '.join(orders)}")
        return orders[verb](argument)

    def _fault(self, argument: str) -> dict[str, Any]:
        self.apply(parse_fault(argument))
        return {"fault": argument}

    def _clear(self, argument: str) -> dict[str, Any]:
        request = parse_fault(argument)
        if request.name in slow_devices.NAMES and self._slow is not None:
            self._slow.switch(request.name, False)
        else:
            self._responder.faults.clear(request.name, request.role)
        return {"clear": argument}

    def _status(self) -> dict[str, Any]:
        bench = self._responder.bench
        states = {slave.role: slave.al.status for slave in bench.slaves}
        drives = {drive.role: drive.state.name for drive in bench.drives}
        truth = bench.plant.state if isinstance(bench.plant, Plant) else {}
        return {
            "shafts": {name: truth[name] for name in _SHAFTS if name in truth},
            "powered": [drive.role for drive in bench.drives if drive.power.powered],
            "counters": asdict(self._responder.counters),
            "al_status": states,
            "drives": drives,
            "cycle": bench.cycle,
        }

    def _stop(self) -> dict[str, Any]:
        self._responder.stop()
        return {"stop": True}


def serve(options: Mapping[str, Any], report: Callable[[dict[str, Any]], None]) -> dict[str, Any]:
    """Emulate until asked to stop (order, SIGTERM or Ctrl-C); return the counters.

    Parameters
    ----------
    options : fields of :class:`EmulatorOptions`.
    report : called once when the emulator answers, with where everything is.

    Raises
    ------
    PortError : the interface cannot be opened.
    ValueError : an option or a fault makes no sense.
    """
    chosen = EmulatorOptions(**options)
    with ExitStack() as closing:
        port = Port(chosen.interface)
        closing.callback(port.close)
        wanted = slow_devices.SlowDeviceOptions(chosen.modbus_rtu, chosen.modbus_tcp, chosen.serial)
        slow = closing.enter_context(slow_devices.slow_devices(wanted)) if wanted.any else None
        bench = _bench(chosen)
        responder = Responder(bench, port, None if slow is None else slow.readings.get_obj(), chosen.make_up_s)
        responder.warm_up()
        service = Service(responder, slow)
        for text in chosen.faults:
            service.apply(parse_fault(text))
        responder.rearrange()
        if chosen.control is not None:
            closing.callback(ControlServer(chosen.control, service.order).close)
        for number in (signal.SIGTERM, signal.SIGINT):
            closing.callback(signal.signal, number, signal.signal(number, lambda *_: responder.stop()))
        _real_time(chosen.cpu, chosen.priority)
        gc.collect()
        gc.freeze()
        gc.disable()
        closing.callback(gc.enable)
        places = {} if slow is None else dict(slow.places)
        slaves = [
            {"role": s.role, "name": s.identity.name, "product": f"0x{s.identity.product:08X}"} for s in bench.slaves
        ]
        report({"interface": chosen.interface, "plant": chosen.plant, "slaves": slaves, **places})
        responder.run()
        return asdict(responder.counters)


def _bench(chosen: EmulatorOptions) -> EmulatedBench:
    unknown = set(chosen.without) - set(ROLES[2:])
    if unknown:
        raise ValueError(f"only {' and '.join(ROLES[2:])} can be left out, not {', '.join(sorted(unknown))}")
    try:
        return bench_of(chosen.plant, chosen.seed, chosen.cycle_time_s, chosen.without)
    except PlantError as error:
        raise ValueError(str(error)) from error


def _real_time(cpu: int | None, priority: int | None) -> None:
    """Pin and raise this thread where asked; threads that were started before keep their place."""
    if cpu is not None:
        os.sched_setaffinity(0, {cpu})
    if priority is not None:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
        ctypes.CDLL(None, use_errno=True).mlockall(_LOCK_ALL)


def main() -> None:
    """Run from options given as one JSON argument: ``python -m fakes.ethercat.wire.service '{"interface": "…"}'``."""
    import sys

    options = json.loads(sys.argv[1])
    if "control" in options:
        options["control"] = Path(options["control"])
    print(json.dumps(serve(options, lambda places: print(json.dumps(places), flush=True))), flush=True)


if __name__ == "__main__":
    main()
