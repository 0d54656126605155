"""From the channels' models to findings: one an effect, across channels, with what cannot be told said."""

from __future__ import annotations

from typing import Any

import numpy as np

from bench.mismatch.channels import SENSOR_ERRORS, Analysis
from bench.mismatch.dataset import Dataset
from bench.mismatch.evaluate import Scores
from bench.mismatch.findings import Finding, alternatives_json, as_good, confidence, free_equation, parameters
from bench.mismatch.judge import Found
from bench.mismatch.linear import ChannelModel, columns_at, columns_of
from bench.mismatch.locate import Location, conditions, strongest, text, time_window
from bench.mismatch.peaks import Peak
from bench.mismatch.rivals import strongest_orders
from bench.mismatch.unexplained import half_explained, slow_structures, unexplained
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.laws import Law, factor
from bench.simulation.terms import LIBRARY, LOAD_TORQUE, MOTOR_TORQUE, TRANSMISSION_ERROR

Evidence = dict[tuple[str, str], tuple[float, float]]


def conclude(data: Dataset, analysis: Analysis, scores: dict[str, Scores], evidence: Evidence) -> list[Finding]:
    """Findings of all channels, one an effect, strongest first."""
    names = {m.index: m.name for m in data.members}
    out: list[Finding] = []
    for channel, model in analysis.models.items():
        for found in model.found:
            out.append(_linear(channel, model, found, scores[channel], names, data.campaign_start))
    if analysis.transmission is not None and analysis.transmission.harmonics is not None:
        out += _harmonic(analysis, scores[TRANSMISSION_ERROR], names, data)
    if analysis.ripples:
        out += _ripples(analysis, scores[MOTOR_TORQUE], data)
    _load_motor(out, analysis)
    for finding in out:
        pair = evidence.get((finding.channel, finding.source.entry.effect if isinstance(finding.source, Found) else ""))
        if pair is not None:
            finding.rmse_before, finding.rmse_after = pair
    doubted = {c for c, score in scores.items() if c != TRANSMISSION_ERROR and half_explained(analysis, c, score)}
    slow = slow_structures(analysis, scores)
    out = [f for f in out if f.channel not in doubted | set(slow)]
    out += unexplained(data, analysis, scores, slow, {f.channel for f in out}, names)
    merged = _merged(out, analysis)
    return sorted(merged, key=lambda f: -f.gain)


def _contribution(model: ChannelModel, found: Found, frame: Frame) -> FloatArray:
    """What a finding adds at rows."""
    if found.entry.effect == "unknown":
        columns = columns_at(model, found.entry, frame)
    else:
        columns = columns_of(model.channel, found.entry, model.rows.frame)[model.used]
    return np.asarray(columns @ found.coefficients)


def _beyond_base(model: ChannelModel, effect: FloatArray) -> FloatArray:
    """What of a free function's contribution the simulation's own terms could not have said: where it really acts."""
    base = model.layout.columns[:, list(model.layout.base)]
    if base.shape[1] == 0:
        return effect
    scale = np.maximum(np.sqrt(np.mean(base**2, axis=0)), 1e-300)
    return np.asarray(effect - base / scale @ np.linalg.lstsq(base / scale, effect, rcond=1e-9)[0])


def _linear(
    channel: str, model: ChannelModel, found: Found, score: Scores, names: dict[int, str], start: float
) -> Finding:
    frame = model.rows.frame.take(model.used)
    effect = _contribution(model, found, frame)
    entry = found.entry
    unknown = entry.effect == "unknown"
    variables = entry.variables
    where = conditions(frame, _beyond_base(model, effect) if unknown else effect, variables)
    orders = [entry.point[0]] if entry.effect == "friction.position_dependent" else []
    if entry.effect == "load.unbalance":
        orders = [1.0]
    if unknown and "angle" in variables:
        orders = strongest_orders(found.coefficients)
    label = text(where, variables, orders, [])
    if unknown:
        label = f"{entry.form}: {label}"
    share = _share(score)
    location = Location(label, where, orders, [], None, strongest(frame, effect, names), share)
    if "time" in variables:
        location.time_window = time_window(frame, effect, start)
    close = [a for a in found.alternatives if as_good(a, found)] if not unknown else []
    status = "unknown" if unknown else "ambiguous" if close else "named"
    loss = min((a.loss for a in found.alternatives if not a.contains), default=100.0)
    name = "unknown" if unknown else entry.effect
    return Finding(
        name,
        status,
        confidence(status, found.gain, loss),
        channel,
        location,
        free_equation(channel, found) if unknown else LIBRARY[name].equation,
        parameters(channel, found) if not unknown or entry.point else [],
        found.gain,
        score.before,
        score.after,
        alternatives_json(found, score.after),
        numbers=entry.numbers,
        source=found,
        form=entry.form,
        point=entry.point,
    )


def _share(score: Scores) -> float:
    excess = score.before**2 - score.floor**2
    return float(np.clip((score.before**2 - score.after**2) / excess, 0.0, 1.0)) if excess > 0 else 0.0


def _harmonic(analysis: Analysis, score: Scores, names: dict[int, str], data: Dataset) -> list[Finding]:
    model = analysis.transmission
    assert model is not None
    assert model.harmonics is not None
    rows = model.inside & (model.angle.frame.steady > 0.5)
    frame = model.angle.frame.take(rows)
    out: list[Finding] = []
    groups: dict[str, list[Peak]] = {}
    for peak in model.harmonics.peaks:
        groups.setdefault(_peak_effect(peak, data.ratio), []).append(peak)
    for effect, peaks in groups.items():
        gain = float(sum(p.gain for p in peaks))
        orders = sorted({float(f) for p in peaks for f in p.orders})
        windows = _windows(peaks)
        where = conditions(frame, np.ones(frame.size), ())
        location = Location(text(where, (), orders, windows), where, orders, windows, None, [], _share(score))
        location.recordings = [names[t.recording] for t in model.harmonics.turns[:5] if t.recording in names]
        out.append(
            Finding(
                effect,
                "named",
                confidence("named", gain, gain),
                TRANSMISSION_ERROR,
                location,
                LIBRARY[effect].equation,
                _peak_parameters(peaks),
                gain,
                score.before,
                score.after,
                numbers=2 * max(len(orders), 2),
                source=peaks,
            )
        )
    law = model.harmonics.law
    if law is not None:
        out.append(_law(law, frame, score, names))
    return out


def _ripples(analysis: Analysis, score: Scores, data: Dataset) -> list[Finding]:
    """Orders of the motor shaft in the motor torque: 6k of its electrical period are ripple, others have no name."""
    frame = analysis.models[MOTOR_TORQUE].rows.frame
    where = conditions(frame.take(frame.steady > 0.5), np.ones(int((frame.steady > 0.5).sum())), ())
    out: list[Finding] = []
    for effect, chosen in (
        ("motor.torque_ripple", [r for r in analysis.ripples if r.order % 6 == 0]),
        ("unknown", [r for r in analysis.ripples if r.order % 6 != 0]),
    ):
        if not chosen:
            continue
        orders = sorted(r.order * data.ratio for r in chosen)
        gain = sum(r.gain for r in chosen)
        named = effect != "unknown"
        values = [
            {
                "symbol": f"a_{r.order}",
                "value": abs(r.amplitude),
                "unit": "N*m",
                "std": abs(r.amplitude) / np.sqrt(2 * r.gain),
            }
            for r in chosen
        ]
        motor = ", ".join(str(r.order) for r in chosen)
        growing = ", in proportion to the motor's torque" if any(r.at for r in chosen) else ""
        label = f"at order {motor} of the motor{growing}, {text(where, (), orders, [])}"
        names = [m.name for m in data.members if m.recording.kind == "constant_velocity"][:3]
        out.append(
            Finding(
                effect,
                "named" if named else "unknown",
                confidence("named" if named else "unknown", gain, gain),
                MOTOR_TORQUE,
                Location(label, where, orders, [], None, names, _share(score)),
                LIBRARY[effect].equation if named else "tau_m += a*cos(n*u*theta) + b*sin(n*u*theta)",
                values,
                gain,
                score.before,
                score.after,
                numbers=2 * len(chosen),
                source=chosen,
            )
        )
    return out


def _peak_effect(peak: Peak, ratio: float) -> str:
    if peak.kind == "sideband":
        return "te.sideband"
    if peak.kind == "pulse":
        return "te.local_defect"
    order = peak.orders[0]
    motor = order / ratio
    if abs(motor - round(motor)) < 0.5 / ratio and round(motor) >= 1 and peak.model == "constant":
        return "sensor.motor_encoder"
    return "te.harmonic"


def _windows(peaks: list[Peak]) -> list[list[float]]:
    """Angle windows of pulses; those that touch become one."""
    spans = sorted([p.angle - 2.0 * p.width, p.angle + 2.0 * p.width] for p in peaks if p.kind == "pulse")
    out: list[list[float]] = []
    for a, b in spans:
        if out and a <= out[-1][1] + 0.02:
            out[-1][1] = max(out[-1][1], b)
        else:
            out.append([a, b])
    return [[a % (2 * np.pi), b % (2 * np.pi)] if a < 0 or b > 2 * np.pi else [a, b] for a, b in out]


def _peak_parameters(peaks: list[Peak]) -> list[dict[str, Any]]:
    out: list[dict[str, Any]] = []
    for peak in peaks:
        if peak.kind == "pulse":
            out += [
                {"symbol": "p", "value": peak.height, "unit": "rad", "std": abs(peak.height) * 0.05},
                {"symbol": "theta_p", "value": peak.angle, "unit": "rad", "std": peak.width * 0.1},
                {"symbol": "w_p", "value": peak.width, "unit": "rad", "std": peak.width * 0.3},
            ]
        for order, coefficients in zip(peak.orders, peak.coefficients, strict=True):
            size = float(np.abs(coefficients[0]))
            unit = "1" if peak.kind == "sideband" else "rad"
            out.append(
                {"symbol": f"A_{order}", "value": size, "unit": unit, "std": size / max(np.sqrt(2 * peak.gain), 1.0)}
            )
    return out


def _law(law: Law, frame: Frame, score: Scores, names: dict[int, str]) -> Finding:
    name = law.effect
    x = np.column_stack([frame.torque, frame.velocity, frame.temperature])
    change = np.abs(factor(law, x, frame.time, law.orders) - 1.0).max(axis=1)
    where = conditions(frame, change, law.variables)
    unknown = name == "unknown"
    symbols = {"te.resonance": (("w_0", "rad/s"), ("zeta", "1"), ("p", "1"))}.get(name, (("scale", "1"),))
    label = text(where, law.variables, law.orders, [])
    return Finding(
        name,
        "unknown" if unknown else "named",
        confidence("unknown" if unknown else "named", law.gain, law.gain),
        TRANSMISSION_ERROR,
        Location(
            f"{law.form}: {label}" if unknown else label,
            where,
            [float(f) for f in law.orders],
            [],
            None,
            list(names.values())[:3],
            _share(score),
        ),
        LIBRARY[name].equation if name in LIBRARY else "A_f -> A_f*(1 + eps_f*g), free form",
        [
            {"symbol": s, "value": float(v), "unit": u, "std": 0.02 * abs(float(v))}
            for (s, u), v in zip(symbols, law.point, strict=False)
        ],
        law.gain,
        score.before,
        score.after,
        numbers=2 * len(law.orders) + 2,
        source=law,
    )


def _load_motor(findings: list[Finding], analysis: Analysis) -> None:
    """A gain in the load torque that leaves no trace in the motor torque is the load motor's error: no term of the
    library.
    """
    if analysis.trace is None or analysis.traced:
        return
    coefficient, deviation = analysis.trace
    if abs(coefficient) > 3.0 * deviation + 0.3 or deviation > 0.2:
        return
    for finding in findings:
        if finding.channel == LOAD_TORQUE and finding.effect == "sensor.torque_gain":
            finding.effect, finding.status = "unknown", "unknown"
            finding.equation = (
                "load_torque += g*load_motor_torque: the load motor's torque is off, not the sensor's gain"
            )
            finding.location.text += "; no trace in motor_torque, so the error is the load motor's"
            finding.confidence = confidence("unknown", finding.gain, 0.0)


def _merged(findings: list[Finding], analysis: Analysis) -> list[Finding]:
    """One finding an effect; the strongest channel keeps it, the others are named beside it."""
    out: dict[str, Finding] = {}
    for finding in sorted(findings, key=lambda f: -f.gain):
        key = finding.effect if finding.effect != "unknown" else f"unknown:{finding.channel}"
        first = out.get(key)
        if first is None:
            out[key] = finding
            continue
        first.more.append(finding)
        if finding.channel != first.channel and finding.channel not in first.also_in:
            first.also_in.append(finding.channel)
        first.location.orders = sorted({*first.location.orders, *finding.location.orders})
        if finding.channel == first.channel:
            first.parameters += [p for p in finding.parameters if p not in first.parameters]
            first.gain += finding.gain
    for finding in out.values():
        if finding.effect in SENSOR_ERRORS and analysis.traced and MOTOR_TORQUE not in finding.also_in:
            finding.also_in.append(MOTOR_TORQUE)
    return list(out.values())
