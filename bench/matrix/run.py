"""Run rows of the matrix, each in a folder of its own that is removed afterwards."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from bench.configuration import BenchFile
from bench.matrix.host import run_host_row
from bench.matrix.outcome import Outcome, combine_tries
from bench.matrix.plant import run_plant_row
from bench.matrix.rows import HOST, PLANT, SERVICE, SETUP, SLOW, WIRE, Row
from bench.matrix.services import run_service_row
from bench.matrix.setup import run_setup_row
from bench.matrix.slow import run_slow_rows
from bench.matrix.wire import run_wire_row

_RUN: dict[str, Callable[[Row, BenchFile, Path, int], Outcome]] = {
    PLANT: run_plant_row,
    SETUP: run_setup_row,
    HOST: run_host_row,
    SERVICE: run_service_row,
    WIRE: run_wire_row,
}


WIRE_TRIES = 3
"""Tries of a row on real frames, where none are asked for: what else the computer does has a share in them."""
RATE_TRIES = 20
"""Tries of a row in real time of which one was not right: what is seen then is a rate."""
_IN_REAL_TIME = frozenset({SLOW, SERVICE, WIRE})


def run_rows_often(rows: Sequence[Row], file: BenchFile, tries: int | None = None) -> Iterator[Outcome]:
    """Yield what became of each row in all its tries (seeds 0, 1, …), rows beside the bus last.

    ``tries`` is for every row; None: one, and :data:`WIRE_TRIES` on real frames; a row in real time that was not right
    in one of these is struck :data:`RATE_TRIES` times in all.
    """
    beside = [row for row in rows if row.kind == SLOW]
    groups = [[row] for row in rows if row.kind != SLOW] + ([beside] if beside else [])
    for group in groups:
        number = tries or (WIRE_TRIES if group[0].kind == WIRE else 1)
        tried = [list(run_rows(group, file, seed)) for seed in range(number)]
        for row, outcomes in zip(group, zip(*tried, strict=True), strict=True):
            poor = row.kind in _IN_REAL_TIME and not all(outcome.passed for outcome in outcomes)
            more = range(number, RATE_TRIES) if poor and tries is None else ()
            yield combine_tries([*outcomes, *(outcome for seed in more for outcome in run_rows([row], file, seed))])


def run_rows(rows: Sequence[Row], file: BenchFile, seed: int = 0) -> Iterator[Outcome]:
    """Yield what became of each row in one try, one after the other."""
    beside = [row for row in rows if row.kind == SLOW]
    for row in rows:
        if row.kind == SLOW:
            if row is beside[0]:
                with TemporaryDirectory(prefix="matrix-") as folder:
                    yield from run_slow_rows(beside, file, Path(folder), seed)
            continue
        with TemporaryDirectory(prefix="matrix-") as folder:
            yield _RUN[row.kind](row, file, Path(folder), seed)
