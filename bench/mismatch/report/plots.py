"""What is drawn of a finding: what is left without it and with it, over the quantity it depends on."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.discovery import ChannelOutcome
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.report.drawing import Pair, drawn
from bench.mismatch.report.finding import Finding
from bench.mismatch.report.location import by_recording, strongest
from bench.mismatch.report.variables import VARIABLES, VELOCITY, variable
from bench.simulation.frame import FloatArray, Frame, recording_starts
from bench.simulation.quantities import AUXILIARY
from bench.simulation.terms import MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR
from bench.simulation.waves import angle_from

UNITS: dict[str, tuple[str, float]] = {
    "transmission_error": ("µrad", 1e6),
    "motor_torque": ("N·m", 1.0),
    "load_torque": ("N·m", 1.0),
    "temperature": ("K", 1.0),
}
"""unit of a channel for people, and how many of it are in an SI unit"""
LINEAR_UNITS = UNITS | {"transmission_error": ("µm", 1e6), "motor_torque": ("N", 1.0), "load_torque": ("N", 1.0)}
BEYOND = 2.5
"""how far beyond its location, in speed, a finding is drawn: warm-ups are far faster than any operating point"""
ANGLES = 2048
"""points a revolution at which the transmission error is taken for its spectrum: orders up to half of them"""
AROUND = 25
"""orders drawn below the lowest and above the highest of a finding"""
PULSE_WIDTHS = 6.0
"""widths of an angle window drawn to either side of it"""
PULSE_PARTS = 60
"""points over an angle window"""
COURSES = ("transient", "elapsed")
"""a course of time from a recording's start is drawn of one recording"""


def plot(finding: Finding, data: Dataset) -> str:
    """An SVG of the finding; empty where there is nothing to draw."""
    unit, scale = (LINEAR_UNITS if data.linear else UNITS)[finding.channel]
    pair = _pair(finding, data, unit, scale)
    return "" if pair is None or pair.x.size == 0 else drawn(pair)


def _pair(finding: Finding, data: Dataset, unit: str, scale: float) -> Pair | None:
    found = finding.discovery
    if finding.channel == TRANSMISSION_ERROR and found.angle_windows:
        return _over_angle(finding, unit, scale)
    if finding.channel == TRANSMISSION_ERROR and found.orders:
        return _spectrum(finding, unit, scale)
    if finding.channel == MOTOR_TORQUE and found.squares is not None and found.orders:
        return _shaft(finding, data, unit)
    return _over_variable(finding, data, unit, scale)


def _over_variable(finding: Finding, data: Dataset, unit: str, scale: float) -> Pair:
    """What is left without and with the finding, and its own course, over the first quantity that can be drawn."""
    outcome, found = finding.outcome, finding.discovery
    frame = outcome.rows.frame
    rows = outcome.usable & (outcome.rows.number > 0)
    name = next((v for v in found.variables if v in VARIABLES), found.variables[0] if found.variables else "time")
    drawn_over = variable(name, data.linear)
    label, added, after = drawn_over.axis + _unit(name, data), found.added, outcome.left
    if finding.channel == TEMPERATURE:
        added, after = _centred(added, frame, rows), _centred(after, frame, rows)
    if name in COURSES:
        shown = strongest(by_recording(frame, np.where(rows, added**2 * outcome.rows.number, 0.0)))[:1]
        rows &= np.isin(frame.recording, shown)
        label += "".join(f", recording {data.name(r)}" for r in shown)
    if drawn_over.range == VELOCITY:
        near = np.abs(frame.velocity) <= BEYOND * finding.location.ranges[VELOCITY][1]
        rows = rows & near if (rows & near).any() else rows
    return Pair(
        drawn_over.values(frame)[rows],
        scale * (after + added)[rows],
        scale * after[rows],
        frame.last_direction[rows],
        label,
        unit,
        logarithmic=drawn_over.logarithmic,
        curve=scale * added[rows],
    )


def _unit(name: str, data: Dataset) -> str:
    """Unit of an auxiliary quantity behind its name, as the recordings have it; empty for others."""
    spec = data.members[0].recording.specs.get(name) if data.members and name.startswith(AUXILIARY) else None
    return f" / {spec.unit}" if spec is not None and spec.unit not in ("", "1") else ""


def _centred(values: FloatArray, frame: Frame, rows: NDArray[np.bool_]) -> FloatArray:
    """Less the mean of each recording: the level from which a recording starts is free."""
    count = np.maximum(np.bincount(frame.recording[rows], minlength=int(frame.recording.max()) + 1), 1)
    total = np.bincount(frame.recording[rows], values[rows], count.size)
    return np.asarray(values - (total / count)[frame.recording])


def _spectrum(finding: Finding, unit: str, scale: float) -> Pair | None:
    """Order spectrum of what is left in steady motion, without and with the orders: root mean square of recordings."""
    outcome, found = finding.outcome, finding.discovery
    sizes = [_amplitudes(outcome, values) for values in (outcome.left + found.added, outcome.left)]
    if any(size is None for size in sizes):
        return None
    low = max(1, int(min(found.orders)) - AROUND)
    high = min(ANGLES // 2 - 1, int(max(found.orders)) + AROUND)
    if high < low:
        return None
    shown = np.arange(low, high + 1)
    before, after = (scale * size[shown] for size in sizes if size is not None)
    label = "order per output revolution"
    return Pair(shown.astype(np.float64), before, after, np.ones(shown.size), label, unit, spectrum=True)


def _amplitudes(outcome: ChannelOutcome, values: FloatArray) -> FloatArray | None:
    """Amplitudes of whole orders (ANGLES/2,), mean square over recordings, root; None where none turns once."""
    frame, starts = outcome.rows.frame, recording_starts(outcome.rows.frame)
    squares, number = np.zeros(ANGLES // 2), 0
    good = outcome.usable & (outcome.rows.number > 0) & (frame.steady > 0.5)
    for a, b in itertools.pairwise(starts):
        rows = np.flatnonzero(good[a:b]) + a
        if rows.size < ANGLES:
            continue
        travelled = np.abs(frame.theta[rows] - frame.theta[rows[0]])
        whole = np.floor(float(travelled.max()) / (2.0 * np.pi) + 0.5 / ANGLES) * 2.0 * np.pi
        rows = rows[travelled <= whole]
        if whole <= 0.0 or rows.size == 0:
            continue
        bin_of_row = (np.mod(frame.theta[rows], 2.0 * np.pi) / (2.0 * np.pi) * ANGLES).astype(int) % ANGLES
        count = np.bincount(bin_of_row, minlength=ANGLES)
        mean = np.bincount(bin_of_row, values[rows], ANGLES) / np.maximum(count, 1)
        full = np.flatnonzero(count)
        course = np.interp(np.arange(ANGLES), full, mean[full], period=ANGLES)
        squares += np.abs(2.0 / ANGLES * np.fft.rfft(course)[: ANGLES // 2]) ** 2
        number += 1
    return np.sqrt(squares / number) if number else None


def _over_angle(finding: Finding, unit: str, scale: float) -> Pair:
    """Means over the output angle about the windows, without and with the finding."""
    outcome, found = finding.outcome, finding.discovery
    rows = outcome.usable & (outcome.rows.number > 0)
    angle = np.mod(outcome.rows.frame.theta[rows], 2.0 * np.pi)
    values = np.stack([(outcome.left + found.added)[rows], outcome.left[rows], found.added[rows]])
    number = outcome.rows.number[rows]
    angles: list[FloatArray] = []
    means: list[FloatArray] = []
    for begin, end in found.angle_windows:
        width = (end - begin) % (2.0 * np.pi)
        middle = begin + 0.5 * width
        distance = angle_from(angle, middle)
        near = np.abs(distance) <= min((PULSE_WIDTHS + 0.5) * width, np.pi)
        if not near.any() or width <= 0.0:
            continue
        step = width / PULSE_PARTS * (2.0 * PULSE_WIDTHS + 1.0)
        part = np.floor(distance[near] / step).astype(int)
        kept, part = np.unique(part, return_inverse=True)
        weight = np.maximum(np.bincount(part, number[near]), 1e-300)
        angles.append(np.degrees(np.mod(middle + (kept + 0.5) * step, 2.0 * np.pi)))
        means.append(np.stack([np.bincount(part, v[near] * number[near]) / weight for v in values]))
    if not angles:
        return Pair(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0), "", unit)
    x, y = np.concatenate(angles), scale * np.concatenate(means, axis=1)
    label = "output angle / deg"
    return Pair(x, y[0], y[1], np.ones(x.size), label, f"{unit}, means", curve=y[2])


def _shaft(finding: Finding, data: Dataset, unit: str) -> Pair | None:
    """Spectrum of the motor torque over the motor's angle, and the same less what of it the finding's orders hold."""
    if not data.shaft:
        return None
    amplitude = np.array([s.in_band for s in data.shaft])
    held = np.isfinite(amplitude)
    shown = np.flatnonzero(held.any(axis=0))
    squares = np.where(held, np.abs(np.where(held, amplitude, 0.0)) ** 2, 0.0).sum(axis=0)[shown]
    before = np.sqrt(squares / held.sum(axis=0)[shown])
    ratio = data.ratio
    of_finding = np.isin(shown, [round(f / ratio) for f in finding.discovery.orders])
    titles = ("measured", "of it, the finding's orders")
    label = "order per revolution of the motor"
    return Pair(
        shown.astype(np.float64),
        before,
        np.where(of_finding, before, 0.0),
        np.ones(shown.size),
        label,
        unit,
        True,
        titles=titles,
    )
