"""What stands above the noise and follows nothing that could predict it: located, described, and called unknown."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from bench.mismatch import lines
from bench.mismatch.channels import Analysis
from bench.mismatch.columns import RIPPLE_ORDERS
from bench.mismatch.dataset import Dataset
from bench.mismatch.evaluate import Scores
from bench.mismatch.findings import Finding
from bench.mismatch.locate import Location, conditions, strongest, text
from bench.mismatch.tones import search
from bench.mismatch.wander import Wander, wander
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR
from bench.simulation.terms.nominal.transmission_error import PAPER_ORDERS

TOO_MUCH = {"transmission_error": 1.3, "motor_torque": 1.08, "load_torque": 1.08, "temperature": 1.3}
"""held-out residual over the noise floor, beyond what folders without effect have shown"""
WANDERING = (MOTOR_TORQUE, LOAD_TORQUE)
FEWEST_TURNS = 10
"""steady revolutions a direction: as many as the polynomial has coefficients"""
LEAST_LINE = 0.02
"""of a channel's mean square: what a line has to make of it"""
LEAST_EXPLAINED = 0.7
"""part of a channel's excess (held out) that named terms have to explain to keep their names"""


def unexplained(
    data: Dataset,
    analysis: Analysis,
    scores: dict[str, Scores],
    slow: dict[str, Wander],
    explained: set[str],
    names: dict[int, str],
) -> list[Finding]:
    """Tones, lines and wander of every channel; and channels without a finding whose held-out residual stands above the
    noise.
    """
    out: list[Finding] = []
    for channel, score in scores.items():
        frame = _frame(analysis, channel)
        own = _tones(data, analysis, channel, score, frame, names)
        own += _lines(data, analysis, channel, score, frame, names) if not own else []
        if not own and channel in slow:
            own = [_wandering(slow[channel], channel, frame, score, names)]
        told = channel in explained or not determined(analysis, channel)
        if not own and not told and score.stands_out(TOO_MUCH[channel], frame.recording):
            own = [_residual(channel, score, frame, names, _unfollowed(analysis, channel))]
        out += own
    return out


def determined(analysis: Analysis, channel: str) -> bool:
    """Whether recordings are enough to calibrate a channel's simulation: a residual held out says nothing else.

    Each order of the transmission error follows a quadratic polynomial of three quantities in each direction.
    """
    harmonics = analysis.harmonics
    if channel != TRANSMISSION_ERROR or harmonics is None:
        return True
    driven = Counter(turn.direction > 0 for turn in harmonics.turns)
    return min(driven.values(), default=0) >= FEWEST_TURNS


def undetermined(analysis: Analysis, scores: dict[str, Scores]) -> str:
    """A sentence where a residual stands above the noise as so few recordings to calibrate with would leave it, too."""
    score = scores.get(TRANSMISSION_ERROR)
    if score is None or determined(analysis, TRANSMISSION_ERROR):
        return ""
    if not score.stands_out(TOO_MUCH[TRANSMISSION_ERROR], _frame(analysis, TRANSMISSION_ERROR).recording):
        return ""
    return (
        f"the transmission error of held-out recordings is {score.after / score.floor:.1f} times its noise, but its"
        f" series is calibrated on few steady revolutions: {FEWEST_TURNS} in each direction driven are needed to tell"
        " structure from that"
    )


def slow_structures(analysis: Analysis, scores: dict[str, Scores]) -> dict[str, Wander]:
    """What moves slowly inside the recordings and is no noise, by channel."""
    out: dict[str, Wander] = {}
    for channel in WANDERING:
        if channel in scores:
            model, score = analysis.models[channel], scores[channel]
            found = wander(score.residual_after, model.rows.frame, model.used, score.floor**2)
            if found is not None:
                out[channel] = found
    return out


def half_explained(analysis: Analysis, channel: str, score: Scores) -> bool:
    """Whether findings leave so much of a channel's excess that their names cannot be meant."""
    recordings = _frame(analysis, channel).recording
    excess = score.before**2 - score.floor**2
    if excess <= 0.0 or not score.stands_out(TOO_MUCH[channel], recordings):
        return False
    return (score.before**2 - score.after**2) / excess < LEAST_EXPLAINED


def _frame(analysis: Analysis, channel: str) -> Frame:
    if channel == TRANSMISSION_ERROR and analysis.transmission is not None:
        return analysis.transmission.angle.frame
    return analysis.models[channel].rows.frame


def _orders(analysis: Analysis, ratio: float) -> list[float]:
    """Orders that stand in the channels by themselves: the series', the motors' ripple, the motor encoder's."""
    harmonics = analysis.harmonics
    series = list(harmonics.series.orders) if harmonics is not None else list(PAPER_ORDERS)
    motor = [k * ratio for k in (1, 2, 3, 4, 6, 8, *(r.order for r in analysis.ripples))]
    return [*map(float, series), *RIPPLE_ORDERS, *motor]


def _tones(
    data: Dataset, analysis: Analysis, channel: str, score: Scores, frame: Frame, names: dict[int, str]
) -> list[Finding]:
    out = []
    for tone in search(data.tones.get(channel, []), _orders(analysis, data.ratio)):
        where = conditions(frame, np.ones(frame.size), ())
        label = f"at {tone.frequency:.2f} Hz whatever the speed, its phase new in every recording"
        recordings = [names[i] for i in tone.recordings if i in names][:5]
        share = tone.amplitude**2 / 2.0 / max(score.after**2, 1e-300)
        values: list[dict[str, Any]] = [
            {"symbol": "f", "value": tone.frequency, "unit": "Hz", "std": 0.5 * tone.bin_hz},
            {"symbol": "a", "value": tone.amplitude, "unit": _unit(channel), "std": tone.deviation},
        ]
        out.append(
            _unknown(
                channel,
                Location(label, where, recordings=recordings, share_of_excess=min(share, 1.0)),
                f"{channel} += a*sin(2*pi*f*t + phi), phi unknown in each recording",
                score,
                min(0.6 + 0.1 * tone.ratio, 0.95),
                values,
            )
        )
    return out


def _lines(
    data: Dataset, analysis: Analysis, channel: str, score: Scores, frame: Frame, names: dict[int, str]
) -> list[Finding]:
    spectra = data.lines.get(channel, [])
    known = _orders(analysis, data.ratio)
    if channel == TRANSMISSION_ERROR:
        harmonics = analysis.harmonics
        spectra = lines.of_turns(harmonics.turns) if harmonics is not None else []
    elif any("angle" in found.entry.variables for found in analysis.models[channel].found):
        return []  # what a narrow place of the turn leaves over stands at many orders
    else:
        known += [k * data.ratio for k in range(1, int(lines.HIGHEST / data.ratio) + 1)]
        # the notch is as good as the angle it is made over: what the series' orders do to that stands beside it
        known += [abs(ripple + sign * f) for ripple in RIPPLE_ORDERS for f in PAPER_ORDERS for sign in (1, -1)]
    found = [line for line in lines.search(spectra, known) if line.amplitude**2 > 2.0 * LEAST_LINE * score.after**2]
    if not found:
        return []
    where = conditions(frame, np.ones(frame.size), ())
    orders = sorted(round(line.order, 1) for line in found)
    label = f"{text(where, (), orders, [])}, its phase new in every recording"
    shown = [names[i] for i in dict.fromkeys(i for line in found for i in line.recordings) if i in names][:5]
    share = sum(line.amplitude**2 for line in found) / 2.0 / max(score.after**2, 1e-300)
    values: list[dict[str, Any]] = [
        {"symbol": f"A_{line.order:.1f}", "value": line.amplitude, "unit": _unit(channel), "std": line.deviation}
        for line in found
    ]
    location = Location(label, where, orders, [], None, shown, min(share, 1.0))
    equation = f"{channel} += A*sin(f*theta + phi), phi unknown in each recording"
    sure = min(0.6 + 0.1 * max(line.ratio for line in found), 0.95)
    return [_unknown(channel, location, equation, score, sure, values)]


def _wandering(slow: Wander, channel: str, frame: Frame, score: Scores, names: dict[int, str]) -> Finding:
    where = conditions(frame.take(score.rows), score.residual_after[score.rows], ())
    label = f"wanders within recordings, {slow.ratio:.1f} times as far as noise would, {text(where, (), [], [])}"
    return _unknown(
        channel,
        Location(label, where, recordings=[names[i] for i in slow.recordings if i in names]),
        f"{channel}: no function of one quantity follows it",
        score,
        0.8,
        [{"symbol": "s", "value": slow.deviation, "unit": _unit(channel), "std": slow.error}],
    )


def _unfollowed(analysis: Analysis, channel: str) -> list[float]:
    """Orders of the series that the rest of the transmission error stands at."""
    harmonics = analysis.harmonics
    if channel != TRANSMISSION_ERROR or harmonics is None:
        return []
    return lines.unfollowed(harmonics.turns, harmonics.series.orders)


def _residual(channel: str, score: Scores, frame: Frame, names: dict[int, str], orders: list[float]) -> Finding:
    own = frame.take(score.rows)
    residual: FloatArray = score.residual_after[score.rows]
    variables = ("speed", "torque", "temperature")
    where = conditions(own, residual, variables)
    label = f"residual above the noise, {text(where, variables, orders, [])}"
    return _unknown(
        channel,
        Location(label, where, orders, recordings=strongest(own, residual, names)),
        f"{channel}: no function of one quantity follows it",
        score,
        0.6,
        [],
    )


def _unit(channel: str) -> str:
    return {TRANSMISSION_ERROR: "rad", TEMPERATURE: "K"}.get(channel, "N*m")


def _unknown(
    channel: str, location: Location, equation: str, score: Scores, sure: float, values: list[dict[str, Any]]
) -> Finding:
    gain = float(score.after / score.floor)
    return Finding("unknown", "unknown", sure, channel, location, equation, values, gain, score.before, score.after)
