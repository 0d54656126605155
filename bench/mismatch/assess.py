"""One comparison of a data set with a given simulation: search, scores on what was held out, findings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.mismatch import evaluate
from bench.mismatch.channels import Analysis, analyse_channels
from bench.mismatch.comparable import INPUTS
from bench.mismatch.conclude import conclude
from bench.mismatch.dataset import Dataset
from bench.mismatch.evaluate import Scores
from bench.mismatch.findings import Finding
from bench.mismatch.given import Given
from bench.mismatch.linear import ChannelModel, dropped
from bench.mismatch.motor_ripple import Ripple
from bench.simulation.terms import MOTOR_TORQUE, TRANSMISSION_ERROR

Progress = Callable[[str, float], None]
FEWEST = 6
"""recordings (or blocks) that can be fitted, below which noise and structure are not told apart"""

WORSE = 1.01
"""held-out residual after, over that before, from which nothing found in a channel is believed"""


@dataclass(slots=True)
class Assessment:
    """What a comparison found: the channels' models, their scores by channel, the findings, strongest first."""

    analysis: Analysis
    scores: dict[str, Scores]
    findings: list[Finding]


def assess(data: Dataset, given: Given, channels: Sequence[str], progress: Progress | None = None) -> Assessment:
    """Compare the recordings of ``data`` with the simulation ``given`` in ``channels``."""
    tell = progress or (lambda _what, _share: None)
    tell("searching the channels", 0.0)
    analysis = analyse_channels(data, given, channels)
    tell("scoring what was held out", 0.9)
    evidence = _gated(analysis, data)
    scores = _scores(analysis, data, given, channels)
    for channel in [c for c, score in scores.items() if score.after > WORSE * score.before]:
        _take_back(analysis, channel)
        scores[channel] = _scores(analysis, data, given, [channel])[channel]
    return Assessment(analysis, scores, conclude(data, analysis, scores, evidence))


def channels_of(data: Dataset) -> tuple[list[str], list[str]]:
    """Channels that can be compared, and a sentence for each that cannot."""
    present = {name for m in data.members for name in m.recording.channels}
    out: list[str] = []
    skipped: list[str] = []
    for channel, (made_of, _) in INPUTS.items():
        missing = [name for name in made_of if name not in present]
        if missing:
            skipped.append(f"{channel} is not compared: the recordings have no {', '.join(missing)}")
        elif not _rows(data, channel):
            skipped.append(f"{channel} is not compared: no recording has a usable sample of it in motion")
        else:
            out.append(channel)
    return out, skipped


def _rows(data: Dataset, channel: str) -> int:
    """Rows of a channel in the recordings that can be fitted."""
    rows = {"temperature": data.heat, TRANSMISSION_ERROR: data.angle}.get(channel, data.slow.get(channel))
    if rows is None:
        return 0
    fitted = ~np.isin(rows.frame.recording, list(data.held_out()))
    moving = np.ones(fitted.size, dtype=bool) if channel == "temperature" else rows.frame.direction != 0
    return int(np.sum(fitted & moving & (rows.number > 0)))


def _usable(model: ChannelModel, analysis: Analysis) -> NDArray[np.bool_]:
    if model.channel == TRANSMISSION_ERROR and analysis.transmission is not None:
        return analysis.transmission.slow_inside
    return model.rows.frame.direction != 0 if model.channel != "temperature" else model.rows.number > 0


def _gated(analysis: Analysis, data: Dataset) -> dict[tuple[str, str], tuple[float, float]]:
    """Take back what held-out recordings refute; their root mean squares without and with each finding that stays."""
    held = data.held_out()
    out: dict[tuple[str, str], tuple[float, float]] = {}
    if analysis.transmission is not None:
        evaluate.gate_harmonics(analysis.transmission, held)
    for channel, model in analysis.models.items():
        for effect, pair in evaluate.gate(model, _usable(model, analysis), held).items():
            out[channel, effect] = pair
    return out


def _take_back(analysis: Analysis, channel: str) -> None:
    """Take everything found in a channel back: together it makes recordings that selected nothing worse."""
    whole = analysis.transmission
    if channel == TRANSMISSION_ERROR and whole is not None and whole.harmonics is not None:
        whole.harmonics = whole.harmonics.without_law().without(whole.harmonics.peaks)
    model = analysis.models[channel]
    for found in list(model.found):
        dropped(model, found.entry)


def _scores(analysis: Analysis, data: Dataset, given: Given, channels: Sequence[str]) -> dict[str, Scores]:
    held = data.held_out()
    out: dict[str, Scores] = {}
    for channel in channels:
        if channel == TRANSMISSION_ERROR:
            if analysis.transmission is not None:
                out[channel] = evaluate.transmission(analysis.transmission, held)
        elif channel in analysis.models:
            model = analysis.models[channel]
            known = _variance(given.ripples, data) if channel == MOTOR_TORQUE else 0.0
            found = _variance(analysis.ripples, data) if channel == MOTOR_TORQUE else 0.0
            out[channel] = evaluate.linear(model, _usable(model, analysis), held, found, known)
    return out


def _variance(ripples: Sequence[Ripple], data: Dataset) -> float:
    """Variance of a sum of sines in the recordings scored, weighted by their samples."""
    held = data.held_out()
    scored = [s for s in data.shaft if s.recording in held] or data.shaft
    size = [(s.spread / max(s.sigma, 1e-300)) ** 2 for s in scored]
    power = [sum(0.5 * abs(r.of(s.torque)) ** 2 for r in ripples) for s in scored]
    return float(np.average(power, weights=size)) if scored else 0.0
