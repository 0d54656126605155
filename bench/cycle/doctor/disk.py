"""The disk recordings go to."""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from pathlib import Path

from bench.cycle.doctor.finding import Finding, advice, bad, good

_BYTES = 32 << 20
_NEEDED_MB_S = 2.0
"""Several times what a recording of 17 channels at 2 kHz takes."""
_SLOW_SYNC_S = 0.5
"""The recorder flushes as often as this."""


def disk(folder: Path, minimum_free: float) -> list[Finding]:
    """Measure how fast ``folder`` takes data and look at the room left; ``minimum_free`` is in bytes."""
    name = f"disk of {folder}"
    place = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    free = shutil.disk_usage(place).free
    found = []
    if free < minimum_free:
        text = f"{free / 1e6:.0f} MB free, storage.minimum_free is {minimum_free / 1e6:.0f} MB"
        found.append(bad(f"{name}: room", text, "make room, or name another folder with --out"))
    else:
        found.append(good(f"{name}: room", f"{free / 1e9:.1f} GB free"))
    try:
        speed, sync = _measure(place)
    except OSError as error:
        return [*found, bad(f"{name}: speed", f"cannot be written to: {error.strerror}", "a folder that can")]
    text = f"{speed:.0f} MB/s, {sync * 1000:.0f} ms to make one block safe"
    if speed < _NEEDED_MB_S or sync > _SLOW_SYNC_S:
        change = "a local disk: a slow one holds recordings in memory, and loses more of them in a power cut"
        found.append(advice(f"{name}: speed", text, change))
    else:
        found.append(good(f"{name}: speed", text))
    return found


def _measure(place: Path) -> tuple[float, float]:
    """Return MB/s with the data safe at the end, and the time of one small safe write, s."""
    with tempfile.NamedTemporaryFile(dir=place, prefix=".bench-doctor-") as file:
        block = os.urandom(1 << 20)
        begin = time.perf_counter()
        for _ in range(_BYTES >> 20):
            file.write(block)
        file.flush()
        os.fsync(file.fileno())
        speed = _BYTES / 1e6 / (time.perf_counter() - begin)
        begin = time.perf_counter()
        file.write(block[:4096])
        file.flush()
        os.fsync(file.fileno())
        return speed, time.perf_counter() - begin
