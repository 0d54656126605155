"""Feedforward, C export, comparison, report."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.errors import ConfigurationError
from bench.identification import Identification, to_simulation
from bench.identification.comparison.compare import compare, holm
from bench.identification.compensation.c_export import export_c
from bench.identification.compensation.feedforward import Loop, Series, input_angle, ripple_free, steady_phases
from bench.identification.loads import KEY, torque_range
from bench.identification.report import write_report
from bench.simulation import Parameter, Simulation, Term, TransmissionErrorModel
from tests.bench.identification.synthetic import true_model

SERIES = Series(np.array([1.0, 46.0]), np.array([5e-5, 2e-5]), np.array([0.3, -1.0]))


def test_input_angle_makes_the_load_side_stand_where_it_should() -> None:
    wanted = np.linspace(0.0, 7.0, 300)
    theta = input_angle(SERIES, wanted)
    assert theta + SERIES.value(theta) == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize(("gain", "left"), [(0.0, 1.0), (1.0, 0.0), (-1.0, 2.0)])
def test_taking_the_error_off_removes_it_and_adding_it_doubles_it(gain: float, left: float) -> None:
    velocity, start, h = 0.15, 0.4, 0.0005
    phases = steady_phases(SERIES, start, velocity, 2.0 * np.pi / velocity, 0.0, gain)
    speeds, at = [], phases[0].velocity
    for phase in phases:
        n = round(phase.duration_s / h)
        speeds.append(at + (phase.velocity - at) * (np.arange(n) + 0.5) / n)
        at = phase.velocity
    theta = start + np.cumsum(np.concatenate(speeds)) * h
    time = np.arange(1, theta.size + 1, dtype=np.float64) * h
    load = np.asarray(theta + SERIES.value(theta), dtype=np.float64)
    found = ripple_free(time, theta, load, velocity, [150], SERIES.orders)
    plain = float(np.sqrt(0.5 * np.sum(SERIES.amplitude**2)))
    assert found.rmse == pytest.approx(left * plain, abs=0.03 * plain)
    # order 46 is 2 % weaker in a speed taken over 5 ms
    ripple = velocity * float(np.sqrt(0.5 * np.sum((SERIES.orders * SERIES.amplitude) ** 2)))
    assert found.speed == pytest.approx(left * ripple, abs=0.05 * ripple)


@pytest.mark.parametrize(("allowed_for", "most"), [(False, 1.0), (True, 0.02)])
def test_the_drives_loop_gives_way_to_the_load_unless_it_is_allowed_for(allowed_for: bool, most: float) -> None:
    """A shaft under a PI loop and the load's torque by way of TE'; what is left against the error itself."""
    loop, velocity, torque, h = Loop(0.6, 0.02, 0.0029, 0.006, 185.0), 0.15, 700.0, 0.0005
    series = Series(np.array([276.0]), np.array([8e-6]), np.array([0.4]))
    extra = loop.extra(series, 1.0, torque, velocity) if allowed_for else None
    phases = steady_phases(series, 0.0, velocity, 2.0, torque, 1.0, extra)
    wanted = np.interp(
        np.arange(4000) * h, np.arange(401) * 0.005, [phases[0].velocity, *(phase.velocity for phase in phases)]
    )
    theta, speed, integral = 0.0, velocity * loop.ratio, loop.viscous * velocity * loop.ratio + torque / loop.ratio
    at = np.empty(wanted.size)
    for n, v in enumerate(wanted):
        for _ in range(4):
            off = v * loop.ratio - speed
            integral += loop.gain / loop.integral_time * off * h / 4
            load = (1.0 + series.slope(np.array([theta]))[0]) * torque / loop.ratio
            speed += (loop.gain * off + integral - load - loop.viscous * speed) / loop.inertia * h / 4
            theta += speed / loop.ratio * h / 4
        at[n] = theta
    error = at + series.value(at) - velocity * h * np.arange(1, at.size + 1)
    tail = slice(1000, None)
    columns = np.column_stack([np.ones(3000), np.sin(276.0 * at[tail]), np.cos(276.0 * at[tail])])
    left = np.hypot(*np.linalg.lstsq(columns, error[tail], rcond=None)[0][1:]) / series.amplitude[0]
    assert left < most
    assert allowed_for or left > 0.1


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler here")
def test_c_function_agrees_with_ours_to_rounding(tmp_path: Path) -> None:
    export_c(Simulation.nominal().with_transmission_error(true_model()), tmp_path)
    command = [
        "cc",
        "-std=c99",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-O2",
        "transmission_error.c",
        "test_transmission_error.c",
    ]
    subprocess.run([*command, "-lm", "-o", "test"], cwd=tmp_path, check=True)
    result = subprocess.run([tmp_path / "test"], capture_output=True, text=True, check=False)
    assert result.returncode == 0
    assert float(result.stdout) < 1e-12


def test_c_export_of_half_a_model_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="no transmission error"):
        export_c(Simulation.nominal(), tmp_path)
    half = TransmissionErrorModel(true_model().positive, None)
    with pytest.raises(ConfigurationError, match="no negative direction"):
        export_c(Simulation.nominal().with_transmission_error(half), tmp_path)


def test_a_gearbox_compared_with_itself_has_not_changed(found: Identification) -> None:
    simulation = to_simulation(found)
    changes = compare(simulation, simulation)
    assert changes
    assert not any(c.changed for c in changes)


def test_wear_is_found_where_it_is_and_nowhere_else(found: Identification) -> None:
    before = to_simulation(found)
    model = before.transmission_error()
    assert model is not None
    assert model.positive is not None
    k = int(np.flatnonzero(model.positive.orders == 46)[0])
    amplitude = model.positive.amplitude.copy()
    amplitude[k, 9] += 5e-7
    worn = before.with_transmission_error(replace(model, positive=replace(model.positive, amplitude=amplitude)))
    worn = worn.with_term(Term("friction.coulomb", parameters={"f_c": Parameter(0.52, "N*m", 1e-3)}))
    changed = [c.what for c in compare(before, worn) if c.changed]
    assert set(changed) == {"order 46, positive", "friction.coulomb f_c"}


def test_what_only_one_of_two_has_measured_is_not_judged(found: Identification) -> None:
    """A term that recordings do not determine is left at 0, and its covariance too."""
    before = to_simulation(found)
    model = before.transmission_error()
    assert model is not None
    assert model.positive is not None
    positive = model.positive
    assert positive.covariance is not None
    assert positive.offset_covariance is not None
    k = int(np.flatnonzero(positive.orders == 46)[0])
    amplitude, covariance = positive.amplitude.copy(), positive.covariance.copy()
    offset, offset_covariance = positive.offset.copy(), positive.offset_covariance.copy()
    amplitude[k, 3], offset[3] = 0.0, 0.0
    for place in (covariance[k], offset_covariance):
        place[3, :] = place[:, 3] = 0.0
    changes = {
        "amplitude": amplitude,
        "covariance": covariance,
        "offset": offset,
        "offset_covariance": offset_covariance,
    }
    one_torque = before.with_transmission_error(replace(model, positive=replace(positive, **changes)))
    judged = {c.what: c for c in compare(before, one_torque)}
    for what in ("order 46, positive", "compliance, positive"):
        assert np.isnan(judged[what].p_value)
    assert not any(c.changed for c in judged.values())
    assert np.isfinite(judged["compliance, negative"].p_value)


@pytest.mark.parametrize(
    ("torques", "judged"),
    [([-600.0, 600.0], True), ([-560.0, 610.0], True), ([0.0, 600.0], False), ([-600.0, 300.0], False), (None, False)],
)
def test_compliance_is_judged_over_one_range_of_torques_only(
    found: Identification, torques: list[float] | None, judged: bool
) -> None:
    before = to_simulation(found)
    series = before.terms["te.fourier"]
    stated = before.with_term(replace(series, extra={**series.extra, KEY: {"positive": [-600.0, 600.0]}}))
    other = {} if torques is None else {KEY: {"positive": torques}}
    after = before.with_term(replace(series, extra={k: v for k, v in series.extra.items() if k != KEY} | other))
    changes = {c.what: c for c in compare(stated, after)}
    assert np.isfinite(changes["compliance, positive"].p_value) == judged
    # the orders have covariances of their own points
    assert np.isfinite(changes["order 46, positive"].p_value)


def test_the_range_of_torques_of_the_recordings_stands_beside_the_series(found: Identification) -> None:
    for direction, result in found.refined.items():
        torque = result.design.inputs[:, 0]
        assert torque_range(to_simulation(found), direction) == pytest.approx((torque.min(), torque.max()), abs=1e-3)


def test_parameters_without_deviation_are_not_judged() -> None:
    def one(value: float) -> Simulation:
        return Simulation.nominal().with_term(Term("friction.viscous", parameters={"f_v": Parameter(value)}))

    (change,) = compare(one(1.0), one(2.0))
    assert not change.changed
    assert np.isnan(change.p_value)


@given(st.lists(st.floats(0.0, 1.0), max_size=30))
def test_holm_rejects_between_bonferroni_and_single_tests(p_values: list[float]) -> None:
    verdicts = holm(p_values)
    for p, rejected in zip(p_values, verdicts, strict=True):
        assert rejected or p > 0.05 / len(p_values)
        assert not rejected or p <= 0.05


def test_report_is_one_file_that_needs_nothing_else(found: Identification, tmp_path: Path) -> None:
    page = write_report(found, tmp_path / "report").read_text(encoding="utf-8")
    assert page.count("data:image/png;base64,") >= 6
    assert "http" not in page.replace("http-equiv", "")
    for words in (
        "By load torque",
        "By velocity",
        "By temperature",
        "Validation example",
        "input gear",
        "Not determined",
        "<math>",
        "mN·m",
        "Coulomb friction",
        "Save the figure",
    ):
        assert words in page
    shown = re.sub(r"<[^>]*>", " ", page)
    assert not re.search(r"\b(nan|inf)\b", shown)
    opened = page[page.index("<div class=verdict>") : page.index("<figure>")]
    assert opened.count("<p>") == 3
    assert "Largest orders" in opened or "largest orders +" in opened


def test_a_report_says_what_changed_since_the_last_campaign(found: Identification, tmp_path: Path) -> None:
    page = write_report(found, tmp_path / "report", ("Since <spring>: nothing.",)).read_text(encoding="utf-8")
    assert "Against the last campaign of this gearbox" in page
    assert "Since &lt;spring&gt;: nothing." in page
