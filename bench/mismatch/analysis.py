"""All channels of a folder, one after another: what the simulation leaves out in each."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.discovery import ChannelOutcome, Discovery
from bench.mismatch.given import ENCODER, SENSOR, Given, Known
from bench.mismatch.memory import give_back
from bench.mismatch.orders import model as orders
from bench.mismatch.orders.discoveries import discoveries as of_orders
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.periodic import Periodic
from bench.mismatch.orders.periodicity import Periodicity, on_rows
from bench.mismatch.orders.reaction import Reaction, reaction_of
from bench.mismatch.orders.torques import torque_discoveries
from bench.mismatch.orders.turns import found_in
from bench.mismatch.power_zeros import Zeros
from bench.mismatch.power_zeros import chosen as zeros_chosen
from bench.mismatch.prediction import corrected
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.recordings.output_orders import OutputSpectrum
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.recordings.vibration import Density, ShaftSpectrum
from bench.mismatch.regression import noise
from bench.mismatch.regression.candidates import TURNING
from bench.mismatch.regression.course import columns_at
from bench.mismatch.regression.discoveries import discoveries as of_regression
from bench.mismatch.regression.model import ChannelModel, of_start
from bench.mismatch.regression.noise_floor import scattered
from bench.mismatch.regression.problem import (
    CHANNELS,
    BaseTerm,
    ChannelProblem,
    WanderingZero,
    fixed_part,
    nominal_base,
    zero_precisions,
)
from bench.mismatch.regression.search import searched
from bench.mismatch.regression.sensitivity import sensitivities
from bench.mismatch.regression.slots import settle, without_empty_laws
from bench.mismatch.regression.state import Search
from bench.mismatch.unnamed.formula import in_formulas
from bench.mismatch.unnamed.structure import examine
from bench.simulation import waves
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms import LIBRARY, LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR
from bench.simulation.waves import Wave

Progress = Callable[[str, float], None]
SPECTRA = "spectra of the steady parts, medians over recordings and frequencies"
DIFFERENCES = "differences of neighbouring rows"
SCATTER = "scatter inside blocks of two seconds and of these about parabolas over nine of them, medians over recordings"
TURNS = "revolutions against each other, medians over orders and frequencies"


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


def compared_channels(data: Dataset) -> tuple[list[str], list[str]]:
    """Channels that can be compared, and a sentence for each that cannot."""
    out: list[str] = []
    skipped: list[str] = []
    for channel, spec in CHANNELS.items():
        missing = [name for name in spec.made_of if name not in data.present]
        rows = data.rows.get(channel)
        if missing:
            skipped.append(f"{channel} is not compared: the recordings have no {', '.join(missing)}")
        elif rows is None or not _usable(channel, rows).any():
            skipped.append(f"{channel} is not compared: no recording has a usable sample of it in motion")
        elif channel == TRANSMISSION_ERROR and not found_in(rows.frame):
            skipped.append(
                f"{channel} is not compared: no steady part covers an output revolution, so orders cannot be found"
            )
        else:
            out.append(channel)
    return out, skipped


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
    tell = progress or (lambda _what, _share: None)
    out = Analysis(given)
    sensor: tuple[Known, ...] = given.known.get(LOAD_TORQUE, ())
    if data.linear:
        banned = (*banned, *TURNING)
    for number, channel in enumerate(c for c in CHANNELS if c in channels):
        tell(f"searching the {channel.replace('_', ' ')}", number / len(channels))
        rows = data.rows[channel]
        if channel != LOAD_TORQUE:
            rows = replace(rows, frame=corrected(rows.frame, sensor))
        if channel == TRANSMISSION_ERROR:
            out.transmission = _transmission(data, given, rows, seed, banned)
            out.outcomes[channel] = _of_transmission(out.transmission, data, seed, formulas)
            assert out.transmission.offset is not None
            periodic = out.transmission.periodic
            known = () if periodic is None else (*periodic.series.orders, *(w.order for w in periodic.weak))
            heard = data.density.get(channel, ())
            examine(out.outcomes[channel], out.transmission.offset, heard, seed, known)
            out.transmission.offset.close()
            out.reaction = _reaction(out, data, given, channels, seed)
        else:
            reaction = out.reaction if channel == MOTOR_TORQUE else None
            if reaction is not None:
                rows = replace(rows, y=rows.y - reaction.on_rows(rows.frame))
            if channel == TEMPERATURE:
                search = _heat(out, data, given, rows, seed, banned)
            else:
                search = searched(_problem(data, given, channel, rows, banned), seed)
            out.searches[channel] = search
            out.outcomes[channel] = _of_search(search, data, formulas)
            if reaction is not None:
                out.outcomes[channel].notes.append(reaction.words)
            if channel in (LOAD_TORQUE, MOTOR_TORQUE) and not data.linear:
                out.outcomes[channel].discoveries += _periodic(data, given, search, reaction, seed)
            examine(out.outcomes[channel], search, data.density.get(channel, ()), seed)
            search.close()
            if channel == LOAD_TORQUE:
                sensor = (*sensor, *_sensor_errors(search))
                banned = (*banned, *_shown_here_first([chosen.effect for chosen in search.model.chosen]))
        give_back()
    return out


def _reaction(out: Analysis, data: Dataset, given: Given, channels: Sequence[str], seed: int) -> Reaction | None:
    """The load's reaction through all that is periodic in the transmission error and that no encoder misreads."""
    whole = out.transmission
    made = {MOTOR_TORQUE, TRANSMISSION_ERROR} & data.simulated  # a simulation from elsewhere has a reaction of its own
    off = CHANNELS[MOTOR_TORQUE].fixed in given.switched_off
    if whole is None or whole.periodic is None or MOTOR_TORQUE not in channels or data.linear or made or off:
        return None
    misread = [f for d in out.outcomes[TRANSMISSION_ERROR].discoveries if d.effect == ENCODER for f in d.orders]
    known = given.waves.get(TRANSMISSION_ERROR, ())
    periodic = replace(
        whole.periodic, waves=(*whole.periodic.waves, *known), pulses=(*whole.periodic.pulses, *given.pulses)
    )
    train = data.folds() >= 0
    acting = periodic.less({*misread, *given.misread})
    return reaction_of(acting, whole.rows.frame, whole.inside, train, given.reaction, seed)


def _heat(out: Analysis, data: Dataset, given: Given, rows: Rows, seed: int, banned: Sequence[str]) -> Search:
    """The search of the temperature, with the loss less the zeros of the torques that it wants taken off.

    They are asked for again beside what was found: surroundings that warm up drown a zero of a sensor.
    """
    models = {c: out.searches[c].model for c in (LOAD_TORQUE, MOTOR_TORQUE) if c in out.searches}

    def problem(own: Rows) -> ChannelProblem:
        return _problem(data, given, TEMPERATURE, own, banned)

    def search() -> Search:
        return searched(problem(replace(rows, frame=out.zeros.less(rows.frame))), seed)

    out.zeros = zeros_chosen(models, rows, problem)
    first = search()
    found = [block for own in first.model.chosen for block in own.blocks]
    again = zeros_chosen(models, rows, problem, found) if found else out.zeros
    if again.which == out.zeros.which:
        return first
    first.close()
    out.zeros = again
    return search()


def _usable(channel: str, rows: Rows) -> NDArray[np.bool_]:
    moving = np.ones(rows.size, dtype=bool) if channel == TEMPERATURE else rows.frame.direction != 0
    return np.asarray(moving & (rows.number > 0))


def _base(given: Given, channel: str, rows: Rows) -> list[BaseTerm]:
    base = nominal_base(channel, given.switched_off)
    base += [BaseTerm(own) for own in sensitivities(given.base, channel, tuple(rows.frame.aux))]
    return base + [BaseTerm(known.regressor) for known in given.known.get(channel, ())]


def _problem(data: Dataset, given: Given, channel: str, rows: Rows, banned: Sequence[str]) -> ChannelProblem:
    base = _base(given, channel, rows)
    if channel == TEMPERATURE:
        torque = noise.mixture(data.density.get(MOTOR_TORQUE, []))
        base.append(BaseTerm(WanderingZero(), zero_precisions(rows.frame, torque)))
    taken = fixed_part(channel, rows.frame, given.switched_off)
    own = given.waves.get(channel, ())
    if own:
        taken = taken + on_rows(own, rows)
    rows = replace(rows, y=rows.y - taken)
    heard = noise.mixture(data.density.get(channel, []))
    return ChannelProblem(
        channel,
        rows,
        _usable(channel, rows),
        data.folds(),
        tuple(base),
        heard,
        None,
        given.switched_off,
        tuple(banned),
        given.unsettled.get(channel, ()),
        given.switched_off if data.folder.manner.free and channel not in data.simulated else (),
        tuple(name for name, unit in data.auxiliary_units.items() if unit in ANGLES),
        data.folder.manner.free,
        data.folder.manner.free and data.cut,
    )


def _sensor_errors(search: Search) -> list[Known]:
    model = search.model
    out = []
    for chosen in model.chosen:
        if chosen.effect.startswith(SENSOR):
            out += [Known(block.regressor, model.fit.of(block.place)[0]) for block in chosen.blocks]
    return out


def _shown_here_first(found: Collection[str]) -> list[str]:
    """Effects that are not looked for elsewhere once the load torque is compared, where some were ``found``.

    What the sensor reads wrongly shows there first: what goes with the torque elsewhere is something else. A delay of
    its channel that does not show there is none: what goes with the torque's rate elsewhere is a loop's form.
    """
    errors = [effect for effect in LIBRARY if effect.startswith(SENSOR)]
    return errors if DELAY in found else [*errors, DELAY]


def _of_search(search: Search, data: Dataset, formulas: bool) -> ChannelOutcome:
    slots = settle(search)
    if formulas:
        slots = in_formulas(search, slots, data.auxiliary_units)
    slots = without_empty_laws(search, slots)
    model = search.model
    problem = model.problem
    frame = problem.rows.frame
    whole = of_start(problem, model.predict(frame))
    before = of_start(problem, model.predict(frame, [], model.refitted([])))
    densities = data.density.get(problem.channel, [])
    error, method = floor_error(densities), DIFFERENCES if problem.noise is None else SPECTRA
    if problem.spec.integral:
        error, method = scattered(problem)[1], SCATTER
    outcome = ChannelOutcome(
        problem.channel,
        problem.rows,
        problem.usable,
        problem.held_out,
        whole,
        before,
        model.floor,
        error,
        method,
    )
    number = np.where(problem.usable, problem.rows.number, 0.0)
    outcome.discoveries += of_regression(search, slots, whole, number)
    outcome.doubt = uncertainty(model, frame, problem.held_out, problem.rows.number)
    outcome.notes += model.notes
    return outcome


def uncertainty(model: ChannelModel, frame: Frame, rows: NDArray[np.bool_], number: FloatArray) -> float:
    """Mean variance of a model's prediction over the samples of some rows, by the covariance of its coefficients."""
    chosen = np.flatnonzero(rows)[:: max(1, int(rows.sum()) // MOST_ROWS)]
    if chosen.size == 0:
        return 0.0
    blocks = [b for b in model.blocks() if b.regressor.effect != "nuisance"]
    columns = np.hstack([np.zeros((chosen.size, 0)), *(columns_at(b.regressor, frame, chosen) for b in blocks)])
    covariance = model.fit.of([i for b in blocks for i in b.place])[1]
    variance = np.sum(columns @ covariance * columns, axis=1)
    return float(np.average(np.maximum(variance, 0.0), weights=np.maximum(number[chosen], 1e-9)))


ANGLES = ("rad", "")
"""units of auxiliary quantities that may be angles: radians, into which angles are imported, and none told"""
MOST_ROWS = 4000
"""rows on which the uncertainty of a prediction is worked out"""


def _periodic(data: Dataset, given: Given, search: Search, reaction: Reaction | None, seed: int) -> list[Discovery]:
    """What is periodic in a torque and too quick for its rows; without the ``reaction``, which it is known to hold."""
    problem = search.model.problem
    channel = problem.channel
    output, shaft = data.output.get(channel, []), data.shaft if channel == MOTOR_TORQUE else []
    if reaction is not None:
        output, shaft = [reaction.less_output(s) for s in output], [reaction.less_shaft(s) for s in shaft]
    seen = Periodicity(
        channel,
        [_less(s, given.waves.get(channel, ())) for s in output],
        [_less_ripple(s, given.ripples, data.ratio) for s in shaft],
        problem.rows,
        problem.folds,
        data.ratio,
        search.model.floor,
    )
    return torque_discoveries(seen, seed)


def _less(seen: OutputSpectrum, known: Sequence[Wave]) -> OutputSpectrum:
    """A spectrum over the output angle less waves that the simulation has."""
    if not known:
        return seen
    amplitude = seen.amplitude.copy()
    load = seen.torque / 1000.0
    size = {"1": 1.0, "d": seen.direction, "tau": load, "d*abs_tau": seen.direction * abs(load)}
    for wave in known:
        order = round(wave.order)
        if order < amplitude.size and wave.times in size:
            amplitude[order] -= complex(wave.cosine, wave.sine) * size[wave.times]
    return replace(seen, amplitude=amplitude)


def _less_ripple(seen: ShaftSpectrum, known: Sequence[Wave], ratio: float) -> ShaftSpectrum:
    """A spectrum over the motor's angle less ripple that the simulation has."""
    if not known:
        return seen
    amplitude = seen.amplitude.copy()
    for wave in known:
        order = round(wave.order / ratio)
        if order < amplitude.size:
            amplitude[order] -= complex(wave.cosine, wave.sine) * (seen.torque if wave.times == "motor_torque" else 1.0)
    return replace(seen, amplitude=amplitude)


DELAY = "sensor.timing_skew"
"""id of the delay of the torque channel"""
GROUPS = 5
"""groups of recordings whose noise is told apart to see how sure the noise is"""


def floor_error(densities: Sequence[Density]) -> float | None:
    """Standard error of the noise of a sample: groups of recordings against each other; None where they are too few."""
    own = []
    for k in range(GROUPS):
        found = noise.mixture(densities[k::GROUPS])
        if found is not None:
            own.append(float(np.sqrt(found.variance)))
    return float(np.std(own, ddof=1) / np.sqrt(len(own))) if len(own) == GROUPS else None


def _transmission(data: Dataset, given: Given, rows: Rows, seed: int, banned: Sequence[str]) -> TransmissionModel:
    taken = np.zeros(rows.size)
    own = given.waves.get(TRANSMISSION_ERROR, ())
    if own:
        taken = taken + waves.evaluate(own, rows.frame.theta, rows.frame)
    for pulse in given.pulses:
        taken = taken + pulse.evaluate(rows.frame.theta)
    base = _base(given, TRANSMISSION_ERROR, rows)
    told = orders.Given(given.orders, data.folder.notch, given.laws)
    off = (*given.switched_off, *banned)
    begun = orders.begun(replace(rows, y=rows.y - taken), data.folds(), told, base, off)
    return orders.analyse(begun, seed)


def _of_transmission(model: TransmissionModel, data: Dataset, seed: int, formulas: bool) -> ChannelOutcome:
    plain = model.periodic
    found = of_orders(model, data.gearbox, seed)
    if model.periodic is not plain:
        # a pulse or a law says what orders had said badly: the offset is what they leave now
        orders.offset_anew(model, seed)
    offset = model.offset
    assert offset is not None
    slots = settle(offset)
    if formulas:
        slots = in_formulas(offset, slots, data.auxiliary_units)
    frame = model.rows.frame
    own = offset.model
    periodic = model.periodic.evaluate(frame) if model.periodic is not None else np.zeros(frame.size)
    given = np.zeros(frame.size)
    if model.plain is not None:
        given = Periodic(model.plain, laws=model.given.laws).evaluate(frame)
    level = own.predict(frame)
    before = given + own.predict(frame, [], own.refitted([]))
    held = np.isin(frame.recording, list(data.held_out()))
    floor = own.floor
    spread = model.seen.white if model.seen is not None else np.zeros(0)
    error = float(floor * np.std(spread) / spread.mean() / np.sqrt(spread.size)) if spread.size > GROUPS else None
    outcome = ChannelOutcome(
        TRANSMISSION_ERROR,
        model.rows,
        model.inside,
        model.inside & held,
        periodic + level,
        before,
        floor,
        error,
        TURNS if model.noise is not None else DIFFERENCES,
    )
    if model.periodic is not None and outcome.held_out.any():
        chosen = np.flatnonzero(outcome.held_out)[:: max(1, int(outcome.held_out.sum()) // MOST_ROWS)]
        part = frame.take(chosen)
        x = np.column_stack([part.torque, part.velocity, part.temperature])
        outcome.doubt = float(np.mean(model.periodic.series.variance(x, part.last_direction)))
        outcome.doubt += uncertainty(own, frame, outcome.held_out, model.rows.number)
    outcome.discoveries += found
    number = np.where(model.inside, model.rows.number, 0.0)
    outcome.discoveries += of_regression(offset, slots, level, number, frame, model.rows.y - periodic)
    outcome.notes += [*model.notes, *own.notes]
    return outcome
