"""What the service refuses, by kind; the sentence says why."""

from __future__ import annotations

from bench.errors import BenchError


class NotNow(BenchError):
    """The act is not possible in the state the bench is in."""


class Unknown(BenchError):
    """There is no such run, alarm, campaign or analysis."""
