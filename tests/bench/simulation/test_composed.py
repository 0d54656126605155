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
