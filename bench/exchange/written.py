"""A simulation file as formulas: each channel that it predicts, of the quantities that a sample has.

The quantities are those of :mod:`bench.exchange.sample`. Coefficients stay parameters by name; what stands inside a
function is a number.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bench.errors import ConfigurationError
from bench.exchange import formula, fourier, pieces
from bench.exchange.formula import Written, columns_of, lift, make, total
from bench.exchange.sample import INPUTS, STANDSTILL, formula_frame, loss
from bench.mismatch.given import REACTION, Given, Known
from bench.mismatch.orders.shaken import INERTIA
from bench.mismatch.power_zeros import CONSTANT, LOAD, MOTOR, REPORTED, REST, SINGLE, STORED, reported_by
from bench.mismatch.prediction import Predictor
from bench.mismatch.regression.problem import CHANNELS, nominal_base
from bench.mismatch.regression.regressors import Free, Named
from bench.mismatch.unnamed.formula_regressor import Equation
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.linear import in_metres, is_of_linear_axis
from bench.simulation.model import Simulation
from bench.simulation.quantities import FACTORS
from bench.simulation.reading import is_read
from bench.simulation.terms import CHANNEL_UNITS, LIBRARY, LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR

OUTPUT = "simulated_"
"""begins the name of a predicted channel, which may be an input as well"""
START = "temperature_start"
STATES = (
    "relaxing",
    "play",
    "lag",
    "integral",
    "limited_integral",
    "campaign_lag",
    "worked_up",
    "held",
    "distance",
    "begun",
    "reversals",
)


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of an exported simulation: its name there, value, unit and meaning."""

    name: str
    value: float
    unit: str
    meaning: str


@dataclass(frozen=True, slots=True)
class Formulas:
    """A simulation as formulas: outputs by name, inputs and parameters they need; why channels are left out; ``notes``:
    which terms are not in them; whether they are of a ``linear`` axis.
    """

    outputs: dict[str, Written]
    inputs: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    refused: tuple[str, ...]
    notes: tuple[str, ...] = ()
    linear: bool = False

    def words(self, text: str) -> str:
        """A text or unit as the simulation's axis has it: of a linear one in newtons and metres."""
        return in_metres(text) if self.linear else text

    def input(self, name: str) -> tuple[str, str]:
        """Unit and meaning of an input."""
        unit, meaning = INPUTS.get(name, ("", "quantity of the recordings"))
        return self.words(unit), self.words(meaning)

    def unit_of(self, channel: str) -> str:
        """SI unit of an output."""
        return self.words(CHANNEL_UNITS[channel])

    @property
    def steps(self) -> list[Written]:
        """All formulas in the order of evaluation."""
        return formula.in_evaluation_order(list(self.outputs.values()))


def formulas_of(simulation: Simulation, standstill: float = 1e-3) -> Formulas:
    """Write a simulation as formulas.

    ``standstill``: motor speed in rad/s below which it stands, a parameter as well. Raises ConfigurationError where
    nothing can be written, or the simulation stands on one from elsewhere.
    """
    if "base" in simulation.extra:
        raise ConfigurationError(
            "the simulation stands on one from elsewhere ('base'), which cannot be exported; export that one."
        )
    writer = _Writer(Given.of(simulation), standstill)
    outputs: dict[str, Written] = {}
    refused, notes = [], []
    for channel in CHANNELS:
        missing = writer.missing(channel)
        if missing and not writer.calibrated(channel):
            refused.append(f"{channel} is left out: the simulation has no numbers for {', '.join(missing)}")
            continue
        outputs[OUTPUT + channel] = writer.channel(channel)
        if missing:
            notes.append(
                f"{channel} is without {', '.join(missing)}: the recordings it was calibrated on did not show "
                f"{'it' if len(missing) == 1 else 'them'}, and the simulation has no numbers for "
                f"{'it' if len(missing) == 1 else 'them'}"
            )
    if set(SINGLE) & set(writer.predictor.takes_zeros) and OUTPUT + TEMPERATURE in outputs:
        notes.append(
            f"{TEMPERATURE} is without the zeros of single recordings that the analysis took off the loss: they belong "
            "to those recordings, and a new one has others"
        )
    if any(law.swings for law in writer.given.laws) and OUTPUT + TRANSMISSION_ERROR in outputs:
        notes.append(
            f"{TRANSMISSION_ERROR} has a resonance as its steady response: what the mode swings by freely after a "
            "change of speed is not written"
        )
    if not outputs:
        raise ConfigurationError(f"nothing can be exported: {'; '.join(refused)}.")
    steps = formula.in_evaluation_order(list(outputs.values()))
    used = {n.extra[0] for n in steps if n.op == "input"}
    inputs = [*(n for n in INPUTS if n in used), *sorted(n for n in used if n not in (*INPUTS, "time"))]
    named = {n.extra[0] for n in steps if n.op == "parameter"}
    linear = is_of_linear_axis(simulation)
    parameters = [p for p in writer.parameters.values() if p.name in named]
    if linear:
        parameters = [replace(p, unit=in_metres(p.unit), meaning=in_metres(p.meaning)) for p in parameters]
    return Formulas(outputs, tuple(inputs), tuple(parameters), tuple(refused), tuple(notes), linear)


def identifier(name: str) -> str:
    """Convert a name to an identifier that programming languages accept."""
    out = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_")
    return out if out[:1].isalpha() else f"p_{out}"


class _Writer:
    """Writes channel by channel; collects parameters."""

    def __init__(self, given: Given, standstill: float) -> None:
        self.given = given
        self.parameters: dict[str, Parameter] = {}
        self._parameter(STANDSTILL, standstill, "rad/s", "motor speed below which it stands")
        self.frame = formula_frame(given.simulation.gearbox.ratio)
        self.predictor = Predictor(given)

    def _parameter(self, name: str, value: float, unit: str, meaning: str) -> Written:
        key = identifier(name)
        while key in self.parameters and self.parameters[key].meaning != meaning:
            key += "_"
        self.parameters.setdefault(key, Parameter(key, float(value), unit, meaning))
        return formula.reference("parameter", key)

    def calibrated(self, channel: str) -> bool:
        """Whether some nominal term of a channel is calibrated; a term that is not was then not in the recordings."""
        given = self.given
        if channel == TRANSMISSION_ERROR:
            return given.simulation.transmission_error() is not None
        regressors = (term.regressor for term in nominal_base(channel, given.switched_off))
        return any(isinstance(named, Named) and given.nominal_coefficients(named) is not None for named in regressors)

    def missing(self, channel: str) -> list[str]:
        """Nominal terms that are in force and not calibrated."""
        given, out = self.given, []
        series = given.simulation.transmission_error()
        for term in nominal_base(channel, given.switched_off):
            named = term.regressor
            assert isinstance(named, Named)
            lacking = series is None if named.effect == "te.offset" else given.nominal_coefficients(named) is None
            if lacking:
                out.append(named.effect)
        if channel == TRANSMISSION_ERROR and given.orders and series is None:
            out.append("te.fourier")
        if channel == TEMPERATURE and REST in self.predictor.takes_zeros:
            out += self.missing(MOTOR_TORQUE)
        return out + list(given.unsettled.get(channel, ()))

    def channel(self, channel: str) -> Written:
        """The formula of a channel, as :class:`bench.mismatch.prediction.Predictor` evaluates it."""
        given, frame = self.given, self.frame
        if channel != LOAD_TORQUE:
            frame = self._corrected(frame)
        if channel == TEMPERATURE:
            frame = self._less(frame)
        parts: list[Any] = []
        fixed = CHANNELS[channel].fixed
        if fixed and fixed not in given.switched_off:
            parts.append(columns_of(LIBRARY[fixed].forms[channel][0].columns(frame, ()))[0])
        for term in nominal_base(channel, given.switched_off):
            named = term.regressor
            assert isinstance(named, Named)
            coefficients = None if named.effect == "te.offset" else given.nominal_coefficients(named)
            if coefficients is not None:
                parts.append(self._regressor(Known(named, coefficients), frame))
        parts += [self._regressor(k, frame) for k in given.known.get(channel, ()) if k.coefficients is not None]
        angle = frame.theta if channel == TRANSMISSION_ERROR else frame.q
        parts += [pieces.wave(wave, angle, frame) for wave in given.waves.get(channel, ())]
        if channel == MOTOR_TORQUE:
            parts += [pieces.wave(wave, frame.theta, frame) for wave in given.ripples]
            parts += self._reaction(frame)
        if channel == TRANSMISSION_ERROR:
            parts += fourier.series(given, frame)
            parts += [pieces.pulse(p.angle, p.width, p.height, frame) for p in given.pulses]
        if channel == TEMPERATURE:
            parts.append(self._parameter(START, 25.0, "degC", "temperature at the beginning"))
        return total(parts)

    def _regressor(self, known: Known, frame: Frame) -> Written:
        regressor = known.regressor
        assert known.coefficients is not None
        if isinstance(regressor, Named):
            columns = columns_of(regressor.columns(frame))
            where = f"{regressor.term.name} in {regressor.channel}"
            factors = [
                self._parameter(f"{regressor.effect}.{s.symbol}", float(c), s.unit, f"{where}: {s.meaning}")
                for s, c in zip(regressor.form.linear, known.coefficients, strict=True)
            ]
            return total([make("mul", f, c) for f, c in zip(factors, columns, strict=True)])
        if isinstance(regressor, Equation):
            return self._equation(regressor, known.coefficients, frame)
        if not isinstance(regressor, Free):
            raise ConfigurationError(f"{regressor.words} cannot be exported: it is no term, table or formula.")
        parts, at = [], 0
        for grid in regressor.grids:
            values = known.coefficients[at : at + grid.size]
            at += grid.size
            times = lift(1.0)
            for name in grid.times.split("*"):
                times = make("mul", times, lift(FACTORS[name](frame)))
            value = lift(values[0])
            if grid.over:
                value = formula.table(grid, values, [pieces.quantity(name, frame) for name in grid.over])
            part = make("mul", times, value)
            parts.append(_of_temperature(part, grid.times) if regressor.channel == TEMPERATURE else part)
        return total(parts)

    def _equation(self, equation: Equation, coefficients: FloatArray, frame: Frame) -> Written:
        """A formula that no name fits; its coefficients and constants are parameters."""
        where = f"{equation.words}, {equation.equation}"
        inside = tuple(
            (c.symbol, self._parameter(f"{equation.effect}.{c.symbol}", c.value, c.unit, where))
            for c in equation.constants
        )
        formula_of = replace(equation.formula, constants=inside)  # type: ignore[arg-type]
        values = formula_of.parts_at([pieces.quantity(name, frame) for name in equation.formula.over])
        parts = []
        terms = zip(
            equation.formula.coefficients, coefficients, equation.units, equation.formula.parts, values, strict=True
        )
        for symbol, coefficient, unit, (times, _), value in terms:
            part = make(
                "mul", self._parameter(f"{equation.effect}.{symbol}", float(coefficient), unit, where), lift(value)
            )
            for name in times.split("*"):
                part = make("mul", lift(FACTORS[name](frame)), part)
            parts.append(_of_temperature(part, times) if equation.channel == TEMPERATURE else part)
        return total(parts)

    def _corrected(self, frame: Frame) -> Frame:
        """The frame with the load torque less the errors of its sensor."""
        errors = [k for k in self.given.known.get(LOAD_TORQUE, ()) if k.misread]
        errors = [k for k in errors if k.coefficients is not None]
        if not errors:
            return frame
        torque: Any = make("sub", frame.torque, total([self._regressor(k, frame) for k in errors]))
        return replace(frame, torque=torque, torque_level=torque, power=loss(frame, torque))

    def _less(self, frame: Frame) -> Frame:
        """The frame with the loss less what the simulation takes off it, but for the zeros of single recordings."""
        which = [name for name in self.predictor.takes_zeros if name not in SINGLE]
        known = self.given.known.get(MOTOR_TORQUE, ())
        motor = [k for name in which if name in REPORTED for k in reported_by(known, name)]
        # the power that speeds the motor up is that of the torque of its inertia
        constants = {MOTOR: CONSTANT[MOTOR_TORQUE], STORED: INERTIA}
        motor += [k for name in which if name in constants for k in self._nominal(MOTOR_TORQUE, constants[name])]
        load = self._nominal(LOAD_TORQUE, CONSTANT[LOAD_TORQUE]) if LOAD in which else []
        if not motor and not load and REST not in which:
            return frame
        into, out = (total([self._regressor(k, frame) for k in members]) for members in (motor, load))
        if REST in which:
            moving: Any = np.abs(frame.direction)
            into = make("add", into, moving * make("sub", frame.motor_torque, self.channel(MOTOR_TORQUE)))
        return replace(frame, power=loss(frame, frame.torque, into * frame.omega - out * frame.velocity))

    def _nominal(self, channel: str, effect: str) -> list[Known]:
        """A nominal term of a channel with its coefficients; empty where it is not in force, or has none."""
        given = self.given
        named = (t.regressor for t in nominal_base(channel, given.switched_off) if t.regressor.effect == effect)
        known = [(n, given.nominal_coefficients(n)) for n in named if isinstance(n, Named)]
        return [Known(n, coefficients) for n, coefficients in known if coefficients is not None]

    def _reaction(self, frame: Frame) -> list[Written]:
        """The load's reaction through the transmission error."""
        given = self.given
        if not given.reaction:
            return []
        slope = total(
            [
                *fourier.slope(given, frame),
                *(pieces.wave(wave.slope, frame.theta, frame) for wave in given.acting_waves),
                *(pieces.pulse_slope(p.angle, p.width, p.height, frame) for p in given.pulses),
            ]
        )
        name = "share of tau/u*dTE/dtheta in the motor torque"
        share = self._parameter(".".join(REACTION), given.reaction, "1", name)
        return [make("mul", make("mul", share, lift(frame.torque / frame.ratio)), slope)]


def _of_temperature(part: Written, times: str) -> Written:
    """A function in the temperature: a rate added up, or what is read beyond it since the beginning."""
    if not is_read(times):
        return part.remembered("integral")
    return make("sub", part, part.remembered("begun", 0.0))


__all__: Sequence[str] = ["Formulas", "Parameter", "formulas_of", "identifier"]
