"""The exam's tables: groups, strengths, which effects come together, which designs cannot tell two apart."""

from __future__ import annotations

from dataclasses import dataclass, replace

from fakes.concealed.design import Design

GROUPS = ("clear", "faint", "null", "compound", "unknown", "ambiguous", "switched_off", "quick", "null_small")
#: Strength (in units of the noise floor) is drawn evenly from here.
CLEAR, FAINT = (1.0, 1.8), (0.28, 0.42)

_STEADY = Design(transients=(0, 0, 0), flying=True, heating=False)
#: Short runs at two speeds: enough for one plain effect or for none.
QUICK_DESIGN = Design(
    loads=(-1000.0, -500.0, 0.0, 500.0, 1000.0),
    speeds=(5.0, 7.5, 10.0),
    levels=2,
    grid=20,
    validation=4,
    anchors=2,
    transients=(1, 1, 1),
    heat_time=200.0,
)
#: The effects of the quick set, one a case; None for a folder without.
QUICK: tuple[str | None, ...] = ("friction.stribeck", None)
_FAR = (-1000.0, -800.0, -600.0, 600.0, 800.0, 1000.0)
_ONE_WARM_UP = replace(_STEADY, speeds=(7.5,), warm_ups=1, levels=14, heat_time=110.0, sobol_free=False, grid=42)
# Drag that grows with the square would stall the motor at full heating speed: this bench warms up slowly.
_NO_SLOW_SPEED = replace(_STEADY, speeds=(5.0, 7.5, 10.0), grid=38, heat_speed=(40.0, 55.0), heat_time=1500.0)


#: Share of an effect that another has to say before they count as not told apart: what is left of it has a fifth of its
#: size, as much as nature's form of either may differ from the one that an analysis knows.
ALIKE = 0.96


@dataclass(frozen=True, slots=True)
class Confusion:
    """A design that cannot tell ``effect`` from ``also``, checked by the overlap of both after the nominal's refit.

    Attributes:
        form: the form of ``effect`` to conceal.
        shape: numbers of that form to be set.
        strength: from where it is drawn; fainter where a clear one would be no physical drag any more.
        least_overlap: share of the effect that the alternative has to say on the bench that is drawn; another bench and
            other points are drawn until it does; where none of some draws does, the effect is to be named. 0 where the
            design alone decides.
    """

    effect: str
    form: str
    also: tuple[str, ...]
    design: Design
    shape: tuple[tuple[str, float], ...] = ()
    strength: tuple[float, float] = CLEAR
    least_overlap: float = 0.0


CONFUSIONS: tuple[Confusion, ...] = (
    Confusion(
        "te.hysteresis",
        "four Maxwell-slip elements on torque",
        ("te.lost_motion",),
        replace(_STEADY, loads=_FAR, sobol_free=False),
        (("width", 110.0),),
    ),
    Confusion(
        "friction.viscous_temperature",
        "Arrhenius",
        ("friction.run_in",),
        _ONE_WARM_UP,
        least_overlap=ALIKE,
    ),
    Confusion(
        "friction.viscous_quadratic",
        "square of speed",
        ("friction.stribeck",),
        _NO_SLOW_SPEED,
        strength=(0.35, 0.6),
    ),
    Confusion(
        "sensor.torque_gain",
        "gain error",
        ("sensor.torque_nonlinearity",),
        replace(_STEADY, loads=(-600.0, 600.0), sobol_free=False),
    ),
    Confusion(
        "te.stiffness_nonlinear",
        "two-slope",
        ("te.lost_motion",),
        replace(_STEADY, loads=(-900.0, -300.0, 300.0, 900.0), sobol_free=False),
    ),
    Confusion(
        "load.unbalance",
        "arm before the torque sensor",
        ("friction.position_dependent",),
        replace(_STEADY, directions=(1,), grid=40),
    ),
    Confusion(
        "te.lost_motion",
        "linear within, saturated beyond",
        ("te.hysteresis",),
        replace(_STEADY, loads=_FAR, sobol_free=False),
        (("tau_0", 60.0),),
    ),
    Confusion(
        "friction.run_in",
        "power of distance",
        ("friction.viscous_temperature",),
        _ONE_WARM_UP,
        least_overlap=ALIKE,
    ),
    Confusion(
        "friction.stribeck",
        "rational",
        ("friction.viscous_quadratic",),
        _NO_SLOW_SPEED,
        strength=(0.35, 0.6),
    ),
)
COMPOUNDS: tuple[tuple[str, ...], ...] = (
    ("friction.stribeck", "te.harmonic"),
    ("friction.viscous_temperature", "te.lost_motion"),
    ("te.sideband", "motor.torque_ripple"),
    ("friction.position_dependent", "friction.stribeck"),
    ("te.hysteresis", "te.harmonic"),
    ("thermal.second_mass", "friction.viscous_quadratic"),
    ("sensor.torque_gain", "te.local_defect"),
    ("te.drift_time", "te.lost_motion"),
    ("thermal.ambient_drift", "sensor.torque_zero_temperature"),
    ("friction.presliding", "friction.run_in"),
    ("te.resonance", "sensor.motor_encoder"),
    ("load.unbalance", "motor.torque_constant"),
    ("friction.stribeck", "te.harmonic", "thermal.sensor_lag"),
    ("friction.viscous_temperature", "te.stiffness_nonlinear", "sensor.torque_nonlinearity"),
    ("te.local_defect", "te.sideband", "friction.position_dependent"),
    ("thermal.convection_speed", "te.temperature_nonlinear", "friction.stribeck"),
    ("te.velocity_nonlinear", "friction.run_in", "sensor.torque_hysteresis"),
    ("te.harmonic", "te.drift_time", "motor.torque_ripple"),
    ("sensor.timing_skew", "friction.viscous_quadratic"),
    ("te.hysteresis", "friction.presliding"),
)
SWITCHABLE = (
    "friction.coulomb",
    "friction.viscous",
    "friction.viscous_temperature_linear",
    "friction.load_dependent",
    "motor.inertia",
    "thermal.convection",
    "load.bearing_friction",
    "load.inertia",
)

#: Pairs that no design here tells apart well enough to be asked for together.
TOO_CLOSE: tuple[frozenset[str], ...] = (
    frozenset(("te.hysteresis", "te.lost_motion")),
    frozenset(("te.lost_motion", "te.stiffness_nonlinear")),
    frozenset(("te.harmonic", "te.sideband")),
    frozenset(("thermal.second_mass", "thermal.sensor_lag")),
    frozenset(("thermal.second_mass", "thermal.ambient_drift")),
    frozenset(("thermal.second_mass", "thermal.convection_speed")),
    frozenset(("thermal.ambient_drift", "thermal.convection_speed")),
    frozenset(("friction.stribeck", "friction.viscous_quadratic")),
    frozenset(("sensor.torque_gain", "sensor.torque_nonlinearity")),
    frozenset(("sensor.torque_gain", "motor.torque_constant")),
    frozenset(("sensor.torque_nonlinearity", "sensor.torque_hysteresis")),
    frozenset(("load.unbalance", "friction.position_dependent")),
)
