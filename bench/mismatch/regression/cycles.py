"""What comes and goes evenly over the campaign's time: a hall that is heated in turns, a pump, a drag that breathes.

The period is looked for in what a model leaves, by a periodogram of the rows (Lomb, Astrophys. Space Sci. 39 (1976)
447), for each factor that it may be multiplied with.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from bench.mismatch.regression.bank import Fit
from bench.mismatch.regression.model import Block, ChannelModel, add_block, fit_blocks, likelihood_of
from bench.mismatch.regression.regressors import Free, Regressor
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.quantities import factor, in_words
from bench.simulation.tables import Grid

SHORTEST_S = 60.0
"""a minute: what is quicker changes within one recording, and is a tone"""
FEWEST_PERIODS = 2.0
"""periods in the campaign, below which a cycle is a drift"""
MOST_PERIODS = 2000.0
"""periods in the campaign over which no heating or air conditioning keeps its phase: of campaigns of months only slower
cycles are tried"""
FINENESS = 3.0
"""frequencies that are tried to each that the campaign tells apart"""
SMALLEST_MOVE = 0.03
"""of the distance of two frequencies that are tried: how closely a cycle's is found beside a model fitted anew"""
MOST_LINES = 8
"""of a spectrum that are tried beside a model fitted anew"""
MOST_MOVES = 12
"""of a frequency to one side or the other"""
ALIKE = 1e-9
"""share of the squares below which cosine and sine are one at the rows there are, to rounding"""
KNOTS_A_PERIOD = 24
"""knots of the table in a simulation file: a straight line between two of them misses the wave by under a hundredth"""


class Cycle(Grid):
    """A wave over time as a table: cosine and sine of one period."""

    __slots__ = ()

    @property
    def size(self) -> int:
        """Cosine and sine."""
        return 2

    @property
    def period(self) -> float:
        """Period, s."""
        return KNOTS_A_PERIOD * (self.knots[0][1] - self.knots[0][0])

    @property
    def course(self) -> str:
        """How often it comes."""
        factors = in_words(self.times)
        return f"a cycle{f' times {factors}' if factors else ''} of {self.period / 60.0:.3g} min"

    @property
    def formula(self) -> str:
        """Its equation, with the period in seconds."""
        return f"(f_c*cos(2*pi*time/{self.period:.4g}) + f_s*sin(2*pi*time/{self.period:.4g}))"

    @property
    def symbols(self) -> list[str]:
        """Symbols of the two amplitudes."""
        return ["f_c", "f_s"]

    def columns(self, frame: Frame) -> FloatArray:
        """The regressors (n, 2), straight between the knots as the file has them."""
        knots = np.asarray(self.knots[0])
        waves = [np.interp(frame.time, knots, values) for values in self._at(knots)]
        return np.column_stack(waves) * factor(self.times, frame)[:, None]

    def to_json(self, values: FloatArray) -> dict[str, object]:
        """As a table over time."""
        cosine, sine = self._at(np.asarray(self.knots[0]))
        return Grid(self.over, self.times, self.knots).to_json(values[0] * cosine + values[1] * sine)

    def _at(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        phase = 2.0 * np.pi * time / self.period
        return np.cos(phase), np.sin(phase)


def cycle(channel: str, times: str, period: float, begin: float, end: float) -> Free:
    """A wave of a ``period`` (s) over the campaign's time from ``begin`` to ``end`` (s), times a factor."""
    step = period / KNOTS_A_PERIOD
    knots = begin + step * np.arange(int(np.ceil((end - begin) / step)) + 1)
    return Free(channel, (Cycle(("time",), times, (tuple(knots.tolist()),)),))


def cycle_of(regressor: Regressor) -> Cycle | None:
    """The cycle that a regressor is, if it is one."""
    grid = regressor.grids[0] if isinstance(regressor, Free) else None
    return grid if isinstance(grid, Cycle) else None


def price_of_period(regressor: Regressor) -> float:
    """Log-likelihood that the best of all periods that were tried has to gain by being the best of so many."""
    cycle = cycle_of(regressor)
    return 0.0 if cycle is None else float(np.log(_frequencies(cycle.knots[0][-1] - cycle.knots[0][0]).size))


def in_cycles(model: ChannelModel, factors: Sequence[str]) -> Iterator[Block]:
    """Cycles beside a model, for each of the ``factors`` the one whose period gains most, where it gains its price."""
    problem = model.problem
    frame = problem.rows.frame.take(problem.train)
    begin, end = float(frame.time.min()), float(frame.time.max())
    frequencies = _frequencies(end - begin)
    if frequencies.size == 0:
        return
    left = (problem.rows.y - model.predict(problem.rows.frame))[problem.train]
    by = np.array([factor(times, frame) for times in factors]).reshape(len(factors), frame.size)
    weight = problem.rows.number[problem.train] * by**2
    value = np.divide(left, by, out=np.zeros(by.shape), where=by != 0.0)
    coarse = _powers(frame.time - begin, value, weight, frequencies)
    step = 1.0 / (FINENESS * (end - begin))
    for k, times in enumerate(factors):

        def less(frequency: float, k: int = k) -> float:
            return -float(_powers(frame.time - begin, value[[k]], weight[[k]], np.array([frequency]))[0, 0])

        def at(frequency: float, times: str = times) -> Block:
            return add_block(problem, model.bank, cycle(model.channel, times, 1.0 / frequency, begin, end))

        # what the model calibrated without it has taken of the wave may have made another line the highest
        found = []
        for line in _lines(coarse[k]):
            best = float(frequencies[line])
            near = max(best - step, float(frequencies[0])), best + step
            fine = float(minimize_scalar(less, bounds=near, method="bounded").x)
            one = at(fine)
            found.append((_beside(model, one), one, fine))
        beside, one, fine = max(found, key=lambda each: each[0].likelihood)
        highest = beside.likelihood
        if not highest - model.fit.likelihood > price_of_period(one.regressor):
            continue
        # and it has moved the period
        move, moves = step, MOST_MOVES
        while move > SMALLEST_MOVE * step and moves:
            moves -= 1
            tried = [f for f in (fine - move, fine + move) if f >= frequencies[0]]
            further = [(at(f), f) for f in tried]
            likelihoods = [likelihood_of(model.bank, [*model.blocks(), b], beside.variance) for b, _ in further]
            best_of = int(np.argmax(likelihoods))
            if likelihoods[best_of] > highest:
                highest, (one, fine) = likelihoods[best_of], further[best_of]
            else:
                move *= 0.5
        yield one


def _lines(powers: FloatArray) -> list[int]:
    """The highest lines of a spectrum (f,), highest first: recordings with gaps between them show a cycle at other
    periods as well.
    """
    inner = np.concatenate(([-np.inf], powers, [-np.inf]))
    tops = np.flatnonzero((powers >= inner[:-2]) & (powers > inner[2:]))
    return [int(k) for k in tops[np.argsort(-powers[tops])][:MOST_LINES]]


def _beside(model: ChannelModel, one: Block) -> Fit:
    """A model with a cycle, all else fitted anew."""
    return fit_blocks(model.bank, [*model.blocks(), one], model.variances)


def _frequencies(span: float) -> FloatArray:
    """Frequencies (Hz) of the cycles that a campaign of ``span`` seconds can show; none where it is too short."""
    span = max(span, 1e-9)
    low, high = FEWEST_PERIODS / span, min(1.0 / SHORTEST_S, MOST_PERIODS / span)
    if low >= high:
        return np.zeros(0)
    return np.arange(low, high, 1.0 / (FINENESS * span))


def _powers(time: FloatArray, values: FloatArray, weights: FloatArray, frequencies: FloatArray) -> FloatArray:
    """Weighted squares of each of some values (k, n) that a wave of each of some frequencies (f,) takes off: (k, f).

    The frequencies are evenly apart: each wave is the one before, turned on. With S the sum of weights w, q that of
    w*v*exp(i*phi) and z that of w*exp(2i*phi), the normal equations of cosine and sine give
    2*(S*abs(q)**2 - Re(conj(z)*q**2))/(S**2 - abs(z)**2).
    """
    out = np.empty((len(values), frequencies.size))
    wave = np.exp(2j * np.pi * frequencies[0] * time)
    rotation = np.exp(2j * np.pi * (frequencies[1] - frequencies[0] if frequencies.size > 1 else 0.0) * time)
    weighted, total = weights * values, weights.sum(axis=1)
    for k in range(frequencies.size):
        q, z = weighted @ wave, weights @ wave**2
        apart = np.maximum(total**2 - np.abs(z) ** 2, ALIKE * total**2)
        above = total * np.abs(q) ** 2 - np.real(np.conj(z) * q**2)
        out[:, k] = np.divide(2.0 * above, apart, out=np.zeros(len(values)), where=apart > 0.0)
        wave = wave * rotation
    return out
