from __future__ import annotations

import json

import numpy as np
import pytest

from bench.identification import Identification, to_json, to_simulation
from bench.identification.summary import verdict
from bench.identification.validation import revolution, table
from bench.simulation import evaluate
from bench.simulation.terms.nominal.transmission_error import PAPER_ORDERS


def test_table_of_one_revolution_is_the_series() -> None:
    rng = np.random.default_rng(0)
    z = 1e-5 * (rng.normal(size=3) + 1j * rng.normal(size=3))
    orders = [1.0, 46.0, 276.0]
    grid = np.linspace(0.0, 2.0 * np.pi, 2**12 + 1)
    assert revolution(orders, z, 12) == pytest.approx(evaluate(grid, orders, np.abs(z), np.angle(z)), abs=1e-15)


def test_scores_are_those_of_the_samples(found: Identification) -> None:
    r = found.reductions[0]
    assert r.steady is not None
    theta = r.steady.angle / 2.0**32 * 2.0 * np.pi
    y = r.steady.sample.astype(np.float64)
    columns = [np.ones_like(theta)]
    for f in (*PAPER_ORDERS, 150, 300):
        columns += [np.sin(f * theta), np.cos(f * theta)]
    x = np.column_stack(columns)
    rest = y - x @ np.linalg.lstsq(x, y, rcond=None)[0]
    got = next(s for s in found.scores if s.recording_id == r.recording_id)
    assert got.rmse["bound"] == pytest.approx(np.sqrt(np.mean(rest**2)), rel=1e-3)
    assert got.mae["bound"] == pytest.approx(np.mean(np.abs(rest)), rel=1e-3)


def test_summary_is_plain_json_and_says_who_is_better(found: Identification) -> None:
    summary = json.loads(json.dumps(to_json(found), allow_nan=False))
    assert summary["refined_better_on_validation"] is True
    assert "is better than the paper's" in verdict(found)
    rows = table(found.scores)
    assert rows["identification"]["positive"]["bound"]["recordings"] == 36
    assert summary["paper_table"]["validation"]["negative"]["rmse"] == 2.82e-5
    changes = summary["sensitivities"]["positive"]["A"]
    # The paper: quadratic terms are the more sensitive ones, torque's most of all, the linear ones alike.
    assert changes["τ²"] < changes["τ"]
    assert changes["τ"] == pytest.approx(changes["T"], rel=0.05)


def test_simulation_file_has_values_and_leaves_out_what_is_not_determined(found: Identification) -> None:
    simulation = to_simulation(found)
    assert simulation.value("friction.coulomb", "f_c") == pytest.approx(0.5, rel=0.01)
    assert simulation.value("thermal.loss_heating", "C") is None
    paper = to_simulation(found, "paper").transmission_error()
    refined = simulation.transmission_error()
    assert paper is not None
    assert refined is not None
    assert paper.positive is not None
    assert paper.positive.covariance is None
