"""A plant that plays a simulation file: the identified model in place of the truth, on the hardware of a plant file.

Drives, sensors, noise, stiffness and ripple stay the base plant's; the transmission error, friction, heat balance and
load side are the simulation's. Parameters the file does not give stay the base's; the weak orders go.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bench.simulation import formulas, tables, waves
from bench.simulation.fourier import FourierSet
from bench.simulation.laws import from_json as law_from_json
from bench.simulation.model import NOMINAL_TERMS, Simulation, Term
from bench.simulation.quantities import AUXILIARY
from bench.simulation.terms.table import LIBRARY
from fakes.plant.errors import PlantError
from fakes.plant.parts import Effect
from fakes.plant.transmission import TransmissionError
from fakes.plant.truth import PlantTruth

_FREE = ("table", "formula")
"""forms of a row that holds a free function"""
_THERMAL = ("thermal.sensor_lag", "thermal.second_mass", "thermal.convection_speed", "thermal.ambient_drift")
"""further terms that the plant's own heat balance has"""
_NEEDED = ("motor.inertia", "motor.load_reaction", "load.inertia", "load.reaction", "thermal.loss_heating")


def truth_from_simulation(path: Path, base: PlantTruth) -> PlantTruth:
    """Return the truth of a plant that obeys the simulation file at ``path``.

    Raises:
        PlantError: a term cannot be played.
        bench.errors.ConfigurationError: the file is wrong.
    """
    return of_simulation(Simulation.load(path), base, str(path))


def of_simulation(simulation: Simulation, base: PlantTruth, where: str = "simulation") -> PlantTruth:
    """Return the truth of a plant that obeys ``simulation``, with the hardware of ``base``."""
    if "base" in simulation.extra:
        raise PlantError(
            f"{where} stands on a simulation from elsewhere ({simulation.extra['base'].get('source')}), which a plant "
            "cannot play; one that stands alone can be"
        )
    if simulation.gearbox.ratio != base.gearbox.ratio:
        raise PlantError(
            f"{where} is of a gearbox of ratio {simulation.gearbox.ratio:g}, the plant {base.name} has "
            f"{base.gearbox.ratio:g}; choose a base plant of the same ratio"
        )
    for effect in _NEEDED:
        if not simulation.enabled(effect):
            raise PlantError(f"{where}: {effect} cannot be switched off in a plant, a body without it does not move")

    def given(effect: str, symbol: str, otherwise: float) -> float:
        found = simulation.value(effect, symbol)
        return otherwise if found is None else found

    friction = replace(
        base.friction,
        coulomb=given("friction.coulomb", "f_c", base.friction.coulomb),
        viscous=given("friction.viscous", "f_v", base.friction.viscous),
        viscous_temperature=given("friction.viscous_temperature_linear", "f_vT", base.friction.viscous_temperature),
        load_dependent=given("friction.load_dependent", "f_l", base.friction.load_dependent),
    )
    motor = replace(
        base.input_motor,
        inertia=given("motor.inertia", "J", base.input_motor.inertia),
        torque_offset=given("motor.torque_offset", "tau_0", base.input_motor.torque_offset),
    )
    further = [t for name, t in simulation.terms.items() if t.enabled and name not in NOMINAL_TERMS]
    series = _series(simulation, base, where)
    played = frozenset(float(f) for f in series.orders)
    bearing = given("load.bearing_friction", "f_b", base.load_side.bearing_friction)
    return replace(
        _with_heat(simulation, base, given),
        friction=friction,
        input_motor=motor,
        load_motor=replace(base.load_motor, inertia=given("load.inertia", "J_L", base.load_motor.inertia)),
        load_side=replace(base.load_side, bearing_friction=bearing),
        torque_sensor=replace(base.torque_sensor, zero=given("load.torque_offset", "z_0", base.torque_sensor.zero)),
        transmission_error=series,
        effects=tuple(effect for term in further for effect in _effects(term, played, where)),
        laws=tuple(law_from_json(term.effect, row["law"]) for term in further for row in term.rows() if "law" in row),
    )


def _with_heat(simulation: Simulation, base: PlantTruth, given: Callable[[str, str, float], float]) -> PlantTruth:
    """Return the base with the simulation's heat balance, in either way of writing it (C, R or their reciprocals)."""
    heat = base.heat
    capacity = given("thermal.loss_heating", "C", heat.capacity)
    rate = simulation.value("thermal.loss_heating", "1/C")
    if rate:
        capacity = 1.0 / rate
    resistance = given("thermal.convection", "R", heat.resistance)
    ambient = given("thermal.convection", "T_amb", heat.ambient)
    cooling = simulation.value("thermal.convection", "1/(R*C)")
    if not simulation.enabled("thermal.convection"):
        resistance = np.inf
    elif cooling:
        resistance = 1.0 / (cooling * capacity)
        above = simulation.value("thermal.convection", "(T_amb-25)/(R*C)")
        ambient = ambient if above is None else 25.0 + above / cooling

    def further(effect: str, symbol: str) -> float:
        return simulation.value(effect, symbol) or 0.0

    # the library writes the drift of the surroundings over R·C and against hours
    drift, swing = "thermal.ambient_drift", capacity * (resistance if np.isfinite(resistance) else 0.0)
    return replace(
        base,
        heat=replace(
            heat,
            capacity=capacity,
            resistance=resistance,
            ambient=ambient,
            ambient_rate=swing * further(drift, "d_1") / 3600.0,
            ambient_curvature=swing * further(drift, "d_2") / 3600.0**2,
            ambient_cosine=swing * further(drift, "d_c"),
            ambient_sine=swing * further(drift, "d_s"),
            ambient_period=3600.0 * further(drift, "period"),
            ambient_change=swing * further(drift, "d_e"),
            ambient_begin=3600.0 * further(drift, "t_b"),
            ambient_settling=3600.0 * further(drift, "t_e"),
            speed_cooling=further("thermal.convection_speed", "h_1"),
            speed_exponent=further("thermal.convection_speed", "n") or 1.0,
            housing_rate=further("thermal.second_mass", "1/(R_h*C)"),
            housing_time=further("thermal.second_mass", "tau_h") or heat.housing_time,
        ),
        lubricant_sensor=replace(base.lubricant_sensor, lag=further("thermal.sensor_lag", "tau_s")),
    )


def _series(simulation: Simulation, base: PlantTruth, where: str) -> TransmissionError:
    """Return the simulation's series with the elastic part of the base's stiffness taken out of a_0."""
    plain = base.transmission_error.without_weak_orders()
    model = simulation.transmission_error()
    if model is None:
        return plain
    if model.positive is None or model.negative is None:
        raise PlantError(f"{where}: te.fourier must have both directions for a plant to play it")
    sets = (model.positive, model.negative)
    orders = np.union1d(model.positive.orders, model.negative.orders)

    def spread(of: Callable[[FourierSet], np.ndarray[tuple[int, ...], np.dtype[np.float64]]]) -> TransmissionArray:
        table = np.zeros((2, orders.size, 10))
        for direction, part in enumerate(sets):
            table[direction, np.searchsorted(orders, part.orders)] = of(part)
        return table

    offset = np.stack([part.offset for part in sets])
    offset[:, 3] += 1.0 / base.torsional_stiffness
    return TransmissionError(
        orders=orders,
        amplitude=spread(lambda part: part.amplitude),
        phase=spread(lambda part: part.phase),
        offset=offset,
        weak=np.zeros(orders.size, dtype=np.bool_),
        box=plain.box,
    )


TransmissionArray = np.ndarray[tuple[int, ...], np.dtype[np.float64]]


def _effects(term: Term, played: frozenset[float], where: str) -> Iterator[Effect]:
    """What is played on top of a term's rows: no laws, no orders of the series, nothing that the plant's heat has."""
    for row in term.rows():
        if "law" in row or (term.effect in _THERMAL and row.get("form") not in _FREE):
            continue
        orders = [float(f) for f in row.get("orders", [])]
        if orders and played.issuperset(orders) and not row["parameters"].keys() & {"c", "s", "f"}:
            continue
        yield _effect(term.effect, row, where)


def _effect(effect: str, row: dict[str, Any], where: str) -> Effect:
    """Find the library's form that has the row's parameters (and its ``form``, where the file names one)."""
    channels = row.get("channels", [])
    if "waves" in row and len(channels) == 1:
        kind = str(row.get("form", "waves"))
        return Effect(effect, channels[0], kind, (), waves=waves.from_json(row["waves"], f"{where}: {effect}"))
    beside = next((name for name in row.get("over", ()) if name.startswith(AUXILIARY)), None)
    if beside is not None:
        raise PlantError(f"{where}: {effect} cannot be played by a plant: it has no quantity '{beside}'")
    if row.get("form") == "table" and len(channels) == 1:
        grid, values = tables.from_json(row, f"{where}: {effect}")
        return Effect(effect, channels[0], "table", tuple(float(v) for v in values), grid=grid)
    if row.get("form") == "formula" and len(channels) == 1:
        formula, values = formulas.from_json(row, f"{where}: {effect}")
        return Effect(effect, channels[0], "formula", tuple(float(v) for v in values), formula=formula)
    if effect not in LIBRARY:
        raise PlantError(f"{where}: {effect} cannot be played by a plant: the library has no such term")
    values = row["parameters"]
    for channel in row.get("channels", list(LIBRARY[effect].forms)):
        for form in LIBRARY[effect].forms.get(channel, ()):
            symbols = {s.symbol for s in (*form.linear, *form.nonlinear)}
            if symbols == set(values) and row.get("form", form.name) == form.name:
                linear = tuple(values[s.symbol] for s in form.linear)
                return Effect(effect, channel, form.name, linear, tuple(values[s.symbol] for s in form.nonlinear))
    given = ", ".join(values) or "none"
    raise PlantError(f"{where}: the parameters of {effect} ({given}) are not those of any of its forms")
