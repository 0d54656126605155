"""The parts of the plant with their true values, SI units, temperatures in °C.

One dataclass a table of the plant file. The laboratory's configuration knows these values only as well as a laboratory
does; here they are what the emulated bench obeys.
"""

from __future__ import annotations

from dataclasses import dataclass

from bench.simulation.formulas import Formula
from bench.simulation.tables import Grid
from bench.simulation.waves import Wave


@dataclass(frozen=True, slots=True)
class Gearbox:
    """Cycloidal drive between input motor and output flange."""

    ratio: float
    z1: int
    z2: int
    z3: int
    z4: int
    stiffness: float
    """torsional stiffness at the output, N·m/rad"""
    damping_ratio: float
    """of the load inertia swinging on gearbox and coupling, 1"""


@dataclass(frozen=True, slots=True)
class Friction:
    """Friction at the input shaft: the nominal equation 2 of the bench."""

    coulomb: float
    """f_c, N·m"""
    viscous: float
    """f_v, N·m·s/rad at the reference temperature"""
    viscous_temperature: float
    """f_vT, N·m·s/(rad·K)"""
    load_dependent: float
    """f_l, 1"""
    reference_temperature: float = 25.0
    minimum_viscous_share: float = 0.1
    """the linear law would turn negative far above the campaign's temperatures: f_v never falls below this share"""


@dataclass(frozen=True, slots=True)
class Heat:
    """One mass with the lubricant's temperature, equation 3."""

    capacity: float
    """C, J/K"""
    resistance: float
    """R to the surroundings, K/W"""
    ambient: float
    """surroundings, °C"""
    initial: float
    """lubricant when the plant starts, °C"""
    ambient_rate: float = 0.0
    """warming of the surroundings, K/s (0: constant)"""
    ambient_curvature: float = 0.0
    """K/s²"""
    ambient_cosine: float = 0.0
    """wave of the surroundings, K"""
    ambient_sine: float = 0.0
    ambient_period: float = 0.0
    """s, 0: no wave"""
    ambient_change: float = 0.0
    """change of the surroundings in the end, K, such as by a heating that is switched on"""
    ambient_begin: float = 0.0
    """time after which they change, s"""
    ambient_settling: float = 0.0
    """time constant of that, s, 0: no change"""
    speed_cooling: float = 0.0
    """further cooling at 100 rad/s of the motor, 1/s"""
    speed_exponent: float = 1.0
    housing_rate: float = 0.0
    """conductance to a second mass over C, 1/s (0: one mass)"""
    housing_time: float = 1000.0
    """time constant of the second mass, s"""


@dataclass(frozen=True, slots=True)
class Motor:
    """A motor with its brake."""

    inertia: float
    """kg·m² with everything that turns with it"""
    maximum_torque: float
    """N·m, limit of the drive"""
    torque_offset: float = 0.0
    """constant torque between what the drive reports and what the shaft feels, N·m (τ_0 at the input motor)"""
    brake_torque: float = 0.0
    """N·m, 0: no brake"""
    brake_delay: float = 0.05
    """from power off to brake closed, s"""


@dataclass(frozen=True, slots=True)
class Drive:
    """A servo drive: its frame, its loops, what it reports."""

    polarity: int
    """+1 where the drive's positive direction is the bench's, −1 where it is opposite"""
    proportional_gain: float
    """velocity loop, N·m·s/rad"""
    integral_time: float
    """velocity loop, s"""
    velocity_filter: float
    """time constant of the velocity estimate, s"""
    torque_filter: float
    """time constant of the torque set value filter, s"""
    current_lag: float
    """time constant of the current loop, s"""
    quick_stop_deceleration: float
    """rad/s²"""
    torque_resolution: float
    """of the reported torque, N·m"""
    torque_noise: float
    """of the reported torque, N·m RMS"""
    torque_gain: float = 1.0
    """true torque over reported torque"""


@dataclass(frozen=True, slots=True)
class Encoder:
    """A rotary encoder; counts are rounded down."""

    bits: int
    """counts per revolution as a power of two"""
    noise: float = 0.0
    """counts RMS before rounding"""
    zero: float = 0.0
    """counts at the angle 0"""


@dataclass(frozen=True, slots=True)
class TorqueSensor:
    """Flange sensor with a ±10 V output and the terminal that digitises it."""

    rated_torque: float
    """N·m at full scale"""
    full_scale_counts: int
    zero: float
    """z_0, N·m"""
    noise: float
    """N·m RMS"""
    gain: float = 1.0


@dataclass(frozen=True, slots=True)
class Pt100:
    """Resistance thermometer."""

    noise: float
    """K RMS"""
    offset: float = 0.0
    """K"""
    lag: float = 0.0
    """time constant behind what it measures, s"""


@dataclass(frozen=True, slots=True)
class LoadSide:
    """Everything behind the torque sensor that is not the load motor itself."""

    coupling_stiffness: float
    """N·m/rad"""
    bearing_friction: float
    """f_b, N·m"""


@dataclass(frozen=True, slots=True)
class Ripple:
    """One order of the load motor's torque ripple, in electrical multiples of the load angle."""

    order: float
    amplitude: float
    """N·m"""
    phase: float
    """rad"""


@dataclass(frozen=True, slots=True)
class Effect:
    """A term of the physics library that is played on top (a plant that runs a simulation file)."""

    effect: str
    channel: str
    form: str
    linear: tuple[float, ...]
    """coefficients of the form's columns"""
    nonlinear: tuple[float, ...] = ()
    grid: Grid | None = None
    """knots of a free function whose values are ``linear``, in place of a form"""
    waves: tuple[Wave, ...] = ()
    """waves over the angle, in place of a form"""
    formula: Formula | None = None
    """a formula whose coefficients are ``linear``, in place of a form"""


@dataclass(frozen=True, slots=True)
class Numerics:
    """How the equations are stepped."""

    drive_ticks: int = 4
    """samples of the drives' own loops in a bus cycle (8 kHz)"""
    substeps: int = 1
    """mechanical steps in each of those"""
    te_interval: int = 20
    """bus cycles between two evaluations of the amplitude and phase polynomials"""
    te_time_constant: float = 0.02
    """of torque and velocity as the transmission error's polynomials see them, s"""
    te_reversal_travel: float = 2.0e-4
    """travel at the output over which the transmission error goes over to the other direction's, rad"""
