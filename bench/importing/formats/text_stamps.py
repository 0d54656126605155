"""Dates and times of day as text files write them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError

_TIME = r"\d{1,2}:\d{2}:\d{2}([.,:]\d+)?"
_ZONE = r"\s*(Z|[+-]\d{2}:?\d{2})?"
_ISO = re.compile(rf"\d{{4}}[-/]\d{{1,2}}[-/]\d{{1,2}}([T ]+{_TIME}{_ZONE})?")
_LOCAL = re.compile(rf"(\d{{1,2}})([./])(\d{{1,2}})\2(\d{{4}})([T ]+{_TIME}{_ZONE})?")
_OF_DAY = re.compile(_TIME)


def is_stamp(field: str) -> bool:
    """Whether a field is a date, a date and time, or a time of day."""
    return any(form.fullmatch(field) for form in (_ISO, _LOCAL, _OF_DAY))


def is_time_of_day(field: str) -> bool:
    """Whether a field is a time without a date."""
    return _OF_DAY.fullmatch(field) is not None


def has_zone(field: str) -> bool:
    """Whether a stamp says its time zone."""
    return re.search(r":\d{2}([.,]\d+)?\s*(Z|[+-]\d{2}:?\d{2})$", field) is not None


def seconds_of_day(texts: Sequence[str], where: str) -> NDArray[np.float64]:
    """Times of day as seconds that go on over midnight.

    Raises
    ------
    RecordingError
        A text is no time of day.
    """
    out = np.empty(len(texts))
    for index, text in enumerate(texts):
        if not is_time_of_day(str(text).strip()):
            raise RecordingError(
                f"{where} is '{text}' at index {index}, it should be a time of day such as 12:30:15.250."
            )
        hours, minutes, seconds = re.split(":", str(text).strip().replace(",", "."), maxsplit=2)
        out[index] = int(hours) * 3600 + int(minutes) * 60 + float(seconds.replace(":", "."))
    midnights = np.concatenate(([0], np.cumsum(np.diff(out) < -43200)))
    return np.asarray(out + 86400.0 * midnights)


def parse_stamps(texts: Sequence[str], where: str) -> NDArray[np.datetime64]:
    """Dates as ``datetime64``: UTC where they say a zone, otherwise as they stand.

    Raises
    ------
    RecordingError
        Some say a zone and others none, day and month cannot be distinguished, or one is no date.
    """
    import pandas

    plain = [str(text).strip() for text in texts]
    zones = [has_zone(text) for text in plain]
    if any(zones) != all(zones):
        index = zones.index(not zones[0])
        raise RecordingError(
            f"{where} is '{plain[index]}' at index {index} and '{plain[0]}' at index 0, "
            "either all time stamps should say their time zone or none."
        )
    form: Any = "ISO8601"
    if _LOCAL.fullmatch(plain[0]):
        plain, form = _year_first(plain, where), "ISO8601"
    plain = [text.replace(",", ".").replace("/", "-") for text in plain]
    try:
        made = pandas.to_datetime(pandas.Series(plain), format=form, utc=all(zones))
    except (ValueError, OverflowError) as error:
        index = next((i for i, text in enumerate(plain) if not is_stamp(text)), 0)
        raise RecordingError(
            f"{where} is '{texts[index]}' at index {index}, it should be a date and time such as "
            f"2026-03-01T12:30:15.250 ({str(error).splitlines()[0]})."
        ) from error
    values = made.dt.tz_convert(None) if all(zones) else made
    return np.asarray(values.to_numpy(), dtype="datetime64[ns]")


def _year_first(texts: Sequence[str], where: str) -> list[str]:
    """Dates such as 01.03.2026 or 3/1/2026 with the year first."""
    found = [_LOCAL.fullmatch(text) for text in texts]
    if not all(found):
        index = found.index(None)
        raise RecordingError(f"{where} is '{texts[index]}' at index {index}, it should be a date like '{texts[0]}'.")
    parts = [match.groups() for match in found if match is not None]
    day_first = parts[0][1] == "." or any(int(groups[0]) > 12 for groups in parts)
    if not day_first and not any(int(groups[2]) > 12 for groups in parts):
        raise RecordingError(
            f"{where} is '{texts[0]}', which may be day or month first; year-month-day (2026-03-01) would be clear."
        )
    order = (2, 0) if day_first else (0, 2)
    return [
        f"{groups[3]}-{int(groups[order[0]]):02d}-{int(groups[order[1]]):02d}{(groups[4] or '').replace(' ', 'T', 1)}"
        for groups in parts
    ]
