"""A CiA 402 servo drive over process data in blocks: units, set values, state, faults."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drivers.cia402.config import ServoDriveConfig
from drivers.cia402.encoder import EncoderExtender
from drivers.cia402.faults import describe
from drivers.cia402.modes import SET_VALUE
from drivers.cia402.objects import entries
from drivers.cia402.parameters import Parameter, apply, cycle_parameters, limit_parameters, verify
from drivers.cia402.sequence import COMMANDS, Goal, Outcome, Sequence, advance, begin, holds
from drivers.cia402.states import Command, State
from drivers.cia402.units import DriveUnits, read_units
from drivers.errors import DriveFaultError, DriverError, ParameterMismatchError
from drivers.ethercat.sdo import SdoClient
from drivers.ethercat.slave import Pdo, SlaveSpec

_OFF = Command.DISABLE_VOLTAGE


class ServoDrive:
    """One drive.

    Life: give :attr:`spec` to the bus; the bus configures it (units read; limits written, read back and compared);
    :meth:`attach` its process data; then, block by block, set values, :meth:`prepare`, exchange, :meth:`digest`.

    Parameters
    ----------
    config : what the configuration says of it.

    Attributes
    ----------
    sequence : the way to the goal asked for last; its ``state`` is the drive's as of the last block.
    """

    def __init__(self, config: ServoDriveConfig) -> None:
        self.config = config
        self.name = config.name
        self.sequence = begin(Goal.DISABLED, timeout_cycles=1 << 30)
        self._outputs_map = entries(config.outputs)
        self._inputs_map = entries(config.inputs)
        self._units: DriveUnits | None = None
        self._parameters: tuple[Parameter, ...] = ()
        self._out: dict[str, NDArray[Any]] = {}
        self._in: dict[str, NDArray[Any]] = {}
        self._encoder = EncoderExtender(config.encoder_modulus)

    @property
    def spec(self) -> SlaveSpec:
        """The slave as the bus should find and configure it."""
        config = self.config
        return SlaveSpec(
            config.name,
            config.position,
            config.vendor,
            config.product,
            rx_pdos=(Pdo(config.rx_pdo, self._outputs_map),),
            tx_pdos=(Pdo(config.tx_pdo, self._inputs_map),),
            revision=config.revision,
            watchdog_s=config.watchdog_s,
            sync0_shift_ns=config.sync0_shift_ns,
            configure=self.configure,
        )

    @property
    def units(self) -> DriveUnits:
        """Scales of the drive, in its own direction; known once the bus has configured it."""
        if self._units is None:
            raise DriverError(f"{self.name}: the units are not known yet; the bus should configure the drive first")
        return self._units

    def configure(self, sdo: SdoClient) -> None:
        """Check the mode, read the units, set the limits (PREOP; again whenever the drive comes back from a loss).

        Raises
        ------
        DriverError
            If the drive cannot run the mode, or its units or limits are not those of the configuration.
        """
        config = self.config
        if not sdo.read(0x6502, 0, "u4") & config.mode.support_bit:
            raise DriverError(
                f"{self.name}: the drive does not support {config.mode.text} (6502:00); its firmware should"
            )
        self._units = read_units(sdo, config.velocity_rad_s)
        self._compare("counts per revolution (6092, 6091, 608F)", self._units.counts_per_turn, config.counts_per_turn)
        self._compare("rated torque in N·m (6076)", self._units.rated_torque_nm, config.rated_torque_nm)
        self._parameters = (
            *limit_parameters(config.limits, self._units),
            *cycle_parameters(config.cycle_time_s),
            Parameter(0x607E, 0, "u1", 0, "polarity", optional=True),
            Parameter(0x6060, 0, "i1", config.mode, "mode of operation"),
            *config.parameters,
        )
        apply(sdo, self._parameters)

    def verify(self, sdo: SdoClient) -> tuple[str, ...]:
        """Read limits and mode again; one sentence for each the drive no longer keeps."""
        return verify(sdo, self._parameters)

    def attach(self, outputs: NDArray[Any] | None, inputs: NDArray[Any] | None) -> None:
        """Take the drive's process data: structured arrays (capacity,) as :class:`EtherCatBus` offers them.

        The mode is put into the outputs, so that the first cycles on the way to OP do not take it away.
        """
        self._out = {} if outputs is None else {entry: outputs[entry] for entry in outputs.dtype.names or ()}
        self._in = {} if inputs is None else {entry: inputs[entry] for entry in inputs.dtype.names or ()}
        if "6060:00" in self._out:
            self._out["6060:00"][:] = self.config.mode
        self._encoder.reset()

    def request(self, goal: Goal | str, timeout_s: float = 2.0) -> None:
        """Start towards a goal, or the one of that name; :attr:`sequence` shows how it goes.

        Raises
        ------
        KeyError
            If there is no goal of that name.
        """
        cycles = max(1, math.ceil(timeout_s / self.config.cycle_time_s))
        self.sequence = begin(Goal[goal] if isinstance(goal, str) else goal, cycles, self.sequence.state)

    def reached(self, goal: str | None = None) -> bool:
        """Whether the drive has come to the goal asked for last and is there (and it has the name ``goal``)."""
        return self.sequence.outcome is Outcome.REACHED and goal in (None, self.goal_name)

    @property
    def goal_name(self) -> str:
        """Name of the goal asked for last."""
        return self.sequence.goal.name

    @property
    def state_name(self) -> str:
        """Name of the drive's state as of the last block."""
        return self.sequence.state.name

    def snapshot(self) -> Sequence:
        """Return what :meth:`restore` needs: goal and state, not the extended position."""
        return self.sequence

    def restore(self, token: Sequence) -> None:
        """Return to a snapshot: the way to the goal goes on as it stood then."""
        self.sequence = token

    def set_velocity(self, velocity_rad_s: ArrayLike, n: int) -> None:
        """Set target velocities (scalar or (n,)), rad/s at the motor shaft in the bench's direction, for n cycles."""
        self._write("60FF:00", velocity_rad_s, self.config.polarity * self.units.velocity_rad_s, n)

    def set_torque(self, torque_nm: ArrayLike, n: int) -> None:
        """Set target torques (scalar or (n,)), N·m at the motor shaft in the bench's direction, for n cycles."""
        self._write("6071:00", torque_nm, self.config.torque_sign * self.units.torque_nm, n)

    def prepare(self, n: int) -> None:
        """Write control word and mode into the next n cycles. While not enabled the set value of the mode is zero."""
        self._field(self._out, "6040:00")[:n] = self.sequence.controlword
        if "6060:00" in self._out:
            self._out["6060:00"][:n] = self.config.mode
        if self.sequence.state is not State.OPERATION_ENABLED:
            self._out[SET_VALUE[self.config.mode]][:n] = 0

    def command(self, goal: Goal, row: int) -> None:
        """Write into one row what leads an enabled drive towards a goal, with set values of zero, unseen.

        For whoever must stop the drive without looking at its state machine: the commands of the goals without torque
        do no harm in any state.
        """
        for entry, field in self._out.items():
            field[row] = self.config.mode if entry == "6060:00" else 0
        self._field(self._out, "6040:00")[row] = COMMANDS[goal].get(State.OPERATION_ENABLED, _OFF).controlword

    def digest(self, n: int) -> int:
        """Take the n cycles just exchanged: advance the sequence; number of cycles for which its goal held.

        A drive that has reached its goal is looked at in every cycle of the block: the first in which it is elsewhere
        ends the sequence.
        """
        status = self._field(self._in, "6041:00")[:n]
        held = n
        if self.sequence.outcome is Outcome.REACHED:
            holding = holds(self.sequence.goal, status)
            held = n if holding.all() else int(np.argmin(holding))
        last = min(held, n - 1)
        self.sequence = advance(self.sequence, int(status[last]), self._mode_matches(last), n)
        return held if self.sequence.outcome is not Outcome.RUNNING else 0

    def position(self, n: int) -> NDArray[np.int64]:
        """Positions (n,) of the block just exchanged, counts in the drive's direction, extended; once a block."""
        return self._encoder.extend(self._field(self._in, "6064:00")[:n])

    def position_rad(self, counts: ArrayLike) -> NDArray[np.float64]:
        """Angles, rad at the motor shaft in the bench's direction, of extended counts."""
        return np.asarray(counts, np.float64) * (self.config.polarity * self.units.position_rad)

    def velocity(self, n: int) -> NDArray[np.float64]:
        """Actual velocities (n,), rad/s at the motor shaft in the bench's direction."""
        raw: NDArray[np.float64] = self._field(self._in, "606C:00")[:n].astype(np.float64)
        return raw * (self.config.polarity * self.units.velocity_rad_s)

    def torque(self, n: int) -> NDArray[np.float64]:
        """Actual torques (n,), N·m at the motor shaft in the bench's direction."""
        raw: NDArray[np.float64] = self._field(self._in, "6077:00")[:n].astype(np.float64)
        return raw * (self.config.torque_sign * self.units.torque_nm)

    def fault_text(self, n: int = 1) -> str | None:
        """Sentence on the fault of the last of n cycles, None where there is none."""
        if self.sequence.state not in (State.FAULT, State.FAULT_REACTION_ACTIVE):
            return None
        code = int(self._in["603F:00"][n - 1]) if "603F:00" in self._in else None
        reason = "read 603F:00 for the reason" if code is None else f"error {describe(code)}"
        return f"{self.name} is in {self.sequence.state.text}: {reason}"

    def check(self, n: int = 1) -> None:
        """Raise unless the sequence is on its way or there.

        Raises
        ------
        DriveFaultError
            With the fault, or with the state the drive stayed in or went to.
        """
        sequence = self.sequence
        if sequence.outcome in (Outcome.RUNNING, Outcome.REACHED):
            return
        wanted = sequence.goal.name.lower().replace("_", " ")
        verb = "left" if sequence.outcome is Outcome.LEFT else "did not reach"
        reason = self.fault_text(n) or f"it is in {sequence.state.text}"
        raise DriveFaultError(f"{self.name} {verb} the goal '{wanted}' within {sequence.cycles} cycles: {reason}")

    def _field(self, image: dict[str, NDArray[Any]], entry: str) -> NDArray[Any]:
        """One entry over the whole capacity; the views are made once, which costs less than by name in every cycle."""
        try:
            return image[entry]
        except KeyError:
            reason = f"has no entry {entry} in its process data" if image else "has no process data yet"
            cure = "map it in the configuration" if image else "attach() comes before the first cycle"
            raise DriverError(f"{self.name} {reason}; {cure}") from None

    def _write(self, entry: str, values: ArrayLike, scale: float, n: int) -> None:
        field = self._field(self._out, entry)
        raw = np.rint(np.asarray(values, np.float64) / scale)
        if not np.isfinite(raw).all():
            raise DriverError(f"{self.name}: a set value for {entry} is not a number; finite ones are needed")
        bits = 8 * field.itemsize - 1
        field[:n] = np.minimum(np.maximum(raw, -(1 << bits)), (1 << bits) - 1)

    def _mode_matches(self, row: int) -> bool:
        return "6061:00" not in self._in or int(self._in["6061:00"][row]) == self.config.mode

    def _compare(self, what: str, of_drive: float, configured: float | None) -> None:
        if configured is not None and not math.isclose(of_drive, configured, rel_tol=1e-6):
            raise ParameterMismatchError(
                f"{self.name}: {what} is {of_drive:g} in the drive but {configured:g} in the configuration; "
                "they should agree, or every angle and torque is wrong"
            )
