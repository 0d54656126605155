"""What stands in the header of every recording: what was measured, on what, by which revision of the program."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from bench.campaigns.taken import Taken
from bench.configuration import BenchFile
from bench.cycle.rig import Rig
from bench.recording import Gearbox, RecordingHeader, Setpoint
from bench.version import __version__

WORK_TREE = Path(__file__).resolve().parents[3]
"""where the program's git folder is, if it runs from a work tree"""


def recording_header(
    begun: Taken, campaign_id: str, file: BenchFile, rig: Rig, more: Mapping[str, Any]
) -> RecordingHeader:
    """Return the header of a recording that begins now; ``more`` are root attributes that say whose it is."""
    config = file.configuration
    gearbox = config.gearbox
    teeth = gearbox.teeth.model_dump() if gearbox.teeth is not None else {}
    return RecordingHeader(
        recording_id=begun.recording_id,
        campaign_id=campaign_id,
        kind=begun.kind,
        started_at=rig.now,
        sample_rate=1.0 / config.bus.cycle_time,
        source=rig.source,
        setpoint=Setpoint(*(math.nan if value is None else value for value in begun.setpoint.values())),
        gearbox=Gearbox(gearbox.ratio, **teeth),
        point_id=begun.point_id,
        take=begun.take,
        zero_id=rig.zero_id,
        gearbox_serial=gearbox.serial,
        config=file.text,
        software={"name": "gearbench", "version": __version__, "revision": revision()},
        attributes={"tare_torque": rig.zeros.load_torque, "label": begun.label, **more},
    )


@cache
def revision() -> str:
    """Return the revision of the program where it runs from a git work tree, else an empty text."""
    head = WORK_TREE / ".git" / "HEAD"
    try:
        text = head.read_text("utf-8").strip()
        return (head.parent / text.removeprefix("ref: ")).read_text("utf-8").strip() if "ref:" in text else text
    except OSError:
        return ""
