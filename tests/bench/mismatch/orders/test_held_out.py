"""Orders that recordings held out contradict are not reported, and leave the model."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from bench.mismatch.orders import discoveries


@pytest.mark.parametrize("contradicted", [True, False])
def test_new_orders_go_where_recordings_held_out_are_predicted_worse(
    monkeypatch: pytest.MonkeyPatch, contradicted: bool
) -> None:
    without = SimpleNamespace(name="without the orders")
    periodic = SimpleNamespace(less=lambda orders: without if set(orders) == {7.0, 31.5} else None)
    model = SimpleNamespace(periodic=periodic, notes=[])
    sight = SimpleNamespace(gains=lambda _vector, _order: (50.0, 0.0), at=lambda _model, _order: 1j)
    asked: list[tuple[object, object]] = []

    def borne_out(_model: object, before: object, after: object, _doubtful: bool) -> bool:
        asked.append((before, after))
        return not contradicted

    monkeypatch.setattr(discoveries, "borne_out", borne_out)
    monkeypatch.setattr(discoveries, "order_p_value", lambda _model, _gain: 1e-4)
    found = SimpleNamespace(words="2 orders that the simulation does not have")
    monkeypatch.setattr(discoveries, "of_orders", lambda *_args: found)
    told = discoveries._plain(cast("Any", model), cast("Any", sight), [7.0, 31.5], cast("Any", None))
    assert asked == [(without, periodic)]
    assert (told is None) is contradicted
    assert (model.periodic is without) is contradicted
    assert len(model.notes) == contradicted
