"""What the rounding of a reported torque leaves of a level: noise smooths it, a quiet drive does not.

A drive reports a torque in thousandths of its rated one. Where the load is kept and its noise is smaller than such a
step, every sample of a recording is rounded alike, and the mean is off by up to half a step, by an amount that depends
on the level and is the same whenever that level is run. It looks like a curvature of whatever is compared with it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.recording import Recording

_LOOKED_AT = 12
"""recordings whose steady parts are looked at, spread over all"""


def unresolved(recordings: Sequence[Recording], channel: str) -> float:
    """Root mean square error of a channel's mean in a steady recording by its rounding, in the channel's unit; 0 where
    it is no whole number in the file, or nothing is steady.

    A step Δ and noise of the standard deviation σ leave Δ/√12·exp(-2π²σ²/Δ²) (Widrow and Kollár, Quantization Noise,
    2008, ch. 5: the first harmonic of the rounding error's mean). What is seen of a small σ is rounded itself: then
    rather more is told than is left.
    """
    having = [r for r in recordings if channel in r.specs]
    steady = [(r, part) for r in having if (part := r.longest_steady()) is not None]
    left = []
    for recording, part in steady[:: max(1, len(steady) // _LOOKED_AT)]:
        spec = recording.specs[channel]
        if not np.issubdtype(np.dtype(spec.dtype), np.integer):
            continue
        codes = np.asarray(recording.raw(channel, part.start, part.stop), dtype=np.float64)
        noise = max(float(np.var(codes)) - 1.0 / 12.0, 0.0)
        left.append(abs(spec.scale) / np.sqrt(12.0) * float(np.exp(-2.0 * np.pi**2 * noise)))
    return float(np.median(left)) if left else 0.0
