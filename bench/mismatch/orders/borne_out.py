"""Whether recordings held out bear out a law of the amplitudes."""

from __future__ import annotations

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.orders.model import TransmissionModel, steady_rows
from bench.mismatch.orders.periodic import Periodic
from bench.mismatch.recordings.rows import error_of_mean, hardly_acts


def borne_out(model: TransmissionModel, before: Periodic, after: Periodic, doubtful: bool) -> bool:
    """Whether steady rows held out bear out a law, predicted ``before`` it and ``after`` it.

    A ``doubtful`` one has to predict them better, if a true one would be seen in them; or else no worse by more than
    the standard error of that, from one recording to another. Any other goes where they are worse; if it adds less than
    half to them of what it adds to the fitted ones, only where they are worse by more than the standard error. As in
    the other channels (:func:`bench.mismatch.regression.refuted.borne_out`).
    """
    frame = model.rows.frame
    rows = np.flatnonzero(steady_rows(model) & (model.folds[frame.recording] < 0) & (model.rows.number > 0))
    if not rows.size:
        return True
    part, number = frame.take(rows), model.rows.number[rows]
    y = model.without_offset[rows]
    one, other = before.evaluate(part), after.evaluate(part)
    gained = (y - one) ** 2 - (y - other) ** 2
    error = error_of_mean(gained, part.recording, number)
    if error is None:
        return True
    mean = float(np.average(gained, weights=number))
    if not doubtful:
        return mean > (-criteria.ONE_ERROR * error if _hardly_acts(model, before, after) else 0.0)
    seen = float(np.average((one - other) ** 2, weights=number)) > criteria.ONE_ERROR * error
    return mean > (0.0 if seen else -criteria.ONE_ERROR * error)


def _hardly_acts(model: TransmissionModel, before: Periodic, after: Periodic) -> bool:
    """Whether a law adds far less to the steady rows held out than to the fitted ones."""
    rows = steady_rows(model) & (model.rows.number > 0)
    part, held = model.rows.frame.take(rows), model.folds[model.rows.frame.recording[rows]] < 0
    return hardly_acts(after.evaluate(part) - before.evaluate(part), model.rows.number[rows], held, ~held)
