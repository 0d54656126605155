"""What the load torque has without a name may be an error of its sensor: the transmission error is asked beside it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bench.mismatch.regression.model import Chosen, add_block
from bench.mismatch.regression.nameless_load import nameless_load
from bench.mismatch.regression.problem import NUISANCE
from bench.mismatch.regression.regressors import Free, named
from bench.mismatch.regression.search import begun
from bench.simulation.tables import Grid
from bench.simulation.terms import MOTOR_TORQUE
from tests.bench.mismatch.regression.synthetic import campaign, problem


def test_the_twist_of_what_has_no_name_is_a_column_of_its_own() -> None:
    frame = campaign()
    jump = 3.0 * (frame.temperature > 30.0)
    own = problem(frame, jump + np.random.default_rng(1).normal(0.0, 0.01, frame.size))
    search = begun(own)
    table = Free(MOTOR_TORQUE, (Grid(("temperature",), "1", ((22.0, 29.9, 30.1, 40.0),)),))
    function = Chosen(add_block(own, search.model.bank, table, 1e-3))
    churn = Chosen(add_block(own, search.model.bank, named("friction.viscous_quadratic", MOTOR_TORQUE, "square")))
    model = replace(search.model, chosen=[function, churn], fit=search.model.refitted([function, churn]))
    (term,) = nameless_load(model)
    assert term.regressor.effect == NUISANCE
    (column,) = term.regressor.columns(frame).T
    assert np.allclose(column, model.contribution(function, frame))
    assert np.ptp(column) > 2.0
    assert nameless_load(replace(model, chosen=[churn], fit=model.refitted([churn]))) == ()
