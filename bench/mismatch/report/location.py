"""Where a finding acts: the smallest ranges that hold nine tenths of the energy of what it adds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.discovery import ABOVE, BELOW, NAMED, UNNAMED, ChannelOutcome, Discovery
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.regression import windows
from bench.mismatch.report.figures import energy
from bench.mismatch.report.smallest import box, interval, pieces, steps
from bench.mismatch.report.truth import truth_of
from bench.mismatch.report.variables import RANGES, TEMPERATURE, TIME, TORQUE, VELOCITY, levels, variable
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.quantities import made_of
from bench.simulation.terms import MOTOR_TORQUE
from bench.simulation.terms import TEMPERATURE as TEMPERATURE_CHANNEL

HELD = 0.9
"""share of the energy that a location holds, its recordings too: the report's contract"""
STEPS = {"te.lost_motion": TORQUE}
"""effects that are a step, and over what: they are where they change, not where they have changed. An effect that the
recordings do not tell from one that is no step is where it adds something
"""
PARTS = 60
"""of the range over which a step is looked for"""
ALIKE_PARTS = 8
"""of the range of a quantity that both directions have, inside which they are compared"""
LEAST_SHARED = 0.5
"""share of an effect's energy in the parts that both directions have, below which these do not tell its direction"""
JUST_AFTER = ("since_reversal",)
"""variables of effects that act just after a start or a reversal"""
LOAD = "load"
"""quantity that is the size of the load torque, whichever its sign"""
DELAY = "sensor.timing_skew"
"""effect that goes with the rate of the load torque"""
BOTH, POSITIVE, NEGATIVE = "both", "positive", "negative"

Range = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Location:
    """The report's location of a finding; ranges in rad/s, N·m, °C. ``outside`` (range -> shares of the samples below
    and above it) says how it is put in words.
    """

    ranges: dict[str, Range]
    span: dict[str, Range]
    direction: str
    depends: tuple[str, ...]
    outside: dict[str, Range]
    orders: tuple[float, ...]
    angle_windows: tuple[Range, ...]
    time_window: Range | None
    """POSIX times"""
    recordings: tuple[str, ...]
    unmeasured: tuple[str, ...] = ()
    """ranges of quantities that no recording has: they are told to nobody"""
    words: tuple[str, ...] = ()
    """further words on where it acts, which no range says"""
    in_words: tuple[str, ...] = ()
    """ranges of which the words say more than their limits do"""

    @property
    def time_window_iso(self) -> list[str] | None:
        """The time window as two ISO 8601 times, UTC."""
        return None if self.time_window is None else [_iso(t) for t in self.time_window]


def location_of(discovery: Discovery, outcome: ChannelOutcome, data: Dataset) -> Location:
    """The location of a discovery, by the energy of what it adds on the rows that are compared."""
    energies = _energy(discovery, outcome)
    quantities = [variable(part) for name in discovery.variables for part in made_of(name)]
    depends = tuple(name for name in RANGES if any(v.range == name for v in quantities))
    frame, usable = outcome.rows.frame, outcome.usable & (outcome.rows.number > 0)
    # what the recordings cover that are compared: of some their starts are not
    covered = np.isin(frame.recording, np.unique(frame.recording[usable])) & (outcome.rows.number > 0)
    span = {name: _span(levels(frame, name)[covered]) for name in RANGES}
    ranges = span | _ranges(discovery, outcome, energies, depends, covered)
    weight = np.where(usable, outcome.rows.number, 0.0)
    beyond = _beyond(discovery, ranges)
    swinging = _with_swings(discovery, outcome, energies, data)
    return Location(
        ranges,
        span,
        _direction(frame, np.where(weight > 0, 1.0, 0.0) if _heat(discovery) else swinging, weight, depends),
        depends,
        {name: _outside(levels(frame, name), weight, ranges[name]) for name in depends},
        discovery.orders,
        discovery.angle_windows,
        _time_window(discovery, frame, energies, any(v.range == TIME for v in quantities), data.folder.start),
        tuple(data.name(r) for r in strongest(of_recordings(discovery, outcome, energies, data))),
        tuple(name for name, by in MEASURED_BY.items() if not set(by) & data.present),
        tuple(dict.fromkeys([*(v.words for v in quantities if v.words), *beyond])),
        (TORQUE,) if beyond else (),
    )


def _energy(discovery: Discovery, outcome: ChannelOutcome) -> FloatArray:
    """Energy (n,) of what a discovery adds.

    An effect that acts just after a start or a reversal has its energy also at the rows that are not compared because
    the speed changes fast: as much as it adds to as many samples.
    """
    plain_energy = energy(discovery, outcome)
    if discovery.effect == UNNAMED or tuple(discovery.variables) != JUST_AFTER:
        return plain_energy
    rows, frame = outcome.rows, outcome.rows.frame
    lasting = (rows.number > 0) & (frame.step > 0)
    if not lasting.any():
        return plain_energy
    missing = np.where(frame.direction != 0, frame.step * np.median(rows.number[lasting] / frame.step[lasting]), 0.0)
    return np.asarray(np.where(outcome.usable & (rows.number > 0), plain_energy, discovery.beyond**2 * missing))


def _ranges(
    discovery: Discovery,
    outcome: ChannelOutcome,
    energies: FloatArray,
    depends: Sequence[str],
    covered: NDArray[np.bool_],
) -> dict[str, Range]:
    """Smallest ranges of the quantities a discovery depends on, that together hold nine tenths of its energy; of one
    side of a limit all that rows of the recordings have that are ``covered`` (n,).
    """
    frame = outcome.rows.frame
    if discovery.side is not None:
        return _of_side(*discovery.side, frame, covered)
    step = STEPS.get(discovery.effect) if discovery.status == NAMED else None
    if step is not None:
        weight = np.where(outcome.usable, outcome.rows.number, 0.0)
        # what is added changes with other quantities as well, by what the simulation, refitted, makes of them
        term = truth_of(discovery)
        course = discovery.added if term is None else term.on(frame)
        found = pieces(*steps(levels(frame, step), course, weight, PARTS), HELD) if weight.any() else None
        return {} if found is None else {step: found}
    return box({name: levels(frame, name) for name in depends}, energies, HELD)


def _of_side(name: str, side: str, limit: float, frame: Frame, usable: NDArray[np.bool_]) -> dict[str, Range]:
    """All states on one side of a limit that the ``usable`` rows (n,) have: where nothing but states tells where it
    acts, those of a few settings stand for what lies between them and the limit.
    """
    target = variable(name).range
    if target not in RANGES:
        return {}
    low, high = _span(levels(frame, target)[usable])
    if name == LOAD and side == BELOW:
        return {target: (max(low, -limit), min(high, limit))}
    if name == LOAD and low < -limit:
        return {target: (low, high if high > limit else -limit)}
    return {target: (low, limit) if side == BELOW else (limit, high)}


def _beyond(discovery: Discovery, ranges: dict[str, Range]) -> list[str]:
    """What a range that holds both signs of the load does not say: that the effect acts at large ones."""
    if discovery.side is None or discovery.side[:2] != (LOAD, ABOVE):
        return []
    limit = discovery.side[2]
    return [f"beyond ±{limit:.3g} N·m"] if ranges[TORQUE][0] < -limit < limit < ranges[TORQUE][1] else []


def _heat(discovery: Discovery) -> bool:
    """Whether a discovery is a term of the heat balance: none of them knows which way the gearbox turns."""
    return discovery.channel == TEMPERATURE_CHANNEL and discovery.effect != UNNAMED


def _span(values: FloatArray) -> Range:
    return (float(values.min()), float(values.max())) if values.size else (0.0, 0.0)


def _outside(values: FloatArray, weight: FloatArray, inside: Range) -> Range:
    """Shares of the samples that lie below and above a range."""
    total = max(float(weight.sum()), 1e-300)
    below, above = float(weight[values < inside[0]].sum()), float(weight[values > inside[1]].sum())
    return below / total, above / total


def _direction(frame: Frame, energies_of_rows: FloatArray, weight: FloatArray, depends: Sequence[str]) -> str:
    """The direction that holds nine tenths of the energy, not only because the bench ran mostly that way, or warmed up
    at a speed of no other recording: both are asked as well where both directions were driven, and at like values of
    the quantities that the effect ``depends`` on. Where these hold little of the energy the direction is not known.
    """
    forward = frame.last_direction > 0
    if min(weight[forward].sum(), weight[~forward].sum()) <= 0.0:
        return POSITIVE if weight[forward].sum() > 0.0 else NEGATIVE
    alike = weight > 0
    cell = np.zeros(frame.size, dtype=np.int64)
    for name in RANGES:
        values = levels(frame, name)
        spans = [_span(values[side & (weight > 0)]) for side in (forward, ~forward)]
        low, high = max(low for low, _ in spans), min(high for _, high in spans)
        alike &= (values >= low) & (values <= high)
        if name in depends:
            part = np.clip((values - low) / max(high - low, 1e-300) * ALIKE_PARTS, 0.0, ALIKE_PARTS - 1.0)
            cell = ALIKE_PARTS * cell + part.astype(np.int64)
    both = [alike & side for side in (forward, ~forward)]
    if not all(rows.any() for rows in both):
        both = [forward, ~forward]
    whole = [float(energies_of_rows[side].sum()) for side in (forward, ~forward)]
    energies = [float(energies_of_rows[rows].sum()) for rows in both]
    weights = [np.bincount(cell[rows], weight[rows], int(cell.max()) + 1) for rows in both]
    shared = np.min(weights, axis=0) > 0.0
    sums = [np.bincount(cell[rows], energies_of_rows[rows], shared.size)[shared] for rows in both]
    means = [float(np.sum(each / w[shared])) for each, w in zip(sums, weights, strict=True)]
    if sum(float(each.sum()) for each in sums) < LEAST_SHARED * sum(energies):
        return BOTH  # where it acts only one direction was driven: nothing tells what it does in the other
    for side, name in enumerate((POSITIVE, NEGATIVE)):
        if all(each[side] >= HELD * sum(each) > 0.0 for each in (whole, energies, means)):
            return name
    return BOTH


def _time_window(discovery: Discovery, frame: Frame, energies: FloatArray, depends: bool, start: float) -> Range | None:
    window = discovery.time_window
    if discovery.side is not None and discovery.side[0] == TIME:
        _, side, limit = discovery.side
        window = (float(frame.time.min()), limit) if side == BELOW else (limit, float(frame.time.max()))
    if window is None and depends:
        window = interval(frame.time, energies, HELD * float(energies.sum()))
    return None if window is None else (start + window[0], start + window[1])


def of_recordings(discovery: Discovery, outcome: ChannelOutcome, energies: FloatArray, data: Dataset) -> FloatArray:
    """Energy of a discovery in each recording (recordings,); ``energies`` (n,) of the rows that are compared."""
    rows = outcome.rows
    recording, compared = rows.frame.recording, outcome.usable & (rows.number > 0)
    if discovery.everywhere is not None:
        has_rows = np.bincount(recording, compared) > 0.0
        energies = np.where(has_rows[recording], discovery.everywhere**2 * rows.number, 0.0)
    return by_recording(rows.frame, _with_swings(discovery, outcome, energies, data))


def _with_swings(discovery: Discovery, outcome: ChannelOutcome, energies: FloatArray, data: Dataset) -> FloatArray:
    """Energies of rows (n,) with what a delay adds to swings faster than a row lasts: they are late as well."""
    if discovery.effect != DELAY:
        return energies
    rows = outcome.rows
    size = float(discovery.parameters[0]["value"]) / (rows.frame.ratio if outcome.channel == MOTOR_TORQUE else 1.0)
    swings = np.array([data.swing.get(r, 0.0) for r in range(int(rows.frame.recording.max(initial=-1)) + 1)])
    compared = outcome.usable & (rows.number > 0)
    return np.asarray(energies + size**2 * np.where(compared, rows.number * swings[rows.frame.recording], 0.0))


def by_recording(frame: Frame, values: FloatArray) -> FloatArray:
    """Sum of ``values`` (n,) over the rows of each recording (recordings,)."""
    return np.asarray(np.bincount(frame.recording, values), dtype=np.float64)


def strongest(energies: FloatArray) -> list[int]:
    """Recordings of the largest of ``energies`` (recordings,), in order: the fewest that hold ``HELD`` of it."""
    return windows.strongest(np.maximum(energies, 0.0)).tolist() if energies.size else []


def _iso(posix: float) -> str:
    return datetime.fromtimestamp(posix, UTC).isoformat(timespec="seconds").replace("+00:00", "Z")


def _limits(ranges: dict[str, Range], where: Location) -> dict[str, Any]:
    return {name: None if name in where.unmeasured else list(limits) for name, limits in ranges.items()}


MEASURED_BY = {TORQUE: ("load_torque", "load_motor_torque"), TEMPERATURE: ("temperature",)}
"""channels that tell a range's quantity; the velocity is that of what is compared"""


def to_json(where: Location, words: str, share: float | None) -> dict[str, Any]:
    """The location as the report has it."""
    return {
        "text": words,
        "conditions": _limits(where.ranges, where) | {"direction": where.direction},
        "span": _limits(where.span, where),
        "orders": list(where.orders),
        "angle_windows": [list(w) for w in where.angle_windows],
        "time_window": where.time_window_iso,
        "recordings": list(where.recordings),
        "share_of_excess": share,
    }


__all__ = ["HELD", "VELOCITY", "Location", "by_recording", "location_of", "strongest", "to_json"]
