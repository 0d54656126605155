"""What a channel's search knows: its bank of candidates, and the model found so far."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from bench.mismatch.regression.bank import Bank, Fit
from bench.mismatch.regression.folds import density, to_be_beaten
from bench.mismatch.regression.knots import CLOSE_KNOTS, KNOTS
from bench.mismatch.regression.model import Block, ChannelModel, Chosen
from bench.mismatch.regression.regressors import UNKNOWN, Free, Regressor, knots_of_table
from bench.mismatch.regression.scan import LEAST_ENERGY_LEFT, Scan, scan
from bench.mismatch.regression.sign_blocks import Units
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import kind_of


@dataclass(slots=True)
class Search:
    """A channel's bank with all its candidates, and the model found so far."""

    model: ChannelModel
    blocks: list[Block]
    """candidates"""
    extra: FloatArray
    """parameters of each candidate beyond its columns"""
    units: Units
    seed: int
    scans: list[Scan]
    refuted: list[Chosen] = field(default_factory=list)
    """functions without a name that points left out, or recordings held out, refuted"""

    @property
    def bank(self) -> Bank:
        """The bank."""
        return self.model.bank

    def density(self, chosen: Sequence[Chosen]) -> FloatArray:
        """Log predictive density of each point left out, with some effects."""
        return density(self.model, self.model.blocks(chosen))

    def to_be_beaten(self, chosen: Sequence[Chosen]) -> FloatArray:
        """Log predictive density of each point left out, with some effects, that more effects have to beat."""
        return to_be_beaten(self.model, self.model.blocks(chosen))

    def scan(
        self, chosen: Sequence[Chosen], fitted: Fit, shuffled: bool = False, least: float = LEAST_ENERGY_LEFT
    ) -> Scan:
        """Gains of all candidates beside some effects, and their price (``shuffled``: by the residual itself);
        ``least``: see :func:`bench.mismatch.regression.scan.scan`.
        """
        model = self.model
        blocks = model.blocks(chosen)
        index = [i for b in blocks for i in b.indices]
        precision = np.concatenate([b.precision for b in blocks]) if blocks else np.zeros(0)
        residual = model.bank.residual(index, fitted.coefficients)
        indices = [b.indices for b in self.blocks]
        extra, cut, seed = self.extra, self.units, self.seed
        return scan(model.bank, index, precision, fitted, residual, indices, extra, cut, seed, shuffled, least)

    def out(self, regressor: Regressor) -> bool:
        """Whether a function without a name is one of those that were refuted: of the same quantities, times the same
        factors. A table that was refuted because it is finer than any that is searched for says nothing of those.
        """
        refuted = (c.main.regressor for c in self.refuted)
        return any(_of(regressor) == _of(r) and (_is_finer(regressor) or not _is_finer(r)) for r in refuted)

    def without_refuted(self) -> None:
        """Let no function that was refuted be a candidate, nor an alternative."""
        keep = [k for k, b in enumerate(self.blocks) if b.regressor.effect != UNKNOWN or not self.out(b.regressor)]
        self.blocks, self.extra = [self.blocks[k] for k in keep], self.extra[keep]

    def close(self) -> None:
        """Let go of what only a search needs, when all is found: from now on effects of the model can be refitted, no
        more.
        """
        self.bank.close([i for b in self.model.blocks() for i in b.indices])
        self.blocks, self.scans = [], []


def _is_finer(regressor: Regressor) -> bool:
    """Whether a function is a finer table than any that is searched for."""
    most = CLOSE_KNOTS if regressor.variables == ("speed",) else KNOTS[-1]
    return len(knots_of_table(regressor)) > most


def _of(regressor: Regressor) -> tuple[object, ...]:
    """What a function is of: its effect, and of each of its tables the kind, the quantities and the factor."""
    grids = (
        tuple((type(g), tuple(map(kind_of, g.over)), g.times) for g in regressor.grids)
        if isinstance(regressor, Free)
        else ()
    )
    return regressor.effect, grids
