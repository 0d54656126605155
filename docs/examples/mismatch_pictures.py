"""The pictures of docs/mismatch.md, drawn from a folder of recordings: what its noise is, and what a gain is worth.

python docs/examples/mismatch_pictures.py FOLDER OUT
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from bench.mismatch import criteria
from bench.mismatch.given import Given
from bench.mismatch.recordings.loading import load
from bench.mismatch.regression import noise
from bench.mismatch.regression.maxima import tail
from bench.mismatch.regression.problem import ChannelProblem, fixed_part, nominal_base
from bench.mismatch.regression.search import begun
from bench.simulation.model import Simulation

CHANNEL = "motor_torque"
folder, out = Path(sys.argv[1]), Path(sys.argv[2])
data = load(folder)
heard = data.density[CHANNEL]
told = noise.mixture(heard)
assert told is not None, "the recordings are too few, or too short, for spectra"

figure, axis = plt.subplots(figsize=(7.0, 3.2), layout="constrained")
frequency = heard[0].step * np.arange(heard[0].power.size)
for own in heard:
    axis.loglog(frequency[1:], own.power[1:], color="0.8", lw=0.5, label="recordings" if own is heard[0] else None)
curve = np.full(frequency.size, 2.0 * told.white / told.rate)
for variance, memory in zip(told.parts, noise.MEMORIES_S, strict=True):
    curve += 4.0 * variance * memory / (1.0 + (2.0 * np.pi * frequency * memory) ** 2)
axis.loglog(frequency[1:], curve[1:], color="C3", label=f"noise: {np.sqrt(told.variance):.3g} N·m RMS a sample")
axis.set(xlabel="Hz", ylabel="N²·m²/Hz", title="Steady parts of the motor torque")
axis.legend()
figure.savefig(out / "mismatch-noise.png", dpi=110)

rows = data.rows[CHANNEL]
usable = (rows.frame.direction != 0) & (rows.number > 0)
given = Given.of(Simulation.nominal())
bare = type(rows)(rows.frame, rows.y - fixed_part(CHANNEL, rows.frame, given.switched_off), rows.number)
search = begun(ChannelProblem(CHANNEL, bare, usable, data.folds(), tuple(nominal_base(CHANNEL, ())), told))
seen = search.scan([], search.model.fit)
best: dict[str, float] = {}
for block, gain in zip(search.blocks, seen.gain, strict=True):
    name = block.regressor.effect if block.regressor.effect != "unknown" else "the best free function"
    best[name] = max(best.get(name, -np.inf), float(gain))
shown = sorted(best, key=lambda name: -best[name])[:9][::-1]

figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.4), layout="constrained")
left.hist(seen.surrogate, bins=30, color="0.7")
left.axvline(tail(seen.surrogate, criteria.ERROR_RATE_OF_A_CHANNEL), color="C3", label="price")
left.set(xlabel="best gain of the bank in noise", ylabel="surrogates")
left.legend()
right.barh(shown, [max(best[name], 0.1) for name in shown], color="C0")
right.axvline(seen.price, color="C3")
right.set(xscale="log", xlabel="best gain in the recordings")
figure.savefig(out / "mismatch-price.png", dpi=110)
