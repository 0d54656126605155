"""Which column of a file is the time, and the rate where its stamps are too coarse to be one."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bench.importing.looking.column import Column
from bench.importing.looking.entries import Entry
from bench.importing.looking.guesses import counts_by_one, rises_evenly, step_of, unit_of_time
from bench.importing.looking.inventory import Inventory
from bench.importing.looking.names import Meaning
from bench.importing.mapping import OPEN
from bench.importing.units import unit_of


def clock_of(found: Inventory, meanings: Mapping[str, Meaning]) -> Column | None:
    """The column that is the time: one the file names, one called so, or the first without a meaning whose numbers rise
    as a clock's do, and not as row numbers do.
    """
    clocks = [column.variable.clock for column in found.columns if column.variable.clock]
    rising = [column for column in found.columns if step_of(column) is not None]
    named = [column for column in rising if column.name in clocks]
    called = [column for column in rising if meanings[column.name].quantity == "time"]
    by_file = sorted(named, key=lambda column: (clocks.count(column.name), column.values.size), reverse=True)
    by_name = sorted(
        called, key=lambda column: (column.values.size, column.stamps, meanings[column.name].sure), reverse=True
    )
    by_numbers = [
        column
        for column in found.columns
        if not meanings[column.name].quantity and rises_evenly(column) and not counts_rows(column, meanings)
    ]
    return next(iter([*by_file, *by_name, *(by_numbers if len(found.columns) > 1 else ())]), None)


def counts_rows(column: Column, meanings: Mapping[str, Meaning]) -> bool:
    """Whether a column holds the numbers of the rows, whatever its name (``n``, ``count``): it rises by one in each and
    has no unit. A time in milliseconds does so too, which its name or its file has to say.
    """
    column_meaning = meanings[column.name]
    named = column_meaning.quantity == "time" or column.variable.clock == column.name
    return not named and not column_meaning.unit and counts_by_one(column)


def coarse_clock(found: Inventory, meanings: Mapping[str, Meaning]) -> Column | None:
    """A column that is called the time and never falls, though it mostly stays: several samples have one stamp."""
    for column in found.columns:
        seconds = column.seconds
        called = meanings[column.name].quantity == "time" and not column.stamps
        if called and np.isfinite(seconds).all() and np.all(np.diff(seconds) >= 0.0) and seconds[-1] > seconds[0]:
            return column
    return None


def why_no_clock(found: Inventory, meanings: Mapping[str, Meaning]) -> str:
    """Say why no column is the time: one that is called so runs backwards, stands still or holds no number,
    or one holds the numbers of the rows."""
    for column in found.columns:
        if meanings[column.name].quantity != "time" or column.empty:
            continue
        backwards = np.flatnonzero(np.diff(column.seconds) < 0.0)
        if backwards.size:
            place = found.location(column, int(backwards[0]) + 1)
            return f"'{column.name}' is no time, it runs backwards from {place} on"
        if column.constant:
            return f"'{column.name}' is no time, it is {column.span[0]:g} in all samples"
    for column in found.columns:
        if counts_rows(column, meanings):
            return f"'{column.name}' counts the rows by one and is no time"
    return "no column is a time"


def rate_entry(coarse: Column) -> dict[str, Entry]:
    """The rate of samples whose stamps are coarser than they are."""
    unit_in_file = coarse.variable.heading[1] or coarse.variable.unit
    unit = unit_in_file or unit_of_time(coarse)[0]
    doubled = int(np.sum(np.diff(coarse.seconds) == 0.0))
    why = f"{doubled} of {coarse.values.size} stamps of {coarse.name} are doubled, so it is coarser than the samples"
    if unit == OPEN:
        return {"rate": Entry(OPEN, f"samples per second: {why}", sure=False)}
    seconds = float(np.ptp(coarse.seconds)) * unit_of(unit, coarse.name, "s").factor
    rate = float(f"{(coarse.values.size - 1) / seconds:.6g}")
    return {"rate": Entry(rate, f"Hz, a guess: {why}; they are taken as even", sure=False)}
