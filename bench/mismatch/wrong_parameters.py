"""Parameters of a simulation from elsewhere that were wrong: each a discovery, before any physics is added."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.special import ndtr

from bench.foreign.base import Base
from bench.mismatch import criteria
from bench.mismatch.analysis import Analysis
from bench.mismatch.discovery import NAMED, Discovery
from bench.mismatch.reference import models_of, named, parameters_in, values_of, without
from bench.mismatch.regression.bank import Fit
from bench.mismatch.regression.model import Block, ChannelModel
from bench.mismatch.regression.problem import NUISANCE
from bench.mismatch.regression.sensitivity import PARAMETER
from bench.simulation.frame import FloatArray


def wrong_parameters(analysis: Analysis, given: Base, last: Base) -> list[Discovery]:
    """Free parameters whose value as ``given`` the recordings do not bear.

    One counts as wrong in a channel where its change gains more of log-likelihood than the price of anything else
    there, and takes off what is worth telling; and where recalibration alone changes it by as much, within a factor of
    two: else what was added shares a part with it, which a note says. ``last``: the values at which the channels were
    compared.
    """
    values, std = values_of(analysis, last)
    alone, _ = values_of(analysis, last, whole=False)
    out = []
    for model in models_of(analysis):
        blocks = parameters_in(model)
        for block in blocks:
            name = named(block)
            change = values[name] - given.named[name]
            deviation = std[name]
            score = abs(change) / max(deviation, 1e-300)
            frame = model.problem.rows.frame
            added = block.regressor.columns(frame)[:, 0] * change
            usable = model.problem.usable & (model.problem.rows.number > 0)
            number = model.problem.rows.number[usable]
            size = float(np.sqrt(np.average(added[usable] ** 2, weights=number)))
            if 0.5 * score**2 <= model.price or size < criteria.LEAST_OVERALL * model.floor:
                continue
            if not 0.5 <= (alone[name] - given.named[name]) / change <= 2.0:
                analysis.outcomes[model.channel].notes.append(
                    f"parameter {name} is {alone[name]:.4g} recalibrated alone and {values[name]:.4g} beside what was "
                    f"added, the simulation has {given.named[name]:.4g}: what was added shares a part with it, and "
                    "whether it was wrong is not known"
                )
                continue
            p = next(parameter for parameter in given.free if parameter.name == name)
            out.append(
                Discovery(
                    effect=PARAMETER,
                    status=NAMED,
                    confidence=None,
                    channel=model.channel,
                    words=_words(name, p.unit, given.named[name], values[name], deviation),
                    equation=f"{name}: {given.named[name]:.6g} -> {values[name]:.6g}",
                    variables=(),
                    parameters=(
                        {
                            "symbol": name,
                            "value": values[name],
                            "unit": p.unit,
                            "std": deviation,
                            "given": given.named[name],
                        },
                    ),
                    added=_added(model, block, added, last.named[name] == given.named[name]),
                    gain=0.5 * score**2,
                    # of as many parameters as were free, by the fitted noise
                    p_value=float(min(1.0, 2.0 * ndtr(-score) * len(blocks))),
                    simulation_rows=(),
                )
            )
    return out


def _added(model: ChannelModel, block: Block, straight: FloatArray, linear: bool) -> FloatArray:
    """What the change adds beside everything else refitted; where the simulation was run anew, along its slope."""
    if not linear:
        return straight
    rest = without(model, block)
    frame = model.problem.rows.frame
    return np.asarray(model.predict(frame) - _predicted(model, block, rest))


def _predicted(model: ChannelModel, left_out: Block, fit: Fit) -> FloatArray:
    frame = model.problem.rows.frame
    out = np.zeros(frame.size)
    for block in model.blocks():
        if block is not left_out and block.regressor.effect != NUISANCE:
            out += block.regressor.columns(frame) @ fit.of(block.indices)[0]
    return out


def _words(name: str, unit: str, given: float, found: float, std: float) -> str:
    of = "" if unit == "1" else f" {unit}"
    share = f" ({100.0 * (found / given - 1.0):+.3g} %)" if given else ""
    return f"parameter {name} is {found:.6g} ± {std:.2g}{of}, the simulation has {given:.6g}{of}{share}"


def by_channel(discoveries: list[Discovery]) -> Mapping[str, list[Discovery]]:
    """Discoveries by channel."""
    out: dict[str, list[Discovery]] = {}
    for discovery in discoveries:
        out.setdefault(discovery.channel, []).append(discovery)
    return out
