"""Orders whose phase is new in every recording are found at their order; tones, known orders and noise are no lines."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bench.mismatch import peaks
from bench.mismatch.harmonics import calibrated
from bench.mismatch.lines import OrderSpectrum, of_turns, order_spectrum, search, unfollowed
from bench.mismatch.periodic import NOTHING
from bench.mismatch.spectrum import Turn, turns
from bench.simulation.frame import FloatArray, Frame
from tests.bench.mismatch.synthetic import transmission

RATE, RECORDINGS = 200.0, 15
SPEEDS = (0.3, 0.45, 0.7)


def heard(line: float, tone: float = 0.0, coherent: float = 0.0, seed: int = 1) -> list[OrderSpectrum]:
    """Recordings of a little more than a turn: a line at order 660.4, a tone at 5 Hz, an order 555 with one phase."""
    rng = np.random.default_rng(seed)
    out = []
    for index in range(RECORDINGS):
        speed = SPEEDS[index % 3]
        time = np.arange(int(RATE * 2.1 * np.pi / speed)) / RATE
        theta = speed * time * (-1.0) ** index + rng.uniform(0, 6)
        signal = rng.normal(size=time.size) + coherent * np.cos(555.0 * theta)
        signal += line * np.cos(660.4 * theta + rng.uniform(0, 6)) + tone * np.cos(10 * np.pi * time)
        yes = np.ones(time.size, dtype=bool)
        spectrum = order_spectrum(index, signal, yes, yes, RATE, theta)
        assert spectrum is not None
        out.append(spectrum)
    return out


def test_a_line_is_found_at_its_order_with_its_amplitude() -> None:
    (line,) = search(heard(0.5))
    assert line.order == pytest.approx(660.4, abs=0.5)
    assert line.amplitude == pytest.approx(0.5, rel=0.3)
    assert len(line.recordings) > RECORDINGS // 2


def test_noise_tones_and_known_orders_are_no_lines() -> None:
    for seed in range(4):
        assert search(heard(0.0, tone=0.6, coherent=0.6, seed=seed), (555.0,)) == []


def test_too_short_a_run_has_no_spectrum() -> None:
    yes = np.ones(400, dtype=bool)
    angle = np.linspace(0.0, 3.0, 400)
    assert order_spectrum(0, np.zeros(400), yes, yes, RATE, angle) is None
    assert order_spectrum(0, np.zeros(400), yes, ~yes, RATE, 9.0 * angle) is None


def slipping(frame: Frame) -> FloatArray:
    return np.asarray(3e-6 * np.cos(33.3 * frame.theta + 2.4 * frame.recording**2))


ORDERS = (1.0, 46.0, 92.0)


def left_over(extra: Any) -> tuple[list[Turn], set[int]]:
    """Revolutions of recordings with something ``extra``, the calibrated orders taken off; and who trains."""
    data = transmission(extra=extra)
    assert data.angle is not None
    rows = replace(data.angle, y=data.angle.y + data.angle.frame.torque / 4e6)
    train = {m.index for m in data.members if not m.held_out}
    known = calibrated(rows, ORDERS, train, NOTHING)
    return turns(replace(rows, y=rows.y - known.evaluate(rows.frame)), ORDERS), train


@pytest.mark.parametrize("extra", [slipping, None])
def test_an_order_that_slips_is_a_line_of_the_transmission_error_and_noise_is_none(extra: Any) -> None:
    found = search(of_turns(left_over(extra)[0]), ORDERS)
    assert [line.order for line in found[:1]] == ([] if extra is None else [pytest.approx(33.3, abs=0.5)])
    assert all(line.amplitude == pytest.approx(3e-6, rel=0.3) for line in found[:1])


@pytest.mark.parametrize("slips", [True, False])
def test_an_order_is_named_only_where_its_phase_is_its_own(slips: bool) -> None:
    def extra(frame: Frame) -> FloatArray:
        swell = (frame.torque / 800.0) ** 2 + 0.1
        return np.asarray(3e-6 * swell * np.cos(33.0 * frame.theta + slips * 2.4 * frame.recording**2))

    left, train = left_over(extra)
    chosen = np.array([t.recording in train for t in left])
    found = peaks.search(peaks.Spectra.of(left, chosen, ORDERS, {}))
    assert [p.orders for p in found] == ([] if slips else [(33,)])


def test_the_order_that_its_polynomials_do_not_follow_is_told() -> None:
    def extra(frame: Frame) -> FloatArray:
        wild = np.sin(1.7 * frame.recording**2)
        return np.asarray(3e-6 * wild * np.cos(46.0 * frame.theta))

    assert unfollowed(left_over(extra)[0], ORDERS) == [46.0]
    assert unfollowed([], ORDERS) == []
