"""The search of the transmission error: its model, what is left of it, and both again where a tone made some orders."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import AMBIGUOUS, UNNAMED, ChannelOutcome, Discovery
from bench.mismatch.given import Given
from bench.mismatch.orders.courses import EFFECTS
from bench.mismatch.orders.misread import HARMONIC, torque_check
from bench.mismatch.orders.model import GivenOrders, KnownOffset, Swings, TransmissionModel, begun
from bench.mismatch.orders.of_motor import multiples
from bench.mismatch.orders.reaction import reaction_of
from bench.mismatch.orders.revolutions import directions, states
from bench.mismatch.orders.shaft import PHASES
from bench.mismatch.orders.sight import known_orders
from bench.mismatch.orders.turns import analyse, misleading
from bench.mismatch.orders.weak import design
from bench.mismatch.outcomes import of_transmission
from bench.mismatch.problems import base_of
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.recordings.read_again import runs_of
from bench.mismatch.recordings.rows import Rows, error_of_mean
from bench.mismatch.regression.excess import levelled
from bench.mismatch.regression.problem import CHANNELS, BaseTerm
from bench.mismatch.report.figures import strength
from bench.mismatch.unnamed import following
from bench.mismatch.unnamed.crossings import on_grid
from bench.mismatch.unnamed.orders_of_tone import made_by_tone, tone_on_rows
from bench.mismatch.unnamed.ring_down import RingDown, ring_down
from bench.mismatch.unnamed.structure import examine, look_for_tone
from bench.mismatch.unnamed.tones import Tone
from bench.simulation import waves
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import STATES
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR

APART = 0.5
"""orders by which one is another order"""
SETTLES = 0.5
"""of the energy that an offset moved by inside revolutions in one turn, what it moves by in the next at most where
orders and offset, found in turns, settle: a play that a torque crosses moved by a hundredth each time
"""


@dataclass(frozen=True, slots=True)
class Task:
    """What is to be searched: the ``rows`` of the transmission error of a folder, of which some ``channels`` are
    compared, for what the simulation ``given`` leaves out, but for effects that are ``banned``.

    ``unnamed``: what the load torque has without a name; ``formulas``: whether one is looked for where something has no
    name.
    """

    data: Dataset
    given: Given
    rows: Rows
    channels: Sequence[str]
    banned: Sequence[str]
    unnamed: Sequence[BaseTerm]
    formulas: bool
    seed: int

    def searched(self) -> tuple[TransmissionModel, ChannelOutcome]:
        """The model and its outcome. What the offset does inside revolutions, a tone, and parts of orders that follow
        something, are taken off before orders are looked for, where they may have made some.
        """
        model, outcome = self._beside_a_tone()
        found = following.search(model, self.seed)
        if found is None:
            return model, outcome
        added = found.evaluate(self.rows.frame)
        _close(model)
        less = replace(self, rows=replace(self.rows, y=self.rows.y - added))
        again, other = less._beside_a_tone()
        beyond = added + again.given_orders - model.given_orders
        told = following.as_discovery(again, found, beyond)
        if told is None or not _leaves_less(other, outcome):
            _close(again)
            return model, outcome
        other.rows = replace(other.rows, y=other.rows.y + added)
        other.whole = other.whole + added
        # the simulation recalibrated is that of all that was measured
        other.before, again.plain = outcome.before, model.plain
        _put(told, found.course.of in STATES, other)
        return again, other

    def _beside_a_tone(self) -> tuple[TransmissionModel, ChannelOutcome]:
        """The model and its outcome, without the orders that a tone has made."""
        model, outcome, tone = self._beside_its_offset()
        doubtful = () if tone is None else made_by_tone(model, tone)
        if tone is None or not doubtful:
            return model, outcome
        taken = tone_on_rows(model, tone, doubtful)
        _close(model)
        model, outcome, _ = self._once(taken, model.known)
        held = orders_of(model)
        gone = [f for f in doubtful if min((abs(f - g) for g in held), default=np.inf) > APART]
        if gone:
            outcome.notes.append(
                f"no order at {', '.join(f'{f:g}' for f in gone)}: what acted there was the tone of"
                f" {tone.frequency:.3g} Hz, with which it is gone"
            )
        return model, outcome

    def reacts(self, model: TransmissionModel) -> bool:
        """Whether the load's reaction through the transmission error can be looked for in the motor torque."""
        data = self.data
        # a simulation from elsewhere has a reaction of its own
        simulated = {MOTOR_TORQUE, TRANSMISSION_ERROR} & data.simulated
        off = CHANNELS[MOTOR_TORQUE].fixed in self.given.switched_off
        return model.periodic is not None and MOTOR_TORQUE in self.channels and not (data.linear or simulated or off)

    def _beside_its_offset(self) -> tuple[TransmissionModel, ChannelOutcome, Tone | None]:
        """The model, its outcome and the tone that is heard in what it leaves: of a further search that knows the
        offset of the one before, where that may have misled the orders and less is left with the further one. It is
        made once, and once more if it was the first to find states.
        """
        best = self._once()
        while True:
            before, known = best[0].known, misleading(best[0])
            if known is None or (before is not None and known.states == before.states):
                return best
            _close(best[0])
            again = self._once(known=known)
            if not _leaves_less(again[1], best[1]):
                return best
            best = again

    def _once(
        self, taken: FloatArray | None = None, known: KnownOffset | None = None
    ) -> tuple[TransmissionModel, ChannelOutcome, Tone | None]:
        """The model whose orders are looked for with a tone ``taken`` off the rows (n,), and the offset that is
        ``known``; its outcome with what is left of it, and the tone that is heard there.
        """
        model = self._model(taken, known)
        if self.reacts(model):
            self._attribute_multiples(model)
        outcome = of_transmission(model, self.data, self.seed, self.formulas)
        assert model.offset is not None
        densities = self.data.density.get(TRANSMISSION_ERROR, ())
        examine(outcome, model.offset, densities, self.seed, None if self.data.linear else self._rings(outcome))
        return model, outcome, ask_for_tone(outcome, self.data, model, self.seed)

    def _rings(self, outcome: ChannelOutcome) -> RingDown | None:
        """Ringing after the load torque has changed its sign. Rows over the angle are mostly short enough for it."""
        frame, densities, fitted = outcome.rows.frame, self.data.density.get(LOAD_TORQUE, ()), self.data.folds() >= 0
        left = np.where(outcome.usable, outcome.left, np.nan)
        return ring_down(
            frame,
            densities,
            fitted,
            lambda some: (on_grid(frame, left, number) for number in some),
            self.data.folder.notch,
        )

    def _model(self, tone: FloatArray | None, known: KnownOffset | None) -> TransmissionModel:
        data, given, rows = self.data, self.given, self.rows
        taken = np.zeros(rows.size)
        given_waves = given.waves.get(TRANSMISSION_ERROR, ())
        if given_waves:
            taken = taken + waves.evaluate(given_waves, rows.frame.theta, rows.frame)
        for pulse in given.pulses:
            taken = taken + pulse.evaluate(rows.frame.theta)
        for part in given.over_input_angle():
            if part.coefficients is not None:
                taken = taken + part.regressor.columns(rows.frame) @ part.coefficients
        base = [*base_of(given, TRANSMISSION_ERROR, rows), *self.unnamed]
        series = GivenOrders(given.orders, data.folder.notch, given.laws)
        rows = replace(rows, y=rows.y - taken)
        beginning = begun(rows, data.folds(), series, base, given.switched_off, self.banned)
        if not beginning.revolutions:
            beginning.given = GivenOrders(())
            beginning.swings = Swings(data.folder.manner.free, data.cut)
        model = analyse(replace(beginning, tone=tone, known=known), self.seed)
        while known is not None:
            before, known = known, misleading(model)
            if known is None or known.moved > SETTLES * before.moved:
                break
            assert model.offset is not None
            model.offset.close()
            model = analyse(replace(beginning, tone=tone, known=known), self.seed)
        return model

    def _attribute_multiples(self, model: TransmissionModel) -> None:
        """Decide by the motor torque whose the multiples of the ratio are that were found in the transmission error."""
        data, given = self.data, self.given
        ratio, seen, periodic = float(data.gearbox.ratio or 1.0), model.seen, model.periodic
        assert periodic is not None
        # an order of which the simulation has waves or ripple is not seen as a whole
        part = {round(w.order, 6) for w in (*given.acting_waves, *given.misread_waves, *given.ripples)}
        candidates = [] if seen is None else [f for f in seen.orders if f not in known_orders(model) and f not in part]
        found = [f for f in multiples(candidates, ratio) if round(f / ratio) % PHASES]
        if seen is None or not found:
            return
        others = periodic.less({*found, *given.misread})
        folds = data.folds()
        reaction = reaction_of(others, model.rows.frame, model.inside, folds >= 0, 0.0, self.seed)
        if reaction is None or reaction.std is None:
            return
        fitted = frozenset(np.flatnonzero(folds >= 0).tolist())
        model.torque_check = torque_check(
            seen, model.revolutions, fitted, data.shaft, ratio, (reaction.share, reaction.std), found
        )


def _put(told: Discovery, state: bool, outcome: ChannelOutcome) -> None:
    """Put orders that follow something among an outcome's findings. How an order that the simulation has not depends on
    what is recorded is a property of that order; of a ``state`` nothing recorded tells. A law of the same orders, with
    one of several names that are not told apart, is a part of the same; and so is a smaller function of one quantity
    beside something without a name, whose form is known roughly.
    """
    names = {told.effect, *(a.effect for a in told.alternatives if a.as_good)}
    same = [d for d in outcome.discoveries if d.orders and set(d.orders) <= set(told.orders)]
    if told.status == AMBIGUOUS:
        same = [d for d in same if d.effect in names]
    elif told.effect == UNNAMED:
        size = strength(told, outcome)
        same = [d for d in same if d.effect in EFFECTS.values() and strength(d, outcome) < size]
    else:
        same = []
    outcome.discoveries = [d for d in outcome.discoveries if all(d is not law for law in same)]
    for law in same:
        told = _joined(told, law)
    plain = next((d for d in outcome.discoveries if d.effect == HARMONIC), None)
    if plain is None or state or not set(told.orders) <= set(plain.orders):
        outcome.discoveries.append(told)
        return
    rows = tuple({**row, "effect": HARMONIC} for row in told.simulation_rows)
    whole = _joined(plain, replace(told, simulation_rows=rows))
    outcome.discoveries = [whole if d is plain else d for d in outcome.discoveries]


def _joined(first: Discovery, second: Discovery) -> Discovery:
    """Two discoveries of the same orders as one, the first."""
    return replace(
        first,
        equation=f"{first.equation}; {second.equation}",
        parameters=first.parameters + second.parameters,
        added=first.added + second.added,
        excess=None if first.excess is None else first.excess + second.beyond,
        everywhere=None,
        simulation_rows=first.simulation_rows + second.simulation_rows,
        numbers=first.numbers + second.numbers,
    )


def _close(model: TransmissionModel) -> None:
    """Give back what the search of a model's offset holds."""
    assert model.offset is not None
    model.offset.close()


def _leaves_less(one: ChannelOutcome, other: ChannelOutcome) -> bool:
    """Whether ``one`` of two outcomes of the same rows leaves less of the fitted ones, recordings' means apart, and of
    those held out no more by more than the standard error from one recording to another.
    """
    rows, held = one.rows, one.held_out
    number = np.where(one.usable & ~held, rows.number, 0.0)
    recording = rows.frame.recording
    less, more = (float(number @ levelled(out.left, rows.frame, number) ** 2) for out in (one, other))
    if less >= more:
        return False
    better = (other.left**2 - one.left**2)[held]
    error = error_of_mean(better, recording[held], rows.number[held])
    return error is None or float(np.average(better, weights=rows.number[held])) > -criteria.ONE_ERROR * error


def orders_of(model: TransmissionModel | None) -> tuple[float, ...]:
    """Orders that the transmission error is known to have; none where it is not compared."""
    periodic = None if model is None else model.periodic
    return () if periodic is None else (*periodic.series.orders, *(w.order for w in periodic.weak))


def largest_of(model: TransmissionModel | None) -> tuple[float, ...]:
    """The largest amplitude of each of :func:`orders_of` in the revolutions, rad."""
    periodic = None if model is None else model.periodic
    if model is None or periodic is None:
        return ()
    seen = model.revolutions
    series = np.abs(periodic.series.vectors(states(seen), directions(seen))).max(axis=0)
    return (*series.tolist(), *(float(np.abs(w.at(design(w.model, seen))).max()) for w in periodic.weak))


def ask_for_tone(
    outcome: ChannelOutcome,
    data: Dataset,
    model: TransmissionModel | None,
    seed: int,
    inertia: float | None = None,
) -> Tone | None:
    """Ask for a tone in a channel; the tone, if there is one. The gearbox's orders, of which the ``model`` of the
    transmission error knows, are felt in the torques as well, by their ``inertia`` at the load side (kg·m²), most of
    all those that a mode makes large; None where no inertia says how much.
    """
    channel = outcome.channel
    known = () if channel == TEMPERATURE else orders_of(model)
    felt = None
    if known and inertia is not None:
        # what comes once a turn of the motor's shaft is also ripple, which no inertia makes
        of_shaft = np.isin(known, multiples(known, data.ratio))
        felt = [np.inf if own else inertia * size for own, size in zip(of_shaft, largest_of(model), strict=True)]
    runs = partial(runs_of, data, channel)
    unsteady = data.unsteady.get(channel, ())
    return look_for_tone(outcome, data.density.get(channel, ()), seed, known, unsteady, felt=felt, runs=runs)
