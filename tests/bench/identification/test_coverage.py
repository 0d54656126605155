from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import t
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.cli.benchmarks import coverage_runs
from bench.cli.benchmarks.coverage import pairs_of
from bench.cli.benchmarks.coverage_runs import campaign_text
from bench.identification import Identification, to_simulation
from bench.identification.comparison.coverage import LIMIT, deviates, normal_deviate
from bench.identification.comparison.coverage_table import comparisons, interval, page, series
from bench.identification.comparison.power import CHANGES, power
from bench.identification.statistics.freedom import parameter_freedom, series_freedom
from bench.simulation import FourierSet, Parameter, Simulation, Term, TransmissionErrorModel
from bench.simulation._coefficients import fourier_to_json
from tests.bench.identification.synthetic import true_model


def test_deviates_are_normal_where_the_deviation_rests_on_little() -> None:
    drawn = t.rvs(5, size=4000, random_state=1)
    z = normal_deviate(drawn, np.ones(4000), 5.0)
    assert np.mean(np.abs(z) < LIMIT) == pytest.approx(0.95, abs=0.012)
    assert z.std() == pytest.approx(1.0, abs=0.04)
    assert np.isnan(normal_deviate(np.ones(1), np.zeros(1), 5.0)[0])


def test_truth_is_compared_with_what_was_found(found: Identification) -> None:
    truth = {
        "nominal": {"friction.coulomb": {"f_c": 0.5}, "thermal.loss_heating": {"C": 25e3}},
        "transmission_error": fourier_to_json(true_model(), series=True)["parameters"],
    }
    truth["transmission_error"]["positive"]["a0"] = true_model().positive.offset.tolist()  # type: ignore[union-attr]
    deviations = deviates(to_simulation(found), truth)
    # the synthetic campaign does not warm: nothing is claimed of C
    assert set(deviations["parameters"]) == {"f_c"}
    assert abs(deviations["parameters"]["f_c"]["z"]) < 4.0
    z = np.asarray(deviations["series"]["positive"]["A"], dtype=float)
    assert z.size == 200
    assert np.mean(np.abs(z) < LIMIT) > 0.88


def test_order_that_the_plant_lacks_has_the_amplitude_zero_and_no_phase() -> None:
    amplitude, phase = np.zeros((2, 10)), np.zeros((2, 10))
    amplitude[:, 9], phase[:, 9] = (5.0e-6, 3.0e-6), (0.3, 1.0)
    positive = FourierSet(
        np.array([3.0, 14.0]), amplitude, phase, np.zeros(10), np.full((2, 10), 1e-6), np.full((2, 10), 0.1)
    )
    model = Simulation.nominal().with_transmission_error(TransmissionErrorModel(positive, None))
    order_3 = {"A": amplitude[0].tolist(), "phi": phase[0].tolist()}
    truth = {"nominal": {}, "transmission_error": {"positive": {"3": order_3, "a0": [0.0] * 10}}}
    z = deviates(model, truth)["series"]["positive"]
    assert z["A"] == z["phi"] == [0.0] * 10
    assert z["absent"][:9] == [0.0] * 9
    assert z["absent"][9] == pytest.approx(3.0)
    campaign = {"series": {"positive": z}}
    assert "| positive | amplitudes of orders that the plant lacks | 10 | 90.0 % | 90 to 90 % | no |" in series(
        [campaign]
    )
    assert "| positive | phases | 10 | 100.0 % | 100 to 100 % | no |" in series([campaign])


def test_degrees_of_freedom_stand_in_the_file_and_are_read_back(found: Identification, tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    to_simulation(found).save(path)
    read = Simulation.load(path)
    assert parameter_freedom(read.terms["friction.coulomb"], "f_c") == pytest.approx(
        found.friction.freedom["f_c"], abs=0.01
    )
    assert series_freedom(read, "positive") == found.refined["positive"].freedom
    assert series_freedom(Simulation.nominal(), "positive") == float("inf")


def _model(offsets: np.ndarray, covariance: np.ndarray, freedom: float | None) -> Simulation:
    size = offsets.shape[0]
    amplitude = np.zeros((size, 10))
    amplitude[:, 9] = 1e-5 + offsets
    matrix = np.zeros((size, 20, 20))
    matrix[:, 9, 9] = matrix[:, 19, 19] = covariance
    one = FourierSet(np.arange(1.0, size + 1), amplitude, np.zeros((size, 10)), np.zeros(10), covariance=matrix)
    model = Simulation.nominal().with_transmission_error(TransmissionErrorModel(one, None))
    extra = {} if freedom is None else {"freedom": {"positive": freedom}}
    return model.with_term(Term("te.fourier", coefficients=TransmissionErrorModel(one, None), extra=extra))


def test_changes_that_are_put_in_are_found_when_large_enough() -> None:
    sharp = _model(np.zeros(60), np.full(60, 1e-20), 20.0)
    found = power(sharp, sharp)
    assert found["order 46"] == [True, True, True]
    blunt = _model(np.zeros(60), np.full(60, 1e-12), 20.0)
    assert power(blunt, blunt)["order 46"] == [False, False, False]
    assert power(sharp, sharp)["Coulomb friction"] is None
    friction = Term("friction.coulomb", parameters={"f_c": Parameter(0.5, "N*m", 0.003)})
    assert power(*(sharp.with_term(friction),) * 2)["Coulomb friction"] == [False, False, True]


def test_a_change_that_the_models_cannot_have_is_not_counted() -> None:
    row: dict[str, Any] = {"before": 1, "after": 2, "compared": 5, "changed": []}
    row["power"] = {name: None if name == "order 46" else [False, True, True] for name in CHANGES}
    lines = comparisons([row, row])
    assert "| order 46 | not in these models | not in these models | not in these models |" in lines
    assert "| order 1 | found in 0 of 2 | found in 2 of 2 | found in 2 of 2 |" in lines
    few = _model(np.zeros(3), np.full(3, 1e-20), 20.0)
    assert power(few, few)["order 46"] is None


def test_campaigns_differ_and_are_the_same_again() -> None:
    assert campaign_text(3, 1650.0) == campaign_text(3, 1650.0)
    assert campaign_text(3, 1650.0) != campaign_text(4, 1650.0)
    torques = tomllib.loads(campaign_text(3, 1650.0))["stages"][0]["points"][0]["load_torques"]
    halves = tomllib.loads(campaign_text(3, 825.0))["stages"][0]["points"][0]["load_torques"]
    assert [float(t.split()[0]) for t in torques] == pytest.approx([2 * float(t.split()[0]) for t in halves], abs=0.2)


def test_interval_of_a_share() -> None:
    low, high = interval(38, 40)
    assert low == pytest.approx(0.831, abs=0.002)
    assert high == pytest.approx(0.994, abs=0.002)
    assert interval(40, 40)[1] == 1.0


def test_command_goes_on_where_it_was(
    campaign_folder: Path, found: Identification, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []

    def stand_in(seed: int, work: Path, bench: str, rated_torque: float) -> Path:
        asked.append(seed)
        work.mkdir(exist_ok=True)
        return campaign_folder

    monkeypatch.setattr(coverage_runs, "recordings", stand_in)
    # identified once for all tests
    monkeypatch.setattr("bench.identification.identify_folder", lambda folder, options: found)
    store, table = tmp_path / "coverage.json", tmp_path / "coverage.md"
    line = ["benchmark", "coverage", "--campaigns", "2", "--work", str(tmp_path / "work"), "--store", str(store)]
    first = CliRunner().invoke(make_app(), [*line, "--table", str(table)])
    assert first.exit_code == 0, first.output
    assert asked == [1, 2]
    content: dict[str, Any] = json.loads(store.read_text())
    assert [c["seed"] for c in content["campaigns"]] == [1, 2]
    # the same recordings twice: nothing differs
    assert [p["changed"] for p in content["pairs"]] == [[]]
    assert set(content["pairs"][0]["power"]) == set(CHANGES)
    assert "| f_c |" in table.read_text()
    assert table.read_text() == page(content)
    CliRunner().invoke(make_app(), line)
    assert asked == [1, 2]
    CliRunner().invoke(make_app(), [*line, "--first", "2"])
    assert asked == [1, 2, 3]


def test_a_store_of_something_else_is_refused(tmp_path: Path) -> None:
    store = tmp_path / "other.json"
    store.write_text('{"format": "bench-proof"}')
    result = CliRunner().invoke(
        make_app(), ["benchmark", "coverage", "--store", str(store), "--work", str(tmp_path)], standalone_mode=False
    )
    assert "is no bench-coverage of rh380n" in str(result.exception)


@pytest.mark.parametrize(("campaigns", "pairs"), [(1, 0), (2, 1), (4, 6), (13, 40), (40, 40)])
def test_pairs_are_different_and_spread_over_the_campaigns(campaigns: int, pairs: int) -> None:
    made = pairs_of(list(range(1, campaigns + 1)))
    assert len(made) == len({frozenset(pair) for pair in made}) == pairs
    apart = made[: campaigns // 2]
    assert len({seed for pair in apart for seed in pair}) == 2 * len(apart)
    often = [sum(seed in pair for pair in made) for seed in range(1, campaigns + 1)]
    assert max(often) - min(often) <= 2
