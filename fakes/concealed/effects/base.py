"""What a concealed effect may do to a bench."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fakes.concealed.design import Point
from fakes.concealed.truth import Location, Parameter

Floats = NDArray[np.float64]

#: Where an effect may add something: the transmission error (rad); the motor encoder's reading (rad of the shaft);
#: friction in the input shaft's balance (N·m: it heats and is measured); the reported motor torque; what the gearbox
#: output carries unseen by the torque sensor; what gearbox and sensor see but the load motor does not report; the
#: torque sensor's reading.
HOOKS = (
    "transmission",
    "motor_encoder",
    "friction",
    "motor_reading",
    "output_torque",
    "load_side",
    "sensor_reading",
)


@dataclass(slots=True)
class Run:
    """The true state (N,) of one recording while it is made, SI units.

    Attributes:
        clock: s since the campaign's first recording began.
        travel: rad run at the load side since then, in either direction.
        torque: true torque at the gearbox output; ``motor_torque`` true torque at the input shaft.
        temperature: true lubricant temperature in °C.
        power: heat by losses in W. duration: s of the whole campaign, as planned.
        side: 1 for the last direction positive, 0 negative.
    """

    point: Point
    index: int
    rate_hz: float
    time: Floats
    clock: Floats
    theta: Floats
    rate: Floats
    acceleration: Floats
    sign: Floats
    side: NDArray[np.int64]
    travel: Floats
    command: Floats
    torque: Floats
    temperature: Floats
    motor_torque: Floats
    duration: float

    @property
    def motor_rate(self) -> Floats:
        """Speed of the input motor in rad/s."""
        return self.rate * 185.0


@dataclass(slots=True)
class ThermalWorld:
    """What an effect may change of the heat balance at coarse steps (M,)."""

    conductance: Floats
    ambient: Floats
    extra_power: Floats
    house_capacity: float = 0.0
    house_link: float = 0.0
    capacity_bump: tuple[float, float, float] = (0.0, 0.0, 1.0)


@dataclass(slots=True)
class Effect:
    """Base of all concealed effects: does nothing. ``amplitude`` is set by the strength calibration.

    Attributes:
        effect: vocabulary id or ``unknown``.
        form: the mathematical form, for people.
        channels: where it shows, strongest first.
        amplitude: the one number that scales it, in the unit of its first parameter.
        shape: the other numbers, by name.
        claimed: where it acts, as far as that can be said beforehand.
    """

    effect: str
    form: str
    channels: tuple[str, ...]
    amplitude: float
    shape: dict[str, float] = field(default_factory=dict)
    claimed: Location = field(default_factory=Location)

    def reset(self) -> None:
        """Forget any history: a new campaign begins."""

    def add(self, hook: str, run: Run) -> Floats | None:
        """Addition (N,) to one of :data:`HOOKS`, None where the effect has none there."""
        return None

    def modulation(self, theta: Floats, rate: Floats, orders: Floats) -> tuple[Floats, Floats] | None:
        """Relative gain and phase lag, each (K, N), of the series' ``orders`` (K,).

        ``theta`` and ``rate`` (N,) are the input angle and its rate at the load side, rad and rad/s.
        """
        return None

    def heat(self, world: ThermalWorld, run: Run, clock: Floats, coarse: slice) -> None:
        """Change the heat balance at times ``clock`` (M,); ``coarse`` picks the run's samples there."""

    def rest(self, world: ThermalWorld, clock: Floats) -> None:
        """Change the heat balance while the bench stands unrecorded, at times ``clock`` (M,)."""

    def probe_lags(self) -> tuple[float, ...]:
        """Time constants in s with which the PT100 follows the lubricant, one lag behind the other."""
        return ()

    def sensor_delay(self) -> float:
        """Delay in s of the torque sensor's channel."""
        return 0.0

    def parameters(self) -> tuple[Parameter, ...]:
        """True parameters where the form is the vocabulary's own; none otherwise."""
        return ()

    def location(self) -> Location:
        """Where the effect acts."""
        return self.claimed
