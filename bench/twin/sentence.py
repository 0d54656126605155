"""What the twin says when the model no longer holds: one sentence for people, the same as data."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from bench.twin.finding import Finding
from bench.twin.names import Likely
from bench.twin.scale import ALPHA
from bench.twin.watch import Watch


def no_longer(watch: Watch, finding: Finding, names: Sequence[Likely]) -> dict[str, Any]:
    """The message of an alarm."""
    since, noticed = watch.seen[finding.since].recording, watch.seen[finding.noticed].recording
    return {
        "type": "no_longer_holds",
        "text": _sentence(watch, finding, names),
        "since": since.recording_id,
        "noticed": noticed.recording_id,
        "evidence": round(watch.seen[finding.noticed].evidence, 3),
        "streams": [
            {
                "channel": changed.stream.channel,
                "what": changed.stream.what,
                "number": changed.stream.number,
                "size": changed.size if math.isfinite(changed.size) else None,
                "unit": changed.unit,
                "words": changed.words,
            }
            for changed in finding.streams
        ],
        "conditions": list(finding.conditions),
        "quick_look": [asdict(likely) for likely in names],
    }


def _sentence(watch: Watch, finding: Finding, names: Sequence[Likely]) -> str:
    since = watch.seen[finding.since].recording.recording_id
    where = "; ".join(changed.words for changed in finding.streams[:3])
    conditions = f", {', '.join(finding.conditions)}" if finding.conditions else ""
    quick = ""
    if names:
        listed = [
            likely.name if likely.share is None else f"{likely.name} ({100.0 * likely.share:.0f} %)" for likely in names
        ]
        quick = f" Quick look, not an analysis: {', '.join(listed)}."
    return (
        f"the model no longer holds, likely since {since}: {where}{conditions}"
        f" (false in at most {100.0 * ALPHA:g} of 100 campaigns).{quick}"
    )
