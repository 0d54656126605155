"""Orders beside an offset that moves inside revolutions: found again with it taken off, until that stays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bench.mismatch.orders.model import GivenOrders, KnownOffset, TransmissionModel, begun
from bench.mismatch.orders.turns import analyse, misleading
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.problem import nominal_base
from bench.simulation.frame import Frame
from bench.simulation.quantities import quantity
from bench.simulation.terms import TRANSMISSION_ERROR
from tests.bench.mismatch.report import made

KNOWN, WEAK = (1.0, 2.0, 46.0), (7.0, 31.0)
SPEEDS, TORQUES = (0.06, 0.1, 0.16), (-700.0, 300.0, 700.0, -300.0)
EACH, NOISE = 400, 1e-6
WAY = 1.5e-5
"""by which the play moves to either side, rad"""


def frame() -> Frame:
    """Steady revolutions one after another: the load changes its sign before every second one, a backward one."""
    out = made.revolutions(SPEEDS, TORQUES, EACH)
    torque = np.resize(TORQUES, int(out.recording.max()) + 1)[out.recording]
    return replace(out, time=np.cumsum(out.step), torque=torque, torque_level=torque)


def model(way: float) -> TransmissionModel:
    """A gearbox whose play the load crosses through a film, ``way`` rad to either side."""
    rng, own = np.random.default_rng(8), frame()
    y = NOISE * rng.normal(size=own.size) + 2e-8 * own.torque
    for order in (*KNOWN, *WEAK):
        y += (1e-5 if order in KNOWN else 3e-6) * np.sin(order * own.theta + rng.uniform(0.0, 2.0 * np.pi))
    y += way * quantity("impulse_8000Nms", own) / 8000.0
    none = np.zeros(own.size)
    rows = Rows(own, y, np.ones(own.size), none, none, none)
    number = len(SPEEDS) * len(TORQUES) * 2
    base = nominal_base(TRANSMISSION_ERROR, ())
    numbers = np.arange(number)
    begin = begun(rows, np.where(numbers % 6 == 0, -1, numbers), GivenOrders(KNOWN), base)
    # the offset as the simulation alone has it, with states among the candidates
    return analyse(replace(begin, known=KnownOffset(2e-8 * own.torque, True, np.inf)), 0)


def test_a_play_that_is_crossed_inside_a_revolution_is_no_order() -> None:
    own = model(WAY)
    assert own.offset is not None
    assert own.offset.model.problem.states
    known = misleading(own)
    assert known is not None
    assert misleading(replace(own, quiet=None)) is None  # no orders were looked for
    energies = []
    for _ in range(4):
        begin = begun(own.rows, own.folds, own.given, own.base)
        before, own = known, analyse(replace(begin, known=known), 0)
        assert own.offset is not None
        assert own.periodic is not None
        energies.append(float(np.mean((own.offset.model.predict(own.rows.frame) - before.values) ** 2)))
        known = misleading(own)
        if known is None:
            break
    assert known is None
    assert energies == sorted(energies, reverse=True)
    found = {*own.periodic.series.orders, *(w.order for w in own.periodic.weak)}
    assert {f for f in found if f < EACH / 2} == {*KNOWN, *WEAK}
    left = own.rows.y - own.periodic.evaluate(own.rows.frame) - own.offset.model.predict(own.rows.frame)
    assert float(np.sqrt(np.mean(left**2))) < 1.1 * NOISE


def test_an_offset_that_stays_inside_revolutions_misleads_nothing() -> None:
    assert misleading(model(0.0)) is None
