"""What the configuration says of one servo drive."""

from __future__ import annotations

from dataclasses import dataclass

from drivers.cia402.modes import SET_VALUE, Mode
from drivers.cia402.objects import DEFAULT_INPUTS, DEFAULT_OUTPUTS
from drivers.cia402.parameters import DriveLimits, Parameter
from drivers.errors import DriverError


@dataclass(frozen=True, slots=True)
class ServoDriveConfig:
    """One servo drive.

    Parameters
    ----------
    name, position, vendor, product, revision : see :class:`drivers.ethercat.SlaveSpec`.
    mode : cyclic mode the bench uses it in.
    limits : the drive's own limits.
    polarity : +1 or −1: sign of the bench's direction of motion in the drive's own. Set in software; the drive's
        polarity object (0x607E) is kept at 0, so that the sign stands in one place only.
    torque_polarity : the same for torque, where the bench counts it against motion (a load motor); None: as motion.
    outputs, inputs : process data entries in order (:func:`drivers.cia402.objects.entries`).
    rx_pdo, tx_pdo : mapping objects that carry them.
    encoder_modulus : counts after which 0x6064 starts again.
    counts_per_turn, rated_torque_nm : what the configuration knows; compared with the drive's own scaling where given.
    velocity_rad_s : rad/s a velocity count, for drives that do not report it; None reads it from the drive.
    cycle_time_s : period of the bus, s.
    watchdog_s : process data watchdog, s: how long the drive runs on without the master.
    sync0_shift_ns : SYNC0 shift where the drive runs on distributed clocks, ns.
    parameters : further objects to set, read back and compare.
    """

    name: str
    position: int
    vendor: int
    product: int
    mode: Mode
    limits: DriveLimits
    polarity: int = 1
    torque_polarity: int | None = None
    revision: int | None = None
    outputs: tuple[str, ...] = DEFAULT_OUTPUTS
    inputs: tuple[str, ...] = DEFAULT_INPUTS
    rx_pdo: int = 0x1600
    tx_pdo: int = 0x1A00
    encoder_modulus: int = 1 << 32
    counts_per_turn: float | None = None
    rated_torque_nm: float | None = None
    velocity_rad_s: float | None = None
    cycle_time_s: float = 0.0005
    watchdog_s: float | None = None
    sync0_shift_ns: int | None = None
    parameters: tuple[Parameter, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what no drive can be run with, where the sentence can name the drive."""
        for sign in (self.polarity, self.torque_sign):
            if sign not in (1, -1):
                raise DriverError(f"{self.name}: the polarity is {sign}; it should be 1 or -1")
        if self.mode not in SET_VALUE:
            names = " or ".join(mode.text for mode in SET_VALUE)
            raise DriverError(f"{self.name}: the bench cannot run {self.mode.text}; the mode should be {names}")
        needed = {"6040:00", SET_VALUE[self.mode]} - set(self.outputs) | {"6041:00", "6064:00"} - set(self.inputs)
        if needed:
            raise DriverError(
                f"{self.name}: the process data lacks {', '.join(sorted(needed))}, needed for {self.mode.text}"
            )

    @property
    def torque_sign(self) -> int:
        """Polarity of torque."""
        return self.polarity if self.torque_polarity is None else self.torque_polarity
