"""Every term of the library: what it offers is finite, of the right shape, and documented."""

from dataclasses import replace

import numpy as np
import pytest

from bench.simulation.frame import ARRAYS, Frame
from bench.simulation.terms import LIBRARY

VOCABULARY = [
    "te.harmonic",
    "te.sideband",
    "te.local_defect",
    "te.resonance",
    "te.lost_motion",
    "te.stiffness_nonlinear",
    "te.hysteresis",
    "te.drift_time",
    "te.velocity_nonlinear",
    "te.temperature_nonlinear",
    "sensor.motor_encoder",
    "sensor.timing_skew",
    "friction.stribeck",
    "friction.viscous_temperature",
    "friction.viscous_quadratic",
    "friction.position_dependent",
    "friction.run_in",
    "friction.presliding",
    "motor.torque_ripple",
    "motor.torque_constant",
    "load.unbalance",
    "thermal.sensor_lag",
    "thermal.second_mass",
    "thermal.ambient_drift",
    "thermal.convection_speed",
    "sensor.torque_zero_temperature",
    "sensor.torque_gain",
    "sensor.torque_nonlinearity",
    "sensor.torque_hysteresis",
]


def frame(n: int = 400) -> Frame:
    rng = np.random.default_rng(1)
    time = np.arange(n) * 0.25
    theta = 0.1 * np.cumsum(np.where(time % 40 < 20, 1.0, -1.0)) * 0.25
    values = {name: rng.normal(size=n) for name in ARRAYS}
    velocity = np.where(time % 40 < 20, 0.1, -0.1)
    values |= {
        "recording": np.repeat(np.arange(4), n // 4),
        "count": np.ones(n),
        "time": time,
        "elapsed": time % 25.0,
        "theta": theta,
        "q": theta,
        "velocity": velocity,
        "direction": np.sign(velocity),
        "last_direction": np.sign(velocity),
        "torque": 300.0 * np.sin(time / 7.0),
        "load_motor_torque": 300.0 * np.sin(time / 7.0),
        "temperature": 20.0 + time / 4.0 + 2.0 * np.repeat(np.arange(4), n // 4),
        "power": np.full(n, 50.0),
        "travel": np.abs(theta),
        "reversal_travel": np.full(n, 0.01),
        "reversal_time": time % 20.0,
        "reversed_before": np.ones(n),
        "steady": np.ones(n),
        "step": np.full(n, 0.25),
    }
    return Frame(ratio=185.0, **values)


def test_the_library_holds_the_vocabulary_and_the_nominal_terms() -> None:
    assert set(VOCABULARY) <= set(LIBRARY)
    assert sum(term.nominal for term in LIBRARY.values()) == 15


def test_friction_that_builds_up_goes_on_from_the_recording_before() -> None:
    every = frame()
    forms = {form.name: form for form in LIBRARY["friction.presliding"].forms["motor_torque"]}
    fresh, kept = (forms[name].columns(every, (0.5,))[:, 0] for name in ("dahl", "dahl_kept"))
    starts = np.flatnonzero(np.diff(every.recording, prepend=-1))
    assert np.array_equal(fresh[: starts[1]], kept[: starts[1]])
    for begin in starts[1:]:
        before, now = every.direction[begin - 1], every.direction[begin]
        # the friction of the last motion is still there: nothing is missing where that goes on, twice where it turns
        assert kept[begin] == pytest.approx(-now * (0.0 if before == now else 2.0), abs=0.2)
        assert abs(fresh[begin]) == pytest.approx(1.0, abs=0.2)


def test_springs_that_stretch_to_a_stribeck_curve_end_on_it() -> None:
    """One way at one speed for long, then the other: h*d where they are stretched; a Dahl spring where there is none
    of it (LuGre: Canudas de Wit et al., IEEE TAC 40 (1995) 419, equations 2 and 3).
    """
    forms = {form.name: form for form in LIBRARY["friction.presliding"].forms["motor_torque"]}
    assert all(forms[name].says == ("friction.stribeck",) for name in ("lugre", "lugre_kept"))
    rows, rate = 4000, 0.01
    speed = np.where(np.arange(rows) < rows // 2, 5.0, -5.0)
    one = frame()
    phi = np.cumsum(speed * rate)
    every = one.take(np.zeros(rows, dtype=np.int64))
    every = replace(
        every,
        velocity=speed / every.ratio,
        direction=np.sign(speed).astype(np.int64),
        theta=phi / every.ratio,
        q=phi / every.ratio,
        step=np.full(rows, rate),
        time=rate * np.arange(rows),
        elapsed=rate * np.arange(rows),
    )
    scale, higher, stribeck = 2.0, 0.6, 8.0
    found = forms["lugre"].columns(every, (scale, higher, stribeck))[:, 0]
    h = 1.0 + higher * np.exp(-((5.0 / stribeck) ** 2))
    assert found[rows // 2 - 1] == pytest.approx(h - 1.0, rel=1e-6)
    assert found[-1] == pytest.approx(-(h - 1.0), rel=1e-6)
    # dz = (1 - z*sgn(dx)/h)*dx/s_d from h, turned: z = -h + 2*h*exp(-x/(s_d*h))
    turned = np.arange(1, 200) * 5.0 * rate
    z = found[rows // 2 : rows // 2 + 199] - 1.0
    assert z == pytest.approx(-h + 2.0 * h * np.exp(-turned / (scale * h)), abs=1e-9)
    # rows of unequal length: the state follows the angle and nothing else
    uneven = replace(every, step=np.where(np.arange(rows) % 50 == 0, 50.0 * rate, rate))
    assert forms["lugre_kept"].columns(uneven, (scale, higher, stribeck))[:, 0] == pytest.approx(found, abs=1e-9)
    dahl = forms["dahl"].columns(every, (scale,))[:, 0]
    assert forms["lugre"].columns(every, (scale, 0.0, stribeck))[:, 0] == pytest.approx(dahl)


def test_a_friction_over_the_angle_that_grows_with_the_load_has_symbols_that_the_equation_shows() -> None:
    term = LIBRARY["friction.position_dependent"]
    plain, loaded = term.forms["motor_torque"]
    assert not {own.symbol for own in plain.linear} & {own.symbol for own in loaded.linear}
    assert all(own.symbol in term.equation for own in (*plain.linear, *loaded.linear))
