"""What an analysis hands on: a discovery, and all that is known of a compared channel.

Rooms of the analysis make these; nothing of the report asks how.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtri

from bench.mismatch import criteria
from bench.mismatch.recordings.rows import Rows
from bench.simulation.frame import FloatArray
from bench.simulation.terms import TRANSMISSION_ERROR

NAMED, AMBIGUOUS, UNKNOWN = "named", "ambiguous", "unknown"
UNNAMED = "unknown"
"""id of an effect that no name fits"""


BELOW, ABOVE = "below", "above"
"""sides of a limit"""
BURSTS, TONE = "bursts", "tone"
"""names of looks at what is left"""


@dataclass(frozen=True, slots=True)
class RefittedAlternative:
    """Another explanation, really refitted in a discovery's place.

    ``loss``: log predictive density of the points left out that it loses against the discovery, with its standard
    ``error``; ``weight``: probability that it predicts best (:func:`bench.mismatch.regression.folds.weights`);
    ``left`` (n,): what the model with it leaves of the channel's rows, None where it was not evaluated there;
    ``of_fitted``: its figures are of log-likelihood in the fitted revolutions, its numbers paid for; ``worse_by``:
    squares with which it predicts points left out over those of the discovery, nan where they were not compared.
    """

    effect: str
    words: str
    loss: float
    error: float
    weight: float
    as_good: bool
    left: FloatArray | None = field(default=None, repr=False)
    of_fitted: bool = False
    worse_by: float = np.nan

    @classmethod
    def of_revolutions(cls, effect: str, words: str, loss: float, error: float, weight: float) -> RefittedAlternative:
        """Of fitted revolutions. ``error`` is over the orders, and one order has none: within odds of twenty to one no
        two explanations are told apart.
        """
        return cls(effect, words, loss, error, weight, loss < max(error, criteria.RICHER), of_fitted=True)


@dataclass(frozen=True, slots=True)
class Discovery:
    """Something the simulation leaves out, in one channel.

    ``variables``: quantities it depends on (names of :data:`bench.simulation.quantities.QUANTITIES`), the most telling
    first; ``orders`` per output revolution, ``angle_windows`` in rad of the output, ``time_window`` in s of the
    campaign, each empty or None where it is no matter of such; ``parameters``: symbol, value, unit, std each;
    ``added`` (n,): the channel's whole model less the model without it, refitted, on all rows of the channel; ``gain``
    of log predictive density on points left out; ``p_value`` against surrogates, None where none were drawn;
    ``simulation_rows``: rows of a simulation file, each with its ``effect``; ``table``: a row an order, where it has
    many; ``alone``: the parameters of a law without the changes of it that were found as well, empty where there are
    none; ``excess`` (n,): what of it no calibration of the simulation can say, each sample counted alike (of
    scatter each recording), where that was worked out: its place is where this lies; ``everywhere`` (n,): the same,
    each sample counted alike, with those that are not compared (at rest, at the slowest speeds), where the channel has
    a value there.
    """

    effect: str
    status: str
    confidence: float | None
    channel: str
    words: str
    equation: str
    variables: tuple[str, ...]
    parameters: tuple[Mapping[str, Any], ...]
    added: FloatArray = field(repr=False)
    gain: float
    p_value: float | None
    simulation_rows: tuple[Mapping[str, Any], ...] = field(repr=False)
    alternatives: tuple[RefittedAlternative, ...] = ()
    orders: tuple[float, ...] = ()
    angle_windows: tuple[tuple[float, float], ...] = ()
    time_window: tuple[float, float] | None = None
    table: tuple[Mapping[str, Any], ...] = ()
    also_in: tuple[str, ...] = ()
    numbers: int = 1
    excess: FloatArray | None = field(default=None, repr=False)
    everywhere: FloatArray | None = field(default=None, repr=False)
    alone: tuple[Mapping[str, Any], ...] = ()
    independent: bool = False
    """whether what is left without an explanation depends on other quantities than this"""
    squares: tuple[float, float] | None = None
    """mean square per held-out sample without and with it, where rows are too coarse to show it"""
    side: tuple[str, str, float] | None = None
    """quantity, side (:data:`BELOW`, :data:`ABOVE`) and limit of the states in which it acts, where states tell that
    and no course does
    """

    @property
    def beyond(self) -> FloatArray:
        """What counts of it (n,): ``excess``, or all that it adds where that was not worked out."""
        return self.added if self.excess is None else self.excess


@dataclass(frozen=True, slots=True)
class Look:
    """A look at what is left: what it asked, in words with its chance; that chance, and what counts of it."""

    words: str
    p_value: float
    counted: float


@dataclass(frozen=True, slots=True)
class Structure:
    """Omnibus test of what is left: chance that pure noise looks as structured, and how that was found."""

    p_value: float | None
    method: str
    bursts: float | None = None
    """chance that the loudest of the blocks in time is noise, however little all of them hold"""
    tone: float | None = None
    """chance that the clearest tone is noise, however small it is over all recordings"""
    looks: Mapping[str, Look] = field(default_factory=dict, repr=False)
    """the looks by name, in the order in which they are told"""

    @classmethod
    def of(cls, looks: Mapping[str, Look]) -> Structure:
        """The test of several looks, corrected for their number."""
        words = "; ".join([*(look.words for look in looks.values()), "corrected for the number of looks"])
        chance = min(1.0, len(looks) * min(look.counted for look in looks.values()))
        shown = {name: look.p_value for name, look in looks.items()}
        return cls(chance, words, shown.get(BURSTS), shown.get(TONE), looks)


@dataclass(slots=True)
class ChannelOutcome:
    """A compared channel: its ``rows`` (every recording's), who may be scored, what models say on them.

    ``usable`` (n,) rows that are compared, ``held_out`` (n,) those of them that nothing was fitted to; ``whole`` (n,)
    the final model, ``before`` (n,) the recalibrated simulation. ``rmse`` per sample on held-out recordings, from the
    simulation file: "as_given", "before", "after" (None: nothing held out, or nothing given); ``in_sample`` the same
    on recordings that were fitted, where nothing could be held out.
    """

    channel: str
    rows: Rows = field(repr=False)
    usable: NDArray[np.bool_] = field(repr=False)
    held_out: NDArray[np.bool_] = field(repr=False)
    whole: FloatArray = field(repr=False)
    before: FloatArray = field(repr=False)
    floor: float
    floor_std: float | None
    floor_method: str
    discoveries: list[Discovery] = field(default_factory=list)
    structure: Structure | None = None
    rmse: dict[str, float | None] = field(default_factory=dict)
    in_sample: dict[str, float | None] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    doubt: float = 0.0
    """mean variance of the prediction of a held-out sample by what the calibration leaves uncertain, in squares of
    the unit
    """
    levels: float = 0.0
    """variance of the recordings' levels that the fit gives their offsets, in squares of the unit"""
    scattering: tuple[tuple[float, ...], float] = ((), 0.0)
    """orders that scatter more than noise about the model, and the mean square of that, in squares of the unit"""

    @property
    def settled(self) -> float | None:
        """What ``model.json`` leaves of held-out samples that compare with the noise floor: the median over the
        recordings in steady motion, where there are any; else all.
        """
        steady = self.rmse.get("after_steady")
        return self.rmse.get("after") if steady is None else steady

    @property
    def altogether(self) -> float | None:
        """The same over all those samples, a few recordings far off among them."""
        return self.rmse.get("after_altogether")

    @property
    def of_levels(self) -> float:
        """How much of the mean square of held-out samples the recordings' levels may be, which nothing recorded
        predicts: by the variance that the fitted recordings' levels have, and how well so few tell that of others
        (F distribution); of the transmission error no more than the noise of a sample, for larger ones are no matter of
        noise. 0 where held-out recordings leave more than noise about their own means as well: that is no matter of
        levels.
        """
        inside = self.rmse.get("after_inside")
        if inside is None or self.floor_std is None:
            return 0.0
        most = criteria.MORE_THAN_NOISE * self.floor + criteria.FLOOR_ERRORS * self.floor_std
        held = np.unique(self.rows.frame.recording[self.held_out]).size
        fitted = np.unique(self.rows.frame.recording[self.usable & ~self.held_out]).size
        if inside > most or not held or fitted < 2:
            return 0.0
        drawn = float(fdtri(held, fitted - 1, 1.0 - criteria.ERROR_RATE_OF_A_CHANNEL))
        likely = self.levels * drawn
        return min(likely, self.floor**2) if self.channel == TRANSMISSION_ERROR else likely

    @property
    def left(self) -> FloatArray:
        """What the final model leaves (n,)."""
        return np.asarray(self.rows.y - self.whole)
