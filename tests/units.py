"""Which tests share a process, and which begin first, where pytest runs several processes (``pytest -n 3``).

A unit is what one process runs from its first test to its last, so that what its tests share is made once: a file, or
what a line of :data:`UNITS` says. Units that wait (for a browser, a bus at the pace of the clock, another program) and
units that compute stand in turn, and the longest begin first: at the end no processor waits for one long unit.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pytest

UNITS = (
    # fixtures of the whole session, which these folders alone use
    r"tests/bench/(identification|proof|twin)/",
    # the commands of a page need those before them
    r"tests/docs/test_commands\.py::test_short_commands_run\[[^:]*",
    # a bench of its own for each row
    r"tests/bench/matrix/test_matrix\.py::.*",
    # a service, a bus or a campaign of its own for each test
    r"tests/bench/service/test_(archive|idle|joining|stop)\.py::.*",
    r"tests/system/test_bus_process\.py::.*",
    r"[^:]*",
)
"""What the beginning of a test's name has to match; the first line that does says what its unit is called."""

FIRST = (
    "tests/browser/test_operator.py",
    "tests/bench/twin/",
    "tests/browser/test_page_speed.py",
    "tests/docs/test_commands.py::test_short_commands_run[README.md",
    "tests/bench/matrix/test_matrix.py::test_rows_of_a_thermometer_beside_the_bus[modbus]",
    "tests/bench/proof/",
    "tests/browser/test_stop.py",
    "tests/bench/identification/",
    "tests/browser/test_looks.py",
    "tests/docs/test_commands.py::test_short_commands_run[docs/twin.md",
    "tests/browser/test_newcomer.py",
    "tests/bench/mismatch/test_end_to_end.py",
    "tests/browser/test_by_hand.py",
    "tests/bench/investigate/test_through.py",
    "tests/system/test_bus_process.py",
    "tests/bench/mismatch/test_leave_one_out.py",
    "tests/bench/matrix/test_opening_times.py",
    "tests/bench/service/test_own_files.py",
    "tests/fakes/ethercat/wire/test_orders.py",
    "tests/system/test_campaign.py",
    "tests/bench/service/test_idle.py",
    "tests/browser/",
    "tests/bench/service/test_joining.py",
    "tests/bench/service/test_by_hand.py",
    "tests/bench/matrix/",
    "tests/docs/",
    "tests/bench/campaigns/",
    "tests/bench/service/",
    "tests/system/",
    "tests/drivers/",
    "tests/bench/recording/",
    "tests/bench/stop_button/",
)
"""Beginnings of the names of units that take long, the longest first; all others follow."""


def unit(test: str) -> str:
    """Return the name of the unit of a test."""
    return next(found[0] for pattern in UNITS if (found := re.match(pattern, test)))


def rank(test: str) -> int:
    """Return how early a test's unit begins, 0 being the first."""
    name = unit(test)
    return next((number for number, beginning in enumerate(FIRST) if name.startswith(beginning)), len(FIRST))


def first_things_first(items: list[pytest.Item]) -> None:
    """Put the tests in the order in which their units begin."""
    items.sort(key=lambda item: rank(item.nodeid))


def scheduler(config: pytest.Config, log: object) -> object:
    """Return what hands out whole units, in the order of their first tests."""
    from xdist.scheduler import LoadScopeScheduling

    class Units(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return unit(nodeid)

    config.option.loadscopereorder = False
    return Units(config, log)  # type: ignore[arg-type]
