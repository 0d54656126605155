"""``campaign.json`` as a run leaves it: every take, and every point still to be measured."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from bench.campaigns.listener import Expected
from bench.campaigns.planning.registry import build_sequence
from bench.campaigns.taken import Status, Summary, Taken, setpoint_dict


def recordings(takes: Sequence[Taken], points: Sequence[Expected], done: set[str]) -> list[dict[str, Any]]:
    """Return the entries of the manifest: takes in their order, then the points that have none that passed."""
    return [taken.as_dict() for taken in takes] + [
        {
            "recording_id": None,
            "file": None,
            "kind": build_sequence(expected.point.sequence, expected.point.options).kind,
            "label": expected.point.label,
            "setpoint": setpoint_dict(expected.point),
            "status": Status.PENDING.value,
            "quality": {},
            "point_id": expected.identity,
        }
        for expected in points
        if expected.identity not in done
    ]


def end_and_zero(summary: Summary, tare_nm: float) -> dict[str, Any]:
    """Return how the run ended and what the torque sensor's zero did; ``tare_nm`` is what is subtracted."""
    drift = summary.tare_drift
    return {
        "end": {"kind": summary.end.kind.name.lower(), "text": summary.end.text},
        "torque_sensor": {"tare_before_nm": tare_nm, "drift_nm": None if math.isnan(drift) else drift},
    }
