"""Quantities of a frame that functions depend on, and factors they are multiplied with: by name, as files name them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np

from bench.errors import ConfigurationError
from bench.simulation.composed import composed
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import campaign_lag, limited_integral, taken_along, through, worked_up

ANGLE, ABOUT_ZERO = "angle", "angle_about_zero"
"""names of the output angle: a revolution begins at 0, or opposite to it"""
INPUT_ANGLE = "input_angle"
"""the quantity over which a formula has waves of the transmission error"""
AUXILIARY = "aux/"
"""begins the name of a quantity that is no channel of the bench"""
HELD = "state/"
"""begins the name under which a frame holds a state that was calculated through a campaign: no recorded one has it"""
READ = "read"
"""the factor of a function that a thermometer reads beyond the temperature: its own value is 1"""
SHORTEST_TRAVEL = 1e-5
"""rad at the output: distances since a reversal count by their order of magnitude from here on"""
GENTLE = 0.3
"""rad/s² at the motor, above which accelerations count by their order of magnitude"""
WARMING_S = 400.0
"""over which the temperature is averaged (first-order lag) that the lubricant is compared with: housings of gearboxes
follow their lubricant in two to ten minutes
"""
SLOW_WARMING_S = 1600.0
"""the same for what follows more slowly, in a quarter to three quarters of an hour: shafts, frame and bed of the bench
"""
QUICK_WARMING_S = 100.0
"""the same for what follows faster, in one to three minutes: the wall of a housing, a torque sensor's shaft and flanges
"""
STATE_TIMES_S = (8.0, 20.0, 50.0, 125.0, 320.0, 800.0, 2000.0)
"""time constants of states that follow what is driven, a factor of two and a half apart: a function of one with another
constant is nearly one of the next; below lies what a recording's rows hardly show, above the campaign's own course
"""
WORKED_TIMES_S = (4.0, 16.0, 64.0)
"""time constants with which motion works something up that rest restores more slowly, a factor of four apart: a curve
over such a state makes up for less"""
WORKED = {f"worked_in_{s:g}s": s for s in WORKED_TIMES_S}
"""kinds of such states, with the time constant of motion"""
REST_TIMES_S = (50.0, 125.0, 320.0, 800.0, 2000.0)
"""time constants with which rest restores it: pauses of a campaign last from seconds to half an hour"""
STATE_REACHES = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
"""rad at the output: how far something is taken along before it slips, up to most of a revolution"""
STATE_IMPULSES = (100.0, 250.0, 600.0, 1500.0, 4000.0, 10000.0, 25000.0)
"""N·m·s: time integral of the load torque that moves something from one stop to the other end of its way, by half: a
load of some hundred N·m crosses it in less than a second, or in more than a minute
"""

FILM = "film"
"""kind of the quantities with a preload: they have a scale as states have, and remember nothing"""
FILM_LOADS = (10.0, 40.0, 160.0, 640.0)
"""N·m beside the load torque that a film bears: preload of bearings and teeth, from a hundredth to most of a rated
load
"""
_JUMPS = 0.01
"""of a revolution, by which less of it is run if it begins elsewhere: more than a sample of full revolutions misses"""
_SLOWEST = 1e-4
"""rad/s: below it no film is told from none"""
_WALTHER = (9.2033, 3.5667)
"""A and B of log10(log10(nu/(mm^2/s) + 0.7)) = A - B*log10(T/K) (ASTM D341) for a mineral oil ISO VG 100 of viscosity
index 95: 100 mm²/s at 40 °C and 11.1 at 100 °C
"""


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity of a frame: what it is called, its unit, its values (n,)."""

    label: str
    unit: str
    values: Callable[[Frame], FloatArray]


def _above_lagged(words: str, seconds: float) -> Quantity:
    """The temperature above its own average (first-order lag of so many ``seconds``) over the campaign, which
    ``words`` call: what warms more slowly than the gearbox, or from one side, is behind.
    """
    lagged = partial(campaign_lag, constant=seconds)
    return Quantity(f"temperature above {words}", "K", lambda f: f.temperature - through(_temperature, f, lagged))


def _risen(seconds: float) -> Quantity:
    return _above_lagged(f"its own, lagged by {seconds:g} s", seconds)


def _recent(words: str, unit: str, values: Callable[[Frame], FloatArray], seconds: float) -> Quantity:
    """What was driven, as a state that follows it with a time constant remembers it."""
    lagged = partial(campaign_lag, constant=seconds)
    return Quantity(f"{words}, lagged by {seconds:g} s", unit, lambda f: through(values, f, lagged))


def _taken_along(reach: float) -> Quantity:
    """How far something is wound up that the output takes along until it slips."""
    wound = partial(taken_along, reach=reach)
    return Quantity(f"angle taken along by up to {reach:g} rad", "rad", lambda f: through(_angle, f, wound))


def _impulse(limit: float) -> Quantity:
    """How far something has come that the load torque moves through a viscous film, between two stops."""
    come = partial(limited_integral, limit=limit)
    words = f"impulse of the load torque between stops at {limit:g} N*m*s"
    return Quantity(words, "N*m*s", lambda f: through(_load, f, come))


def _worked(rest: float, motion: float) -> Quantity:
    """How far motion has worked up what rest restores: a film that is squeezed out, grease that thins."""
    state = partial(worked_up, rest=rest, motion=motion)
    words = f"how far motion has worked it up within {motion:g} s, restored by {rest:g} s of rest"
    return Quantity(words, "1", lambda f: through(lambda at: np.abs(at.direction), f, state))


def viscosity(temperature: FloatArray) -> FloatArray:
    """Kinematic viscosity in mm²/s of an oil ISO VG 100 of viscosity index 95, at temperatures (n,) in °C (ASTM
    D341).
    """
    a, b = _WALTHER
    out: FloatArray = 10.0 ** (10.0 ** (a - b * np.log10(temperature + 273.15))) - 0.7
    return out


def _film(load: float) -> Quantity:
    """How thick a lubricant's film is: viscosity times speed over load (Hersey, J. Wash. Acad. Sci. 4 (1914) 542)."""

    def number(f: Frame) -> FloatArray:
        bears = load + np.abs(f.torque_level)
        return np.log10(viscosity(f.temperature) * np.maximum(np.abs(f.velocity), _SLOWEST) / bears)

    return Quantity(
        f"viscosity times speed over load (Hersey number) with {load:g} N*m of preload",
        "log10 mm^2*rad/(s^2*N*m)",
        number,
    )


def _angle(frame: Frame) -> FloatArray:
    return frame.q


def _temperature(frame: Frame) -> FloatArray:
    return frame.temperature


def _load(frame: Frame) -> FloatArray:
    return frame.torque_level


_DRIVEN: dict[str, tuple[str, str, Callable[[Frame], FloatArray]]] = {
    "recent_speed": ("speed", "rad/s", lambda f: np.abs(f.velocity)),
    "recent_load": ("square of the load torque", "kN^2*m^2", lambda f: (f.torque_level / 1000.0) ** 2),
    "recent_load_size": ("size of the load torque", "N*m", lambda f: np.abs(f.torque_level)),
    "recent_torque": ("load torque", "N*m", _load),
    "recent_loss": ("loss", "W", lambda f: f.power),
    "recent_load_motor": ("load motor's torque", "N*m", lambda f: f.load_motor_level),
}


@dataclass(frozen=True, slots=True)
class _Kind:
    """A kind of states: the quantity at a scale, ``scales`` of the candidates, and how names have them: in a ``unit``,
    so many ``per`` SI unit.
    """

    made: Callable[[float], Quantity]
    scales: tuple[float, ...]
    unit: str = "s"
    per: float = 1.0


_KINDS: dict[str, _Kind] = {
    **{kind: _Kind(partial(_recent, *driven), STATE_TIMES_S) for kind, driven in _DRIVEN.items()},
    "risen": _Kind(_risen, STATE_TIMES_S),
    **{kind: _Kind(partial(_worked, motion=s), REST_TIMES_S) for kind, s in WORKED.items()},
    "taken_along": _Kind(_taken_along, STATE_REACHES, "mrad", 1000.0),
    "impulse": _Kind(_impulse, STATE_IMPULSES, "Nms"),
    FILM: _Kind(_film, FILM_LOADS, "Nm"),
}
STATES = frozenset(_KINDS)
"""kinds of states that are not recorded, which a model may have where nothing that is recorded explains the rest"""
_STATE = re.compile(rf"({'|'.join(sorted(_KINDS))})_([1-9]\d*)({'|'.join(sorted({k.unit for k in _KINDS.values()}))})")


def state_named(kind: str, scale: float) -> str:
    """Name of a state of a kind with a ``scale``: a time constant in s, a reach in rad, an impulse in N·m·s or a
    preload in N·m; to a second, a mrad, a N·m·s or a N·m.
    """
    one = _KINDS[kind]
    return f"{kind}_{max(round(one.per * scale), 1)}{one.unit}"


def state_of(name: str) -> tuple[str, float] | None:
    """Kind and scale of a state by its name; None of any other quantity."""
    found = _STATE.fullmatch(name)
    if found is None or found[3] != _KINDS[found[1]].unit:
        return None
    return found[1], float(found[2]) / _KINDS[found[1]].per


def range_of(kind: str) -> tuple[float, float]:
    """Least and largest scale of a kind of states that a model is given."""
    scales = _KINDS[kind].scales
    return scales[0], scales[-1]


_MADE_OF = {FILM: ("speed", "torque", "temperature"), "load_power": ("velocity", "torque")}


def made_of(name: str) -> tuple[str, ...]:
    """The quantities that one is made of, by which it has a place; itself where it is made of no others."""
    return _MADE_OF.get(kind_of(name), (name,))


def kind_of(name: str) -> str:
    """What a quantity is alike with: the kind of a state, the angle wherever it begins, itself otherwise."""
    state = state_of(name)
    if state is None:
        return ANGLE if name == ABOUT_ZERO else name
    return state[0]


def without_a_jump(name: str, frame: Frame) -> str:
    """The name under which a quantity does not jump in a frame: a joint that swings about zero passes from 0 to 2π, and
    a function of that would be one of two ends. Any other quantity has its own name.
    """
    if name != ANGLE:
        return name
    swing, angle = (float(np.ptp(quantity(n, frame))) if frame.size else 0.0 for n in (ABOUT_ZERO, ANGLE))
    return ABOUT_ZERO if swing < angle * (1.0 - _JUMPS) else ANGLE


OF_KIND: dict[str, tuple[str, ...]] = {
    kind: tuple(state_named(kind, scale) for scale in one.scales) for kind, one in _KINDS.items()
}
"""names of the states of each kind that are candidates, one a scale"""
REMEMBERED = frozenset({"quick_warming", "warming", "slow_warming", *(STATES - {FILM})})
"""kinds of quantities with a state that goes on from one recording to the next"""


class _Known(dict[str, Quantity]):
    """Quantities by name; states have names of any scale."""

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or (isinstance(name, str) and state_of(name) is not None)

    def __missing__(self, name: str) -> Quantity:
        state = state_of(name)
        if state is None:
            raise KeyError(name)
        kind, scale = state
        return _KINDS[kind].made(scale)


QUANTITIES: dict[str, Quantity] = _Known(
    {
        "speed": Quantity("speed", "rad/s", lambda f: np.abs(f.velocity)),
        "velocity": Quantity("velocity", "rad/s", lambda f: f.velocity),
        "torque": Quantity("load torque", "N*m", lambda f: f.torque_level),
        "load": Quantity("size of the load torque", "N*m", lambda f: np.abs(f.torque_level)),
        "load_motor_torque": Quantity("load motor's torque", "N*m", lambda f: f.load_motor_level),
        "motor_torque": Quantity("motor torque", "N*m", lambda f: f.motor_torque),
        "load_power": Quantity("power at the output", "W", lambda f: f.torque_level * f.velocity),
        "temperature": Quantity("temperature", "degC", lambda f: f.temperature),
        "quick_warming": _above_lagged("that of the last two minutes", QUICK_WARMING_S),
        "warming": _above_lagged("that of the last minutes", WARMING_S),
        "slow_warming": _above_lagged("that of the last half hour", SLOW_WARMING_S),
        "time": Quantity("time", "s", lambda f: f.time),
        "travel": Quantity("distance run", "rad", lambda f: f.travel),
        ANGLE: Quantity("output angle", "rad", lambda f: np.mod(f.q, 2.0 * np.pi)),
        ABOUT_ZERO: Quantity("output angle", "rad", lambda f: np.mod(f.q + np.pi, 2.0 * np.pi) - np.pi),
        INPUT_ANGLE: Quantity("input angle over the ratio", "rad", lambda f: np.mod(f.theta, 2.0 * np.pi)),
        "since_reversal": Quantity(
            "distance since start or reversal", "log10 rad", lambda f: np.log10(f.reversal_travel + SHORTEST_TRAVEL)
        ),
        "distance_since_start": Quantity("distance since start or reversal", "rad", lambda f: f.reversal_travel),
        "seconds": Quantity("time in the recording", "s", lambda f: f.elapsed),
        "elapsed": Quantity("time in the recording", "log10 s", lambda f: np.log10(f.elapsed + 1.0)),
        "torque_rate": Quantity("change of the load torque", "N*m/s", lambda f: f.torque_rate),
        # in steady motion the acceleration is the encoder's noise
        "speeding_up": Quantity(
            "acceleration in the direction of motion",
            f"arsinh of {GENTLE:g} rad/s^2",
            lambda f: np.where(f.steady > 0.5, 0.0, np.arcsinh(f.acceleration * f.last_direction / GENTLE)),
        ),
    }
)

FACTORS: dict[str, Callable[[Frame], FloatArray]] = {
    "1": lambda f: np.ones(f.size),
    "d": lambda f: f.direction,
    "last_d": lambda f: f.last_direction,
    "w": lambda f: f.omega,
    "p": lambda f: (f.last_direction > 0).astype(np.float64),
    "n": lambda f: (f.last_direction <= 0).astype(np.float64),
    "tau": lambda f: f.torque_level / 1000.0,
    "abs_tau": lambda f: np.abs(f.torque_level) / 1000.0,
    "load_motor": lambda f: f.load_motor_level / 1000.0,
    "v": lambda f: f.velocity / 0.1,
    "abs_v": lambda f: np.abs(f.velocity) / 0.1,
    "slowness": lambda f: 1.0 / (1.0 + np.abs(f.velocity) / 0.1),
    "T": lambda f: (f.temperature - 35.0) / 15.0,
    "reversed": lambda f: f.reversed_before,
    "per_ratio": lambda f: np.full(f.size, 1.0 / f.ratio),
    "motor_torque": lambda f: f.motor_torque,
    "power": lambda f: f.power / 100.0,
    READ: lambda f: np.ones(f.size),
}
"""factors of the order of one; a product is written with ``*``, such as ``d*abs_tau``"""
FACTOR_WORDS: dict[str, str] = {
    "1": "",
    "d": "d",
    "last_d": "d",
    "w": "w_m",
    "p": "[d > 0]",
    "n": "[d < 0]",
    "tau": "tau/(1 kN*m)",
    "abs_tau": "abs(tau)/(1 kN*m)",
    "load_motor": "load_motor_torque/(1 kN*m)",
    "v": "dtheta/(0.1 rad/s)",
    "abs_v": "abs(dtheta)/(0.1 rad/s)",
    "slowness": "1/(1 + abs(dtheta)/(0.1 rad/s))",
    "T": "(T - 35 degC)/(15 K)",
    "reversed": "[after a reversal]",
    "per_ratio": "1/u",
    "motor_torque": "tau_m",
    "power": "loss/(100 W)",
    READ: "",
}

FACTOR_OF: dict[str, str] = {
    "w": "velocity",
    "tau": "torque",
    "abs_tau": "load",
    "load_motor": "load_motor_torque",
    "v": "velocity",
    "abs_v": "speed",
    "slowness": "speed",
    "T": "temperature",
}
"""the quantity that a factor is made of"""


def quantity(name: str, frame: Frame) -> FloatArray:
    """Values (n,) of a quantity; one with a state as the frame holds it, where it does. Raises ConfigurationError where
    there is none of that name.
    """
    if name.startswith(AUXILIARY):
        plain = name.removeprefix(AUXILIARY)
        made = None if plain in frame.aux else composed(plain, frame)
        if made is not None:
            return made
        if plain not in frame.aux:
            raise ConfigurationError(f"the recordings have no quantity '{name}', which the simulation depends on")
        return frame.aux[plain]
    if f"{HELD}{name}" in frame.aux:
        return frame.aux[f"{HELD}{name}"]
    if name not in QUANTITIES:
        raise ConfigurationError(_no_quantity(name))
    return np.asarray(QUANTITIES[name].values(frame))


def _no_quantity(name: str) -> str:
    states = [
        state_named("recent_speed", 50.0),
        state_named("taken_along", 0.02),
        state_named("impulse", 600.0),
        state_named(FILM, 40.0),
    ]
    return (
        f"there is no quantity '{name}', it should be one of {', '.join(QUANTITIES)}, or a state such as"
        f" {', '.join(states)} (a whole number)"
    )


def _no_factor(name: str) -> str:
    return f"there is no factor '{name}', it should be one of {', '.join(FACTORS)}"


def require_known(over: Iterable[str], times: Iterable[str], where: str) -> None:
    """Raise ConfigurationError, which begins with ``where``, if a quantity, or a factor of a product, is not known.
    Which auxiliary quantities there are the recordings say.
    """
    for name in over:
        if not name.startswith(AUXILIARY) and name not in QUANTITIES:
            raise ConfigurationError(f"{where}: {_no_quantity(name)}")
    for part in (part for product in times for part in product.split("*")):
        if part not in FACTORS:
            raise ConfigurationError(f"{where}: {_no_factor(part)}")


def factor(name: str, frame: Frame) -> FloatArray:
    """Values (n,) of a factor, or of a product of several. Raises ConfigurationError where one is not known."""
    out = np.ones(frame.size)
    for part in name.split("*"):
        if part not in FACTORS:
            raise ConfigurationError(_no_factor(part))
        if part != "1":
            out = out * FACTORS[part](frame)
    return out


def in_words(name: str) -> str:
    """A factor as equations have it, empty for 1."""
    return "*".join(word for word in (FACTOR_WORDS[part] for part in name.split("*")) if word)


def label(name: str) -> str:
    """What a quantity is called."""
    return name if name.startswith(AUXILIARY) else QUANTITIES[name].label
