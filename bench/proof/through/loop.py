"""The loop closed: another campaign on the same plant, and what the model found on the first one says of it.

The plant begins anew, as do its time and the distance it has run; noise, loads, speeds and a temperature are others.
Asked are the model's residual before anything is searched, what ``bench mismatch`` says of it, and how far an emulated
bench that plays the model is from the hidden plant, sample by sample.
"""

from __future__ import annotations

import json
import math
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bench.errors import ProofError
from bench.proof.recompute import measured_channel, predictor, ratio, squares, steady
from bench.proof.through.run import AGAIN, BENCH, run_on
from bench.recording import Recording, RecordingFolder

OTHER = 1
"""added to a campaign's seed: the noise of another day"""
_WARMING = "heating"

Noise = Mapping[str, Mapping[str, float]]
"""recording → channel → noise RMS"""


def closed(plant: str, seed: int, model: Path, noise: Noise, check: Any) -> dict[str, Any]:
    """What of a ``model.json`` holds on new data, JSON-ready.

    ``plant``, ``seed``: of the first campaign. ``noise``: of the other campaign. ``check(folder, model)`` analyses the
    new recordings with the model given, and returns the verdict or why there is none.

    Returns ``residual`` (channel → RMSE over noise, nothing refitted), ``verdict``, ``played`` (channel → RMS distance
    of the playing bench from the plant, over that of two measurements of one thing; up to the first warm-up, from
    which on angles differ), and ``why`` a part is missing.
    """
    out: dict[str, Any] = {"residual": {}, "verdict": "", "played": {}, "why": ""}
    predict = predictor()
    if not model.exists() or predict is None:
        return out | {"why": "there is no model.json, or nothing that predicts one"}
    content = json.loads(model.read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory() as secret:
        folder = Path(secret) / "series"
        try:
            run_on(plant, folder, seed + OTHER, AGAIN)
        except ProofError as error:
            return out | {"why": str(error)}
        recordings = RecordingFolder.open(folder).recordings
        for channel, square in squares(predict, content, recordings).items():
            found = ratio(square, noise, channel, square)
            if math.isfinite(found):
                out["residual"][channel] = found
        out["verdict"] = check(folder, model)
        playing = Path(secret) / "played.toml"
        playing.write_text(_plant_file(model), encoding="utf-8")
        try:
            run_on(str(playing), Path(secret) / "played", seed + OTHER, AGAIN)
        except ProofError as error:
            return out | {"why": f"the emulator does not play it: {error}"}
        out["played"] = apart(recordings, RecordingFolder.open(Path(secret) / "played").recordings, noise)
    return out


def _plant_file(model: Path) -> str:
    return f'format = "emulated-plant"\nsimulation = {json.dumps(str(model.absolute()))}\nbase = "{BENCH}"\n'


def apart(first: Sequence[Recording], second: Sequence[Recording], noise: Noise) -> dict[str, float]:
    """Channel → RMS difference of two runs of one campaign in steady motion, up to its first warm-up, over that of the
    noise of two.
    """
    others = {recording.recording_id: recording for recording in second}
    sums: dict[str, float] = {}
    allowed: dict[str, float] = {}
    for one in first:
        if one.kind == _WARMING:
            break
        other = others.get(one.recording_id)
        if other is None or other.size != one.size:
            continue
        for channel, level in noise.get(one.recording_id, {}).items():
            ours, theirs = measured_channel(one, channel), measured_channel(other, channel)
            if ours is None or theirs is None:
                continue
            inside = steady(one) & steady(other)
            sums[channel] = sums.get(channel, 0.0) + float(np.sum((ours - theirs)[inside] ** 2))
            allowed[channel] = allowed.get(channel, 0.0) + 2.0 * level**2 * np.count_nonzero(inside)
    return {channel: math.sqrt(total / allowed[channel]) for channel, total in sums.items() if allowed[channel] > 0.0}
