"""The whole bench as a small library: connect, plan, run, look at recordings, identify, find what is left out.

.. code-block:: python

    bench = connect("rh380n")
    recordings = bench.run(campaign("mine", steady(load_torques=(0.0, 400.0), speeds_deg_s=(10.0, -10.0))), "mine")
    for data in recordings:
        print(data.set_load_torque, float(data.transmission_error.std()))
    model = recordings.identify()
    report = recordings.find_mismatch("report", model)

Values are SI (rad, rad/s, N·m) and °C; a name says so where it is otherwise.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from math import radians
from pathlib import Path

import numpy as np
import xarray

from bench.campaigns import Block, Campaign, Order, Plan, Stage, load_campaign, make_plan
from bench.campaigns.execution.session import run_campaign
from bench.campaigns.listener import Listener, Tap
from bench.campaigns.operator.directions import Directions
from bench.campaigns.taken import Summary
from bench.configuration import BenchConfiguration, BenchFile, load_bench, on_interface
from bench.errors import DeviceError
from bench.identification import Identification, Options, identify_folder, to_simulation
from bench.locks import bus_in_use, service_for
from bench.mismatch.report.report import Report
from bench.mismatch.run import run as run_mismatch
from bench.recording import Recording, RecordingFolder
from bench.simulation import Simulation
from bench.trend import Trend
from bench.trend.book import trend

__all__ = [
    "Bench",
    "Block",
    "Campaign",
    "Identification",
    "Order",
    "Plan",
    "Recordings",
    "Report",
    "Simulation",
    "Stage",
    "Trend",
    "campaign",
    "connect",
    "load_campaign",
    "recordings",
    "steady",
    "to_xarray",
    "trend",
]


def connect(name_or_path: str | Path = "rh380n", *, bus: str | None = None) -> Bench:
    """Return a bench by the name of a shipped one or the path of a file; nothing is opened yet.

    ``bus`` is a network interface: hardware, or ``bench emulate`` at the other end of it. Without it the bench is where
    its file says, which for shipped ones is the emulated bench in this very process.

    Raises
    ------
    ConfigurationError
        If the file is wrong: which key, why, and what would be right.
    """
    file = load_bench(name_or_path)
    return Bench(file if bus is None else on_interface(file, bus))


def steady(
    load_torques: tuple[float, ...] = (0.0,),
    speeds_deg_s: tuple[float, ...] = (10.0, -10.0),
    temperatures_degc: tuple[float | None, ...] = (None,),
    repeats: int = 1,
) -> Block:
    """Return points of constant velocity, every combination; load-side speeds in °/s, None: temperature as found."""
    speeds = tuple(radians(speed) for speed in speeds_deg_s)
    return Block("constant_velocity", load_torques, speeds, temperatures_degc, repeats)


def campaign(name: str, *blocks: Block, order: Order = Order.TEMPERATURE) -> Campaign:
    """Return a campaign of one stage; several stages are written with :class:`Campaign` and :class:`Stage`."""
    return Campaign(name, name, (Stage("all", blocks, order),))


@dataclass(frozen=True, slots=True)
class Bench:
    """A bench one can plan for and run on."""

    file: BenchFile

    @property
    def configuration(self) -> BenchConfiguration:
        """Everything its file says, SI."""
        return self.file.configuration

    def plan(self, what: Campaign | str | Path) -> Plan:
        """Return every point with its time, temperature and energy.

        Raises
        ------
        LimitError
            If a point would break a limit of the bench.
        """
        return make_plan(_campaign(what), self.configuration)

    def run(
        self,
        what: Campaign | str | Path,
        folder: str | Path,
        *,
        real_time: bool = False,
        seed: int = 0,
        resumed_by: str | None = None,
        listener: Listener | None = None,
        directions: Directions | None = None,
        tap: Tap | None = None,
    ) -> Recordings:
        """Run a campaign (an object, a shipped name or a path) into a folder; one that was cut short goes on.

        ``listener`` gets the progress, ``directions`` can pause, skip and stop it from another thread, ``tap`` sees
        every row. ``resumed_by`` is who wants torque again after a stop that was acknowledged and reset.

        Raises
        ------
        LimitError
            If a point would break a limit; nothing has moved then.
        DeviceError
            If a device fails, or a service has this bus: ``bench run`` joins its queue.
        """
        folder = Path(folder)
        service = None if self.configuration.bus.in_process else service_for(self.file)
        if service is not None:
            raise DeviceError(f"the service at {service.get('url')} has this bus; bench run joins its queue")
        with bus_in_use(self.file):
            summary = run_campaign(
                self.file,
                _campaign(what),
                folder,
                listener,
                seed=seed,
                real_time=real_time,
                resumed_by=resumed_by,
                directions=directions,
                tap=tap,
            )
        return Recordings(folder, summary)


@dataclass(frozen=True, slots=True)
class Recordings:
    """A folder of recordings; iterating gives one :class:`xarray.Dataset` each, oldest first."""

    folder: Path
    summary: Summary | None = None
    """How the run that made them went; None for a folder that was there."""

    def __iter__(self) -> Iterator[xarray.Dataset]:
        """Yield every usable recording as a dataset (:func:`to_xarray`)."""
        for recording in RecordingFolder.open(self.folder).recordings:
            yield to_xarray(recording)

    def identify(self, *orders: int) -> Simulation:
        """Return the model of the refined method, with the orders of the paper unless others are named."""
        return to_simulation(self.identification(*orders), "refined")

    def identification(self, *orders: int) -> Identification:
        """Return everything that identification finds, both methods and their scores."""
        return identify_folder(self.folder, Options(orders=orders or None))

    def find_mismatch(self, out: str | Path, simulation: Simulation | None = None) -> Report:
        """Write report.html, report.json and model.json into ``out`` and return what the simulation leaves out.

        ``simulation`` None is the nominal one, calibrated on a part of the recordings.
        """
        if simulation is None:
            return run_mismatch(self.folder, Path(out))
        with tempfile.TemporaryDirectory() as scratch:
            path = Path(scratch) / "model.json"
            simulation.save(path)
            return run_mismatch(self.folder, Path(out), path)


def recordings(folder: str | Path) -> Recordings:
    """Return a folder of recordings that is there already."""
    return Recordings(Path(folder))


def to_xarray(recording: Recording) -> xarray.Dataset:
    """Return a recording in SI units over time, with set point and ratio as attributes and the segment of every sample.

    Where both angles and the ratio are there, ``theta`` (input angle θ = motor angle / u) and ``transmission_error``
    (q − θ) are, too, in rad (of a linear axis in m).
    """
    names = [name for name in recording.channels if name != "time"]
    values = recording.read_si(["time", *names])
    segment = np.full(recording.size, "", dtype="U16")
    for part in recording.segments:
        segment[part.start : part.stop] = part.name
    data = {name: ("time", values[name], {"units": recording.specs[name].unit}) for name in names}
    ratio = recording.gearbox.ratio
    if ratio is not None and {"motor_angle", "load_angle"} <= set(names):
        theta, unit = values["motor_angle"] / ratio, "m" if recording.linear else "rad"
        data["theta"] = ("time", theta, {"units": unit})
        data["transmission_error"] = ("time", values["load_angle"] - theta, {"units": unit})
    point = recording.setpoint
    return xarray.Dataset(
        data,
        coords={"time": ("time", values["time"], {"units": "s"}), "segment": ("time", segment)},
        attrs={
            "recording_id": recording.recording_id,
            "kind": recording.kind,
            "started_at": recording.started_at.isoformat(),
            "ratio": ratio,
            "axis": "linear" if recording.linear else "rotary",
            "set_load_torque": point.load_torque,
            "set_velocity": point.velocity,
            "set_temperature": point.temperature,
            "accepted": recording.accepted,
            "complete": recording.complete,
        },
    )


def _campaign(what: Campaign | str | Path) -> Campaign:
    return what if isinstance(what, Campaign) else load_campaign(str(what))
