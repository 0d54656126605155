"""How far the offset's polynomial may bend is asked again beside what was found."""

from __future__ import annotations

import numpy as np

from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.model import Block, add_base, add_block, plain_residual, prepare_bank
from bench.mismatch.regression.prior import settled
from bench.mismatch.regression.problem import BaseTerm, ChannelProblem
from bench.mismatch.regression.regressors import named
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms import LIBRARY, TRANSMISSION_ERROR
from tests.bench.mismatch.regression.synthetic import campaign

SIGMA = 2e-6
FRAME = campaign(40)
LINEAR = (4, 5)
"""numbers of the monomials that are linear in speed and temperature"""


def problem(frame: Frame, y: FloatArray) -> ChannelProblem:
    """The transmission error with its offset alone; every recording is a fold."""
    term = LIBRARY["te.offset"]
    base = BaseTerm(named("te.offset", TRANSMISSION_ERROR, term.forms[TRANSMISSION_ERROR][0].name))
    folds = np.arange(int(frame.recording.max()) + 1, dtype=np.int64)
    rows = Rows(frame, y, frame.count)
    return ChannelProblem(TRANSMISSION_ERROR, rows, np.ones(frame.size, dtype=bool), folds, (base,))


def bent(block: Block) -> float:
    """Largest spread that the prior of the linear coefficients has, in units of what its column adds."""
    precision = block.precision.reshape(2, -1)[:, list(LINEAR)]
    return float(np.max(1.0 / np.sqrt(precision[precision > 0.0])))


def test_beside_an_effect_the_offset_need_not_bend_in_its_place() -> None:
    """A level that changes at 31 °C is drawn by no polynomial; without it in the model the straight line tries to."""
    term = LIBRARY["te.temperature_nonlinear"]
    form = next(f for f in term.forms[TRANSMISSION_ERROR] if f.name == "transition")
    change = named("te.temperature_nonlinear", TRANSMISSION_ERROR, form.name, (31.0, 0.5))
    y = 20.0 * SIGMA * change.columns(FRAME)[:, 0] + np.random.default_rng(8).normal(0.0, SIGMA, FRAME.size)
    own = problem(FRAME, np.asarray(y))
    bank, *_ = prepare_bank(own, plain_residual(own))
    (without,) = settled(own, bank, add_base(own, bank))
    (beside,) = settled(own, bank, [without], [add_block(own, bank, change)])
    assert bent(beside) < 0.2 * bent(without)


def test_a_straight_line_may_be_as_steep_as_it_is() -> None:
    """Speed and temperature change the offset a thousand times its noise: the prior does not hold that back."""
    rng = np.random.default_rng(9)
    speed, temperature = np.abs(FRAME.velocity) / 0.1, (FRAME.temperature - 35.0) / 15.0
    y = 1000.0 * SIGMA * (speed + 2.0 * temperature) + rng.normal(0.0, SIGMA, FRAME.size)
    own = problem(FRAME, np.asarray(y))
    bank, *_ = prepare_bank(own, rng.normal(0.0, SIGMA, int(own.train.sum())))
    (block,) = settled(own, bank, add_base(own, bank))
    columns = [bank.columns.column(i) for i in block.indices]
    energy = np.array([float(np.mean(c**2)) for c in columns])[list(LINEAR)]
    spread = np.sqrt(energy / block.precision[list(LINEAR)])
    assert spread.min() > 100.0
    curved = [0, 1, 2]
    assert np.all(block.precision[curved] > 0.0)
