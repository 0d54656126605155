"""Recordings' spectra of noise that is known: white and with a memory, with tones or orders where asked."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter, welch

from bench.mismatch.recordings.vibration import SEGMENTS_S, Density

RATE, SECONDS = 100.0, 80.0
SPEEDS = (0.005, 0.009, 0.014, 0.02)
"""output revolutions a second"""


def densities(
    seed: int,
    white: float = 1.0,
    slow: float = 0.0,
    memory: float = 0.1,
    tone: tuple[float, float] = (0.0, 0.0),
    order: tuple[float, float] = (0.0, 0.0),
    recordings: int = 16,
) -> list[Density]:
    """Spectra of noise of variances ``white`` and ``slow`` (correlation time ``memory`` s).

    ``tone``: frequency in Hz and amplitude; ``order``: per output revolution, and amplitude.
    """
    rng = np.random.default_rng(seed)
    size = round(SEGMENTS_S[0] * RATE)
    time = np.arange(round(SECONDS * RATE)) / RATE
    keep = np.exp(-1.0 / (RATE * memory))
    out = []
    for number in range(recordings):
        turning = SPEEDS[number % len(SPEEDS)]
        values = np.sqrt(white) * rng.normal(size=time.size)
        values += lfilter([np.sqrt(slow * (1.0 - keep**2))], [1.0, -keep], rng.normal(size=time.size))
        values += tone[1] * np.sin(2.0 * np.pi * tone[0] * time + rng.uniform(0.0, 6.28))
        values += order[1] * np.sin(2.0 * np.pi * order[0] * turning * time + rng.uniform(0.0, 6.28))
        power = np.asarray(welch(values, fs=RATE, nperseg=size, detrend="linear")[1])
        averaged = 0.9 * (2 * time.size // size - 1)
        out.append(Density(number, power, RATE / size, averaged, RATE, turning))
    return out
