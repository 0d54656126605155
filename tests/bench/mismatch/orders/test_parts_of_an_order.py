"""An order that is the encoder's and the gearbox's: two findings, whose sum is the order."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.mismatch.orders.discoveries import _encoders_parts, _with_its_parts
from bench.mismatch.orders.misread import Misread, TorqueCheck
from bench.mismatch.orders.periodic import Periodic
from bench.mismatch.orders.reported import of_encoder, of_orders
from bench.mismatch.orders.revolutions import Revolution
from bench.mismatch.orders.weak import WeakOrder
from bench.simulation import Gearbox, waves
from tests.bench.mismatch.orders.test_reaction import NOTHING, RATIO, frame

ORDER = RATIO
FORWARDS, BACKWARDS, ENCODER = (-4.0 + 3.0j) * 1e-6, (-5.0 + 2.0j) * 1e-6, (5.0 + 8.0j) * 1e-6
"""b + j*a of the gearbox's order in either direction and of the encoder's error"""


def model(noise: float, beside: bool = True) -> Any:
    """A model of revolutions in either direction that show the sum."""
    own = frame()
    seen = np.array([FORWARDS, BACKWARDS]) + ENCODER
    order = WeakOrder(ORDER, ("p", "n"), seen, np.full(2, 1e-16), 100.0)
    part = Misread(ORDER, ENCODER, 1e-7, 1e-9, 200.0, beside)
    revolutions = [Revolution(k, slice(0, 1), 100.0, 0.1, 30.0, 60.0 * k, (-1.0) ** k, 1.0, 60.0) for k in range(14)]
    return SimpleNamespace(
        periodic=Periodic(NOTHING, weak=(order,)),
        torque_check=TorqueCheck((ORDER,), (part,)),
        rows=SimpleNamespace(frame=own, number=np.ones(own.size)),
        inside=np.ones(own.size, dtype=bool),
        folds=np.zeros(14, dtype=np.int64),
        noise=SimpleNamespace(variance=noise**2),
        training_revolutions=revolutions,
        given=SimpleNamespace(notch=()),
    )


SIGHT: Any = SimpleNamespace(
    found=(ORDER,), at=lambda *_: np.zeros(14, dtype=np.complex128), gains=lambda *_: (100.0, 1)
)


def plain(of: Any) -> Any:
    return of_orders(of, SIGHT, "te.harmonic", [ORDER], Gearbox(RATIO), 1e-9, 0.9, {})


def of_rows(rows: Any) -> list[waves.Wave]:
    return [w for row in rows for w in waves.from_json(row["waves"], "here")]


def test_the_two_together_are_the_order() -> None:
    own = model(1e-6)
    (part,) = _encoders_parts(own, SIGHT)
    harmonic, encoder = plain(own), of_encoder(own, [part], "")
    assert harmonic is not None
    assert encoder is not None
    whole = own.periodic.evaluate(own.rows.frame)
    assert np.allclose(harmonic.added + encoder.added, whole, atol=1e-12)
    # so they are in the file, each with its own rows
    theta = own.rows.frame.theta
    for found in (harmonic, encoder):
        assert np.allclose(
            waves.evaluate(of_rows(found.simulation_rows), theta, own.rows.frame), found.added, atol=1e-12
        )
    gearbox = np.sqrt(0.5 * (abs(FORWARDS) ** 2 + abs(BACKWARDS) ** 2))
    assert harmonic.table[0]["amplitude"] == pytest.approx(gearbox)
    assert {p["symbol"]: p["value"] for p in encoder.parameters}["a"] == pytest.approx(abs(ENCODER))


def test_a_part_too_weak_to_be_told_stays_in_the_order() -> None:
    own = model(2e-4)
    assert _encoders_parts(own, SIGHT) == []
    assert own.torque_check.beside(ORDER) == 0.0
    assert own.torque_check.orders == (ORDER,)


def test_an_order_that_a_pulse_has_taken_has_no_parts() -> None:
    """Else the encoder's part would stand in the file without what is taken off the order for it."""
    own = model(1e-6)
    assert _encoders_parts(own, SimpleNamespace(found=())) == []  # type: ignore[arg-type]
    assert own.torque_check.beside(ORDER) == 0.0


def test_parts_join_an_order_that_is_the_encoders_alone() -> None:
    own = model(1e-6)
    (part,) = _encoders_parts(own, SIGHT)
    alone = of_encoder(own, [Misread(2.0 * ORDER, 3e-6 + 0j, 1e-7, 1e-9, 50.0, False)], "")
    joined = _with_its_parts(own, alone, [part])
    assert alone is not None
    assert joined is not None
    assert set(joined.orders) == {ORDER, 2.0 * ORDER}
    assert joined.parameters[0]["value"] == ORDER  # the strongest
    assert len(of_rows(joined.simulation_rows)) == 2
    assert joined.gain == pytest.approx(250.0)
