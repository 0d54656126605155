"""Quantities composed of auxiliary ones, by their names."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.errors import ConfigurationError
from bench.simulation.composed import parts_of, summed
from bench.simulation.frame import Frame
from bench.simulation.quantities import quantity
from tests.bench.mismatch.regression.synthetic import campaign


@pytest.fixture
def frame() -> Frame:
    own = campaign(2)
    rng = np.random.default_rng(4)
    return replace(own, aux={"q2": rng.normal(size=own.size), "q-4": rng.normal(size=own.size)})


def test_sums_of_angles(frame: Frame) -> None:
    name = f"aux/cos({summed(('angle', 'q2', 'q-4'), (1, 1, -1))})"
    assert name == "aux/cos(angle + q2 - q-4)"
    assert quantity(name, frame) == pytest.approx(np.cos(frame.q + frame.aux["q2"] - frame.aux["q-4"]))
    assert parts_of("cos(angle + q2 - q-4)") == ("q2", "q-4")


def test_size_sign_product(frame: Frame) -> None:
    assert quantity("aux/abs(q2)", frame) == pytest.approx(np.abs(frame.aux["q2"]))
    assert quantity("aux/sign(q2)", frame) == pytest.approx(np.sign(frame.aux["q2"]))
    assert quantity("aux/product(q2, q-4)", frame) == pytest.approx(frame.aux["q2"] * frame.aux["q-4"])
    assert parts_of("product(q2, q-4)") == ("q2", "q-4")
    assert parts_of("q2") == ("q2",)


def test_a_rate_stops_at_the_end_of_a_recording(frame: Frame) -> None:
    steady = replace(frame, aux={"p": 3.0 * frame.elapsed + 100.0 * frame.recording})
    assert quantity("aux/rate(p)", steady) == pytest.approx(np.full(frame.size, 3.0))


def test_what_is_not_there_is_said(frame: Frame) -> None:
    with pytest.raises(ConfigurationError, match="no quantity 'aux/q9'"):
        quantity("aux/sin(angle + q9)", frame)


def swung(rate: float = 400.0) -> tuple[Frame, np.ndarray, np.ndarray]:
    """An output that swings beside a joint that swings otherwise, as one recording; the joint's rates."""
    own = campaign(1)
    time = np.arange(2000) / rate
    q2, speed2, acceleration2 = 0.7 * np.sin(2.1 * time), 1.47 * np.cos(2.1 * time), -3.087 * np.sin(2.1 * time)
    arrays = {name: np.zeros(time.size) for name in ("theta", "torque", "temperature", "travel")}
    grown = own.take(np.zeros(time.size, dtype=np.int64))
    return (
        replace(
            grown,
            **arrays,
            ratio=1.0,
            elapsed=time,
            step=np.full(time.size, 1.0 / rate),
            q=np.sin(1.3 * time),
            velocity=1.3 * np.cos(1.3 * time),
            acceleration=-1.69 * np.sin(1.3 * time),
            aux={"q2": q2},
        ),
        speed2,
        acceleration2,
    )


def test_second_rates_are_those_of_the_frame_or_from_row_to_row() -> None:
    frame, speed, acceleration = swung()
    assert quantity("aux/rate(q2)", frame)[5:-5] == pytest.approx(speed[5:-5], abs=1e-3)
    assert quantity("aux/acceleration(q2)", frame)[5:-5] == pytest.approx(acceleration[5:-5], abs=1e-3)
    held = replace(frame, aux=frame.aux | {"acceleration(q2)": np.full(frame.size, 4.0)})
    assert quantity("aux/acceleration(q2)", held) == pytest.approx(4.0)


def test_an_inertia_that_changes_takes_what_lagrange_says() -> None:
    frame, *_ = swung()
    # kinetic energy cos(q + q2) * v²/2 of the output: d/dt(dT/dv) - dT/dq
    angle = frame.q + frame.aux["q2"]
    momentum = np.cos(angle) * frame.velocity
    torque = np.gradient(momentum, frame.elapsed) + 0.5 * np.sin(angle) * frame.velocity**2
    told = quantity("aux/momentum(cos(angle + q2))", frame)
    assert told[5:-5] == pytest.approx(torque[5:-5], abs=2e-3)
    assert parts_of("momentum(cos(angle + q2))") == ("q2",)
    with pytest.raises(ConfigurationError, match="sine or cosine"):
        quantity("aux/momentum(q2)", frame)


def test_a_body_on_a_joint_s_arm_is_a_double_pendulum_s() -> None:
    frame, speed, acceleration = swung()
    # the pull of the arm's tip, one metre off, across a body of 1 kg a metre long that stands at q to the arm
    tip = np.exp(1j * frame.aux["q2"])
    pull = (1j * acceleration - speed**2) * tip
    across = 1j * np.exp(1j * (frame.aux["q2"] + frame.q))
    torque = np.real(pull * np.conj(across))
    told = quantity("aux/carried(cos(angle), q2)", frame)
    assert told[5:-5] == pytest.approx(torque[5:-5], abs=5e-3)
    turned = quantity("aux/carried(sin(angle), q2)", frame)
    across = 1j * np.exp(1j * (frame.aux["q2"] + frame.q - 0.5 * np.pi))
    assert turned[5:-5] == pytest.approx(np.real(pull * np.conj(across))[5:-5], abs=5e-3)
    assert parts_of("carried(cos(angle), q2)") == ("q2",)
