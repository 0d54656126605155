"""The simulation that recordings are compared with, as the analysis needs it: what is in force in each channel.

A simulation file's rows become regressors with their coefficients, waves, pulses and laws; what it does not say is as
in the nominal simulation.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from bench.errors import ConfigurationError
from bench.foreign.base import Base
from bench.mismatch.orders.misread import ENCODER
from bench.mismatch.orders.periodic import Pulse
from bench.mismatch.regression.regressors import UNKNOWN, Free, Named, Regressor
from bench.mismatch.unnamed.formula_regressor import Equation, from_row
from bench.simulation import tables, waves
from bench.simulation.frame import FloatArray
from bench.simulation.heat_rates import HEATING, LESS, TAKEN_OFF, with_rates
from bench.simulation.laws import Law
from bench.simulation.laws import from_json as law_from_json
from bench.simulation.model import Simulation, Term
from bench.simulation.orders import nominal_orders, orders_in_doubt
from bench.simulation.quantities import INPUT_ANGLE
from bench.simulation.terms import LIBRARY, LOAD_TORQUE, TRANSMISSION_ERROR
from bench.simulation.waves import Wave

Row = Mapping[str, Any]
REACTION = ("motor.load_reaction", "k_te")
"""term and symbol of how much of the load's reaction through the transmission error the motor torque holds"""
SENSOR = "sensor.torque"
"""begins the ids of errors of the torque sensor: what it reads beyond the torque is taken off before others use it"""
REPORTED_BY, LOAD_MOTOR = "reported_by", "load_motor"
"""key of a row that is an error between torque sensor and load motor, and what it says where the load motor's report is
off: the torque that was read is then right
"""
ACTS_ON, SHAFT = "acts_on", "shaft"
"""key of a row of the load torque without a name, and what it says where it turns the shaft: it is a load, and no error
of the sensor
"""
LOAD_INERTIA, ACCELERATED, SHAFTS = "load.inertia", "accelerated_with", "shafts"
"""term of the load's inertia, a key of it, and what that says where the load torque follows the acceleration of both
shafts together and not the waves of the transmission error (:mod:`bench.mismatch.recordings.followed_waves`)
"""
MOTOR_INERTIA, SMOOTHED = "motor.inertia", "rates_smoothed_s"
"""term of the motor's inertia, and a key of it: over how many seconds the rates are smoothed with which it was found,
where the motion follows no set speeds (:mod:`bench.mismatch.better_window`)
"""
LOAD_SIDE = "load."
"""begins the ids of what turns the shaft at the torque sensor"""


@dataclass(frozen=True, slots=True)
class Known:
    """A regressor in force in a channel; its coefficients (k,), None where the file does not say them; whether an error
    in the load torque is one of the load motor's report and not of the sensor; whether something without a name there
    acts on the shaft.
    """

    regressor: Regressor
    coefficients: FloatArray | None
    of_load_motor: bool = False
    on_shaft: bool = False

    @property
    def misread(self) -> bool:
        """Whether it is an error of what the torque sensor reads."""
        return self.regressor.effect.startswith(SENSOR) and not self.of_load_motor

    @property
    def whose(self) -> dict[str, str]:
        """Keys of its row that say whose error it is, or that it is a load."""
        return ({REPORTED_BY: LOAD_MOTOR} if self.of_load_motor else {}) | ({ACTS_ON: SHAFT} if self.on_shaft else {})

    @property
    def turns(self) -> bool:
        """Whether it is known to turn the shaft at the torque sensor."""
        return self.regressor.effect.startswith(LOAD_SIDE) or self.on_shaft


@dataclass(frozen=True, slots=True)
class Given:
    """What a simulation has in force.

    ``known[channel]``: regressors beyond the nominal terms; ``orders``: of the series, by which its polynomials are
    calibrated; ``waves[channel]``: over the output angle, in the transmission error over the input angle in load-side
    scaling; ``ripples``: of the motor torque, over that angle as well.
    """

    simulation: Simulation
    switched_off: tuple[str, ...]
    orders: tuple[float, ...]
    known: Mapping[str, tuple[Known, ...]] = field(default_factory=dict)
    waves: Mapping[str, tuple[Wave, ...]] = field(default_factory=dict)
    pulses: tuple[Pulse, ...] = ()
    laws: tuple[Law, ...] = ()
    ripples: tuple[Wave, ...] = ()
    unsettled: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """by channel, effects in force of which the file says no numbers: they are calibrated on the recordings"""
    reaction: float = 0.0
    """share of tau/u*dTE/dtheta that the motor torque holds (:mod:`bench.mismatch.orders.reaction`)"""
    misread: tuple[float, ...] = ()
    """orders of the transmission error's series that an encoder reads and the gearbox does not make"""
    misread_waves: tuple[Wave, ...] = ()
    """waves of the transmission error that it reads so; of a series's order they are the encoder's part"""
    base: Base | None = None
    """a simulation from elsewhere on which the terms stand; its channels are taken off when recordings are read"""

    def over_input_angle(self) -> tuple[Known, ...]:
        """Formulas of the transmission error over the input angle: orders that follow something."""
        known = self.known.get(TRANSMISSION_ERROR, ())
        return tuple(k for k in known if isinstance(k.regressor, Equation) and INPUT_ANGLE in k.regressor.formula.over)

    @property
    def acting_waves(self) -> tuple[Wave, ...]:
        """Waves of the transmission error that the gearbox makes."""
        return tuple(w for w in self.waves.get(TRANSMISSION_ERROR, ()) if w not in self.misread_waves)

    @classmethod
    def of(cls, model: Simulation, base: Base | None = None) -> Given:
        """Read a simulation. Raises ConfigurationError where a term's form or numbers are not the library's."""
        model = with_rates(model)
        _check_what_is_taken_off(model)
        off = tuple(effect for effect, term in LIBRARY.items() if term.nominal and not model.enabled(effect))
        orders = _series_orders(model, "te.fourier" in off)
        known: dict[str, list[Known]] = {}
        wave_rows: dict[str, list[Wave]] = {}
        pulses: list[Pulse] = []
        laws: list[Law] = []
        ripples: list[Wave] = []
        unsettled: dict[str, list[str]] = {}

        def add(channel: str, one: Known, row: Row) -> None:
            effect = one.regressor.effect
            of_load_motor = _says(effect, row, REPORTED_BY, LOAD_MOTOR)
            on_shaft = _says(effect, row, ACTS_ON, SHAFT)
            if on_shaft and (effect, channel) != (UNKNOWN, LOAD_TORQUE):
                raise ConfigurationError(
                    f"the simulation's term {effect} has '{ACTS_ON}' in a row of {channel}; only a function without a"
                    f" name ({UNKNOWN}) of {LOAD_TORQUE} may have it"
                )
            known.setdefault(channel, []).append(replace(one, of_load_motor=of_load_motor, on_shaft=on_shaft))

        for effect, term in model.terms.items():
            if not term.enabled or (effect in LIBRARY and LIBRARY[effect].nominal and "also" not in term.extra):
                continue
            for row in term.rows():
                if "law" in row:
                    laws.append(law_from_json(effect, row["law"]))
                elif row.get("form") == "ripple" or (effect == "motor.torque_ripple" and "waves" not in row):
                    ripples += _ripple(effect, row, model.gearbox.ratio)
                elif "waves" in row:
                    where = f"the simulation's term {effect}"
                    for channel in row.get("channels", [TRANSMISSION_ERROR]):
                        wave_rows.setdefault(channel, []).extend(waves.from_json(row["waves"], where))
                elif effect == "te.local_defect":
                    p = numbers(effect, row, ("theta_p", "w_p", "p"))
                    pulses.append(Pulse(p[0], p[1], p[2]))
                elif row.get("form") == "table":
                    grid, values = tables.from_json(row, f"the simulation's term {effect}")
                    for channel in row.get("channels", []):
                        add(channel, Known(Free(channel, (grid,), effect), values), row)
                elif row.get("form") == "formula":
                    for channel in row.get("channels", []):
                        equation = from_row(row, channel, effect, f"the simulation's term {effect}")
                        add(channel, Known(*equation), row)
                elif "orders" in row or effect in ("te.harmonic", "te.sideband"):
                    orders |= set(_orders_of_row(row))
                elif effect == "te.resonance":
                    raise ConfigurationError("the simulation's term te.resonance has neither orders nor a law")
                elif effect in LIBRARY and not LIBRARY[effect].nominal and not row["parameters"] and "form" not in row:
                    for channel in _channels(effect, row):
                        unsettled.setdefault(channel, []).append(effect)
                elif effect in LIBRARY and not LIBRARY[effect].nominal:
                    for channel, one in _linear(effect, row):
                        add(channel, one, row)
        return cls(
            model,
            off,
            tuple(sorted(orders)),
            {channel: tuple(members) for channel, members in known.items()},
            {channel: tuple(members) for channel, members in wave_rows.items()},
            tuple(pulses),
            tuple(laws),
            tuple(ripples),
            {channel: tuple(members) for channel, members in unsettled.items()},
            model.value(*REACTION) or 0.0,
            *_misread(model),
            base,
        )

    def nominal_coefficients(self, named: Named) -> FloatArray | None:
        """Coefficients (k,) of a nominal term as the file has them; None where it does not say them all."""
        return _coefficients(named, self.simulation.terms.get(named.effect))


def says_waves(model: Simulation) -> bool:
    """Whether a simulation's load torque follows the waves of the transmission error. Raises ConfigurationError where
    the key that says so has another value.
    """
    term = model.terms.get(LOAD_INERTIA)
    return term is None or not _says(LOAD_INERTIA, term.extra, ACCELERATED, SHAFTS)


def with_shafts(model: Simulation) -> Simulation:
    """A simulation whose load torque follows the acceleration of both shafts together."""
    term = model.terms.get(LOAD_INERTIA, Term(LOAD_INERTIA))
    return model.with_term(replace(term, extra={**term.extra, ACCELERATED: SHAFTS}))


def says_span(model: Simulation) -> float | None:
    """Over how many seconds the rates are smoothed with which a simulation's inertia was found; None where it does not
    say. Raises ConfigurationError where it says something else.
    """
    term = model.terms.get(MOTOR_INERTIA)
    said = None if term is None else term.extra.get(SMOOTHED)
    if said is None:
        return None
    if isinstance(said, bool) or not isinstance(said, int | float) or not 0.0 < said < np.inf:
        raise ConfigurationError(
            f"the simulation's term {MOTOR_INERTIA} has '{SMOOTHED}': {said!r},"
            " it should be a positive number of seconds"
        )
    return float(said)


def with_span(model: Simulation, span: float) -> Simulation:
    """A simulation that says over how many seconds the rates are smoothed."""
    term = model.terms.get(MOTOR_INERTIA, Term(MOTOR_INERTIA))
    return model.with_term(replace(term, extra={**term.extra, SMOOTHED: span}))


def _misread(model: Simulation) -> tuple[tuple[float, ...], tuple[waves.Wave, ...]]:
    """Orders of the series, and waves, of the rows of the motor encoder's error."""
    term = model.terms.get(ENCODER)
    if term is None or not term.enabled:
        return (), ()
    rows = list(term.rows())
    where = f"the simulation's term {ENCODER}"
    found = [wave for row in rows for wave in waves.from_json(row.get("waves", ()), where)]
    return tuple(float(f) for row in rows for f in row.get("orders", ())), tuple(found)


def _coefficients(named: Named, term: Term | None) -> FloatArray | None:
    if term is None or any(s.symbol not in term.parameters for s in named.form.linear):
        return None
    return np.array([term.parameters[s.symbol].value for s in named.form.linear])


def numbers(effect: str, row: Row, symbols: tuple[str, ...]) -> list[float]:
    """Values of the parameters ``symbols``. Raises ConfigurationError where one is missing."""
    missing = [s for s in symbols if s not in row["parameters"]]
    if missing:
        raise ConfigurationError(
            f"the simulation's term {effect} has no {', '.join(missing)}; it should have {', '.join(symbols)}"
        )
    return [float(row["parameters"][s]) for s in symbols]


def _series_orders(model: Simulation, off: bool) -> set[float]:
    if off:
        return set()
    series = model.terms.get("te.fourier")
    if series is not None and series.orders is not None:
        return {float(f) for f in series.orders}
    if series is not None and series.coefficients is not None:
        sets = (series.coefficients.positive, series.coefficients.negative)
        return {float(f) for s in sets if s is not None for f in s.orders}
    # what is nominal by either reading is not told as missing
    return {*nominal_orders(model.gearbox), *orders_in_doubt(model.gearbox)}


def _orders_of_row(row: Row) -> list[float]:
    if "orders" in row:
        return [float(f) for f in row["orders"]]
    p = row["parameters"]
    if {"f", "m"} <= set(p):
        return [p["f"] - p["m"], p["f"] + p["m"]]
    return [float(p["f"])] if "f" in p else []


def _ripple(effect: str, row: Row, ratio: float) -> list[Wave]:
    """Waves over the motor's angle: of one vector, or of several in proportion to what it changes with."""
    if "waves" in row:
        return list(waves.from_json(row["waves"], f"the simulation's term {effect}"))
    n, cosine, sine = numbers(effect, row, ("n", "a_rc", "a_rs"))
    at = float(row["parameters"].get("tau_r", 0.0))
    order = n * ratio
    if at:  # its amplitude grows with the motor's torque; ``a_rc`` and ``a_rs`` are those at ``tau_r``
        return [Wave(order, "motor_torque", cosine / at, sine / at)]
    return [Wave(order, "1", cosine, sine)]


def _channels(effect: str, row: Row) -> list[str]:
    """Channels in which a row is in force: those it names, else all of its effect, but of an error of the torque sensor
    the sensor's own: the others are predicted from the torque less that error.
    """
    forms = LIBRARY[effect].forms
    return list(row.get("channels", [LOAD_TORQUE] if effect.startswith(SENSOR) and LOAD_TORQUE in forms else forms))


def _check_what_is_taken_off(model: Simulation) -> None:
    """Raise ConfigurationError where the term of the loss names something that cannot be taken off it."""
    term = model.terms.get(HEATING)
    named = [] if term is None else term.extra.get(LESS, [])
    wrong = [name for name in named if name not in TAKEN_OFF] if isinstance(named, list | tuple) else [named]
    if wrong:
        raise ConfigurationError(
            f"the simulation's term {HEATING} has {', '.join(map(repr, wrong))} in '{LESS}', it should be a list of"
            f" some of {', '.join(map(repr, TAKEN_OFF))}"
        )


def _says(effect: str, row: Row, key: str, only: str) -> bool:
    """Whether a row of a term has a ``key``, :data:`REPORTED_BY` or :data:`ACTS_ON`, whose one value is ``only``."""
    said = row.get(key)
    if said not in (None, only):
        raise ConfigurationError(
            f"the simulation's term {effect} has '{key}': {said!r} in a row, it should be '{only}'"
        )
    return said is not None


def _linear(effect: str, row: Row) -> Iterator[tuple[str, Known]]:
    """A term that is a regressor: form by name or by its parameters' symbols, in the channels named, else in all."""
    term = LIBRARY[effect]
    parameters = row["parameters"]
    for channel in _channels(effect, row):
        forms = term.forms.get(channel, ())
        chosen = [f for f in forms if f.name == row["form"]] if "form" in row else list(forms)
        if not chosen:
            raise ConfigurationError(
                f"the simulation's term {effect} has the form {row.get('form')!r} in {channel}, it should be one of "
                f"{', '.join(f.name for f in forms) or 'those of a channel it shows in'}"
            )
        if "point" in row and "form" in row:
            point = tuple(float(v) for v in row["point"])
            form = chosen[0]
            if len(point) != len(form.nonlinear):
                raise ConfigurationError(
                    f"the simulation's term {effect} has {len(point)} numbers in 'point', it should have one for each "
                    f"of {', '.join(s.symbol for s in form.nonlinear) or 'nothing'}"
                )
        else:
            full = [f for f in chosen if all(s.symbol in parameters for s in f.nonlinear)]
            whole = [f for f in full if all(s.symbol in parameters for s in f.linear)]
            # a form that needs fewer of the parameters would pass over the others
            alike = sorted(whole, key=lambda f: -len(f.linear) - len(f.nonlinear)) or full
            if not alike:
                raise ConfigurationError(
                    f"the simulation's term {effect} lacks parameters in {channel}; it should have "
                    f"{', '.join(s.symbol for s in (*chosen[0].linear, *chosen[0].nonlinear))}"
                )
            form = alike[0]
            point = tuple(float(parameters[s.symbol]) for s in form.nonlinear)
        coefficients = None
        if all(s.symbol in parameters for s in form.linear):
            coefficients = np.array([float(parameters[s.symbol]) for s in form.linear])
        yield channel, Known(Named(term, channel, form, point), coefficients)
