"""The load motor's torque ripple: its orders from its pole pairs, or found in what the torque sensor read.

A three-phase motor ripples 6 and 12 times per pole pair and revolution. The torque sensor sees it as it is, at any
speed, while the transmission error gets there through the load's inertia only, with the square of the speed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bench.identification.samples.sums import angle_sums
from bench.identification.samples.windows import steady_window
from bench.identification.series.orders import peak_ratio
from bench.recording import Recording

FloatArray = NDArray[np.float64]

PHASES = 6
MULTIPLES = (1, 2)
HIGHEST_ORDER = 600
"""Highest order looked at: 50 pole pairs."""
LOOKED_AT = 4
PEAK_RATIO = 30.0
"""Power over that of the orders beside, in every recording looked at; by chance less than once in 10¹² orders."""
MIN_SHARE = 0.2
"""Amplitude of the second order of a motor, or of another ripple, of the strongest one's."""


def of_pole_pairs(pole_pairs: int) -> tuple[int, ...]:
    """Orders of a motor's ripple, 6 and 12 a pole pair."""
    return tuple(PHASES * multiple * pole_pairs for multiple in MULTIPLES)


def _spectrum(recording: Recording) -> FloatArray | None:
    """Amplitudes (HIGHEST_ORDER + 1,) of the load torque in N·m by order; None where they are not known."""
    needed = ("load_angle", "load_torque")
    if any(name not in recording.specs for name in needed):
        return None
    channels = recording.read_si(list(needed))
    angle, torque = channels["load_angle"], channels["load_torque"]
    if not (np.isfinite(angle).all() and np.isfinite(torque).all()):
        return None
    window = steady_window(recording, angle)
    if isinstance(window, str):
        return None
    part = slice(window.start, window.stop)
    torque = torque[part] - torque[part].mean()
    if torque.size < 4 * HIGHEST_ORDER:
        return None
    sums, _ = angle_sums(np.ascontiguousarray(angle[part]), torque, np.zeros_like(torque), HIGHEST_ORDER)
    return np.asarray(2.0 / torque.size * np.abs(sums))


def find_ripple(recordings: Sequence[Recording]) -> tuple[tuple[int, ...], str]:
    """Orders of the load motor's ripple as the torque sensor sees them; where there are none, a sentence on why.

    Looks at up to four steady recordings, of speeds as far apart as there are. An order counts that stands out in all
    of them, is a multiple of 6, and has a fifth of the strongest such order's amplitude.
    """
    steady = sorted((r for r in recordings if r.kind == "constant_velocity"), key=lambda r: abs(r.setpoint.velocity))
    if len(steady) > LOOKED_AT:
        steady = [steady[i] for i in np.linspace(0, len(steady) - 1, LOOKED_AT).astype(int)]
    spectra = [s for r in steady if (s := _spectrum(r)) is not None]
    if not spectra:
        return (), "No ripple of a load motor is looked for: no steady recording has a whole revolution of load torque."
    significant = np.all([peak_ratio((s**2).astype(np.float32)) > PEAK_RATIO for s in spectra], axis=0)
    amplitude = np.median(spectra, axis=0)
    orders = np.flatnonzero(significant & (np.arange(significant.size) % PHASES == 0))
    if not orders.size:
        return (), "No ripple of a load motor is taken off: none stands out of the load torque (--pole-pairs names it)."
    strong = orders[amplitude[orders] >= MIN_SHARE * amplitude[orders].max()]
    return tuple(int(order) for order in strong), ""
