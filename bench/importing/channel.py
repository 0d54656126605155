"""One channel from its columns: raw values as the file has them, with what makes SI of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import ConfigurationError, RecordingError
from bench.importing.channel_mapping import ChannelMapping, PartMapping
from bench.importing.constants import constant, offset_in_si
from bench.importing.files import Files
from bench.importing.fill import filled
from bench.importing.formats import Source
from bench.importing.units import PERCENT, Unit, product_unit, quantity, unit_of
from bench.importing.wraps import jumps_of
from bench.recording.header import ChannelSpec
from bench.signals import BY_NAME

LINEAR = {"rad": "m", "rad/s": "m/s", "N·m": "N"}
"""What stands for the rotary units of the channel table on a linear axis (ratio 1)."""
_NEEDED = {
    "rad": "counts_per_revolution such as 4096 makes an angle of an encoder's counts",
    "N·m": "a factor with a unit such as '0.05 N*m' makes the channel's unit of it",
    PERCENT: "a factor that is 100 % of it, such as '3.2 N*m' for the rated torque, makes the channel's unit of it",
}
"""what makes a channel of numbers without a quantity, by the channel's unit"""


@dataclass(frozen=True, slots=True)
class Channel:
    """Raw values (N,) and what they are; ``source`` is the file they stand in.

    ``filled``: indices in the file of samples that held a fill value; they are NaN here. ``doubts``: sentences of what
    of its mapping cannot be.
    """

    raw: NDArray[Any]
    spec: ChannelSpec
    source: Source
    filled: tuple[int, ...] = ()
    doubts: tuple[str, ...] = ()

    @property
    def si(self) -> NDArray[np.float64]:
        """Values in SI units."""
        return np.asarray(self.raw * self.spec.scale + self.spec.offset, dtype=np.float64)

    def with_si(self, values: NDArray[np.float64]) -> Channel:
        """The same channel with other values, given in SI units."""
        return replace(self, raw=values, spec=replace(self.spec, dtype="float64", scale=1.0, offset=0.0))

    def taken(self, rows: NDArray[Any] | slice) -> Channel:
        """The rows chosen."""
        return replace(self, raw=self.raw[rows])


def read_channel(name: str, wanted: ChannelMapping, files: Files, where: str, linear: bool | None) -> Channel:
    """Read a channel.

    Parameters
    ----------
    where : mapping file and key, for the sentence of an error.
    linear : whether it is a linear axis; None: either, whichever its unit is of.

    Returns
    -------
    Of one sample where the mapping gives its ``value``.

    Raises
    ------
    ConfigurationError, RecordingError
        The mapping or the file is wrong.
    """
    parts: tuple[PartMapping, ...] = wanted.sum or (wanted,)
    keys = [f"{where}.sum.{index}" for index in range(len(parts))] if wanted.sum else [where]
    read = [_part(name, part, files, key, linear) for part, key in zip(parts, keys, strict=True)]
    units = {channel.spec.unit for channel in read}
    if len(units) > 1:
        raise ConfigurationError(f"{where}.sum: adds {' and '.join(sorted(units))}, its parts should be of one unit.")
    samples = max(channel.raw.size for channel in read)
    read = [
        channel.taken(np.zeros(samples, dtype=np.int64)) if part.value is not None else channel
        for part, channel in zip(parts, read, strict=True)
    ]
    sizes = {channel.raw.size for channel in read}
    if len(sizes) > 1:
        listed = ", ".join(f"{part.variable or part.column}: {c.raw.size}" for part, c in zip(parts, read, strict=True))
        raise RecordingError(f"{files.main}: the parts of {name} differ in length ({listed}), they should be alike.")
    signal = BY_NAME.get(name)
    description = wanted.description or (signal.description if signal is not None else name.removeprefix("aux/"))
    first = read[0]
    if len(read) > 1:
        first = first.with_si(np.sum([channel.si for channel in read], axis=0))
        first = replace(
            first,
            filled=tuple(sorted({index for channel in read for index in channel.filled})),
            doubts=tuple(doubt for channel in read for doubt in channel.doubts),
        )
    origin = " + ".join(channel.spec.origin for channel in read)
    return replace(first, spec=replace(first.spec, description=description, origin=origin))


def read_values(source: Source, part: PartMapping, where: str) -> NDArray[Any]:
    """Read what stands at the place of a column; ``where`` is the mapping file and key.

    Raises
    ------
    RecordingError
        There is no such column, or it holds neither numbers nor stamps.
    """
    try:
        return source.read(part.variable, part.column, part.row)
    except RecordingError as error:
        raise RecordingError(f"{where}: {error}") from error


def _part(name: str, part: PartMapping, files: Files, where: str, linear: bool | None) -> Channel:
    source = files.source(part.file)
    raw = np.array([part.value]) if part.value is not None else read_values(source, part, where)
    if raw.dtype.kind == "M":
        raise ConfigurationError(f"{where}: '{part.variable}' holds dates, only 'time' should.")
    lost = np.flatnonzero(filled(raw))
    if raw.dtype.kind == "f":
        raw = raw.astype(np.float64)
        raw[lost] = np.nan
    if part.signed_bits is not None:
        raw = _signed(raw, part.signed_bits, where)
    if part.sign_bit is not None:
        raw = _of_sign_and_size(raw, part.sign_bit, where)
    as_written = raw
    if part.wraps_at is not None:
        raw = _unwrapped(raw, part.wraps_at)
    number, text = _conversion(part, where, linear)
    unit = _unit(name, text, where, linear)
    scale = constant(part.scale, source, where, "scale")
    made = replace(unit, factor=number * unit.factor)
    if scale == 0.0:
        raise ConfigurationError(f"{where}.scale: is 0, a number that leaves something of the values would be right.")
    place = part.variable or f"{'column' if part.column else 'row'} {part.column or part.row}"
    spec = ChannelSpec(
        name=name,
        unit=unit.si,
        dtype=str(raw.dtype.newbyteorder("=")),
        scale=scale * number * unit.factor,
        offset=offset_in_si(part.offset, source, where, part.unit, made) + unit.offset,
        origin=f"{files.path(part.file).name}/{place}" if part.value is None else f"{part.value:g} {part.unit}",
    )
    doubt = None if part.wraps_at is None else _uneven(as_written, raw, part.wraps_at, spec, source, where)
    doubts = () if doubt is None else (doubt,)
    channel = Channel(raw.astype(spec.dtype, copy=False), spec, source, tuple(lost.tolist()), doubts)
    for other in part.times:
        by = source.read(other)
        if by.size not in (1, raw.size) or by.dtype.kind not in "iuf":
            raise ConfigurationError(f"{where}.times: '{other}' holds {by.size} values, it should hold {raw.size}.")
        channel = channel.with_si(channel.si * by)
        channel = replace(channel, spec=replace(channel.spec, origin=f"{channel.spec.origin} * {other}"))
    return channel


def _conversion(part: PartMapping, where: str, linear: bool | None) -> tuple[float, str]:
    """Factor and unit of what a channel's numbers are turned into."""
    if part.counts_per_revolution is not None:
        if part.unit not in ("1", "counts", "count"):
            raise ConfigurationError(
                f"{where}.unit: is '{part.unit}', with 'counts_per_revolution' it should be 'counts', or left out."
            )
        return 1.0 / part.counts_per_revolution, "revolution"
    if part.torque_constant is not None:
        plain = "N/A" if linear else "N*m/A"
        given = part.torque_constant
        number, unit = (given, plain) if not isinstance(given, str) else quantity(given, f"{where}.torque_constant")
        return number, product_unit("A" if part.unit == "1" else part.unit, plain if unit == "1" else unit)
    if part.factor is None:
        return 1.0, part.unit
    given = part.factor
    number, unit = (given, "1") if not isinstance(given, str) else quantity(given, f"{where}.factor")
    return number, part.unit if unit == "1" else product_unit(part.unit, unit)


def _unit(name: str, text: str, where: str, linear: bool | None) -> Unit:
    """The unit of a channel; on a linear axis metres and newtons stand for radians and newton metres."""
    signal = BY_NAME.get(name)
    if signal is None:
        return unit_of(text, where)
    allowed = [signal.unit] if not linear else []
    if linear is not False and signal.unit in LINEAR:
        allowed.insert(0, LINEAR[signal.unit])
    for like in allowed:
        try:
            return unit_of(text, where, like)
        except ConfigurationError:
            continue
    if text == "1" and signal.unit in LINEAR:
        raise ConfigurationError(f"{where}.unit: is missing, it should be one that becomes '{signal.unit}'.")
    if signal.unit in LINEAR and unit_of(text, where).si == "1":
        needed = _NEEDED.get(signal.unit if text != PERCENT else text, _NEEDED["N·m"])
        raise ConfigurationError(f"{where}: unit '{text}' is of no quantity, {needed}.")
    if _is_current(text) and signal.unit == "N·m":
        plain = "'80 N/A'" if linear else "0.21 (N·m/A)"
        raise ConfigurationError(
            f"{where}: unit '{text}' is a current's, torque_constant such as {plain} makes a torque."
        )
    return unit_of(text, where, LINEAR.get(signal.unit, signal.unit) if linear else signal.unit)


def _is_current(text: str) -> bool:
    try:
        return unit_of(text, "").si == "A"
    except ConfigurationError:
        return False


def _signed(raw: NDArray[Any], bits: int, where: str) -> NDArray[Any]:
    """Integers of so many bits that were read without their sign."""
    span = 2**bits
    of, advice = f"of integers without a sign of {bits} bits", "leave it out if they have their sign already"
    whole = _unsigned(raw, span, f"{where}.signed_bits", of, advice)
    return np.where(whole >= span // 2, whole - span, whole)


def _of_sign_and_size(raw: NDArray[Any], bit: int, where: str) -> NDArray[Any]:
    """Integers whose sign is a bit of its own above the bits of their size."""
    of, advice = f"with the sign in bit {bit}", "take signed_bits where -1 is the largest integer there is"
    whole = _unsigned(raw, 2 ** (bit + 1), f"{where}.sign_bit", of, advice)
    size = whole % 2**bit
    return np.asarray(np.where(whole >= 2**bit, -size, size))


def _unsigned(raw: NDArray[Any], span: int, key: str, of: str, advice: str) -> NDArray[np.int64]:
    """Whole numbers from 0 to below ``span``; ``of`` says what they are of, ``advice`` what else to write."""
    if not np.all((raw >= 0) & (raw < span)):
        low, high = float(np.nanmin(raw)), float(np.nanmax(raw))
        raise RecordingError(
            f"{key}: the values are {low:g} to {high:g}, {of} they should be 0 to {span - 1}; {advice}."
        )
    return raw.astype(np.int64)


def _unwrapped(raw: NDArray[Any], period: float) -> NDArray[Any]:
    """Count overflows: integers stay integers, and become int64."""
    if raw.dtype.kind in "iu":
        return np.unwrap(raw.astype(np.int64), period=int(period))
    return np.unwrap(raw, period=period)


def _uneven(
    raw: NDArray[Any], unwrapped: NDArray[Any], period: float, spec: ChannelSpec, source: Source, where: str
) -> str | None:
    """Say that the motion does not go on evenly where a value starts again; None where it does."""
    jumps = jumps_of(raw.astype(np.float64))
    if jumps is None:
        return None
    went = np.diff(unwrapped.astype(np.float64))[jumps.rows]
    if jumps.go_on(went):
        return None
    uneven = np.flatnonzero(~jumps.even(went))
    first = int(uneven[0])
    beside = max(jumps.low[first], jumps.high[first], key=abs)
    right = jumps.period()
    mend = "the value at which it starts again" if right is None else f"{right:.12g}"
    place = source.location(int(jumps.rows[first]) + 1)
    return (
        f"{where}.wraps_at is {period:g}, and {uneven.size} of the {went.size} steps where the values start again are "
        f"not like those beside them ({went[first] * spec.scale:.4g} {spec.unit} in {place}, "
        f"{beside * spec.scale:.2g} beside it): likely it is not {period:g}, {mend} would be right."
    )


def fill_missing(channel: Channel, how: str) -> Channel:
    """Fill samples that are not there: the last one held, or a straight line between those on both sides."""
    missing = ~np.isfinite(channel.raw)
    if how == "refuse" or not missing.any() or missing.all():
        return channel
    index = np.arange(channel.raw.size)
    if how == "interpolate":
        return channel.with_si(np.interp(index, index[~missing], channel.si[~missing]))
    last = np.maximum.accumulate(np.where(missing, -1, index))
    return replace(channel, raw=channel.raw[np.where(last >= 0, last, index[~missing][0])])
