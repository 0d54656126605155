from __future__ import annotations

import numpy as np
import pytest

from bench.identification import Identification, Options, with_proposed_orders
from bench.identification.series.orders import peak_ratio
from bench.simulation import Gearbox
from bench.simulation.parts import part_of


@pytest.mark.parametrize(
    ("order", "part"),
    [
        (1, "output shaft"), (13, "output shaft"), (27, "output shaft"),
        (4, "planetary stage"), (12, "planetary stage"),
        (46, "cycloid stage"), (276, "cycloid stage"), (24, "input gear"), (90, "cycloid disc"), (180, "cycloid disc"),
        (150, "load motor"), (300, "load motor"), (185, "motor shaft"), (4440, "motor shaft"), (1001, "none"),
        (110, "none"), (4.5, "none"),
    ],
)  # fmt: skip
def test_parts(order: float, part: str) -> None:
    assert part_of(order, Gearbox()) == part


def test_proposals_find_the_weaker_orders_and_tie_them_to_parts(found: Identification) -> None:
    by_order = {p.order: p for p in found.proposals}
    assert {2, 5, 37, 110} <= set(by_order)
    assert by_order[110].part == "none"
    assert by_order[2].part == "output shaft"
    assert by_order[110].amplitude == pytest.approx(4e-6, rel=0.1)
    assert not by_order[110].used
    assert by_order[46].used
    below = [p for p in found.proposals if p.order <= 300 and not p.used]
    assert {p.order for p in below} <= {2, 5, 37, 110, 150, 300}


def test_proposed_orders_join_those_used_without_the_ripple(found: Identification) -> None:
    options = with_proposed_orders(found, Options())
    assert options.orders is not None
    assert {110, 46} <= set(options.orders)
    assert 150 not in options.orders


def test_noise_alone_has_no_peaks() -> None:
    rng = np.random.default_rng(0)
    power = rng.exponential(size=5000).astype(np.float32)
    assert (peak_ratio(power) > 14.0).sum() <= 1
