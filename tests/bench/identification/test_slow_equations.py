from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.identification import Identification
from bench.identification.balances.heat import identify_heat
from bench.identification.balances.slow_equations import friction_rows, identify_friction
from bench.identification.samples.blocks import make_blocks
from bench.identification.samples.reduction import Reduction
from bench.identification.statistics.regression import regress

TRUE = {"f_c": 0.5, "f_v": 0.006, "f_vT": -1e-4, "f_l": 0.04, "tau_0": 0.04 - 2.0 / 185.0, "J": 0.0029}


def test_friction_comes_out_with_its_parameters(found: Identification) -> None:
    for symbol, true in TRUE.items():
        assert found.friction.values[symbol] == pytest.approx(true, rel=0.01), symbol
        assert found.friction.std[symbol] < 0.02 * abs(true)


def test_load_side_comes_out_with_its_parameters(found: Identification) -> None:
    assert found.load_side.values["f_b"] == pytest.approx(8.0, abs=0.1)
    assert found.load_side.values["J_L"] == pytest.approx(3.0, abs=0.3)


def test_heat_is_not_invented_where_nothing_warms(found: Identification) -> None:
    assert not found.heat.values
    assert any("C, R and T_amb" in s for s in found.sentences)


def test_only_forward_motion_leaves_the_constant_out(found: Identification) -> None:
    forward = [r for r in found.reductions if r.steady is not None and r.steady.window.direction > 0]
    fit, said = identify_friction(friction_rows(forward))
    assert "tau_0" in fit.undetermined
    assert any("tau_0" in s and "both directions" in s for s in said)


def test_one_temperature_leaves_its_coefficient_out(found: Identification) -> None:
    cold = [r for r in found.reductions if np.nanmax(r.blocks.temperature) < 23.0]
    fit, said = identify_friction(friction_rows(cold))
    assert "f_vT" in fit.undetermined
    assert any(s.startswith("f_vT") for s in said)
    assert fit.values["f_c"] == pytest.approx(0.5, rel=0.02)


def test_no_motion_gives_a_sentence() -> None:
    fit, said = identify_friction(friction_rows([]))
    assert not fit.values
    assert "Friction is not identified" in said[0]


def test_regression_names_what_is_collinear() -> None:
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=500), rng.normal(size=500)
    fit = regress({"a": a, "b": b, "twin": a + 1e-6 * b, "zero": 0 * a}, 2 * a - b, np.arange(500) // 50)
    assert set(fit.undetermined) == {"twin", "zero"}
    assert fit.values == pytest.approx({"a": 2.0, "b": -1.0})


def _heated(name: str, start: float, power: float, seconds: float, seed: int) -> Reduction:
    """One recording of the nominal heat balance, C 25 kJ/K, R 0.25 K/W, 21 °C, with a PT100's noise and resolution."""
    rate = 20.0
    t = np.arange(int(seconds * rate)) / rate
    tau = 25e3 * 0.25
    end = 21.0 + power * 0.25
    temperature = end + (start - end) * np.exp(-t / tau) + 0.02 * np.random.default_rng(seed).normal(size=t.size)
    omega = 150.0
    channels = {
        "time": t,
        "motor_angle": omega * t,
        "load_angle": omega * t / 185.0,
        "motor_torque": np.full(t.size, power / omega),
        "load_torque": np.zeros(t.size),
        "temperature": np.round(temperature, 1),
    }
    blocks = make_blocks(channels, rate, np.zeros(t.size, dtype=bool), np.empty(0, dtype=np.int64))
    return Reduction(name, "heating", 185.0, 0.0, (0.0, 0.0, 0.0), False, blocks, None, None, None, ())


def test_heat_balance_comes_out_of_heating_and_cooling() -> None:
    runs = [(22.0, 300.0), (30.0, 300.0), (45.0, 2.0), (60.0, 2.0), (50.0, 250.0)]
    fit = identify_heat([_heated(f"h{i}", start, power, 1500.0, i) for i, (start, power) in enumerate(runs)])
    assert fit.values["C"] == pytest.approx(25e3, rel=0.01)
    assert fit.values["R"] == pytest.approx(0.25, rel=0.01)
    assert fit.values["T_amb"] == pytest.approx(21.0, abs=0.3)
    assert fit.rmse < 0.05
    assert abs(fit.values["C"] - 25e3) < 5.0 * fit.std["C"]


def test_heating_by_a_few_steps_of_the_sensor_determines_nothing() -> None:
    fit = identify_heat([_heated(f"h{i}", 22.0 + i, 300.0, 120.0, i) for i in range(5)])
    assert not fit.values
    assert "1.5 K at most" in fit.sentences[0] or "1.4 K at most" in fit.sentences[0]


def test_emps_meets_its_published_parameters() -> None:
    from scipy.io import loadmat

    from bench.identification.samples.band_limited import band_limited_rows

    file = Path(__file__).parents[4] / "shared" / "real" / "emps" / "DATA_EMPS.mat"
    if not file.exists():
        pytest.skip("../shared/real/emps is absent: no real recording to identify")
    data = loadmat(file)
    force = float(data["gtau"].item()) * data["vir"].ravel()
    rows = band_limited_rows({"motor_angle": data["qm"].ravel(), "motor_torque": force}, 1000.0, 1.0, 0)
    assert rows is not None
    fit, _ = identify_friction(rows)
    published = {"J": 95.1089, "f_v": 203.5034, "f_c": 20.3935, "tau_0": -3.1648}
    for symbol, value in published.items():
        assert fit.values[symbol] == pytest.approx(value, rel=0.01), symbol
    assert set(fit.undetermined) == {"f_l", "f_vT"}
