"""Orders that recordings held out contradict are not reported, and leave the model."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from bench.mismatch.orders import discoveries
from bench.mismatch.orders.borne_out import borne_out
from bench.mismatch.orders.defects import Defect
from bench.mismatch.orders.periodic import Periodic, Pulse
from bench.simulation.frame import FloatArray, Frame
from tests.bench.mismatch.regression.synthetic import campaign


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
    found = SimpleNamespace(words="2 orders that the simulation does not have", orders=(7.0, 31.5))
    monkeypatch.setattr(discoveries, "of_orders", lambda *_args: found)
    told = discoveries._plain(cast("Any", model), cast("Any", sight), [7.0, 31.5], cast("Any", None))
    assert asked == [(without, periodic)]
    assert (told is None) is contradicted
    assert (model.periodic is without) is contradicted
    assert len(model.notes) == contradicted


def test_an_encoder_error_that_recordings_held_out_contradict_takes_its_orders_with_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Whatever name orders have: the model does not keep what no recording held out bears out."""
    model = SimpleNamespace(
        periodic=SimpleNamespace(less=lambda orders: SimpleNamespace(without=tuple(orders))), notes=[]
    )
    monkeypatch.setattr(discoveries, "borne_out", lambda *_args: False)
    found = SimpleNamespace(words="the motor's encoder", orders=(185.0, 370.0))
    assert discoveries._borne_out(cast("Any", model), cast("Any", found)) is None
    assert model.periodic.without == (185.0, 370.0)
    assert model.notes == [
        "the motor's encoder gained in the fit, but recordings held out are predicted worse with it: it is not reported"
    ]


@dataclass
class Model:
    """What the search for pulses holds of a model."""

    periodic: Periodic
    orders: tuple[float, ...] = (5.0, 7.0)
    notes: list[str] = field(default_factory=list)

    def restore(self, before: Model) -> None:
        self.periodic, self.orders = before.periodic, before.orders


@pytest.mark.parametrize("contradicted", [True, False])
def test_pulses_are_asked_against_nothing_in_their_place(monkeypatch: pytest.MonkeyPatch, contradicted: bool) -> None:
    """Orders that draw them predict as well; those that the pulses had drawn are back if these are contradicted."""
    model = Model(Periodic(series=cast("Any", None)))
    asked: list[tuple[tuple[Pulse, ...], tuple[Pulse, ...]]] = []

    def rebuilt(_model: object, pulses: tuple[Pulse, ...]) -> None:
        model.periodic = replace(model.periodic, pulses=tuple(pulses))
        model.orders = (7.0,)

    def borne_out(_model: object, before: Periodic, after: Periodic, _doubtful: bool) -> bool:
        asked.append((before.pulses, after.pulses))
        return not contradicted

    pulse = Pulse(2.1, 0.03, 2e-5)
    found = SimpleNamespace(words="a local defect")
    monkeypatch.setattr(discoveries, "rebuilt", rebuilt)
    monkeypatch.setattr(discoveries, "of_pulses", lambda *_args: found)
    monkeypatch.setattr(discoveries, "borne_out", borne_out)
    told, _ = discoveries._pulses(cast("Any", model), [Defect(pulse, (pulse,), 400.0, 1e-4)], None)
    assert asked == [((), (pulse,))]
    assert (told is None) is contradicted
    assert model.periodic.pulses == (() if contradicted else (pulse,))
    assert model.orders == ((5.0, 7.0) if contradicted else (7.0,))
    assert len(model.notes) == contradicted


@pytest.mark.parametrize(
    ("acts", "worse_by", "stays"),
    [(1.0, 0.3, False), (1.0, -0.3, True), (0.1, 0.3, True), (0.1, 3.0, False), (0.1, -0.3, True)],
)
def test_what_hardly_acts_in_recordings_held_out_goes_only_if_they_are_surely_predicted_worse(
    acts: float, worse_by: float, stays: bool
) -> None:
    """``worse_by`` standard errors, from one recording to another."""
    frame = campaign(24)
    folds = np.where(np.arange(24) % 3 == 0, -1, 0)
    held = folds[frame.recording] < 0
    size = 1e-6 * np.where(held, acts, 1.0)
    # of each recording held out what is left without it, in units of what it adds: half is as good with as without
    scatter = np.linspace(-1.0, 1.0, int(np.sum(folds < 0)))
    error = float(np.std(scatter, ddof=1) / np.sqrt(scatter.size))
    left = np.zeros(24)
    left[folds < 0] = 0.5 + 0.5 * (scatter - worse_by * error)
    model = SimpleNamespace(
        rows=SimpleNamespace(frame=frame, number=frame.count, size=frame.size),
        inside=np.ones(frame.size, dtype=bool),
        folds=folds,
        without_offset=left[frame.recording] * size,
    )

    def added(part: Frame) -> FloatArray:
        return np.array([size[np.flatnonzero(frame.time == t)[0]] for t in part.time])

    before = SimpleNamespace(evaluate=lambda part: np.zeros(part.size))
    after = SimpleNamespace(evaluate=added)
    assert borne_out(cast("Any", model), cast("Any", before), cast("Any", after), False) is stays
