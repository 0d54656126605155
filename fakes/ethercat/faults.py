"""Every fault the emulated bench can be given, by name, in one table.

Faults of slaves and bus are here; those of sensors and motors belong to the plant, and are reached by the same call, so
that a test or a command line needs one name only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING

from fakes.ethercat.drive import faultcodes
from fakes.ethercat.slaves.safety_terminal import RELAY_DELAY_S

if TYPE_CHECKING:
    from fakes.ethercat.bench import EmulatedBench


@dataclass(frozen=True, slots=True)
class Fault:
    """One kind of fault; ``value`` says what its parameter means and what it is if not given."""

    name: str
    text: str
    value: str
    default: float


BUS_FAULTS: tuple[Fault, ...] = (
    Fault("drive_fault", "a drive trips", "error code (0x603F)", float(faultcodes.CONTINUOUS_OVER_CURRENT)),
    Fault("sto", "safe torque off is requested of a drive", "none", 0.0),
    Fault("emergency_stop", "the emergency stop is pressed; the relay takes the torque off", "s", RELAY_DELAY_S),
    Fault("safety_wire", "the wire of the emergency stop to its terminal breaks", "none", 0.0),
    Fault("slave_lost", "one slave does not answer; back, it has lost its settings", "none", 0.0),
    Fault("cable_pulled", "no slave from this one on answers; back, they go on", "none", 0.0),
    Fault("wkc_short", "a slave does not take part in process data", "none", 0.0),
    Fault("frame_lost", "frames do not come back", "number of frames", 1.0),
    Fault("frame_late", "frames come back late (wire only)", "s", 0.001),
)
BY_NAME: dict[str, Fault] = {fault.name: fault for fault in BUS_FAULTS}


class UnknownFaultError(ValueError):
    """No fault of that name, or no slave of that role."""


@dataclass(slots=True)
class BusFaults:
    """What is wrong on the bus now; the one who serves the slaves looks at it."""

    lost: set[str] = field(default_factory=set)
    cut: str | None = None
    short: set[str] = field(default_factory=set)
    frames_to_lose: int = 0
    late_s: float = 0.0
    frames_to_delay: int = 0

    def answering(self, bench: EmulatedBench) -> tuple[bool, ...]:
        """Return, slave by slave, whether it can be reached."""
        reachable: list[bool] = []
        cut = False
        for slave in bench.slaves:
            cut = cut or slave.role == self.cut
            reachable.append(not cut and slave.role not in self.lost)
        return tuple(reachable)


@dataclass(frozen=True, slots=True)
class Scheduled:
    """A fault that will come at a bus cycle."""

    cycle: int
    name: str
    role: str | None
    value: float | None
    on: bool


class FaultSwitch:
    """Switches faults of a bench on and off, at once or at a bus cycle."""

    def __init__(self, bench: EmulatedBench) -> None:
        self._bench = bench
        self.bus = BusFaults()
        self.scheduled: list[Scheduled] = []

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all faults: of the bus and of the plant."""
        plant = getattr(self._bench.plant, "faults", None)
        return (*BY_NAME, *(plant.names if plant is not None else ()))

    def apply(
        self, name: str, role: str | None = None, value: float | None = None, *, at_cycle: int | None = None
    ) -> None:
        """Switch a fault on.

        Parameters
        ----------
        name : of :data:`BUS_FAULTS` or of the plant's faults.
        role : the slave it strikes (faults of a drive or a slave).
        value : its parameter, see the table; the default where not given.
        at_cycle : bus cycle at which it comes; at once if None.

        Raises
        ------
        UnknownFaultError
        """
        self._set(name, role, value, at_cycle, on=True)

    def clear(self, name: str, role: str | None = None, *, at_cycle: int | None = None) -> None:
        """Switch a fault off (what it caused may stay, as a drive's fault does)."""
        self._set(name, role, None, at_cycle, on=False)

    def save(self) -> tuple[BusFaults, tuple[Scheduled, ...]]:
        """Return what is wrong now and what is still to come, for :meth:`load`."""
        bus = replace(self.bus, lost=set(self.bus.lost), short=set(self.bus.short))
        return bus, tuple(self.scheduled)

    def load(self, state: tuple[BusFaults, tuple[Scheduled, ...]]) -> None:
        """Go back to a saved state, so that the same faults strike again at the same cycles."""
        bus, scheduled = state
        self.scheduled = list(scheduled)
        for entry in fields(BusFaults):
            value = getattr(bus, entry.name)
            setattr(self.bus, entry.name, set(value) if isinstance(value, set) else value)

    def next_cycle(self) -> int | None:
        """Return the bus cycle at which the next scheduled fault comes."""
        return min((s.cycle for s in self.scheduled), default=None)

    def due(self, cycle: int) -> None:
        """Switch what was scheduled up to this cycle."""
        now = [s for s in self.scheduled if s.cycle <= cycle]
        self.scheduled = [s for s in self.scheduled if s.cycle > cycle]
        for s in sorted(now, key=lambda s: s.cycle):
            self._switch(s.name, s.role, s.value, s.on)

    def _set(self, name: str, role: str | None, value: float | None, at_cycle: int | None, *, on: bool) -> None:
        if name not in self.names:
            raise UnknownFaultError(f"there is no fault {name!r}; there are {', '.join(self.names)}")
        if name in BY_NAME and name not in _WITHOUT_ROLE and role not in self._bench.by_role:
            raise UnknownFaultError(
                f"fault {name!r} needs a slave, one of {', '.join(self._bench.by_role)}, not {role!r}"
            )
        if name in ("drive_fault", "sto") and role not in {d.role for d in self._bench.drives}:
            raise UnknownFaultError(f"fault {name!r} strikes a drive, and {role!r} is none")
        if at_cycle is None:
            self._switch(name, role, value, on)
        else:
            self.scheduled.append(Scheduled(at_cycle, name, role, value, on))

    def _switch(self, name: str, role: str | None, value: float | None, on: bool) -> None:
        fault = BY_NAME.get(name)
        if fault is None:
            plant = self._bench.plant.faults  # type: ignore[attr-defined]  # PlantLike without faults has no such names
            plant.set(name, value) if on else plant.clear(name)
            return
        _SWITCHES[name](self, role or "", fault.default if value is None else value, on)

    def _drive_fault(self, role: str, value: float, on: bool) -> None:
        if on:
            self._bench.drive(role).fail(int(value))

    def _sto(self, role: str, value: float, on: bool) -> None:
        self._bench.drive(role).set_safe_torque_off(on)

    def _emergency_stop(self, role: str, value: float, on: bool) -> None:
        """Show the open circuit at once; the relay's safe torque off follows after ``value`` seconds."""
        self._bench.safety.pressed = on
        drives = [drive.role for drive in self._bench.drives]
        self.scheduled = [s for s in self.scheduled if s.name != "sto"]
        at = self._bench.cycle + (round(value / self._bench.cycle_time_s) if on else 0)
        self.scheduled += [Scheduled(at, "sto", drive, None, on) for drive in drives]
        self.due(self._bench.cycle)

    def _safety_wire(self, role: str, value: float, on: bool) -> None:
        self._bench.safety.broken = on

    def _slave_lost(self, role: str, value: float, on: bool) -> None:
        if on:
            self.bus.lost.add(role)
        elif role in self.bus.lost:
            self.bus.lost.discard(role)
            self._bench.by_role[role].power_cycle()

    def _cable_pulled(self, role: str, value: float, on: bool) -> None:
        self.bus.cut = role if on else None

    def _wkc_short(self, role: str, value: float, on: bool) -> None:
        (self.bus.short.add if on else self.bus.short.discard)(role)

    def _frame_lost(self, role: str, value: float, on: bool) -> None:
        self.bus.frames_to_lose = int(value) if on else 0

    def _frame_late(self, role: str, value: float, on: bool) -> None:
        self.bus.late_s = value if on else 0.0
        self.bus.frames_to_delay = 1 if on else 0


_WITHOUT_ROLE = frozenset({"frame_lost", "frame_late", "emergency_stop", "safety_wire"})

_SWITCHES: dict[str, Callable[[FaultSwitch, str, float, bool], None]] = {
    "drive_fault": FaultSwitch._drive_fault,
    "sto": FaultSwitch._sto,
    "emergency_stop": FaultSwitch._emergency_stop,
    "safety_wire": FaultSwitch._safety_wire,
    "slave_lost": FaultSwitch._slave_lost,
    "cable_pulled": FaultSwitch._cable_pulled,
    "wkc_short": FaultSwitch._wkc_short,
    "frame_lost": FaultSwitch._frame_lost,
    "frame_late": FaultSwitch._frame_late,
}
