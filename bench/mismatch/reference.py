"""The reference of a comparison: the simulation that was handed over, and where it is one from elsewhere, its values.

A simulation from elsewhere takes the place of our nominal terms in the channels that it predicts. Its free parameters
are part of the fit, by their sensitivities; where the channels are not straight in them, it is run again at the values
found, and the recordings are compared anew.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bench.foreign.base import BY, KEY, Base
from bench.foreign.opening import base_of, open_base
from bench.mismatch.analysis import Analysis
from bench.mismatch.given import LOAD_INERTIA, says_waves, with_shafts
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.recordings.prepared import prepare
from bench.mismatch.regression.bank import Fit
from bench.mismatch.regression.model import Block, ChannelModel, fit_blocks
from bench.mismatch.regression.sensitivity import PARAMETER, Sensitivity
from bench.mismatch.simulation_file import of_gearbox
from bench.recording import Recording
from bench.simulation.model import Simulation, Term
from bench.simulation.terms import LIBRARY

NONLINEARITY = 0.1
"""of the noise floor: by how much the simulation may differ from the straight line in its parameters"""
MOST_ROUNDS = 4


@dataclass(frozen=True, slots=True)
class Reference:
    """The simulation handed over: its ``kind``, its ``file``, our terms, and the simulation from elsewhere."""

    kind: str
    file: str | None
    simulation: Simulation
    base: Base | None = None

    @property
    def waves(self) -> bool | None:
        """Whether the load torque follows the waves of the transmission error; None where no file says so, by the key
        or by an inertia that was calibrated without it.
        """
        term = self.simulation.terms.get(LOAD_INERTIA)
        return None if term is None or not (term.parameters or term.extra) else says_waves(self.simulation)

    def given(self, data: Dataset) -> Simulation:
        """Our terms of the gearbox that was recorded, without the nominal ones of channels that a simulation from
        elsewhere predicts.

        In a simulation file terms stay as the file has them.
        """
        out = self.simulation if self.kind == "model" else of_gearbox(self.simulation, data.gearbox)
        if not data.folder.manner.follows_waves:
            out = with_shafts(out)
        if self.kind == "model" or self.base is None:
            return out
        for effect, term in LIBRARY.items():
            if term.nominal and set(term.forms) & data.simulated:
                out = out.with_term(Term(effect, False))
        return out


def open_reference(simulation: Path | None, store: Path) -> Reference:
    """Open the simulation given by ``--simulation``; ``store``: folder for predictions of a simulation from elsewhere.

    Raises ConfigurationError where it cannot be opened.
    """
    if simulation is None:
        return Reference("nominal", None, Simulation.nominal())
    base = open_base(str(simulation))
    if base is not None:
        return Reference(base.simulator.kind, str(simulation), Simulation.nominal(), replace(base, store=store))
    read = Simulation.load(simulation)
    return Reference("model", str(simulation), read, base_of(read.extra, simulation.resolve().parent, store))


def values_of(analysis: Analysis, base: Base, whole: bool = True) -> tuple[dict[str, float], dict[str, float]]:
    """Values of the free parameters that an analysis found, and their standard deviations, by name.

    Without ``whole``: as they are with nothing added to the simulation. Where a parameter acts in several channels,
    each counts by how sure it is.
    """
    weights: dict[str, list[tuple[float, float]]] = {}
    for model in models_of(analysis):
        fit = model.fit if whole else model.refitted([])
        for block in parameters_in(model):
            coefficients, _ = fit.of(block.indices)
            variance = float(model.covariance(block.indices, fit)[0, 0])
            weights.setdefault(named(block), []).append((float(coefficients[0]), variance))
    values, std = dict(base.named), {}
    for name, estimates in weights.items():
        precision = [1.0 / max(v, 1e-300) for _, v in estimates]
        values[name] += sum(d * p for (d, _), p in zip(estimates, precision, strict=True)) / sum(precision)
        std[name] = float(1.0 / np.sqrt(sum(precision)))
    return values, std


def models_of(analysis: Analysis) -> list[ChannelModel]:
    """Models of all channels; of the transmission error that of its offset."""
    out = [search.model for search in analysis.searches.values()]
    if analysis.transmission is not None and analysis.transmission.offset is not None:
        out.append(analysis.transmission.offset.model)
    return out


def parameters_in(model: ChannelModel) -> list[Block]:
    """Blocks of a model that are sensitivities on which its training rows depend."""
    train = model.problem.train
    blocks = [b for b in model.base if b.regressor.effect == PARAMETER]
    return [b for b in blocks if np.any(b.regressor.columns(model.problem.rows.frame)[train])]


def named(block: Block) -> str:
    """The parameter that a block is the sensitivity of."""
    assert isinstance(block.regressor, Sensitivity)
    return block.regressor.parameter


def is_nonlinear(data: Dataset, analysis: Analysis, values: Mapping[str, float]) -> bool:
    """Whether the simulation at other values differs from its linearisation by more than a share of the noise."""
    base = data.folder.base
    if base is None or not base.free:
        return False
    moved = {name: value - base.named[name] for name, value in values.items()}
    at = replace(data.folder, base=base.at(values))
    for member in _some(data):
        before, after = (prepare(member, 0, folder, group=1) for folder in (data.folder, at))
        for channel, simulated in before.simulated.items():
            if channel not in analysis.outcomes:
                continue
            straight = simulated + sum(
                before.frame.aux[f"simulated/{channel}{BY}{name}"] * step for name, step in moved.items()
            )
            off = after.simulated[channel] - straight
            if np.sqrt(np.mean(off**2)) > NONLINEARITY * analysis.outcomes[channel].floor:
                return True
    return False


def _some(data: Dataset) -> Sequence[Recording]:
    """The fastest and the slowest recording that is fitted."""
    fitted = {id(m.recording): m.recording for m in data.members if not m.held_out}
    ordered = sorted(fitted.values(), key=lambda r: abs(np.nan_to_num(r.setpoint.velocity)))
    return [ordered[0], ordered[-1]] if len(ordered) > 1 else ordered


def without(model: ChannelModel, block: Block) -> Fit:
    """The model fitted with one block of the simulation left where it was."""
    return fit_blocks(model.bank, [b for b in model.blocks() if b is not block], model.variances)


def with_reference(simulation: Simulation, base: Base | None, out: Path) -> Simulation:
    """A simulation with its reference, for a file in the folder ``out``."""
    if base is None:
        return simulation
    return replace(simulation, extra={**simulation.extra, KEY: base.to_json(out.resolve())})
