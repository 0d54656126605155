"""The table of one column in a mapping: where it stands, its unit, and what turns it into the channel's unit."""

from __future__ import annotations

import numpy as np

from bench.importing.looking.column import NAMELESS, Column
from bench.importing.looking.entries import Entry
from bench.importing.looking.guesses import of_sign_and_size, overflow, sign_bit, unsigned_bits
from bench.importing.looking.names import Meaning, may_be_counts
from bench.importing.mapping import OPEN
from bench.importing.units import PERCENT

GUESS = "a guess"
FROM_FILE = "the file says so"
_MOST_AMPERES = 1000.0


def place_of(column: Column) -> dict[str, Entry]:
    """Where a column stands, as a mapping says it."""
    entries: dict[str, Entry] = {}
    headed = not column.variable.name.startswith((NAMELESS, "row "))
    if column.file and not column.headed:
        return {"file": Entry(column.file), "column": Entry(column.number or 1)}
    if column.inside or headed:
        entries["variable"] = Entry(column.inside or column.variable.name)
    else:
        entries["column"] = Entry(int(column.variable.name.split()[1]))
    if column.number is not None:
        entries[column.along] = Entry(column.number)
    bits = unsigned_bits(column)
    if bits is not None:
        why = f"{GUESS}: all values are near 0 or near {2**bits}, as negative ones are without their sign"
        entries["signed_bits"] = Entry(bits, why, sure=False)
    bit = sign_bit(column)
    if bit is not None:
        why = f"{GUESS}: the values go on from {2**bit} as they do from 0, as with a bit for the sign"
        entries["sign_bit"] = Entry(bit, why, sure=False)
    if column.file:
        entries["file"] = Entry(column.file)
        if column.variable.clock is not None:
            entries["time"] = Entry(column.variable.clock, "its own clock")
    return entries


def channel_entries(column: Column, column_meaning: Meaning) -> dict[str, Entry]:
    """The table of a channel: its place, its unit, and what makes the channel's unit of it."""
    entries = place_of(column)
    sideless = column_meaning.quantity in ("angle", "velocity", "torque") and not column_meaning.sided
    named = f"{GUESS}, its name says no side of the gearbox" if sideless else ""
    next(iter(entries.values())).why = (
        named if column_meaning.sure else f"{GUESS}, from its name" if column_meaning.quantity else GUESS
    )
    low, high = column.span
    wraps = None
    if "sign_bit" in entries:
        signed = of_sign_and_size(column.seconds, entries["sign_bit"].value)
        low, high = float(np.nanmin(signed)), float(np.nanmax(signed))
    elif column_meaning.quantity == "angle":
        wraps = overflow(column, column_meaning.unit, column_meaning.counted)
    if column_meaning.counted:
        entries["unit"] = Entry("counts")
        sure = wraps is not None
        entries["counts_per_revolution"] = Entry(
            wraps if sure else OPEN, f"{GUESS}, it overflows there" if sure else "of its shaft", sure=False
        )
    elif column_meaning.unit == PERCENT:
        entries["unit"] = Entry(PERCENT, FROM_FILE)
        entries["factor"] = Entry(OPEN, "what 100 % is, such as '3.2 N*m'", sure=False)
    elif column_meaning.quantity == "current":
        # no motor takes a thousand amperes, of which a file does not even say the unit
        likely = "mA" if max(-low, high) > _MOST_AMPERES else "A"
        entries["unit"] = Entry(
            column_meaning.unit or likely, "" if column_meaning.unit else GUESS, sure=bool(column_meaning.unit)
        )
        entries["torque_constant"] = Entry(OPEN, 'N·m/A at the motor\'s shaft (a linear axis: "… N/A")', sure=False)
    elif column_meaning.unit:
        entries["unit"] = Entry(column_meaning.unit, FROM_FILE)
    elif column_meaning.quantity == "temperature":
        entries["unit"] = Entry("degC", GUESS, sure=False)
    else:
        why = f"the values are {low:.4g} to {high:.4g}"
        if column_meaning.quantity == "angle" and may_be_counts(column):
            why += ", whole numbers: 'counts', with counts_per_revolution, if an encoder counts them"
        entries["unit"] = Entry(OPEN, why, sure=False)
    if wraps is not None:
        entries["wraps_at"] = Entry(wraps, f"{GUESS}: it starts again there")
    return entries
