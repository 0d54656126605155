"""The picture at the top: amplitudes of all orders as stems with their uncertainty, one direction above the other."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from bench.identification.identify import Identification
from bench.identification.report.figures import PART_COLOURS, to_uri
from bench.simulation import TERM_COUNT, basis
from bench.simulation.parts import part_of


def stems(found: Identification) -> tuple[str, str] | None:
    """Return (data URI, caption) of the identified orders at the mean of the inputs; None without a series."""
    if not found.refined:
        return None
    figure = Figure(figsize=(11.0, 2.9 * len(found.refined)), layout="constrained")
    rows = np.atleast_1d(figure.subplots(len(found.refined), 1, sharex=True))
    lines = []
    for axes, (name, result) in zip(rows, found.refined.items(), strict=True):
        centre = np.nan_to_num(result.design.inputs.mean(axis=0))
        x, fourier = basis(centre[0], centre[1], centre[2]), result.fourier
        size = 1e6 * np.abs(fourier.amplitude @ x)
        position = np.arange(size.size)
        spread = np.zeros(size.size)
        if fourier.covariance is not None:
            covariance = fourier.covariance[:, :TERM_COUNT, :TERM_COUNT]
            spread = 1e6 * np.sqrt(np.maximum(np.einsum("i,kij,j->k", x, covariance, x), 0.0))
        parts = [part_of(float(order), found.gearbox, found.notch_orders) for order in fourier.orders]
        for part in dict.fromkeys(parts):
            at = np.array([name_of_part == part for name_of_part in parts])
            colour = PART_COLOURS.get(part, "k")
            axes.vlines(position[at], 0.0, size[at], color=colour, lw=2.0)
            axes.errorbar(position[at], size[at], 2.0 * spread[at], fmt="o", ms=4, capsize=3, color=colour, label=part)
        axes.set(title=f"{name} direction", ylabel="amplitude, µrad", ylim=(0.0, None))
        axes.set_xticks(position, [f"{order:g}" for order in fourier.orders], fontsize=8)
        axes.grid(axis="y", alpha=0.3)
        lines.append(f"{name}: {centre[0]:.0f} N·m, {np.degrees(centre[1]):.2f} °/s, {centre[2]:.1f} °C")
    rows[0].legend(fontsize=7, ncols=4)
    rows[-1].set_xlabel("order per revolution of the load side")
    return to_uri(figure), (
        f"Orders of the refined model at the mean of the inputs ({'; '.join(lines)}), by part; bars are two standard"
        " deviations to either side."
    )
