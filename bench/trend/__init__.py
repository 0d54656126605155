"""One gearbox over months: what its campaigns were identified with, limits of control, and what changed last."""

from bench.trend.book import Trend, gearboxes, identify_missing, trend, trend_of
from bench.trend.limits import Limits, limits_from
from bench.trend.quantities import Value
from bench.trend.series import Point, Series

__all__ = [
    "Limits",
    "Point",
    "Series",
    "Trend",
    "Value",
    "gearboxes",
    "identify_missing",
    "limits_from",
    "trend",
    "trend_of",
]
