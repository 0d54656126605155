"""Explanations that fitted revolutions do not tell apart."""

from __future__ import annotations

import pytest

from bench.mismatch.discovery import RefittedAlternative


@pytest.mark.parametrize(
    ("loss", "error", "as_good"),
    [(2.9, 0.0, True), (3.1, 0.0, False), (5.0, 6.0, True), (7.0, 6.0, False), (-1.0, 0.0, True)],
)
def test_within_odds_of_twenty_to_one_or_a_standard_error_two_are_as_good(
    loss: float, error: float, as_good: bool
) -> None:
    """One order has no standard error (0)."""
    other = RefittedAlternative.of_revolutions("te.drift_time", "drift", loss, error, 0.1)
    assert other.as_good is as_good
    assert other.of_fitted
