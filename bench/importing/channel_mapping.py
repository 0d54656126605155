"""What a mapping says of one channel: where it stands, in which unit, and how raw values become that unit."""

from __future__ import annotations

import re
from math import isfinite
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

NO_PLACE = "no_place"
"""type of the error of a table that does not say where its values stand, as one does whose name is misspelt"""
_CONVERSIONS = ("counts_per_revolution", "torque_constant", "factor")
_RIGHT = {
    ("counts_per_revolution", "torque_constant"): "the first is for the counts of an encoder, the second for a current:"
    " the one that is not of this channel should be left out",
    ("counts_per_revolution", "factor"): "'factor' should be left out for an angle; on a linear axis"
    " {linear} without 'counts_per_revolution' would be right",
    ("torque_constant", "factor"): "'factor' should be left out; a gain belongs into 'scale', or multiplies the torque"
    " constant",
}
"""what would be right where two conversions stand together"""
_PER_TURN = re.compile(r"\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*(\S.*?)\s*/\s*(?:revs?|revolutions?|turns?|U)\s*")
"""the way of a revolution, such as the lead of a screw: ``10 mm/rev``"""


class Strict(BaseModel):
    """A table of a mapping: unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class PartMapping(Strict):
    """One column, or one of several that are added.

    Value in ``unit`` = raw · ``scale`` + ``offset``. ``scale`` and ``offset`` are numbers, or names of variables of the
    same file that hold one number; an ``offset`` may also be a text with its unit, such as ``-180 deg``. What turns one
    quantity into another comes on top: ``torque_constant``, ``counts_per_revolution``, or any ``factor``.
    """

    variable: str | None = None
    """Name in the file: ``qm``, ``data.qm`` (MAT structure), ``group/qm`` (HDF5, TDMS) or the heading of a column."""
    column: int | None = Field(default=None, ge=1)
    """Column of a matrix variable, or of a text file without headings; counted from 1."""
    row: int | None = Field(default=None, ge=1)
    """Row of a matrix variable whose data lie in rows; counted from 1."""
    file: str | None = None
    """Another file it stands in, from the recording's folder; ``*`` is what it was there, ``{stem}`` its stem."""
    value: float | None = None
    """A number that stands in no file and holds for the whole recording, such as a weight that was hung on."""
    unit: str = "1"
    scale: float | str = 1.0
    offset: float | str = 0.0
    factor: float | str | None = None
    """A number, or one with a unit: ``35.15 N/V``, ``10 mm/rev``."""
    torque_constant: float | str | None = None
    """Of a current: N·m/A, on a linear axis N/A."""
    counts_per_revolution: float | None = Field(default=None, gt=0)
    times: tuple[str, ...] = ()
    """Variables of the same file it is multiplied with, sample by sample."""
    signed_bits: Literal[8, 16, 32] | None = None
    """Of integers that were written as unsigned although they are signed (65535 for -1): how many bits they have."""
    sign_bit: int | None = Field(default=None, ge=1, le=31)
    """Of integers whose sign is this bit, from 0, and whose size is in the bits below it (1034 is -10 with bit 10)."""
    wraps_at: float | None = Field(default=None, gt=0)
    """Raw counts (or angle, in raw units) after which the value starts again; it is unwrapped."""

    @property
    def placed(self) -> bool:
        """Whether it says where it stands, or its value."""
        return self.value is not None or self._in_file

    @property
    def _in_file(self) -> bool:
        return self.variable is not None or self.column is not None or self.row is not None

    @model_validator(mode="after")
    def _one_conversion(self) -> PartMapping:
        given = [key for key in _CONVERSIONS if getattr(self, key) is not None]
        if len(given) > 1:
            right = _RIGHT[given[0], given[1]].format(linear=self._per_count())
            raise ValueError(f"has both '{given[0]}' and '{given[1]}', one conversion is enough: {right}")
        return self

    def _per_count(self) -> str:
        """The way of a count as a mapping has it, from that of a revolution where both are given."""
        lead = _PER_TURN.fullmatch(self.factor) if isinstance(self.factor, str) else None
        if lead is None or self.counts_per_revolution is None:
            return "the way of a count, such as unit = 'counts' and factor = '0.001 mm/count'"
        return f"unit = 'counts' and factor = '{float(lead[1]) / self.counts_per_revolution:.12g} {lead[2]}/count'"

    @model_validator(mode="after")
    def _value_or_place(self) -> PartMapping:
        if self.value is not None and (self._in_file or self.file is not None):
            raise ValueError("has a 'value' and a place in a file, one of them is enough")
        raw = [key for key in _RAW if getattr(self, key)]
        if self.value is not None and raw:
            raise ValueError(f"has a 'value' and '{raw[0]}', which is for what stands in a file; leave it out")
        if self.value is not None and not isfinite(self.value):
            raise ValueError("has a 'value' that is no finite number")
        return self


_RAW = ("times", "signed_bits", "sign_bit", "wraps_at", "counts_per_revolution")
"""keys that say how the samples of a file are read"""


class ChannelMapping(PartMapping):
    """One channel: a column, or the ``sum`` of several."""

    sum: tuple[PartMapping, ...] = ()
    time: str | None = None
    """Variable that holds this channel's own time stamps, in the unit of the common ones."""
    missing: Literal["refuse", "hold", "interpolate"] = "refuse"
    """What to do with samples that are not there (NaN)."""
    at: Literal["motor", "output"] | None = None
    """Only for ``motor_torque``: of a torque at the ``output`` (a joint) the motor's is that over the ratio."""
    rate: float | None = Field(default=None, gt=0)
    """Only for ``time`` that stands in no variable: samples per second."""
    timezone: str | None = None
    """Only for ``time``: zone of dates that say none, such as ``Europe/Berlin``."""
    description: str = ""

    @model_validator(mode="after")
    def _has_a_place(self) -> ChannelMapping:
        if self.value is not None and self.time is not None:
            raise ValueError("has a 'value' and a 'time' of its own; a value holds for the whole recording")
        if not self.placed and not self.sum and self.rate is None:
            raise PydanticCustomError(
                NO_PLACE,
                "needs 'variable' or 'column' (or 'sum', a 'value' that holds throughout, or for time 'rate')",
            )
        if self.sum and self.placed:
            raise ValueError("has a 'sum' and a place of its own, one of them is enough")
        if any(not part.placed for part in self.sum):
            raise ValueError("every part of 'sum' needs 'variable' or 'column', or a 'value'")
        return self
