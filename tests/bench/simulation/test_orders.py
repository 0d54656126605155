"""Orders of the nominal series by tooth numbers."""

from __future__ import annotations

from bench.simulation.model import Gearbox
from bench.simulation.orders import OUTPUT_SHAFT, nominal_orders, orders_in_doubt
from bench.simulation.terms.nominal.transmission_error import PAPER_ORDERS


def test_of_the_papers_gearbox_they_are_the_papers() -> None:
    assert nominal_orders(Gearbox()) == PAPER_ORDERS
    assert nominal_orders(Gearbox(185.02, None, None, None, None)) == PAPER_ORDERS


def test_of_another_gearbox_they_follow_its_teeth_that_are_known() -> None:
    orders = set(nominal_orders(Gearbox(120.0, 18, 63, 33, 34)))
    assert orders == {*OUTPUT_SHAFT, 3.5, 10.5, 34.0, 68.0, 102.0, 136.0, 204.0, 18.0, 66.0, 99.0, 132.0}
    assert set(nominal_orders(Gearbox(15.0, None, None, None, 16))) == {*OUTPUT_SHAFT, 16.0, 32.0, 48.0, 64.0, 96.0}
    assert nominal_orders(Gearbox(15.0, None, None, None, None)) == OUTPUT_SHAFT


def test_orders_that_one_revolution_does_not_tell_apart_are_one() -> None:
    """Teeth that share no factor: 61/20 is 3.05, beside 3 of the output shaft."""
    assert not {3.05, 9.15} & set(nominal_orders(Gearbox(123.0, 20, 61, 39, 40)))
    assert {2.6, 7.8} <= set(nominal_orders(Gearbox(105.0, 20, 52, 39, 40)))


def test_an_order_below_one_is_none_of_the_series() -> None:
    assert min(nominal_orders(Gearbox(100.0, 32, 20, 39, 40))) == 1.0


def test_numbers_of_the_list_are_in_doubt_where_the_teeth_say_otherwise() -> None:
    assert orders_in_doubt(Gearbox()) == ()
    # the cycloid stage and the disc have the paper's teeth, the input gear and the planetary stage have not
    assert orders_in_doubt(Gearbox(162.0, 20, 70, 45, 46)) == (4.0, 12.0, 24.0)
    assert orders_in_doubt(Gearbox(118.5, None, None, None, None)) == tuple(
        f for f in PAPER_ORDERS if f not in OUTPUT_SHAFT
    )
    assert 12.0 not in orders_in_doubt(Gearbox(100.0, None, None, None, 12))
    assert orders_in_doubt(Gearbox(1.0, None, None, None, None)) == ()
