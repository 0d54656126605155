"""A function over many items gives the same in one process and in several."""

from __future__ import annotations

import os

from bench.processes import over


def _square_and_process(number: int) -> tuple[int, int]:
    return number * number, os.getpid()


def test_results_come_in_order_and_from_other_processes() -> None:
    here = list(over(_square_and_process, range(7)))
    apart = list(over(_square_and_process, range(7), jobs=2, chunk=2))
    assert [square for square, _ in here] == [square for square, _ in apart] == [0, 1, 4, 9, 16, 25, 36]
    assert {process for _, process in here} == {os.getpid()}
    assert os.getpid() not in {process for _, process in apart}


def test_nothing_to_do_is_nothing_done() -> None:
    assert list(over(_square_and_process, [], jobs=4)) == []
