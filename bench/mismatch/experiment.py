"""The next experiment: a campaign whose points tell the remaining explanations of a finding apart.

Between rivals that are regressors the points are chosen by T-optimality (Atkinson and Fedorov, Biometrika 62 (1975)
57; Hunter and Reiner, Technometrics 7 (1965) 307): where one explanation were true, how far would the other, refitted
to all recordings and the new points together, be off? With the rival's design X on a point's rows, the covariance C of
its parameters from the recordings, and d the difference of the two predictions, the expected gain of log-likelihood is
dᵀ(σ²I + XCXᵀ)⁻¹d/2. Points are added one by one, each the one that raises the least gain over all pairs most.
Where no two regressors stand against each other, a table of experiments of the field is followed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.mismatch.candidates import Candidate, Range, candidates, frame_of
from bench.mismatch.channels import Analysis
from bench.mismatch.columns import RIPPLE_ORDERS, Entry
from bench.mismatch.dataset import Dataset
from bench.mismatch.findings import Finding, as_good
from bench.mismatch.linear import ChannelModel, Found, columns_of
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms import LIBRARY

POINTS = 4
MOST_RIVALS = 3
WARM = 0.5
ENOUGH = 40.0
"""expected gain of log-likelihood at which no further point is asked for"""


@dataclass(frozen=True, slots=True)
class Proposal:
    """Points to run in this order, and why."""

    why: str
    points: tuple[Candidate, ...]


def propose(finding: Finding, analysis: Analysis, out: Path, number: int, data: Dataset) -> None:
    """Write ``next-<number>.toml`` and put it into the finding; nothing where the recordings tell no range to run."""
    covered = Range.of(data)
    if data.linear or covered.fastest <= 0.0:
        return
    model = analysis.models.get(finding.channel)
    proposal: Proposal | None = None
    if finding.status == "ambiguous" and isinstance(finding.source, Found) and model is not None:
        proposal = separating(model, finding.source, covered, data.ratio)
    proposal = proposal or _by_rule(finding, covered)
    out.mkdir(parents=True, exist_ok=True)
    name = f"next-{number}.toml"
    (out / name).write_text(campaign(finding.name, number, proposal.points), encoding="utf-8")
    finding.next_experiment = {"why": proposal.why, "file": name, "points": [p.to_json() for p in proposal.points]}


def separating(model: ChannelModel, found: Found, covered: Range, ratio: float) -> Proposal | None:
    """The points at which a finding and its equals differ most, each refitted; None where none tells them apart."""
    rivals = [a.entry for a in found.alternatives if as_good(a, found)][:MOST_RIVALS]
    if not rivals or model.channel == "temperature":
        return None
    listed = list(candidates(covered))
    frames = [frame_of(c, covered, ratio) for c in listed]
    pairs = [pair for rival in rivals for pair in ((found.entry, rival), (rival, found.entry))]
    looks = [_Look(model, found.entry, true, wrong, frames) for true, wrong in pairs]
    chosen: list[int] = []
    least = 0.0
    while len(chosen) < POINTS and least < ENOUGH:
        gains = {k: min(look.gain([*chosen, k]) for look in looks) for k in range(len(listed)) if k not in chosen}
        # heating takes an hour: a point as found is worth as much at half the gain
        place = max(gains, key=lambda k: min(gains[k], 2.0 * ENOUGH) * (1.0 if listed[k].temperature is None else WARM))
        if gains[place] <= 1.01 * least:
            break
        least = gains[place]
        chosen.append(place)
    if not chosen:
        return None
    names = " and ".join(LIBRARY[e.effect].name for e in (found.entry, *rivals))
    why = (
        f"at these points {names} differ most, each refitted to everything measured: "
        f"expected gain of log-likelihood {least:.0f} at least"
    )
    return Proposal(why, tuple(listed[k] for k in chosen))


class _Look:
    """How far the explanation ``wrong`` would be off at each candidate if ``true`` holds; both calibrated."""

    def __init__(self, model: ChannelModel, own: Entry, true: Entry, wrong: Entry, frames: Sequence[Frame]) -> None:
        others = [e for e in model.chosen if e != own and e.effect != "unknown"]
        bank = model.search.bank
        self._parts: list[tuple[FloatArray, FloatArray]] = []
        index = [model.index([*others, e]) for e in (true, wrong)]
        fits = [bank.fit(i, leave_out=False) for i in index]
        self._covariance = fits[1].covariance
        self._variance = float(np.median(model.noise.sigma)) ** 2 + (
            0.0 if np.isinf(fits[1].offset_variance) else fits[1].offset_variance
        )
        for frame in frames:
            x = [_design(model, [*others, e], i, frame) for e, i in zip((true, wrong), index, strict=True)]
            self._parts.append((x[1], x[0] @ fits[0].coefficients - x[1] @ fits[1].coefficients))

    def gain(self, chosen: Sequence[int]) -> float:
        """Expected log-likelihood by which the points ``chosen`` together speak against the wrong explanation."""
        x = np.vstack([self._parts[k][0] for k in chosen])
        d = np.concatenate([self._parts[k][1] for k in chosen])
        # (σ²I + XCXᵀ)⁻¹ by the lemma of Woodbury: C may be large where the recordings determine little
        scale = np.sqrt(np.maximum(np.diag(self._covariance), 1e-300))
        inner = x * scale
        core = np.linalg.pinv(self._covariance / scale[:, None] / scale[None, :], rcond=1e-10)
        right = inner.T @ d / self._variance
        left = d @ d / self._variance - right @ np.linalg.solve(core + inner.T @ inner / self._variance, right)
        return float(max(0.5 * left, 0.0))


def _design(model: ChannelModel, entries: Sequence[Entry], index: Sequence[int], frame: Frame) -> FloatArray:
    """Regressors of the simulation and some entries at the rows of a candidate, in the order of ``index``.

    What belongs to single recordings (a level, the zero of a torque) is not there in a new one.
    """
    columns: dict[int, FloatArray] = {}
    known = iter(model.known)
    for effect, form_name, place in model.layout.base_effects:
        block = np.zeros((frame.size, len(place)))
        if effect == "notch":
            waves = [f(order * frame.q) for order in RIPPLE_ORDERS for f in (np.cos, np.sin)]
            block = np.column_stack([*waves, *(w * frame.load_motor_torque / 1000.0 for w in waves)])
        elif effect in LIBRARY:
            nominal = LIBRARY[effect].nominal
            form = next(f for f in LIBRARY[effect].forms[model.channel] if f.name == form_name)
            block = form.columns(frame, () if nominal else next(known)[2])
        columns |= {i: block[:, k] for k, i in enumerate(place) if k < block.shape[1]}
    for entry in entries:
        columns |= dict(zip(entry.index, columns_of(model.channel, entry, frame).T, strict=True))
    return np.column_stack([columns.get(i, np.zeros(frame.size)) for i in index])


_STEADY = ("te.lost_motion", "te.hysteresis", "te.stiffness_nonlinear", "sensor.torque_hysteresis")
_THERMAL = ("thermal.sensor_lag", "thermal.second_mass", "thermal.ambient_drift", "thermal.convection_speed")


def _by_rule(finding: Finding, covered: Range) -> Proposal:
    """Experiments of the field for what is located but has no regressor, or no rival that is one."""
    rivals = {finding.effect, *(a["effect"] for a in finding.alternatives)}
    warm = float(round(covered.warmest))
    speeds = [covered.fastest * share for share in (0.1, 0.2, 0.5, 1.0)]
    half = float(round(0.5 * covered.torque))
    words = finding.location.text
    if finding.channel == "temperature" or rivals & set(_THERMAL):
        why = "warm up, rest, cool down and warm up again: sensor, housing and surroundings answer at different times"
        steps = (
            ("heating", warm),
            ("dwell", None),
            ("cooling", float(round(covered.coldest + 6.0))),
            ("heating", warm),
        )
        return Proposal(why, tuple(Candidate(name, 0.0, 0.0, t, _rest(name)) for name, t in steps))
    if rivals & set(_STEADY) or "N·m" in words:
        why = "a torque staircase up and down, reversals under preload: path dependence shows, a function of torque not"
        told = (("amplitude", '"10 deg"'), ("cycles", "3"))
        stairs = Candidate(
            "torque_ramp", covered.torque, 0.5 * covered.fastest, None, (("steps", "5"), ("hold", '"2 s"'))
        )
        turns = [Candidate("reversal", t, 0.3 * covered.fastest, None, told) for t in (0.0, half)]
        return Proposal(why, (stairs, *turns))
    if "deg/s" in words or "order" in words:
        why = "slow and fast points close together, both ways: the laws of speed part, resonances stand at f·speed"
        return Proposal(why, tuple(Candidate("constant_velocity", 0.0, s * v) for v in speeds for s in (1.0, -1.0)))
    why = "the same points cold, warm, and cold again after a cooling: time goes on, the temperature comes back"
    points = [Candidate("constant_velocity", t, 0.5 * covered.fastest, c) for c in (None, warm) for t in (0.0, half)]
    cool = Candidate("cooling", 0.0, 0.0, float(round(covered.coldest + 6.0)))
    return Proposal(why, (*points, cool, *(Candidate(p.sequence, p.torque, p.velocity) for p in points[:2])))


def _rest(sequence: str) -> tuple[tuple[str, str], ...]:
    return (("duration", '"60 s"'),) if sequence == "dwell" else ()


def campaign(title: str, number: int, points: Sequence[Candidate]) -> str:
    """The points as a campaign file, a stage each so that they are run in this order."""
    lines = [
        f"# Tells apart what the recordings could not: {title}.",
        'format = "bench-campaign"',
        'format_version = "1.0"',
        f'name = "next-{number}"',
        f'title = "Next experiment {number}"',
    ]
    for k, point in enumerate(points):
        lines += ["", "[[stages]]", f'name = "step {k + 1}"', 'order = "listed"', "", "[[stages.points]]"]
        lines.append(f'sequence = "{point.sequence}"')
        if point.velocity:
            lines.append(f'velocities = ["{np.degrees(point.velocity):.4g} deg/s"]')
        if point.torque:
            lines.append(f'load_torques = ["{point.torque:g} N*m"]')
        if point.temperature is not None:
            lines.append(f'temperatures = ["{point.temperature:g} degC"]')
        if point.options:
            lines.append("options = { " + ", ".join(f"{key} = {value}" for key, value in point.options) + " }")
    return "\n".join(lines) + "\n"


__all__ = ["Proposal", "campaign", "propose", "separating"]
