"""What the examiner works out itself, from ``model.json`` and the recordings, in place of the report's own figures.

``model.json`` predicts every recording; what is left of the measured channel is set against the noise that the
generator put into these very recordings. Parameters are those of the file, and a finding's share of the excess is what
comes back when its term is taken out of the file.
"""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from bench.errors import BenchError
from bench.recording import Recording, RecordingFolder

Floats = NDArray[np.float64]
Prediction = Iterable[tuple[Recording, Mapping[str, Floats]]]
Predict = Callable[..., Prediction]
"""of a model and recordings; where ``channels`` are named, of these"""
#: Sums of squares of one prediction: channel → recording id → (sum of squared residuals, samples).
Squares = dict[str, dict[str, tuple[float, int]]]

_HEAT = "temperature"
#: Samples whose median a wild one is held against, and from how many standard deviations of the others it is wild.
NEIGHBOURS, WILD = 5, 9.0
_PREDICTION = "bench.mismatch.prediction"


def recompute(truth: Mapping[str, Any], report: Mapping[str, Any], model: Path, folder: Path) -> dict[str, Any]:
    """Residuals, shares and parameters of one folder, as JSON-ready values.

    Returns ``residual`` (channel → RMSE of the recordings held out (of all where none was) over the true noise in
    them), ``shares`` (index of a finding →
    share of the excess in its channel), ``parameters`` (effect → symbol → [value, std or None]), ``predictor`` (whether
    this version has one) and ``why`` nothing was predicted, empty where all was.
    """
    empty = {"residual": {}, "shares": {}, "parameters": {}, "predictor": predictor() is not None}
    if not model.exists():
        return empty | {"why": "there is no model.json"}
    content = json.loads(model.read_text(encoding="utf-8"))
    parameters = parameters_of(content)
    predict = predictor()
    if predict is None:
        return empty | {"parameters": parameters, "why": "no function predicts a model.json yet"}
    recordings = RecordingFolder.open(folder).recordings
    try:
        whole = squares(predict, content, recordings)
    except BenchError as error:
        return empty | {"parameters": parameters, "why": f"model.json does not predict: {error}"}
    held_out = {str(name).removesuffix(".h5") for name in report.get("recordings", {}).get("held_out", [])}
    noise = truth["noise_by_recording"]
    residual = {}
    for channel, by_recording in whole.items():
        ratios = [ratio(by_recording, noise, channel, picked) for picked in (held_out, set(by_recording))]
        # recordings held out, as the report has it; all of them where none was
        finite = [r for r in ratios if math.isfinite(r)]
        if finite:
            residual[channel] = finite[0]
    shares = _shares(predict, content, recordings, whole, report.get("findings", []), noise)
    return empty | {"residual": residual, "shares": shares, "parameters": parameters, "why": ""}


def predictor() -> Predict | None:
    """``predict_all(model, recordings)`` of the simulation, None where this version has none."""
    if find_spec(_PREDICTION) is None:
        return None
    predict: Predict = import_module(_PREDICTION).predict_all
    return predict


def squares(
    predict: Predict, model: Mapping[str, Any], recordings: Sequence[Recording], only: str | None = None
) -> Squares:
    """Squared residuals of every recording, of ``only`` one channel or of all: over steady samples, of the temperature
    over all.
    """
    out: Squares = {}
    options: dict[str, Any] = {} if only is None else {"channels": (only,)}
    for recording, predicted in predict(model, recordings, **options):
        for channel, values in predicted.items():
            measured = measured_channel(recording, channel)
            if measured is None:
                continue
            inside = np.isfinite(values) & np.isfinite(measured) & ~wild(measured)
            if channel != _HEAT:
                inside &= steady(recording)
            left = (measured - values)[inside]
            if left.size:
                out.setdefault(channel, {})[recording.recording_id] = float(left @ left), int(left.size)
    return out


def wild(measured: Floats) -> NDArray[np.bool_]:
    """Samples (N,) far off their neighbours: they are no noise, and no analysis is asked to predict them."""
    off = np.abs(measured - median_filter(measured, NEIGHBOURS, mode="nearest"))
    return np.asarray(off > WILD * 1.4826 * float(np.median(off)))


def measured_channel(recording: Recording, channel: str) -> Floats | None:
    """A compared channel (N,) as measured; None where the recording lacks it."""
    if channel == "transmission_error":
        ratio = recording.gearbox.ratio
        if not {"load_angle", "motor_angle"} <= set(recording.channels) or ratio is None:
            return None
        return np.asarray(recording.si("load_angle") - recording.si("motor_angle") / ratio)
    return np.asarray(recording.si(channel)) if channel in recording.channels else None


def steady(recording: Recording) -> NDArray[np.bool_]:
    """Samples (N,) of the recording's steady segments."""
    inside = np.zeros(recording.size, dtype=bool)
    for part in recording.steady():
        inside[part] = True
    return inside


def ratio(
    by_recording: Mapping[str, tuple[float, int]],
    noise: Mapping[str, Mapping[str, float]],
    channel: str,
    picked: Iterable[str],
) -> float:
    """RMSE of the recordings picked over the true noise in the same ones, NaN where none of them counts."""
    counted = [
        (by_recording[r], noise[r][channel]) for r in picked if r in by_recording and channel in noise.get(r, {})
    ]
    true = sum(count * rms**2 for (_square, count), rms in counted)
    return math.sqrt(sum(square for (square, _count), _rms in counted) / true) if true > 0.0 else math.nan


def parameters_of(model: Mapping[str, Any]) -> dict[str, dict[str, list[float | None]]]:
    """Effect → symbol → [value, std] of the terms in force; the first row of a term that has several."""
    out: dict[str, dict[str, list[float | None]]] = {}
    for term in model.get("terms", []):
        given = term.get("parameters", {})
        if term.get("enabled", True):
            out[str(term["effect"])] = {
                symbol: [float(p["value"]), None if p.get("std") is None else float(p["std"])]
                for symbol, p in given.items()
                if isinstance(p, Mapping) and isinstance(p.get("value"), int | float)
            }
    return out


def without(model: Mapping[str, Any], effect: str) -> dict[str, Any]:
    """The same model with one effect's term taken out."""
    changed = copy.deepcopy(dict(model))
    changed["terms"] = [term for term in changed.get("terms", []) if term["effect"] != effect]
    return changed


def _shares(
    predict: Predict,
    model: Mapping[str, Any],
    recordings: Iterable[Recording],
    whole: Squares,
    findings: Iterable[Mapping[str, Any]],
    noise: Mapping[str, Mapping[str, float]],
) -> dict[str, float]:
    """Index of each named finding → what its term takes of the energy above noise that all of them take."""
    named = [(i, f) for i, f in enumerate(findings) if f["effect"] in {t["effect"] for t in model.get("terms", [])}]
    recordings = tuple(recordings)
    back: dict[int, float] = {}
    for i, finding in named:
        channel = finding["channel"]
        less = squares(predict, without(model, finding["effect"]), recordings, channel).get(channel, {})
        back[i] = sum(s - whole[channel][r][0] for r, (s, _n) in less.items() if r in whole.get(channel, {}))
    out = {}
    for i, finding in named:
        channel = finding["channel"]
        left = sum(s - n * noise[r][channel] ** 2 for r, (s, n) in whole.get(channel, {}).items() if r in noise)
        total = max(left, 0.0) + sum(back[k] for k, f in named if f["channel"] == channel and back[k] > 0.0)
        if back[i] > 0.0:
            out[str(i)] = back[i] / total
    return out
