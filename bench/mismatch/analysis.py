"""All channels of a folder, one after another: what the simulation leaves out in each."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.calibrated_by_heat import CalibrationHeat, calibrated
from bench.mismatch.discovery import ChannelOutcome, Discovery
from bench.mismatch.given import LOAD_INERTIA, LOAD_SIDE, SENSOR, Given, Known
from bench.mismatch.memory import give_back
from bench.mismatch.orders import swings as short
from bench.mismatch.orders.misread import ENCODER
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.periodicity import Periodicity
from bench.mismatch.orders.reaction import Reaction, reaction_of
from bench.mismatch.orders.reported_swings import of_torque
from bench.mismatch.orders.revolutions import found_in
from bench.mismatch.orders.scattering import scattering
from bench.mismatch.orders.shaken import Rates, inertia_from_orders, inertia_of, largest_inertia, without_shaking
from bench.mismatch.orders.torques import torque_discoveries
from bench.mismatch.outcomes import of_search, slots_of
from bench.mismatch.power_zeros import REST, UNNAMED, Zeros, of_model
from bench.mismatch.power_zeros import chosen as zeros_chosen
from bench.mismatch.prediction import corrected
from bench.mismatch.problems import capacity_of, less_fixed, periodicity_of, problem_of, usable, wandering_zero
from bench.mismatch.read_motion import without_misread_motion
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.recordings.read_again import finely
from bench.mismatch.recordings.rows import HEAT_S, Rows
from bench.mismatch.regression.bank import Fit
from bench.mismatch.regression.candidates import ROTATING
from bench.mismatch.regression.equivalent import expected
from bench.mismatch.regression.hidden_states import with_states
from bench.mismatch.regression.model import ChannelModel, Chosen, fit_blocks
from bench.mismatch.regression.nameless_heat import gain_heat, nameless_heat, nameless_load_heat, sensor_heat
from bench.mismatch.regression.nameless_load import nameless_load
from bench.mismatch.regression.problem import CHANNELS, TORQUE_ZERO, BaseTerm, ChannelProblem
from bench.mismatch.regression.regressors import UNKNOWN, Named, Regressor
from bench.mismatch.regression.search import searched
from bench.mismatch.regression.slots import Slot
from bench.mismatch.regression.slow_noise import of_a_row
from bench.mismatch.regression.state import Search
from bench.mismatch.transmission import Task, ask_for_tone
from bench.mismatch.unnamed.crossings import FINE_S, FineResidual, on_grid
from bench.mismatch.unnamed.ring_down import RingDown, ring_down
from bench.mismatch.unnamed.structure import examine
from bench.mismatch.who_reads_wrong import as_reported, mark, mark_load, of_load_motor, of_shaft, on_shaft
from bench.mismatch.whose_orders import told as whose
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import lag, loss_lag
from bench.simulation.terms import LIBRARY, LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR
from bench.simulation.terms.thermal.sensor_lag import SETTLED, lags_of
from bench.simulation.waves import from_json

Progress = Callable[[str, float], None]


@dataclass(slots=True)
class Analysis:
    """What was found: a search a channel, the transmission error's model, an outcome a channel."""

    given: Given
    searches: dict[str, Search] = field(default_factory=dict)
    transmission: TransmissionModel | None = None
    outcomes: dict[str, ChannelOutcome] = field(default_factory=dict)
    zeros: Zeros = field(default_factory=Zeros)
    """zeros of the torques that are taken off the loss that heats"""
    reaction: Reaction | None = None
    """what the motor torque holds of the load's reaction through the transmission error"""
    periodic: dict[str, list[Discovery]] = field(default_factory=dict)
    """orders that are taken off the rows of a torque, where these are short enough to follow them"""
    acting: tuple[Known, ...] = ()
    """what the load torque's sensor reads beside the load, and what of the load its level hides"""
    misread: tuple[Regressor, ...] = ()
    """errors of the torque sensor, which are taken off what it reads"""
    plain: dict[str, Fit] = field(default_factory=dict)
    """the simulation alone, fitted to the rows of such a torque with the orders in them"""


def compared_channels(data: Dataset, orders: Sequence[float] = ()) -> tuple[list[str], list[str]]:
    """Channels that can be compared, and a sentence for each that cannot; ``orders`` that the simulation has of the
    transmission error.
    """
    out: list[str] = []
    skipped: list[str] = []
    for channel, spec in CHANNELS.items():
        missing = [name for name in spec.made_of if name not in data.present]
        rows = data.rows.get(channel)
        if missing:
            skipped.append(f"{channel} is not compared: the recordings have no {', '.join(missing)}")
        elif rows is None or not usable(channel, rows).any():
            skipped.append(f"{channel} is not compared: no recording has a usable sample of it in motion")
        elif channel == TRANSMISSION_ERROR and (data.linear or orders) and not found_in(rows.frame):
            # what is found in swings takes the place of no series, and a linear axis has no revolution to be short of
            skipped.append(
                f"{channel} is not compared: no steady part covers an output revolution, so the simulation's orders"
                " cannot be calibrated"
            )
        elif channel == TEMPERATURE and not _has_a_course(rows):
            skipped.append(
                f"{channel} is not compared: no recording lasts longer than a mean of {HEAT_S:.0f} s,"
                " so none shows how it changes"
            )
        else:
            out.append(channel)
    return out, skipped


def _has_a_course(rows: Rows) -> bool:
    """Whether a recording has two usable rows at least: the level at which it begins is free."""
    return bool(np.bincount(rows.frame.recording[usable(TEMPERATURE, rows)], minlength=1).max(initial=0) > 1)


def analyse(
    data: Dataset,
    given: Given,
    channels: Sequence[str],
    progress: Progress | None = None,
    seed: int = 0,
    banned: Sequence[str] = (),
    formulas: bool = True,
) -> Analysis:
    """Search ``channels`` of a folder for what the simulation ``given`` leaves out, but for the effects ``banned``.

    ``formulas``: whether a formula is looked for where something has no name.
    """
    report_progress = progress or (lambda _what, _share: None)
    out = Analysis(given)
    acting: tuple[Known, ...] = given.known.get(LOAD_TORQUE, ())
    shown: tuple[str, ...] = ()
    in_angles: tuple[str, ...] = ()
    unsure: ChannelModel | None = None
    settled: Sequence[Slot] = ()
    if data.linear:
        banned = (*banned, *ROTATING)
    for number, channel in enumerate(c for c in CHANNELS if c in channels):
        report_progress(f"searching the {channel.replace('_', ' ')}", number / len(channels))
        rows = data.rows[channel]
        unnamed: Sequence[BaseTerm] = ()
        if channel != LOAD_TORQUE:
            rows = replace(rows, frame=corrected(rows.frame, acting))
            # what the load torque has without a name is no second finding where the load acts
            most = 1.0 / data.ratio if channel == MOTOR_TORQUE else None
            unnamed = () if unsure is None else nameless_load(unsure, most)
        if channel == TRANSMISSION_ERROR:
            task = Task(data, given, rows, channels, (*banned, *in_angles), unnamed, formulas, seed)
            out.transmission, out.outcomes[channel] = task.searched()
            assert out.transmission.offset is not None
            out.transmission.offset.close()
            out.outcomes[channel].scattering = scattering(out.transmission)
            if MOTOR_TORQUE in channels and not data.linear:
                outcome = out.outcomes[channel]
                decided = out.transmission.torque_check.orders
                outcome.discoveries = [whose(found, data, decided) for found in outcome.discoveries]
            out.reaction = _reaction(out, data, given, seed) if task.reacts(out.transmission) else None
        else:
            reaction = out.reaction if channel == MOTOR_TORQUE else None
            if reaction is not None:
                rows = replace(rows, y=rows.y - reaction.on_rows(rows.frame))
            if channel == TEMPERATURE:
                search = _heat(out, data, given, rows, seed, (*banned, *shown))
            else:
                if channel == MOTOR_TORQUE and not data.linear:
                    rows = replace(rows, frame=_moved(out, data, given, rows.frame))
                problem = problem_of(data, given, channel, rows, (*banned, *shown), unnamed)
                search = _beside_orders(out, data, given, problem, seed)
                search = search if data.linear else with_states(search, seed)
            out.searches[channel], slots = search, slots_of(search, data, formulas)
            if channel == TEMPERATURE and MOTOR_TORQUE in out.searches:
                # the heat may have moved its calibration
                motor_torque = out.searches[MOTOR_TORQUE]
                out.outcomes[MOTOR_TORQUE] = _outcome(out, data, given, motor_torque, settled, seed)
                motor_torque.close()
            if channel == MOTOR_TORQUE and TEMPERATURE in channels:
                settled = slots
                give_back()
                continue
            out.outcomes[channel] = _outcome(out, data, given, search, slots, seed)
            if channel == LOAD_TORQUE:
                known = _acting(out, data, given, _known_of(search), seed, banned)
                loads, unsure = _loads(out, data, given, search.model, known)
                acting = out.acting = (*acting, *known, *loads)
                out.misread = tuple(k.regressor for k in acting if k.misread)
                in_angles = _excluded_delay(search)
                shown = tuple(_shown_here_first([chosen.effect for chosen in search.model.chosen]))
            if channel == TEMPERATURE and MOTOR_TORQUE in out.searches:
                _as_warm_as_it_is(out, data, given, rows, formulas, seed, (*banned, *shown))
            out.searches[channel].close()
        give_back()
    if LOAD_TORQUE in out.outcomes:
        # the load's inertia makes its torque feel the orders, which are known only now
        inertia = largest_inertia(out.searches[LOAD_TORQUE].model, LOAD_INERTIA)
        ask_for_tone(out.outcomes[LOAD_TORQUE], data, out.transmission, seed, inertia)
    return out


def _moved(out: Analysis, data: Dataset, given: Given, frame: Frame) -> Frame:
    """A frame with the motion of the motor, without what its encoder misreads."""
    outcome = out.outcomes.get(TRANSMISSION_ERROR)
    found = [] if outcome is None else [d for d in outcome.discoveries if d.effect == ENCODER]
    waves = [w for d in found for row in d.simulation_rows for w in from_json(row.get("waves", ()), ENCODER)]
    return without_misread_motion(frame, [*waves, *given.misread_waves], data.folder.manner.smoothing)


def _beside_orders(out: Analysis, data: Dataset, given: Given, problem: ChannelProblem, seed: int) -> Search:
    """The search of a torque. Where its rows are short enough to follow the orders that stand in it, they are taken off
    and it is searched again: a shaft that shakes with its ripple makes the ripple look like inertia, and like friction.
    """
    search = searched(problem, seed)
    if data.linear:
        return search
    channel = problem.channel
    seen = periodicity_of(data, given, search, out.reaction if channel == MOTOR_TORQUE else None, _misread(out))
    rates = _rates_of(data, seen)
    inertia = inertia_from_orders(seen, rates, seed) if channel == MOTOR_TORQUE else None
    inertia = inertia_of(search.model) if inertia is None else inertia
    found = _orders_of(search, without_shaking(seen, inertia, rates), seed)
    waves = np.sum([np.zeros(problem.rows.size), *(d.added for d in found)], axis=0)
    size = float(np.sqrt(np.average(waves**2, weights=np.where(problem.usable, problem.rows.number, 0.0))))
    little = size < criteria.LEAST_STRENGTH * search.model.floor
    # rows of a steady part hardly feel an order, those of a reversal do
    by_chance = 0.5 * sum(d.numbers for d in found)
    if size == 0.0 or (little and expected(search.model, waves[problem.train]) - by_chance < search.model.price):
        return search
    out.plain[channel] = search.model.refitted([])
    search.close()
    # what was taken off is what is reported: it is not looked for again
    out.periodic[channel] = found
    return searched(replace(problem, rows=replace(problem.rows, y=problem.rows.y - waves)), seed)


def _orders_of(search: Search, seen: Periodicity, seed: int) -> list[Discovery]:
    """What is periodic in a torque: by the spectra of its steady parts or, where no part has a spectrum, in the swings
    of the motion.
    """
    model = search.model
    if seen.shaft or seen.output or model.channel != MOTOR_TORQUE:
        return torque_discoveries(seen, seed)
    rows = model.problem.rows
    left = rows.y - model.predict(rows.frame)
    found = short.borne_out(short.search(rows, left, model.problem.train), rows, left, model.problem.held_out)
    return of_torque(found, rows, np.where(model.problem.usable, rows.number, 0.0), model.floor)


def _rates_of(data: Dataset, seen: Periodicity) -> Rates:
    """How the accelerations of recordings with orders were smoothed, at the lowest of their sample rates."""
    recordings = {s.recording for s in seen.shaft} | {s.recording for s in seen.output}
    rate = min((float(data.members[k].recording.sample_rate) for k in recordings), default=1.0)
    return Rates(rate, data.folder.manner.smoothing)


def _outcome(
    out: Analysis, data: Dataset, given: Given, search: Search, slots: Sequence[Slot], seed: int
) -> ChannelOutcome:
    """The outcome of a search of a torque or of the temperature, whose effects were settled (``slots``), with what is
    left of that channel.
    """
    channel = search.model.channel
    reaction = out.reaction if channel == MOTOR_TORQUE else None
    outcome = of_search(search, slots, data)
    if reaction is not None:
        outcome.notes.append(reaction.words)
    if channel in (LOAD_TORQUE, MOTOR_TORQUE) and not data.linear:
        found = out.periodic.get(channel)
        if found is None:
            seen = periodicity_of(data, given, search, reaction, _misread(out))
            found = _orders_of(search, without_shaking(seen, inertia_of(search.model), _rates_of(data, seen)), seed)
        outcome.discoveries += found
    # what is left is tested on what the channel's own rows are fitted best by
    alone = replace(search, model=search.model.by_itself())
    rings = None if channel == TEMPERATURE or data.linear else _rings(out, data, given, alone, reaction)
    examine(outcome, alone, data.density.get(channel, ()), seed, rings)
    if channel != LOAD_TORQUE:
        # the motor feels orders by friction and by its control as well: how much, no inertia says
        ask_for_tone(outcome, data, out.transmission, seed)
    return outcome


def _rings(out: Analysis, data: Dataset, given: Given, search: Search, reaction: Reaction | None) -> RingDown | None:
    """Ringing of a torque after the load has changed its sign. Recordings in which it does are read once more."""
    channel = search.model.channel

    def left(recordings: Sequence[int]) -> Iterator[FineResidual | None]:
        for number, rows in finely(data, channel, recordings, FINE_S):
            if channel != LOAD_TORQUE:
                rows = replace(rows, frame=corrected(rows.frame, out.acting))
            if reaction is not None:
                rows = replace(rows, y=rows.y - reaction.on_rows(rows.frame))
            off = less_fixed(given, channel, rows).y - search.model.predict(rows.frame)
            yield on_grid(rows.frame, np.where(usable(channel, rows), off, np.nan), number)

    frame, densities = search.model.problem.rows.frame, data.density.get(LOAD_TORQUE, ())
    return ring_down(frame, densities, data.folds() >= 0, left, data.folder.notch)


def _as_warm_as_it_is(
    out: Analysis, data: Dataset, given: Given, rows: Rows, formulas: bool, seed: int, banned: Sequence[str]
) -> None:
    """Search the motor torque again where it has something without a name and the temperature's sensor lags: the
    gearbox is warmer than that reads while it warms, and its friction less. If nothing without a name is left then, it
    was the lag's, provided that the temperature has that lag beside the new model of the motor torque as well. ``rows``
    of the temperature, and the effects ``banned`` there.
    """
    heat = out.searches[TEMPERATURE]
    model = out.searches[MOTOR_TORQUE].model
    behind = behind_of(heat.model)
    if behind is None or not model.nameless:
        return
    frame = model.problem.rows.frame
    warmer = frame.temperature + np.interp(frame.time, heat.model.problem.rows.frame.time, behind)
    moved = replace(model.problem.rows, frame=replace(frame, temperature=warmer))
    again = searched(replace(model.problem, rows=moved, states=False), seed)
    other = replace(out, searches={**out.searches, MOTOR_TORQUE: again}, outcomes=dict(out.outcomes))
    if not again.model.nameless and _holds_with(other, data, given, rows, formulas, seed, banned):
        out.searches, out.outcomes, out.zeros = other.searches, other.outcomes, other.zeros
        if out.searches[TEMPERATURE] is not heat:
            heat.close()
    again.close()


def _holds_with(
    out: Analysis, data: Dataset, given: Given, rows: Rows, formulas: bool, seed: int, banned: Sequence[str]
) -> bool:
    """Whether nothing without a name is left in the motor torque, and the temperature still shows a lag with
    it.
    """
    motor_torque, heat = out.searches[MOTOR_TORQUE], None
    slots = slots_of(motor_torque, data, formulas)
    if UNNAMED in out.zeros.which or of_model(out.zeros.which):
        # the temperature was fitted with what is no more, or with zeros of recordings that another model tells
        heat = _heat(out, data, given, rows, seed, banned)
    outcome = _outcome(out, data, given, motor_torque, slots, seed)
    lags = heat is None or behind_of(heat.model) is not None
    if not lags or any(d.effect == UNKNOWN for d in outcome.discoveries):
        if heat is not None:
            heat.close()
        return False
    outcome.notes.append(
        "what the motor torque had without a name comes from the lag of the temperature sensor: calculated with"
        " the temperature of the gearbox itself, nothing without a name is left"
    )
    if heat is not None:
        out.searches[TEMPERATURE], out.outcomes[TEMPERATURE] = (
            heat,
            _outcome(out, data, given, heat, slots_of(heat, data, formulas), seed),
        )
    out.outcomes[MOTOR_TORQUE] = outcome
    return True


def behind_of(model: ChannelModel) -> FloatArray | None:
    """By how much the gearbox is warmer than its sensor reads (n,), K, at the rows of a model of the temperature; None
    where it has no lag. The reading rises by P_s/C, the gearbox by P/C (P_s: the loss that the sensor has followed, or
    the mean of two by their shares). A sensor that reads right when a recording begins is behind by what it lacks.
    """
    frame = model.problem.rows.frame
    parts: list[FloatArray] = []
    for chosen in model.chosen:
        regressor = chosen.main.regressor
        if chosen.effect == LAG and isinstance(regressor, Named):
            coefficients = model.fit.of(chosen.main.indices)[0]
            if regressor.form.name in SETTLED:
                parts.append(-np.asarray(regressor.columns(frame) @ coefficients))
            else:
                kept = regressor.form.remembers
                parts += [
                    share
                    * constant
                    * float(coefficients[0])
                    * (loss_lag(frame, constant) if kept else lag(frame.power, frame, constant))
                    for constant, share in lags_of(regressor.point)
                ]
    return np.sum(parts, axis=0) if parts else None


def _misread(out: Analysis) -> frozenset[float]:
    """Orders of the transmission error that the motor's encoder misreads, wholly or in part."""
    outcome = out.outcomes.get(TRANSMISSION_ERROR)
    found = [] if outcome is None else outcome.discoveries
    return frozenset(f for d in found if d.effect == ENCODER for f in d.orders)


def _reaction(out: Analysis, data: Dataset, given: Given, seed: int) -> Reaction | None:
    """The load's reaction through all that is periodic in the transmission error and that no encoder misreads."""
    whole = out.transmission
    assert whole is not None
    assert whole.periodic is not None
    misread = _misread(out)
    beside = [m for m in whole.torque_check.found if m.beside and m.order in misread]
    acting = whole.periodic.less({*misread, *given.misread} - {m.order for m in beside})
    acting = replace(
        acting,
        waves=(*acting.waves, *given.acting_waves, *(m.taken_off for m in beside)),
        pulses=(*acting.pulses, *given.pulses),
    )
    return reaction_of(acting, whole.rows.frame, whole.inside, data.folds() >= 0, given.reaction, seed)


def _heat(out: Analysis, data: Dataset, given: Given, rows: Rows, seed: int, banned: Sequence[str]) -> Search:
    """The search of the temperature, with the loss less the zeros of the torques that it wants taken off.

    They are asked for again beside the names that were found: surroundings that warm up drown a zero of a sensor. A
    function without a name may be the zero itself.
    """
    models = {c: out.searches[c].model for c in (LOAD_TORQUE, MOTOR_TORQUE) if c in out.searches}

    offsets = models[MOTOR_TORQUE].fit.variance if MOTOR_TORQUE in models else 0.0
    zero = max(TORQUE_ZERO, float(np.sqrt(offsets)) if np.isfinite(offsets) else 0.0)

    problem = problem_of(data, given, TEMPERATURE, rows, banned)
    row = of_a_row(problem)

    def search() -> Search:
        less = replace(rows, frame=out.zeros.less(rows.frame))
        capacity = capacity_of(data, given, less)
        nameless: tuple[BaseTerm, ...] = ()
        if MOTOR_TORQUE in models:
            nameless = (*nameless_heat(models[MOTOR_TORQUE], capacity), *gain_heat(models[MOTOR_TORQUE], capacity))
            unsure = CalibrationHeat(models[MOTOR_TORQUE], whole=REST in out.zeros.which, less=out.zeros.effects)
            if of_model(out.zeros.which) and unsure.indices:
                nameless = (*nameless, unsure.term(capacity))
        if LOAD_TORQUE in models:
            load = models[LOAD_TORQUE]
            nameless = (*nameless, *nameless_load_heat(load, capacity), *sensor_heat(load, out.misread, capacity))
        nuisances = (wandering_zero(data, less, zero, capacity, row), *nameless)
        return searched(problem_of(data, given, TEMPERATURE, less, banned, nuisances), seed)

    out.zeros = zeros_chosen(models, problem)
    first = search()
    found = [block for chosen in first.model.chosen if chosen.effect != UNKNOWN for block in chosen.blocks]
    again = zeros_chosen(models, problem, found) if found else out.zeros
    if again.which != out.zeros.which:
        first.close()
        out.zeros = again
        first = search()
    moved = calibrated(first.model, problem, out.zeros, models)
    if moved is None:
        return first
    out.zeros = moved
    first.close()
    return search()


def _known_of(search: Search) -> list[Known]:
    model = search.model
    found = (chosen for chosen in model.chosen if chosen.effect.startswith((SENSOR, LOAD_SIDE)))
    return [known for chosen in found for known in _as_known(model, chosen)]


def _as_known(model: ChannelModel, chosen: Chosen) -> list[Known]:
    return [Known(block.regressor, model.fit.of(block.indices)[0]) for block in chosen.blocks]


def _loads(
    out: Analysis, data: Dataset, given: Given, model: ChannelModel, found: Sequence[Known]
) -> tuple[list[Known], ChannelModel]:
    """Functions without a name of the load torque that are loads, beside what was ``found`` there; and the model
    without them: of the others nothing tells an error of the sensor from a load.
    """
    loads: list[Known] = []
    unsure = list(model.chosen)
    for chosen in model.nameless:
        one = _as_known(model, chosen)
        probability = of_shaft(data, given, [*found, *loads], one)
        if probability is not None:
            mark_load(out.outcomes[LOAD_TORQUE], chosen.main.regressor.words, probability)
            loads += on_shaft(one)
            unsure = [c for c in unsure if c is not chosen]
    return loads, replace(model, chosen=unsure)


def _acting(
    out: Analysis, data: Dataset, given: Given, found: Sequence[Known], seed: int, banned: Sequence[str]
) -> Sequence[Known]:
    """What was ``found`` in the load torque and acts on the other channels; a note where the sensor reads right."""
    probability = of_load_motor(data, given, found, seed, (*banned, *_shown_here_first([])))
    if probability is None:
        return found
    mark(out.outcomes[LOAD_TORQUE], probability)
    return as_reported(found)


def _excluded_delay(search: Search) -> tuple[str, ...]:
    """A delay of the torque channel, if the load torque has none and tells that to within a sample: what follows the
    torque's rate in the angles is something else then. A load torque that hardly changed tells less than the angles do.
    """
    model, frame = search.model, search.model.problem.rows.frame
    block = next((b for b in search.blocks if b.regressor.effect == DELAY), None)
    if block is None or any(chosen.effect == DELAY for chosen in model.chosen):
        return ()
    variance = fit_blocks(model.bank, [*model.blocks(), block], model.variances).of(block.indices)[1][0, 0]
    within = frame.step > 0.0
    sample = float(np.median(frame.step[within] / frame.count[within]))
    return (DELAY,) if np.sqrt(variance) < sample else ()


def _shown_here_first(found: Collection[str]) -> list[str]:
    """Effects that are not looked for in the motor torque and the temperature once the load torque is compared, where
    some were ``found``.

    What the sensor reads wrongly shows there first: what goes with the torque elsewhere is something else. A delay of
    its channel that does not show there is none: what goes with the torque's rate elsewhere is a loop's form.
    """
    errors = [effect for effect in LIBRARY if effect.startswith(SENSOR)]
    return errors if DELAY in found else [*errors, DELAY]


DELAY = "sensor.timing_skew"
"""id of the delay of the torque channel"""
LAG = "thermal.sensor_lag"
"""id of the lag of the temperature's sensor"""
